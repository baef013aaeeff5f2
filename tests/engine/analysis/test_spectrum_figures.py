"""Figures of spectra, in closed form."""

import numpy as np
import pytest

from lumenray.engine.analysis.spectrum_figures import find_figures
from lumenray.engine.scene.spectrum import Tabulated


def test_figures_have_their_closed_forms():
    # Twice as much at 555 nm as at 300 nm: two thirds of the watts at 683 lm/W.
    nm = np.array([299.0, 300.0, 301.0, 554.0, 555.0, 556.0])
    made = find_figures(Tabulated(nm, np.array([0.0, 1.0, 0.0, 0.0, 2.0, 0.0])))
    assert made.ultraviolet == pytest.approx(1.0 / 3.0)
    assert made.visible == pytest.approx(2.0 / 3.0)
    assert made.centroid == pytest.approx(470.0)
    assert made.peak == 555.0
    assert made.efficacy == pytest.approx(683.0 * 2.0 / 3.0, rel=1e-3)
    grey = find_figures(Tabulated(np.array([300.0, 900.0]), np.array([0.25, 0.25])))
    assert grey.reflectance == pytest.approx(0.25)
    assert grey.infrared == pytest.approx(0.2)
    dark = find_figures(Tabulated(np.array([400.0, 700.0]), np.zeros(2)))
    assert (dark.peak, dark.chromaticity, dark.efficacy) == (None, None, 0.0)
