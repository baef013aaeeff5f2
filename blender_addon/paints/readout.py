"""What panels say of a paint: its colours at the angles of hand instruments, and how far they may be trusted."""

import numpy as np

from ...engine.paint.surface import PaintedSurface
from ...engine.photometry.colour import XYZ_TO_REC709
from ...engine.scattering.data.tristimulus import weights_of
from .angles import STRIP
from .tables import paint_tables

REMEDY = "A plain grey is used until the composition is mended."
"""What is said below a problem with a composition."""

HEAD = ("Angle", "L*", "a*", "b*")
"""Of the table of colours."""

GEOMETRY = "light at 45°, D65, 10° observer"
"""Under which its numbers hold."""


def lab_rows(painted: PaintedSurface) -> list[tuple[str, str, str, str]]:
    """Rows of the table of colours, as instruments print it."""
    return [
        (f"{angle:.0f}°", *(f"{value + 0.0:.1f}" for value in lab))
        for angle, lab in zip(painted.angles, np.round(painted.lab, 1), strict=True)
    ]


def describe_trust(painted: PaintedSurface) -> list[tuple[str, str]]:
    """Lines (label, value) of the errors that are known."""
    table = painted.surface.front_reflection
    return [
        ("Table", f"{' × '.join(map(str, table.values.shape[1:]))}"),
        ("Table error", f"{100.0 * table.error:.2g} %"),
        ("Convergence", f"{100.0 * painted.convergence:.2g} %"),
    ]


def swatch(settings, number: int) -> tuple[float, float, float]:
    """Linear colour at an angle of the strip, as far as a screen shows it; black while it is not known."""
    painted = paint_tables.state_of(settings).reading
    if painted is None:
        return (0.0, 0.0, 0.0)
    place = int(np.argmin(np.abs(painted.angles - STRIP[number])))
    seen = painted.readings[place] @ weights_of(painted.wavelengths, "D65")
    return tuple(float(v) for v in np.clip(XYZ_TO_REC709 @ seen, 0.0, 1.0))
