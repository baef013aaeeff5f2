"""Sunlight by turbidity against published approximations, daylight's colours, and at its ends."""

import colour
import numpy as np
import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.photometry.spectra import GRID, luminous_efficiency
from lumenray.engine.sky.perez import air_mass
from lumenray.engine.sky.sunlight import (
    LUMINOUS_SOLAR_CONSTANT,
    direct_illuminance,
    extinction_of_air,
    sunlight_spectrum,
)


def solar_spectrum():
    """Wavelengths [nm], and irradiance outside the atmosphere by ASTM G173-03 weighed by the eye, of each step. [W/m2]"""
    from colour.plotting.datasets.astm_g_173 import SD_ASTMG173_ETR

    eye = colour.SDS_LEFS["CIE 1924 Photopic Standard Observer"]
    wavelengths = SD_ASTMG173_ETR.wavelengths
    weight = np.interp(wavelengths, eye.wavelengths, eye.values, left=0.0, right=0.0)
    return wavelengths, SD_ASTMG173_ETR.values * weight * np.gradient(wavelengths)


def extinction_by(depth, mass):
    """Luminous extinction coefficient by an optical depth of air over the wavelength in micrometres. [-]"""
    wavelengths, seen = solar_spectrum()
    left = (seen * np.exp(-mass * depth(wavelengths / 1000.0))).sum()
    return -np.log(left / seen.sum()) / mass


def test_luminous_solar_constant_is_that_of_the_standard_spectrum():
    """The spectrum has half a nanometre and four digits; Darula, Kittler and Gueymard (2005) have 0.2 % more."""
    _, seen = solar_spectrum()
    assert abs(683.002 * seen.sum() / LUMINOUS_SOLAR_CONSTANT - 1.0) < 5e-4
    assert abs(133_334.0 / LUMINOUS_SOLAR_CONSTANT - 1.0) < 2e-3


@pytest.mark.parametrize("mass", [1.0, 2.0, 4.0, 8.0])
def test_extinction_of_air_is_that_of_another_depth_and_spectrum(mass):
    """J. E. Hansen and L. D. Travis, 1974, with a depolarization of 0.031, for which the King factor (6 + 3 d) / (6 - 7 d)
    is 1.0536; that of the air here is 1.0490 at 550 nm (Bates, 1984), which makes 0.44 % of the depth. The other spectrum,
    the sun's own for a black body's, changes the mean by as little as 0.1 %.
    """

    def depth(x):
        return 0.008569 * x**-4 * (1.0 + 0.0113 * x**-2 + 0.00013 * x**-4)

    assert extinction_of_air(mass) == pytest.approx(extinction_by(depth, mass) / 1.0044, rel=1.5e-3)


@pytest.mark.parametrize("mass", [1.0, 2.0, 4.0, 8.0])
def test_older_approximation_is_that_of_an_older_depth_of_air(mass):
    """R. Clear, 1982: 0.1 / (1 + 0.0045 m), whose few digits leave a percent open. B. Leckner, 1978, has the depth
    0.008735 x^-4.08, 3 % more than newer measurements of air; ours falls with the air mass as both do.
    """
    older = 0.1 / (1.0 + 0.0045 * mass)
    assert extinction_by(lambda x: 0.008735 * x**-4.08, mass) == pytest.approx(older, rel=0.01)
    fall = (1.0 + 0.0045) / (1.0 + 0.0045 * mass)
    assert extinction_of_air(mass) / extinction_of_air(1.0) == pytest.approx(fall, rel=0.003)


def test_clear_day_has_the_illuminance_that_is_known():
    """About 100 000 lx under a high sun; half of the loss in logarithms is that of twice the turbidity."""
    noon = direct_illuminance(60.0, 2.5)
    assert 95_000.0 < noon < 105_000.0
    losses = [np.log(LUMINOUS_SOLAR_CONSTANT / direct_illuminance(60.0, t)) for t in (2.0, 4.0)]
    assert losses[1] == pytest.approx(2.0 * losses[0], rel=1e-12)


def test_distance_height_and_pressure_count():
    near, far = direct_illuminance(40.0, 3.0, 0.983), direct_illuminance(40.0, 3.0, 1.017)
    assert near / far == pytest.approx((1.017 / 0.983) ** 2, rel=1e-12)
    values = [direct_illuminance(elevation, 3.0) for elevation in (1.0, 5.0, 20.0, 60.0, 90.0)]
    assert (np.diff(values) > 0.0).all()
    assert direct_illuminance(40.0, 3.0, pressure=70_000.0) > direct_illuminance(40.0, 3.0)


def test_sun_below_the_horizon_gives_nothing():
    assert direct_illuminance(0.0, 3.0) == direct_illuminance(-5.0, 3.0) == 0.0


@pytest.mark.parametrize("elevation", [0.0, 10.0, 60.0])
@pytest.mark.parametrize("turbidity", [1.0, 3.0, 20.0])
def test_spectrum_is_finite_and_fits_the_grid(elevation, turbidity):
    spectrum = sunlight_spectrum(elevation, turbidity)
    assert spectrum.values.shape == GRID.shape
    assert spectrum.values.max() == 1.0
    assert (spectrum.values >= 0.0).all()


def test_spectrum_is_weakened_as_the_illuminance_is():
    """What the spectrum tells of the haze, and an older formula of the air, pass as much light as the turbidity says."""
    turbidity, elevation = 4.0, 25.0
    mass = float(air_mass(elevation))
    spectrum = sunlight_spectrum(elevation, turbidity)
    c2, metres = 1.438776877e-2, GRID * 1e-9
    body = metres**-5 / np.expm1(c2 / (metres * 5772.0))
    depth = np.log(body / spectrum.values)
    depth -= depth.min()
    air = 0.008735 * (GRID / 1000.0) ** -4.08 * mass
    # What is left is haze up to a constant: c + h (l / 555)^-1.3.
    shape = np.stack([np.ones_like(GRID), (GRID / 555.0) ** -1.3], axis=1)
    (_, haze), *_ = np.linalg.lstsq(shape, depth - air, rcond=None)
    weights = body * luminous_efficiency()
    passed = (weights * np.exp(-air - haze * shape[:, 1])).sum() / weights.sum()
    expected = direct_illuminance(elevation, turbidity) / LUMINOUS_SOLAR_CONSTANT
    assert passed == pytest.approx(expected, rel=0.03)


def temperature_of(spectrum):
    """Correlated colour temperature by another library. [K]"""
    distribution = colour.SpectralDistribution(spectrum.values[::5], GRID[::5])
    tristimulus = colour.sd_to_XYZ(distribution)
    xy = tristimulus[:2] / tristimulus.sum()
    return colour.temperature.xy_to_CCT(xy, method="Hernandez 1999")


def test_sunlight_reddens_as_the_sun_sinks():
    values = [temperature_of(sunlight_spectrum(e, 2.5)) for e in (90.0, 30.0, 15.0, 8.0, 4.0)]
    assert (np.diff(values) < 0.0).all()
    # Sunlight of clear days: 5000 to 5600 K when high, 3000 K and less near the horizon.
    assert 5000.0 < values[0] < 5700.0
    assert values[-1] < 3300.0


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((40.0, 0.9), "turbidity is 0.9, expected 1 to 20"),
        ((40.0, np.nan), "turbidity is nan"),
        ((91.0, 3.0), "out of range"),
        ((40.0, 3.0, 0.0), "out of range"),
        ((40.0, 3.0, 1.0, -5.0), "out of range"),
    ],
)
def test_what_cannot_be_is_refused(arguments, words):
    with pytest.raises(SceneError, match=words):
        direct_illuminance(*arguments)
