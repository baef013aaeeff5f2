"""Light behind filters beside sums over the spectra of single colours."""

import numpy as np
import pytest

from lumenray.engine.photometry.colour import REC709_LUMINANCE
from lumenray.engine.photometry.filtered_light import filtered_luminance
from lumenray.engine.photometry.spectra import (
    GRID,
    evaluate_emission,
    luminous_efficiency,
    upsample,
)
from lumenray.engine.scene.spectrum import Blackbody, Illuminant, Rgb

COLOURS = np.random.default_rng(1).random((200, 3)) ** 2 * 3.0


def test_white_light_has_the_luminance_of_the_colours():
    found = filtered_luminance(COLOURS.reshape(20, 10, 3), Illuminant("D65"))
    expected = (COLOURS @ REC709_LUMINANCE).reshape(20, 10)
    assert found == pytest.approx(expected, abs=0.005 * 3.0)


@pytest.mark.parametrize("spectrum", [Illuminant("A"), Blackbody(2000.0), Illuminant("FL1")])
def test_other_lamps_are_filtered_wavelength_by_wavelength(spectrum):
    seen = evaluate_emission(spectrum, GRID) * luminous_efficiency()
    found = filtered_luminance(COLOURS, spectrum)
    for colour, luminance in zip(COLOURS, found, strict=True):
        largest = colour.max()
        single = upsample(Rgb(*(colour / largest).tolist()), GRID) @ seen / seen.sum()
        assert luminance == pytest.approx(largest * single, abs=0.005 * largest)


def test_black_filters_let_nothing_pass():
    assert filtered_luminance(np.zeros((2, 3)), Illuminant("A")).tolist() == [0.0, 0.0]
