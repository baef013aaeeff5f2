"""Scattering files from the wild, beside each other and beside what they were made of."""

import numpy as np
import pytest
from folders import WILD
from scattering_models import towards
from scattering_readings import read_back, told

from lumenray.engine.errors import FileFormatError
from lumenray.engine.scattering.data.evaluation import total
from lumenray.engine.scattering.data.table import albedo_of, direction_of, evaluate_table
from lumenray.engine.scattering.readers.speos import read_speos

DATA = WILD / "bsdf"

needs_data = pytest.mark.skipif(not DATA.is_dir(), reason="needs ../shared/data/bsdf")


def real(name: str):
    return read_back((DATA / name).read_bytes())


def differences(one, other, incidence, steepest):
    """Factor between two tables about the mirror direction, and deviation from it root mean square, also if mirrored."""
    rng = np.random.default_rng(1)
    radial, azimuth = np.radians(steepest) * rng.random(20000), 2.0 * np.pi * rng.random(20000)
    wo = direction_of(np.full(20000, incidence), radial, azimuth)
    wo = wo[wo[:, 2] > np.cos(np.radians(80.0))]
    wi = np.broadcast_to(towards(np.degrees(incidence), 0.0), wo.shape)
    a, b, c = (
        evaluate_table(table, wi, directions)[:, 0]
        for table, directions in ((one, wo), (other, wo), (other, wo * [1.0, -1.0, 1.0]))
    )
    factor = np.median(b / a)
    rms = np.sqrt((a**2).mean())
    return factor, *(np.sqrt(((each / factor - a) ** 2).mean()) / rms for each in (b, c))


@needs_data
def test_a_measured_paint_of_zemax_has_its_totals_by_itself():
    """The sphere that measured it integrated the values that it wrote, held where it saw nothing."""
    file = real("zemax/planesymmetric_brdf.bsdf")
    assert told(file).count("|") == 0
    assert "no values farther than 80 degrees from the mirror direction" in told(file)
    assert len(file.incidences) == 13
    assert file.stated["front_reflection"][0] == pytest.approx(0.134506)


@needs_data
def test_a_sample_has_the_same_handedness_in_zemax_and_speos():
    one = real("zemax/asymmetrical_one_wavelength_BRDF.bsdf").sides["front_reflection"]
    data = (DATA / "speos/one_wavelength.brdf").read_bytes()
    # The error of resampling must not hide how near the two files are.
    other = read_speos(data, "one_wavelength.brdf", 0.005).sides["front_reflection"]
    found = np.array([differences(one, other, incidence, 80.0) for incidence in one.incidences])
    np.testing.assert_allclose(found[:, 0], 1.0, atol=0.02)
    assert found[:, 1].max() < 0.02
    assert found[:, 1].sum() < 0.6 * found[:, 2].sum()


@needs_data
def test_a_converted_paint_is_what_it_was_made_of():
    one = real("zemax/planesymmetric_brdf.bsdf").sides["front_reflection"]
    other = real("speos/planesymmetric_brdf_reference.anisotropicbsdf").sides["front_reflection"]
    np.testing.assert_allclose(other.incidences, one.incidences, atol=1e-9)
    for k in (0, 3, 6):
        incidence = one.incidences[k]
        # The converter has nothing where the values of the other hold, so the rest of the same light is brighter.
        factor, off, _ = differences(one, other, incidence, 40.0)
        assert 1.0 < factor < 1.2
        assert off < 0.02
        share = albedo_of(other, incidence)[0] / albedo_of(one, incidence)[0]
        assert share == pytest.approx(1.0, abs=0.01)


@needs_data
def test_real_binary_and_text_files_of_speos_hold_the_same():
    text = real("speos/aniso_bsdf.anisotropicbsdf").sides["front_reflection"]
    binary = real("speos/R_test.anisotropicbsdf").sides["front_reflection"]
    np.testing.assert_array_equal(binary.values, text.values)
    # The spectrum is for 6 degrees.
    at_five, at_ten = (total(text, np.radians(s))[0] for s in (5.0, 10.0))
    assert 0.8 * at_five + 0.2 * at_ten == pytest.approx(0.6227, rel=3e-3)


@needs_data
def test_real_coatings_agree_between_both_files():
    one, both = real("speos/coating_air_substrate.coated"), real("speos/coating_reference.bsdf180")
    for side in ("front_reflection", "front_transmission"):
        np.testing.assert_allclose(one.sides[side].direct, both.sides[side].direct, atol=1e-6)
    # From inside the glass all light is reflected beyond the critical angle, 41.2 degrees for n = 1.5168.
    back = both.sides["back_transmission"]
    assert back.direct[0, back.incidences > np.radians(42.0)].max() == 0.0
    assert back.direct[0, back.incidences < np.radians(40.0)].min() > 0.3


@needs_data
def test_a_measured_car_paint_is_red_and_reflects_less_than_all(monkeypatch):
    # A coarse table has the same light, and is made sooner.
    monkeypatch.setattr("lumenray.engine.scattering.readers.slices.MOST_NODES", 1 << 13)
    table = real("mdl/carpaint_red.mbsdf").sides["front_reflection"]
    for incidence in table.incidences[::11]:
        share = total(table, incidence)
        assert share.max() < 0.3
        assert share[-1] > 1.5 * np.interp(540.0, table.wavelengths, share)


@needs_data
def test_real_files_that_are_no_scattering_are_refused():
    for name in (
        "zemax/coating_zemax.dat",
        "mdl/test_none.mbsdf",
        "mdl/test_file_format_error.mbsdf",
    ):
        with pytest.raises(FileFormatError):
            real(name)
