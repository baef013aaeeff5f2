"""What panels say of a pigment layer: its colour, its errors, and what it will take."""

import numpy as np

from ...engine.errors import LumenrayError
from ...engine.ink.plan import make_plan, memory_of, solves_of
from ...engine.ink.reader import parse_ink
from ...engine.ink.surface import PrintedSurface
from ...engine.photometry.colour import XYZ_TO_REC709
from ...engine.scattering.data.tristimulus import tristimulus
from .description import describe
from .tables import ink_tables

REMEDY = "A plain grey is used until the composition is mended."
"""What is said below a problem with a composition."""


def describe_cost(settings) -> list[tuple[str, str]]:
    """Lines (label, value) of what a layer takes; none where it cannot be solved, of which the state tells why."""
    try:
        ink = parse_ink(describe(settings))
        plan = make_plan(ink, draft=settings.quality == "DRAFT")
    except LumenrayError:
        return []
    return [
        ("Grid", f"{plan.columns} × {plan.columns} × {plan.layers}"),
        ("Solves", f"{solves_of(ink, plan)}"),
        ("Memory", f"{memory_of(ink, plan) / 2**20:.0f} MB per process"),
    ]


def describe_trust(printed: PrintedSurface) -> list[tuple[str, str]]:
    """Lines (label, value) of the colour and the errors that are known."""
    lab = "  ".join(f"{value:.1f}" for value in printed.lab)
    error = float(np.sqrt((printed.standard_errors**2).mean()))
    return [
        ("L* a* b*", f"{lab} (45:0, D50, 2°)"),
        ("Colour error", f"± {printed.lab_error:.2g}"),
        ("Reflectance error", f"± {100.0 * error:.2g} %"),
        ("Grid error", f"{100.0 * printed.grid_error:.2g} %"),
        ("Realisations", f"{printed.realisations}, seed {printed.seed}"),
    ]


def swatch(settings) -> tuple[float, float, float]:
    """Linear colour as far as a screen shows it; black while it is not known."""
    printed = ink_tables.state_of(settings).reading
    if printed is None:
        return (0.0, 0.0, 0.0)
    return shown_colour(printed.readings, printed.wavelengths)


def shown_colour(values, wavelengths) -> tuple[float, float, float]:
    """Linear colour of shares of light in daylight, as far as a screen shows it. Two (w,) arrays, the second in nm"""
    seen = tristimulus(values, wavelengths)
    return tuple(float(v) for v in np.clip(XYZ_TO_REC709 @ seen, 0.0, 1.0))
