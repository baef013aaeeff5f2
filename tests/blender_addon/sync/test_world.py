"""Units of Blender's world."""

import numpy as np
import pytest
from blender_objects import new_world
from conversion import measure_light

pytestmark = pytest.mark.usefixtures("extension")


def test_the_world_has_the_unit_that_is_stated():
    world, _ = new_world((1, 1, 1), 2.0)
    assert measure_light((0, 0, 0))[0] == pytest.approx(np.pi * 2 * 177.83, rel=2e-3)
    world.lumenray.unit = "LUMINANCE"
    assert measure_light((0, 0, 0))[0] == pytest.approx(np.pi * 2, rel=2e-3)
    world.lumenray.unit = "ILLUMINANCE"
    world.lumenray.illuminance = 5000.0
    assert measure_light((0, 0, 0))[0] == pytest.approx(5000.0, rel=2e-3)
