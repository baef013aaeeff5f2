"""Air above a place, as the standard atmosphere has it."""

from .solar_position import Air

SEA_PRESSURE = 101_325.0
"""[Pa]"""

SEA_TEMPERATURE = 15.0
"""[degree Celsius]"""

LAPSE = 0.0065
"""By which it gets colder upwards. [K/m]"""

EXPONENT = 5.25588
"""Of the pressure by the temperature. [-]"""


def standard_air(height: float) -> Air:
    """Return the air at a height above the sea.

    Parameters
    ----------
    height : float    [m]

    References
    ----------
    ISO 2533:1975, standard atmosphere
    """
    temperature = SEA_TEMPERATURE - LAPSE * height
    ratio = (temperature + 273.15) / (SEA_TEMPERATURE + 273.15)
    return Air(SEA_PRESSURE * ratio**EXPONENT, temperature)
