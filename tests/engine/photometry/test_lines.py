"""Emission lines: their photometry is that at the line itself, wherever it lies between full nanometres."""

import colour
import numpy as np
import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.photometry import spectra
from lumenray.engine.requirements.plan import make_plan
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Lines
from lumenray.engine.worker.codec import decode, encode

LUMENS_PER_WATT = 683.002
"""Luminous efficacy at the maximum of V in standard air, as CIE tables are scaled."""


def line(*wavelengths, powers=None):
    wavelengths = np.array(wavelengths)
    return Lines(wavelengths, np.ones(len(wavelengths)) if powers is None else np.array(powers))


def efficiency(nm):
    """V of an independent table of 1 nm steps, linear between."""
    table = colour.colorimetry.SDS_LEFS_PHOTOPIC["CIE 1924 Photopic Standard Observer"]
    return np.interp(nm, table.wavelengths, table.values)


@pytest.mark.parametrize("nm", [405.0, 436.0, 507.0, 546.1, 555.0, 589.3, 632.8, 700.0])
def test_efficacy_of_a_line_is_that_at_the_line(nm):
    assert spectra.efficacy(line(nm)) == pytest.approx(LUMENS_PER_WATT * efficiency(nm), rel=1e-6)


@pytest.mark.parametrize("nm", [360.0, 360.4, 589.0, 589.3, 589.5, 829.999, 830.0])
def test_a_line_keeps_its_whole_power(nm):
    values = spectra.evaluate_emission(line(nm, powers=[2.5]), spectra.GRID)
    assert spectra.integrate(values) == pytest.approx(2.5, rel=1e-12)
    assert np.count_nonzero(values) <= 2
    assert (values >= 0.0).all()


def test_lines_add_up_in_proportion_to_their_powers():
    # Sodium's doublet, 2 : 1.
    doublet = line(588.995, 589.592, powers=[2.0, 1.0])
    expected = LUMENS_PER_WATT * (2.0 * efficiency(588.995) + efficiency(589.592)) / 3.0
    assert spectra.efficacy(doublet) == pytest.approx(expected, rel=1e-6)


def test_two_lines_at_one_place_are_one_of_both_powers():
    twice = spectra.evaluate_emission(line(600.25, 600.25, powers=[1.0, 3.0]), spectra.GRID)
    once = spectra.evaluate_emission(line(600.25, powers=[4.0]), spectra.GRID)
    assert np.array_equal(twice, once)


def test_a_line_falls_to_nothing_within_one_nanometre():
    places = np.array([588.2, 588.8, 589.3, 589.8, 590.4])
    values = spectra.evaluate_emission(line(589.3), places)
    assert np.allclose(values, [0.0, 0.5, 1.0, 0.5, 0.0])


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        (line(359.9), "359.9 nm, expected a wavelength from 360 to 830"),
        (line(550.0, 831.0), "831 nm"),
        (line(np.nan), "lies at nan nm"),
        (line(550.0, powers=[-1.0]), "at 550 nm has the power -1"),
        (line(550.0, 600.0, powers=[1.0, np.nan]), "at 600 nm has the power nan"),
        (line(550.0, powers=[np.inf]), "the power inf"),
        (line(), r"at least one, .* shape \(0,\)"),
        (line(550.0, powers=[1.0, 2.0]), r"shape \(1,\) and \(2,\)"),
        (Lines(np.ones((2, 2)), np.ones((2, 2))), r"a row of .* shape \(2, 2\)"),
    ],
)
def test_unusable_lines_are_refused_in_words(lines, words):
    with pytest.raises(SceneError, match=words):
        spectra.evaluate_emission(lines, spectra.GRID)


def test_lines_without_power_are_refused_as_any_dark_spectrum():
    with pytest.raises(SceneError, match="zero everywhere"):
        spectra.efficacy(line(550.0, powers=[0.0]))


def test_lines_are_no_reflectance():
    with pytest.raises(SceneError, match="a Lines is a light, not a reflectance"):
        spectra.evaluate_reflectance(line(550.0), spectra.GRID)


def test_lines_travel_to_the_engine_and_back():
    sent = line(588.995, 589.592, powers=[2.0, 1.0])
    tree, parts, size = encode(sent)
    block = bytearray(size)
    for offset, array in parts:
        block[offset : offset + array.nbytes] = array.tobytes()
    got = decode(tree, bytes(block))
    assert isinstance(got, Lines)
    assert np.array_equal(got.wavelengths, sent.wavelengths)
    assert np.array_equal(got.powers, sent.powers)


def test_lamps_of_the_same_lines_count_as_one_spectrum_and_others_do_not():
    from lumenray.engine.scene.scene import Scene

    def lamp(key, spectrum):
        output = Output(Quantity.RADIANT_FLUX, 1.0, spectrum)
        return PointLight(key, key, output, np.zeros(3))

    scene = Scene()
    scene.apply(SceneDelta(changed=(lamp("a", line(589.3)), lamp("b", line(589.3)))))
    assert not make_plan(scene).spectral
    scene.apply(SceneDelta(changed=(lamp("b", line(546.1)),)))
    assert make_plan(scene).spectral
    first = scene.hash()
    scene.apply(SceneDelta(changed=(lamp("b", line(546.2)),)))
    assert scene.hash() != first
