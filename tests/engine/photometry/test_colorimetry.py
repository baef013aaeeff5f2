"""Chromaticities, L*a*b* and colour differences against colour-science and their definitions."""

import warnings

import numpy as np
import pytest

from lumenray.engine.photometry.colour import chromaticity, cie_lab, colour_difference

with warnings.catch_warnings():
    warnings.simplefilter("ignore")
    colour = pytest.importorskip("colour")

A_WHITE = np.array([109.850, 100.0, 35.585])
"""CIE illuminant A, 2 degree observer. (CIE 15:2018, table T.3)"""


def samples():
    """Colours from black to the white, through the linear part near black."""
    rng = np.random.default_rng(3)
    bright = rng.uniform(0.0, 1.0, (40, 3)) * A_WHITE
    return np.concatenate([bright, 0.009 * bright, np.zeros((1, 3)), A_WHITE[None]])


def test_lab_is_that_of_colour_science():
    expected = colour.XYZ_to_Lab(samples() / 100.0, colour.XYZ_to_xy(A_WHITE / 100.0))
    # colour-science takes the white by its chromaticity.
    assert np.allclose(cie_lab(samples(), A_WHITE), expected, atol=1e-9)


def test_white_and_black_have_their_defined_lightness():
    assert np.allclose(cie_lab(A_WHITE, A_WHITE), [100.0, 0.0, 0.0])
    assert np.allclose(cie_lab(np.zeros(3), A_WHITE), 0.0)


def test_lab_does_not_jump_at_the_bend():
    bend = A_WHITE * (24.0 / 116.0) ** 3
    low, high = cie_lab(bend * (1.0 - 1e-9), A_WHITE), cie_lab(bend * (1.0 + 1e-9), A_WHITE)
    assert np.allclose(low, high, atol=1e-6)
    # L* = 8 is the bend by its definition.
    assert low[0] == pytest.approx(8.0, abs=1e-6)


def test_chromaticities_are_those_of_colour_science():
    xyz = samples()[:40]
    assert np.allclose(chromaticity(xyz), colour.XYZ_to_xy(xyz), atol=1e-12)


def test_black_has_no_chromaticity():
    assert np.isnan(chromaticity(np.zeros((2, 3)))).all()


def test_colour_difference_is_that_of_1976():
    lab = cie_lab(samples(), A_WHITE)
    expected = colour.delta_E(lab[:40], lab[1:41], method="CIE 1976")
    assert np.allclose(colour_difference(lab[:40], lab[1:41]), expected)
    assert colour_difference([50.0, 3.0, 4.0], [50.0, 0.0, 0.0]) == pytest.approx(5.0)
