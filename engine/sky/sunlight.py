"""Sunlight under a cloudless sky, by the turbidity of the air: its illuminance and its spectrum.

The luminous turbidity tells how many clean, dry atmospheres would weaken sunlight as the real one does: 1 is air alone, 2 to
3 clear days, 5 and more haze. Air takes light by Rayleigh's scattering; what turbidity adds is taken for haze whose optical
depth follows Ångström's power of the wavelength, so that the spectrum follows too. Ozone and water vapour are left out: the
turbidity covers what they take of the illuminance, and they change the colour little.

References
----------
CIE S 017:2020, International lighting vocabulary, 17-29-108, luminous turbidity factor
B. A. Bodhaine, N. B. Wood, E. G. Dutton, J. R. Slusser: On Rayleigh optical depth calculations, Journal of Atmospheric and
Oceanic Technology 16(11), 1999, 1854-1861, equation 30
A. Ångström: On the atmospheric transmission of sun radiation and on dust in the air, Geografiska Annaler 11, 1929, 156-166
IAU 2015 resolution B3, effective temperature of the sun
ASTM G173-03, Standard tables for reference solar spectral irradiances, extraterrestrial spectrum (C. A. Gueymard, 2004)
S. Darula, R. Kittler, C. A. Gueymard: Reference luminous solar constant and solar luminance for illuminance calculations,
Solar Energy 79(5), 2005, 559-565
"""

import numpy as np

from ..errors import SceneError
from ..photometry.spectra import GRID, luminous_efficiency, planck
from ..scene.spectrum import Tabulated
from .perez import air_mass

LUMINOUS_SOLAR_CONSTANT = 133_100.0
"""Illuminance by the sun outside the atmosphere at one astronomical unit: that of the spectrum in ASTM G173-03. Darula and
others have 133 334, older handbooks 127 500 to 134 000. [lx]"""

TEMPERATURE = 5772.0
"""Of a black body with the sun's power. [K]"""

HAZE_EXPONENT = 1.3
"""Ångström's exponent of average haze. [-]"""

TURBIDITIES = (1.0, 20.0)
"""Range of the luminous turbidity. [-]"""

SEA_PRESSURE = 101_325.0
"""[Pa]"""

THICKEST_HAZE = 100.0
"""Optical depth of haze along the sun's way at 555 nm beyond which nothing is left. [-]"""


def extinction_of_air(mass: float) -> float:
    """Return the luminous extinction coefficient of clean, dry air for an air mass. [-]"""
    return float(-np.log(_transmittance(mass * _depth_of_air())) / mass)


def direct_illuminance(elevation: float, turbidity: float, distance=1.0, pressure=SEA_PRESSURE):
    """Return the illuminance of a plane that faces the sun.

    Parameters
    ----------
    elevation : float    Of the sun. [degree]
    turbidity : float    Luminous turbidity, 1 to 20. [-]
    distance : float    Of the sun. [astronomical unit]
    pressure : float    At the place. [Pa]

    Returns
    -------
    float    0 while the sun is not above the horizon. [lx]

    Raises
    ------
    SceneError    A number is out of its range.
    """
    mass = _mass(elevation, turbidity, distance, pressure)
    if elevation <= 0.0:
        return 0.0
    depth = extinction_of_air(mass) * mass * turbidity
    return float(LUMINOUS_SOLAR_CONSTANT / distance**2 * np.exp(-depth))


def sunlight_spectrum(elevation: float, turbidity: float, pressure=SEA_PRESSURE) -> Tabulated:
    """Return the relative spectral power of sunlight.

    Parameters
    ----------
    elevation, turbidity, pressure : float    As in `direct_illuminance`; a sun below the horizon is taken at it.

    Returns
    -------
    Tabulated    On the grid of 1 nm, the greatest value is 1.

    Raises
    ------
    SceneError    A number is out of its range.
    """
    mass = _mass(elevation, turbidity, 1.0, pressure)
    air = mass * _depth_of_air()
    wanted = turbidity * extinction_of_air(mass) * mass
    haze = (GRID / 555.0) ** -HAZE_EXPONENT
    low, high = 0.0, THICKEST_HAZE
    for _ in range(60):
        middle = 0.5 * (low + high)
        is_less = -np.log(_transmittance(air + middle * haze)) < wanted
        low, high = (middle, high) if is_less else (low, middle)
    # The largest is taken out first, as little may be left of a low sun.
    values = np.log(planck(GRID, TEMPERATURE)) - air - low * haze
    return Tabulated(GRID, np.exp(values - values.max()), f"sunlight, turbidity {turbidity:g}")


def _mass(elevation, turbidity, distance, pressure) -> float:
    if not TURBIDITIES[0] <= turbidity <= TURBIDITIES[1]:
        raise SceneError(f"the luminous turbidity is {turbidity}, expected 1 to 20")
    if not (-90.0 <= elevation <= 90.0 and distance > 0.0 and 0.0 < pressure <= 120_000.0):
        raise SceneError(
            f"the sun's elevation {elevation} degrees, its distance {distance} or the pressure {pressure} Pa is out of range"
        )
    return float(air_mass(elevation)) * pressure / SEA_PRESSURE


def _depth_of_air() -> np.ndarray:
    """Optical depth of clean, dry air above the sea. (471,)"""
    square = (GRID / 1000.0) ** 2
    above = 1.0455996 - 341.29061 / square - 0.90230850 * square
    below = 1.0 + 0.0027059889 / square - 85.968563 * square
    return 0.0021520 * above / below


def _transmittance(depth: np.ndarray) -> float:
    """Part of the sun's light that optical depths leave. [-]"""
    weights = planck(GRID, TEMPERATURE) * luminous_efficiency()
    # Factored, so that thick air leaves a number above 0.
    least = float(depth.min())
    return float((weights * np.exp(least - depth)).sum() / weights.sum() * np.exp(-least))
