"""Scenes without what pictures live of: no light, nothing matt, nothing at all. They end by every rule."""

import numpy as np
import pytest
from small_pictures import ROOM, lamp, look_in, picture_of
from small_scenes import paint

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import UniformWorld
from lumenray.engine.scene.material import Glossy, Material
from lumenray.engine.scene.spectrum import Constant

pytestmark = pytest.mark.mitsuba

VIEW = look_in(16, 12)
HIDDEN = lamp(1.5, -3.0)
"""Lamp outside the room."""

DARK = {
    "nothing": (),
    "no light": (ROOM, paint(0.5)),
    "black without lamps in view": (ROOM, paint(0.0), HIDDEN),
}
LIT = {
    "nothing but sky": (UniformWorld(100.0),),
    "black": (ROOM, paint(0.0), lamp()),
    "nothing matt": (ROOM, Material("paint", "paint", Glossy(Constant(0.8), 0.3)), lamp()),
}
RULES = {
    "error": StopRule(error=0.05),
    "1 sample": StopRule(samples=1),
    "3 samples": StopRule(samples=3),
    "1000 samples": StopRule(samples=1000),
    "time": StopRule(seconds=0.2),
}


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("method", ["cells", "paths"])
@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("scene", DARK)
def test_dark_pictures_end(scene, rule, method):
    made = picture_of(DARK[scene], RULES[rule], method, view=VIEW)
    assert not made.tristimulus.any()
    assert not made.luminance_error.any()


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("method", ["cells", "paths"])
@pytest.mark.parametrize("rule", RULES)
@pytest.mark.parametrize("scene", LIT)
def test_pictures_of_odd_scenes_end(scene, rule, method):
    made = picture_of(LIT[scene], RULES[rule], method, view=VIEW)
    assert np.isfinite(made.tristimulus).all()
    assert made.tristimulus[..., 1].mean() > 0.0
    if scene == "nothing but sky":
        np.testing.assert_allclose(made.tristimulus[..., 1], 100.0, rtol=1e-3)


def test_cells_change_nothing_where_nothing_is_matt():
    by_cells, by_paths = (
        picture_of(LIT["nothing matt"], 16, each, view=VIEW) for each in ("cells", "paths")
    )
    np.testing.assert_array_equal(by_cells.tristimulus, by_paths.tristimulus)
