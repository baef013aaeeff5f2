"""What the sky gives usually: horizontal illuminances of cloudless, intermediate and overcast skies by the sun's height.

They stand in where nothing better is known: single skies may well be twice as bright or half as bright.

References
----------
IES Calculation Procedures Committee: Recommended practice for the calculation of daylight availability, Journal of the
Illuminating Engineering Society 13(4), 1984, 381-392, doi:10.1080/00994480.1984.10748791
"""

import math

from ..errors import SceneError

CONDITIONS = {
    "clear": (800.0, 15_500.0, 0.5),
    "intermediate": (300.0, 45_000.0, 1.0),
    "overcast": (300.0, 21_000.0, 1.0),
}
"""Illuminance at sunrise [lx], what the sine of the elevation adds [lx], and the exponent of the sine [-]."""


def usual_illuminance(condition: str, elevation: float) -> float:
    """Return the horizontal illuminance by the sky alone.

    Parameters
    ----------
    condition : str    Of `CONDITIONS`.
    elevation : float    Of the sun. [degree]

    Returns
    -------
    float    0 while the sun is below the horizon. [lx]

    Raises
    ------
    SceneError    There is no such condition or elevation.
    """
    if condition not in CONDITIONS or not -90.0 <= elevation <= 90.0:
        raise SceneError(
            f"the sky is '{condition}' with the sun at {elevation} degrees, expected {', '.join(CONDITIONS)} and -90 to 90"
        )
    if elevation < 0.0:
        return 0.0
    base, rise, exponent = CONDITIONS[condition]
    return base + rise * math.sin(math.radians(elevation)) ** exponent


def condition_of_type(kind: int) -> str:
    """Return the condition that a type of the CIE, 1 to 16, is nearest to."""
    if kind <= 5 or kind == 16:
        return "overcast"
    return "intermediate" if kind <= 10 else "clear"
