"""Fibres: what they send on by closed forms, and nothing more than comes."""

import numpy as np
import pytest
from scipy.integrate import trapezoid

from lumenray.engine.materials.facets import COSINES
from lumenray.engine.materials.fibres import NODES, lobes_of, sent_on

ROOTS = np.linspace(0.0, 1.0, COSINES)


def test_lobes_of_microfibres_stay_within_what_is_possible():
    for roughness in (0.0, 0.1, 0.33, 0.5, 0.8, 1.0):
        a, _, share = lobes_of(roughness)
        assert a.min() > 0.0
        assert share.min() >= 0.0
        assert share.max() < 0.8


def test_the_mean_of_both_ways_sends_on_as_much_as_the_lobes():
    for roughness in (0.3, 0.6, 1.0):
        own = sent_on(roughness, False)
        lobes = np.interp(ROOTS**2, np.linspace(0.0, 1.0, NODES), lobes_of(roughness)[2])
        means = [trapezoid(values * 4.0 * ROOTS**3, ROOTS) for values in (own, lobes)]
        assert means[0] == pytest.approx(means[1], rel=0.01)


def test_rougher_microfibres_shine_more_and_at_steeper_angles():
    smooth, rough = sent_on(0.3, False), sent_on(0.9, False)
    assert smooth[-1] < 0.01
    assert rough[-1] > 0.2
    assert np.all(np.diff(smooth[1:]) < 0.0)


def test_no_velvet_sends_on_more_than_comes():
    for roughness in (0.05, 0.3, 0.7, 1.0):
        assert sent_on(roughness, True).max() <= 1.0


def test_velvet_seen_along_its_normal_is_its_closed_form():
    """There t is half the angle of what leaves, and no fibre shades another up to 60 degrees of t."""
    roughness = 0.8
    theta = np.linspace(1e-4, np.pi / 2, 20001)
    t = 0.5 * theta
    facets = np.exp(-1.0 / (roughness * np.tan(t)) ** 2) / (np.pi * roughness**2 * np.sin(t) ** 4)
    shade = np.minimum(1.0, 2.0 * np.cos(theta))
    expected = trapezoid(facets * shade / 4.0 * 2.0 * np.pi * np.sin(theta), theta)
    assert sent_on(roughness, True)[-1] == pytest.approx(expected, rel=2e-3)
