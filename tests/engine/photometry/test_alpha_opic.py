"""Alpha-opic quantities against figures of the CIE's toolbox."""

import numpy as np
import pytest

from lumenray.engine.photometry.alpha_opic import (
    MELANOPIC,
    RECEPTORS,
    alpha_opic,
    daylight_ratios,
    equivalent_daylight,
)
from lumenray.engine.photometry.spectra import GRID, illuminant, photometric_density
from lumenray.engine.scene.spectrum import Illuminant

TOOLBOX = {
    "s_cone": 0.8173,
    "m_cone": 1.4558,
    "l_cone": 1.6289,
    "rhodopic": 1.4497,
    "melanopic": 1.3262,
}
"""Alpha-opic efficacies of luminous radiation of D65. (CIE S 026:2018, table 2) [mW/lm]"""


def test_ratios_of_daylight_are_those_of_the_standard():
    wanted = [TOOLBOX[name] for name in RECEPTORS]
    assert np.allclose(1000.0 * daylight_ratios(), wanted, atol=5e-5)


def test_a_melanopic_irradiance_of_the_toolbox_is_as_much_daylight():
    """52.3937 mW/m2 are 39.51 lx of melanopic equivalent daylight by the toolbox."""
    receptors = np.zeros(5)
    receptors[MELANOPIC] = 52.3937e-3
    assert equivalent_daylight(receptors)[MELANOPIC] == pytest.approx(39.51, abs=0.005)


def test_a_hundred_lux_of_daylight_act_as_a_hundred_lux():
    irradiance = 100.0 * photometric_density(Illuminant("D65"))
    assert np.allclose(equivalent_daylight(alpha_opic(irradiance)), 100.0)


def test_light_beyond_the_action_spectra_does_not_act():
    assert (alpha_opic(np.where((GRID < 380.0) | (GRID > 780.0), 1.0, 0.0)) == 0.0).all()


def test_several_spectra_are_taken_at_once():
    both = np.stack([illuminant(GRID, "A"), illuminant(GRID, "FL11")])
    assert np.allclose(alpha_opic(both)[1], alpha_opic(both[1]))
