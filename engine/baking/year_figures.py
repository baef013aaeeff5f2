"""Figures of a year of daylight of which maps are made."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Kind:
    """A figure that maps show.

    Parameters
    ----------
    name : str    Of the figure, and in names of files.
    title : str    For people.
    unit : str    That pictures show it in.
    factor : float    From the figure to that unit.
    high : float or None    Top of the pictures' scale; None: a round number of the values. [unit]
    """

    name: str
    title: str
    unit: str
    factor: float = 1.0
    high: float | None = None


COVERAGE = "sda_coverage"
"""Where the daylight suffices by LM-83: 1, elsewhere 0."""

KINDS = (
    Kind("daylight_autonomy", "Daylight autonomy", "%", 100.0, 100.0),
    Kind("continuous_autonomy", "Continuous daylight autonomy", "%", 100.0, 100.0),
    Kind("useful_enough", "Useful daylight that suffices", "%", 100.0, 100.0),
    Kind("useful_supplemented", "Useful daylight with lamps", "%", 100.0, 100.0),
    Kind("useful_too_little", "Too little daylight", "%", 100.0, 100.0),
    Kind("useful_too_much", "Too much daylight", "%", 100.0, 100.0),
    Kind("lm83_autonomy", "Hours with 300 lx by LM-83", "%", 100.0, 100.0),
    Kind(COVERAGE, "Enough daylight by LM-83", "%", 100.0, 100.0),
    Kind("mean_lx", "Mean illuminance", "lx"),
    Kind("exposure_lx_h", "Light exposure", "lx h"),
    Kind("daylight_factor", "Daylight factor", "%", 100.0),
    Kind("sunlit_h", "Hours with more than 1000 lx by the sun alone", "h"),
    Kind("sunshine_h", "Hours of sunshine", "h"),
)
"""What maps are made of, in the order of their worth."""
