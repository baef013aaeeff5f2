"""Luminance meters before surfaces of a known luminance."""

import numpy as np
import pytest
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.luminance_meter import find_weights, measure_luminance
from lumenray.engine.scene.light import UniformWorld
from lumenray.engine.scene.material import Diffuse, Emission, Material
from lumenray.engine.scene.spectrum import Constant

pytestmark = pytest.mark.mitsuba


def glowing(luminance, name):
    return Material(name, name, Diffuse(Constant(0.0)), emission=Emission(Constant(1.0), luminance))


def test_weights_are_those_of_the_solid_angle_of_a_cone():
    for angle in (0.01, 1.0):
        weights = find_weights(angle)
        assert weights.sum() == pytest.approx(1.0)
        assert weights[0, 0] == 0.0
    # Of equal areas of the film those aside are seen under smaller angles.
    assert weights[12, 2] < 0.8 * weights[12, 12]


def test_a_meter_reads_the_mean_within_its_cone():
    """A wall of 300 cd/m2 whose upper half has 100: half of the cone each, and one alone where it is narrow."""
    session = session_of(
        quad("low", (-5, 2, -5), (0, 0, 5), (10, 0, 0), "bright"),
        quad("high", (-5, 2, 0), (0, 0, 5), (10, 0, 0), "dim"),
        glowing(300.0, "bright"),
        glowing(100.0, "dim"),
    )
    places = [(0.0, 0.0, 0.0), (0.0, 0.0, -0.3), (0.0, 0.0, 0.3)]
    axes = [(0.0, 1.0, 0.0)] * 3
    found = measure_luminance(
        session, places, axes, np.deg2rad(10.0), StopRule(each=0.01, floor=1.0)
    )
    np.testing.assert_allclose(found.luminance, [200.0, 300.0, 100.0], rtol=0.01)
    assert (found.standard_error <= 0.011 * found.luminance).all()


def test_a_meter_reads_what_a_matt_surface_reflects():
    """Under an even sky a surface of 50 % has half of its luminance."""
    session = session_of(
        quad("floor", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "paint"), paint(0.5), UniformWorld(1000.0)
    )
    rule = StopRule(each=0.005, floor=1.0)
    found = measure_luminance(session, [(0, -0.5, 1.0)], [(0, 0.5, -1.0)], np.deg2rad(1.0), rule)
    assert abs(found.luminance[0] - 500.0) < 4.0 * found.standard_error[0] + 0.1
    assert found.standard_error[0] < 3.0
    with pytest.raises(SceneError, match="acceptance angle"):
        measure_luminance(session, [(0, 0, 1)], [(0, 0, -1)], 0.0, rule)
