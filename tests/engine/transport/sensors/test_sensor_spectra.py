"""Spectra and alpha-opic quantities at sensors against quadrature of closed forms."""

import numpy as np
import pytest
from small_scenes import box, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.photometry.alpha_opic import MELANOPIC, alpha_opic, equivalent_daylight
from lumenray.engine.photometry.spectra import (
    GRID,
    evaluate_reflectance,
    luminous_efficiency,
    photometric_density,
)
from lumenray.engine.photometry.units import LUMINOUS_EFFICACY
from lumenray.engine.scene.material import Diffuse, Emission, Material
from lumenray.engine.scene.spectrum import Constant, Illuminant, Tabulated

pytestmark = pytest.mark.mitsuba

LUMINANCE = 20.0
"""That all walls give off themselves. [cd/m2]"""

RED = Tabulated(np.array([360.0, 480.0, 620.0, 830.0]), np.array([0.1, 0.15, 0.7, 0.8]))

PLACES, NORMALS = (
    np.array([[1.0, 1.0, 1.0], [0.3, 1.5, 0.4]]),
    np.array([[0, 0, 1.0], [0.6, 0.8, 0]]),
)


def measure(paint, spectrum, **more):
    """In a closed room whose walls shine and reflect, all alike."""
    walls = Material("paint", "paint", Diffuse(paint), Emission(spectrum, LUMINANCE))
    session = session_of(walls, box(2.0, 2.0, 2.0))
    rule = StopRule(samples=1 << 14)
    return session.measure(PLACES, NORMALS, rule, 1, spectrum=True, **more)


def expected(paint, spectrum):
    """Irradiance in it, pi L / (1 - rho) at every wavelength. (471,) [W/(m2 nm)]"""
    emitted = np.pi * LUMINANCE * photometric_density(spectrum)
    return emitted / (1.0 - evaluate_reflectance(paint, GRID))


@pytest.mark.parametrize("lamp", ["FL11", "LED-B3"])
def test_equivalent_daylight_in_a_coloured_room_is_that_of_quadrature(lamp):
    made = measure(RED, Illuminant(lamp)).spectra
    wanted = equivalent_daylight(alpha_opic(expected(RED, Illuminant(lamp))))
    gaps = np.abs(made.equivalent_daylight - wanted) / made.equivalent_daylight_error
    assert gaps.max() < 4.5
    # The errors must be small enough to find anything.
    assert (made.equivalent_daylight_error < 0.03 * wanted).all()


def test_bands_are_those_of_quadrature():
    made = measure(RED, Illuminant("LED-B3")).spectra
    wanted = expected(RED, Illuminant("LED-B3"))
    middles = 0.5 * (made.edges[1:] + made.edges[:-1])
    smooth = np.convolve(wanted, np.ones(5) / 5.0, mode="same")
    seen = np.interp(middles, GRID, smooth)
    assert np.abs(made.bands - seen).max() < 0.05 * seen.max()
    assert np.abs(made.bands.mean(axis=1) / seen.mean() - 1.0).max() < 0.01


@pytest.mark.parametrize("transport", ["mono", "spectral"])
def test_daylight_acts_as_daylight(transport):
    """D65 on neutral walls: every equivalent daylight illuminance is the illuminance. (CIE S 026:2018, 3.9)"""
    made = measure(Constant(0.5), Illuminant("D65"), transport=transport)
    wanted = 2.0 * np.pi * LUMINANCE
    error = np.hypot(made.spectra.equivalent_daylight_error, 1e-4 * wanted)
    assert (np.abs(made.spectra.equivalent_daylight - wanted) < 4.5 * error).all()


def test_a_spectrum_does_not_change_the_illuminance():
    """Within the errors: paths are the same, but of other wavelengths."""
    made = measure(RED, Illuminant("LED-B3"))
    seen = expected(RED, Illuminant("LED-B3")) @ luminous_efficiency()
    wanted = LUMINOUS_EFFICACY * float(seen)
    assert (np.abs(made.illuminance - wanted) < 4.5 * made.standard_error).all()
    assert made.spectra.equivalent_daylight.shape == (2, MELANOPIC + 1)


@pytest.mark.slow
def test_readings_by_cells_have_spectra_too():
    made = measure(RED, Illuminant("LED-B3"), method="cells").spectra
    wanted = equivalent_daylight(alpha_opic(expected(RED, Illuminant("LED-B3"))))
    allowed = 4.5 * made.equivalent_daylight_error + 0.005 * wanted
    assert (np.abs(made.equivalent_daylight - wanted) < allowed).all()
