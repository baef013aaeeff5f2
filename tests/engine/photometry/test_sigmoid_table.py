"""Smooth spectra of colours, against Mitsuba's own look-up."""

import subprocess
import sys

import numpy as np
import pytest

from lumenray.engine.photometry.sigmoid_table import fetch_coefficients
from lumenray.engine.photometry.spectra import GRID

CORNERS = [(1, 0, 0), (0, 1, 1), (1, 1, 0), (0.2, 0.2, 0.1), (1e-5, 0, 1e-6), (0.999, 1, 1)]
GREY = [(0, 0, 0), (1, 1, 1), (0.5, 0.5, 0.5), (0.02, 0.02, 0.02)]


@pytest.mark.mitsuba
def test_spectra_are_those_of_mitsuba():
    import mitsuba as mi

    if mi.variant() is None:
        mi.set_variant("scalar_spectral")
    for colour in [*np.random.default_rng(1).random((200, 3)), *CORNERS, *GREY]:
        theirs = np.array(mi.srgb_model_fetch([float(x) for x in colour]), float).ravel()
        ours = np.array(fetch_coefficients(*map(float, colour)))
        # Those of black and white are infinite.
        values = [np.polyval(np.clip(each, -1e9, 1e9), GRID) for each in (ours, theirs)]
        values = [0.5 + 0.5 * x / np.sqrt(1.0 + x * x) for x in values]
        # Theirs are computed in single precision.
        np.testing.assert_allclose(*values, atol=1e-4)


def test_colours_do_not_load_mitsuba():
    asked = (
        "import sys; from lumenray.engine.photometry.spectra import GRID, upsample; "
        "from lumenray.engine.scene.spectrum import Rgb; upsample(Rgb(0.5, 0.2, 0.1), GRID); "
        "assert 'mitsuba' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", asked], check=True)
