"""Spectra, colour and units against colour-science and closed forms."""

import warnings

import numpy as np
import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.photometry import spectra, units
from lumenray.engine.photometry.colour import automatic_white, scene_linear
from lumenray.engine.scene.spectrum import Blackbody, Constant, Daylight, Illuminant, Rgb, Tabulated
from lumenray.libraries.spectra import illuminant_names

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    colour = pytest.importorskip("colour")


def chromaticity(spectrum):
    xyz = spectra.evaluate_emission(spectrum, spectra.GRID) @ spectra.observer()
    return xyz[:2] / xyz.sum()


@pytest.mark.parametrize("name", illuminant_names())
def test_illuminants_have_their_published_chromaticity(name):
    key = {"FL": name}.get(name, name)
    published = colour.CCS_ILLUMINANTS["CIE 1931 2 Degree Standard Observer"][key]
    assert np.allclose(chromaticity(Illuminant(name)), published, atol=6e-4)


@pytest.mark.parametrize("temperature", [4000.0, 5000.0, 6500.0, 10000.0, 25000.0])
def test_daylight_agrees_with_colour_science(temperature):
    xy = colour.temperature.CCT_to_xy_CIE_D(temperature)
    sd = colour.sd_CIE_illuminant_D_series(xy)
    ours = spectra.daylight(sd.wavelengths, temperature)
    assert np.allclose(ours / ours.mean(), sd.values / sd.values.mean(), atol=2e-3)


def test_daylight_outside_its_range_is_refused():
    with pytest.raises(SceneError, match="blackbody"):
        spectra.evaluate_emission(Daylight(3000.0), spectra.GRID)


@pytest.mark.parametrize("temperature", [2000.0, 2856.0, 6500.0])
def test_blackbodies_lie_on_the_planckian_locus(temperature):
    sd = colour.sd_blackbody(temperature, colour.SpectralShape(360, 830, 1))
    xyz = sd.values @ spectra.observer()
    assert np.allclose(chromaticity(Blackbody(temperature)), xyz[:2] / xyz.sum(), atol=2e-5)


def test_the_unknown_illuminant_is_named_with_the_known_ones():
    with pytest.raises(SceneError, match="D65"):
        spectra.evaluate_emission(Illuminant("D99"), spectra.GRID)


@pytest.mark.parametrize(
    "rgb", [(0.8, 0.2, 0.1), (0.1, 0.5, 0.9), (0.4, 0.4, 0.4), (0.05, 0.9, 0.1)]
)
def test_upsampled_reflectances_return_their_colour_under_d65(rgb):
    values = spectra.upsample(Rgb(*rgb), spectra.GRID)
    assert (values >= 0).all()
    assert (values <= 1).all()
    light = spectra.illuminant(spectra.GRID, "D65")
    xyz = (values * light) @ spectra.observer() / (light @ spectra.observer()[:, 1])
    assert np.allclose(scene_linear(xyz, 1.0), rgb, atol=0.012)


def test_a_density_of_one_lumen_holds_one_lumen():
    for spectrum in (Illuminant("FL2"), Blackbody(3000), Rgb(1, 0.1, 0.1), Constant()):
        density = spectra.photometric_density(spectrum)
        assert units.LUMINOUS_EFFICACY * (
            density * spectra.luminous_efficiency()
        ).sum() == pytest.approx(1.0)


def test_monochromatic_555_nm_has_the_maximum_efficacy():
    line = Tabulated(np.array([554.0, 555.0, 556.0]), np.array([0.0, 1.0, 0.0]))
    assert spectra.efficacy(line) == pytest.approx(683.0, rel=1e-4)


def test_invisible_light_has_no_lumens():
    with pytest.raises(SceneError, match=r"no visible light|zero everywhere"):
        spectra.photometric_density(Tabulated(np.array([200.0, 300.0]), np.array([1.0, 1.0])))


def test_white_of_the_stated_luminance_is_one():
    d65 = np.array([0.3127 / 0.3290, 1.0, (1 - 0.3127 - 0.3290) / 0.3290]) * 250.0
    assert np.allclose(scene_linear(d65, 250.0), 1.0, atol=2e-3)
    assert automatic_white(np.full(10, 18.0)) == pytest.approx(100.0)


def test_unit_factors_follow_their_definitions():
    assert units.intensity_from_flux_isotropic(4 * np.pi) == pytest.approx(1.0)
    # A hemisphere-filling sky: E = pi L.
    assert units.luminance_from_illuminance_disk(np.pi, np.pi / 2) == pytest.approx(1.0)
    # EV100 = 15: 1.2 * 2^15 cd/m2 saturates.
    assert units.luminance_from_ev100(15.0) == pytest.approx(39321.6)
    assert units.spot_solid_angle(np.pi / 2, 0.0) == pytest.approx(2 * np.pi)
    # As the spread closes to pi the light becomes Lambertian.
    assert units.spread_axis_factor(np.pi - 1e-3) == pytest.approx(1.0, abs=2e-3)
