"""Light of further sensors in a year whose blinds others have moved, as the lumels of maps beside a grid."""

from dataclasses import replace

from .blinds import RuledLight
from .coefficients import DaylightCoefficients
from .light import Light, ShadedLight, YearLight


def take_sensors(made: DaylightCoefficients, part: slice) -> DaylightCoefficients:
    """Return the coefficients of some sensors."""
    return replace(
        made,
        sky=made.sky[:, part],
        reflected=made.reflected[:, part],
        doubts=made.doubts[:, part],
        reading=made.reading[part],
        direct=made.direct[part],
        direct_error=made.direct_error[part],
    )


def follow_states(
    light: Light, opened: DaylightCoefficients, closed: tuple[DaylightCoefficients, ...]
) -> Light:
    """Return the light of other sensors with the blinds as they are in a year.

    Parameters
    ----------
    light : Light    Whose blinds count.
    opened : DaylightCoefficients    Of the others, all blinds open.
    closed : tuple of DaylightCoefficients    The same with the blinds of each group closed.
    """
    own = YearLight(opened, light.year)
    if not isinstance(light, ShadedLight):
        return own
    shaded = tuple(YearLight(each, light.year) for each in closed)
    if isinstance(light, RuledLight):
        return RuledLight(own, shaded, light.is_closed, light.by_standard)
    return ShadedLight(own, shaded, light.is_closed)
