"""From a data sheet to a cloth: a screen of white and grey yarns that lets through and reflects what is stated.

A sheet states openness, visible transmittance and reflectance for light along the normal. Openness is the yarns' width;
the other two are found by how much the yarns scatter and absorb. One walk tells all absorptions, so for each strength of
scattering the absorption is solved for the light that is lost, and the strength for how the rest is shared out.
"""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .reader import parse_cloth
from .woven import Maker

PITCH, THICKEST = 0.5, 0.36
"""Of yarns, and their height where they are wider. [mm]"""

FRACTIONS = 2e-5, 0.02
"""Volume fractions of titanium white among which one is sought. [-]"""

DARKEST = 200.0
"""Largest absorption. [1/mm]"""

WAVELENGTH = 550.0
"""At which shares are found: yarns are grey. [nm]"""

RAYS = 30_000

FIT_EXITS = 256
"""Exits of each way into a thread, see `records`: of few, as each strength of scattering takes its own."""

STEPS = 9
"""Halvings of the range of fractions."""

CLOSE = 0.005
"""Difference from what is stated up to which a cloth is found, besides three standard errors. [-]"""


@dataclass(frozen=True)
class FittedSheet:
    """A cloth and what it comes to.

    Parameters
    ----------
    content : dict    Its description, for a file.
    openness, transmittance, reflectance : float    Of light along the normal. [-]
    error : float    Standard error of the two. [-]
    """

    content: dict
    openness: float
    transmittance: float
    reflectance: float
    error: float


def fit_sheet(
    openness: float,
    transmittance: float,
    reflectance: float,
    name: str = "Screen of a data sheet",
    rays: int = RAYS,
    exits: int = FIT_EXITS,
    seed: int = 0,
) -> FittedSheet:
    """Find a plain screen by its data sheet. A variant of Mitsuba must be active.

    Raises
    ------
    SceneError    No such cloth can be, or none of this kind; the text says what comes nearest.
    """
    if not 0.0 <= openness < 0.9:
        raise SceneError(f"an openness of {100 * openness:g} % was stated, expected 0 to 90 %")
    if transmittance < openness:
        raise SceneError(
            f"a transmittance of {100 * transmittance:g} % was stated, expected the openness at least: {100 * openness:g} %"
        )
    if reflectance <= 0.0 or transmittance + reflectance >= 1.0:
        raise SceneError(
            f"{100 * transmittance:g} % let through and {100 * reflectance:g} % reflected were stated, expected less than "
            "100 % together and some reflected"
        )
    low, high = np.log(FRACTIONS)
    best = None
    for _ in range(STEPS):
        fraction = float(np.exp(0.5 * (low + high)))
        made = _at_fraction(fraction, openness, transmittance, reflectance, name, rays, exits, seed)
        if best is None or _apart(made, transmittance, reflectance) < _apart(
            best, transmittance, reflectance
        ):
            best = made
        # More scattering sends more back of what is not absorbed.
        if made.transmittance > transmittance:
            low = np.log(fraction)
        else:
            high = np.log(fraction)
    if _apart(best, transmittance, reflectance) > CLOSE + 3.0 * best.error:
        raise SceneError(
            f"no screen of such yarns lets {100 * transmittance:.3g} % through and reflects {100 * reflectance:.3g} %; "
            f"the nearest has {100 * best.transmittance:.3g} % and {100 * best.reflectance:.3g} %"
        )
    return best


def _apart(made: FittedSheet, transmittance: float, reflectance: float) -> float:
    return max(abs(made.transmittance - transmittance), abs(made.reflectance - reflectance))


def _describe(name: str, fraction: float, absorption: float, openness: float) -> dict:
    width = round(PITCH * (1.0 - openness**0.5), 5)
    yarn = {
        "width_mm": width,
        "height_mm": min(width, THICKEST),
        "index": 1.54,
        "roughness": 0.35,
        "scatterers": [
            {"index": 2.7, "diameter_um": 0.25, "log_spread": 0.2, "volume_fraction": fraction}
        ],
        "absorption_per_mm": absorption,
    }
    return {
        "lumenray_cloth": 1,
        "name": name,
        "description": "Plain screen of grey yarns, found by openness, transmittance and reflectance.",
        "warp": yarn,
        "weft": dict(yarn),
        "weave": {"pattern": "plain", "warp_pitch_mm": PITCH, "weft_pitch_mm": PITCH},
    }


def _at_fraction(fraction, openness, transmittance, reflectance, name, rays, exits, seed):
    """The cloth of a strength of scattering that loses as much light as is stated."""
    cloth = parse_cloth(_describe(name, fraction, 0.0, openness))
    maker = Maker(cloth, np.array([WAVELENGTH]), rays, seed, exits)
    lost, events, ways, _, _, up = maker.trace([0.0, 0.0, -1.0], rays, seed + 1)
    scattered = ~lost & (events > 0)
    way, is_up = ways.sum(axis=0)[scattered], up[scattered] > 0.0
    # Openings are as wide as stated, not as the rays have met them.
    share = (1.0 - openness) / max(int(scattered.sum()), 1)
    left = reflectance + transmittance - openness
    low, high = 0.0, DARKEST
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if share * np.exp(-middle * way).sum() > left else (low, middle)
    kept = np.exp(-high * way)
    own = openness + share * kept[~is_up].sum(), share * kept[is_up].sum()
    error = (1.0 - openness) * float((kept * is_up).std()) / np.sqrt(max(len(kept), 1))
    return FittedSheet(
        _describe(name, fraction, round(high, 5), openness),
        openness,
        float(own[0]),
        float(own[1]),
        error,
    )
