"""Layers of light groups: parts of a map that add up to it."""

import numpy as np
import pytest
from baking_rooms import bake, furnished_room, lamp
from small_scenes import box, paint, quad, session_of

from lumenray.engine.baking.light_layers import split_lights
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.light import UniformWorld
from lumenray.engine.scene.light_groups import LightGroup
from lumenray.engine.scene.material import Emission
from lumenray.engine.scene.spectrum import Constant

LAMPS = (lamp((0.6, 0.7, 1.5), 700.0, name="a"), lamp((1.4, 0.4, 1.2), 300.0, name="b"))
GLOW = paint(0.2, "glow", emission=Emission(Constant(1.0), 60.0))
PANEL = quad("panel", (0.4, 1.2, 1.95), (0, 0.6, 0), (0.6, 0, 0), "glow")
ROOM = (*furnished_room(), PANEL, paint(0.5), GLOW)


def scene_of(*items):
    return session_of(*items).scene


def shining(scene):
    glowing = {key for key, item in scene.materials.items() if item.emission is not None}
    return {*scene.lights, *glowing, *({"world"} if scene.world is not None else set())}


def test_every_light_shines_in_one_layer():
    scene = scene_of(*ROOM, *LAMPS, UniformWorld(10.0))
    groups = (LightGroup("lamps", ("a", "glow")), LightGroup("day", ("world",)))
    layers = split_lights(scene, groups)
    assert [name for name, _ in layers] == ["lamps", "day", "rest"]
    assert [shining(each) for _, each in layers] == [{"a", "glow"}, {"world"}, {"b"}]
    for _, each in layers:
        assert set(each.meshes) == set(scene.meshes)
        assert each.materials["glow"].surface is scene.materials["glow"].surface


def test_groups_that_shine_nowhere_have_no_layer_and_a_rest_only_if_there_is_one():
    scene = scene_of(*ROOM, *LAMPS)
    groups = (LightGroup("all", ("a", "b", "glow")), LightGroup("none", ("world", "gone")))
    assert [name for name, _ in split_lights(scene, groups)] == ["all"]


@pytest.mark.parametrize(
    ("groups", "text"),
    [
        ((LightGroup("x", ("a",)), LightGroup("y", ("a",))), "can be in one"),
        ((LightGroup("x", ("a",)), LightGroup("x", ("b",))), "names of their own"),
        ((LightGroup("rest", ("a",)),), "names of their own"),
    ],
)
def test_groups_that_make_no_sense_are_refused(groups, text):
    with pytest.raises(SceneError, match=text):
        split_lights(scene_of(*ROOM, *LAMPS), groups)


@pytest.mark.slow
@pytest.mark.mitsuba
def test_layers_add_up_and_each_is_the_light_of_its_lamps_alone():
    objects, (one, other) = ("room", "block"), LAMPS
    groups = (LightGroup("one", ("a",)), LightGroup("glow", ("glow",)))
    made = bake((*ROOM, *LAMPS), objects, 64, groups=groups)
    (page,) = made.pages
    assert list(page.layers) == ["one", "glow", "rest"]
    known = page.covered
    total = sum(layer[known].astype(float) for layer in page.layers.values())
    # Both are matched along seams in proportion, so by what rounding leaves of it.
    np.testing.assert_allclose(total, page.illuminance[known], rtol=1e-5)
    off = paint(0.2, "glow")
    area = page.area[known]
    # Each alone, with random numbers of its own; the three together have more error than each.
    for name, lights in (("one", (one, off)), ("rest", (other, off)), ("glow", (GLOW,))):
        alone = bake((*ROOM[:-1], *lights), objects, 64, seed=9)
        expected, error = alone.pages[0].illuminance[known], alone.pages[0].standard_error[known]
        gap = page.layers[name][known].astype(float) - expected
        lit = error > 0.0
        # Like estimates have like errors, but samples are spread by those of their own layer.
        assert 0.8 < np.sqrt(np.mean(gap[lit] ** 2) / np.mean(2.0 * error[lit] ** 2)) < 1.3
        mean = float((gap * area).sum() / (expected * area).sum())
        assert abs(mean) < 0.02
    whole = bake((*ROOM, *LAMPS), objects, 64, seed=5)
    spread = np.hypot(whole.pages[0].standard_error, page.standard_error)[known]
    z = (whole.pages[0].illuminance - page.illuminance)[known][spread > 0.0] / spread[spread > 0.0]
    assert 0.85 < np.sqrt(np.mean(np.clip(z, -5, 5) ** 2)) < 1.2


@pytest.mark.mitsuba
def test_a_lamp_beyond_a_wall_is_a_layer_of_darkness():
    """Two closed boxes with a lamp each: what belongs to the other has no part in the light, nor in the error."""
    near, far = box(1.0, 1.0, 1.0), lamp((5.5, 0.5, 0.5), name="b")
    inside = lamp((0.5, 0.5, 0.5), name="a")
    groups = (LightGroup("near", ("a",)), LightGroup("far", ("b",)))
    (page,) = bake((near, paint(0.3), inside, far), ("box",), 32, groups=groups).pages
    assert page.layers["near"][page.covered].min() > 0.0
    assert page.layers["far"].max() == 0.0
