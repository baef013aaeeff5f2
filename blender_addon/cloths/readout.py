"""What panels say of a cloth: what its data sheet would state, its errors, and what it will take."""

import numpy as np

from ...engine.cloth.plan import rays_in_all
from ...engine.cloth.reader import parse_cloth
from ...engine.cloth.surface import WovenSurface
from ...engine.errors import LumenrayError
from .description import describe
from .tables import cloth_tables

REMEDY = "A plain grey is used until the composition is mended."
"""What is said below a problem with a composition."""


def describe_cost(settings) -> list[tuple[str, str]]:
    """Lines (label, value) of what a cloth takes; none where it cannot be read, of which the state tells why."""
    try:
        cloth = parse_cloth(describe(settings))
    except LumenrayError:
        return []
    return [("Rays", f"{rays_in_all(cloth, settings.quality == 'DRAFT'):,}")]


def describe_sheet(woven: WovenSurface) -> list[tuple[str, str]]:
    """Lines (label, value) of a data sheet after EN 14500, visible light along the normal unless it says otherwise."""
    sheet = woven.sheet
    lines = [
        ("Transmittance Tv", _percent(sheet.transmittance, sheet.transmittance_error)),
        ("Reflectance Rv", _percent(sheet.reflectance, sheet.reflectance_error)),
        ("Rv of the back", _percent(sheet.back_reflectance)),
        ("Openness", _percent(sheet.openness)),
        ("Tv, diffuse light", _percent(sheet.diffuse_transmittance)),
        ("Rv, diffuse light", _percent(sheet.diffuse_reflectance)),
    ]
    if sheet.openness > 0.0:
        lines.append(("Cut-off, warp", f"{sheet.cutoff_warp_deg:.0f}°"))
        lines.append(("Cut-off, weft", f"{sheet.cutoff_weft_deg:.0f}°"))
    return lines


def describe_trust(woven: WovenSurface) -> list[tuple[str, str]]:
    """Lines (label, value) of the errors that are known."""
    return [
        ("Table error", f"± {100.0 * woven.table_error:.2g} %"),
        ("Rays", f"{woven.rays:,}"),
        ("Seed", f"{woven.seed}"),
    ]


def reflected(settings) -> tuple[float, float, float]:
    """Linear colour of what comes back, as far as a screen shows it; black while it is not known."""
    return _colour(settings, "reflected")


def passed(settings) -> tuple[float, float, float]:
    """Likewise of what passes through yarns."""
    return _colour(settings, "passed")


def _colour(settings, name: str) -> tuple[float, float, float]:
    woven = cloth_tables.state_of(settings).reading
    if woven is None:
        return (0.0, 0.0, 0.0)
    return tuple(float(v) for v in np.clip(getattr(woven, name), 0.0, 1.0))


def _percent(share: float, error: float | None = None) -> str:
    if error is None:
        return f"{100.0 * share:#.3g} %"
    return f"{100.0 * share:#.3g} % ± {100.0 * error:.1g} %"
