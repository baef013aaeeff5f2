"""Pictures of the surroundings in the world's panels: loaded, analysed, mended, and the time read off their sun."""

import math

import bpy
import numpy as np
import pytest
from blender_objects import pixels_of
from panels import context, draw
from picture_worlds import image_of, show
from radiance_files import write_picture

from lumenray.benchmarks.environment.drawn_maps import Spot, make_map
from lumenray.blender_addon.daylight.moment import find_moment
from lumenray.blender_addon.environment.found import analyse_world
from lumenray.engine.sky.cie import sun_direction
from lumenray.operators.environment_picture import LUMENRAY_OT_pick_sky as Pick


def sunny(light=1.0, elevation=40.0, azimuth=120.0):
    return make_map(128, [Spot(elevation, azimuth, 3.0, light)], sky=1.0, ground=0.2)


@pytest.fixture
def world():
    """Return a world with a picture whose sun gives a third of what its sky does."""
    return show(image_of(sunny()))[0]


def test_the_panel_says_what_the_picture_holds(world):
    where = context(world=world)
    seen = draw("LUMENRAY_PT_world_picture", where)
    assert "use_sources" in seen
    assert "repair" not in seen
    world.lumenray.unit = "LUMINANCE"
    assert bpy.ops.lumenray.analyse_environment() == {"FINISHED"}
    seen = draw("LUMENRAY_PT_world_picture", where)
    assert {"Horizontal", "Sun : Rest", "Range", "Sun"} <= set(seen)
    assert any("A sun or a lamp clipped at 1 : 5" in text for text in seen)
    # It is 3 degrees wide.
    assert any("Lamp or sun?" in text for text in seen)
    # pi lx by the sky, and a little less than the sun's sine.
    given = next(text for text in seen if text.endswith("lx") and "°" not in text)
    assert float(given.split("\u2009")[0].split(" ")[0]) == pytest.approx(3.78, abs=0.03)
    image = bpy.data.images["Sky Sources"]
    assert tuple(image.size) == (1024, 760)
    assert len(np.unique(pixels_of(image))) > 10
    # What has changed since is said.
    world.lumenray.environment.use_sources = True
    seen = draw("LUMENRAY_PT_world_picture", where)
    assert any("analyse again" in text for text in seen)
    assert {"sun", "repair", "half", "lumenray.time_from_sun"} <= set(seen)
    world.lumenray.environment.repair = "RATIO"
    assert "sun_ratio" in draw("LUMENRAY_PT_world_picture", where)
    bpy.ops.lumenray.analyse_environment(use_picture=False)
    seen = draw("LUMENRAY_PT_world_picture", where)
    assert {"As Rendered", "By Lights", "Mended Sun", "4 : 1"} <= set(seen)
    assert not any("analyse again" in text for text in seen)
    assert "edge_factor" in draw("LUMENRAY_PT_world_picture_limits", where)


def test_before_and_after_a_repair_differ_as_they_should(world):
    """Mended by four times the sky, the whole is five times the sky's pi lx."""
    world.lumenray.unit = "LUMINANCE"
    own = world.lumenray.environment
    own.use_sources, own.repair = True, "RATIO"
    made = analyse_world(world, 177.83)
    assert made.lights == pytest.approx(4.0 * made.picture, rel=1e-4)
    assert made.picture == pytest.approx(math.pi, rel=0.05)
    assert made.analysis.horizontal == pytest.approx(3.78, abs=0.03)


def test_a_world_without_a_picture_says_so(world):
    bpy.context.scene.world = bpy.data.worlds.new("Plain")
    with pytest.raises(RuntimeError, match="show no picture"):
        bpy.ops.lumenray.analyse_environment()
    bpy.context.scene.world.lumenray.source = "CIE"
    assert not bpy.ops.lumenray.analyse_environment.poll()


def test_time_and_north_follow_from_the_sun(world):
    """At the time that is found the sun of place and time stands where the picture shows it."""
    own = world.lumenray
    own.time.month, own.time.day = 5, 20
    for half, is_morning in (("MORNING", True), ("AFTERNOON", False)):
        own.environment.half = half
        assert bpy.ops.lumenray.time_from_sun() == {"FINISHED"}
        assert (own.time.hour < 13.0) == is_morning
        moment = find_moment(world, 1)
        shown = sun_direction(math.radians(40.0), math.radians(120.0))
        assert math.degrees(math.acos(min(moment.towards_sun @ shown, 1.0))) < 0.2
    own.time.month, own.time.day = 12, 21
    with pytest.raises(RuntimeError, match="stands 40"):
        bpy.ops.lumenray.time_from_sun()


def test_the_unit_shows_what_belongs_to_it(world):
    where = context(world=world)
    world.lumenray.unit = "WHITE"
    assert "white" in draw("LUMENRAY_PT_world_unit", where)
    world.lumenray.unit = "ILLUMINANCE"
    assert {"illuminance", "meter_elevation"} <= set(draw("LUMENRAY_PT_world_unit", where))


def test_a_file_is_loaded_into_the_world_and_a_damaged_one_refused(world, tmp_path):
    path = tmp_path / "outside.hdr"
    content = write_picture(sunny()[::2, ::2])
    path.write_bytes(content)
    assert bpy.ops.lumenray.load_environment(filepath=str(path)) == {"FINISHED"}
    node = next(n for n in world.node_tree.nodes if n.type == "TEX_ENVIRONMENT")
    assert node.image.name == "outside.hdr"
    bpy.context.scene.world = None
    bpy.ops.lumenray.load_environment(filepath=str(path))
    made = bpy.context.scene.world
    assert made.name == "outside"
    made.lumenray.environment.use_sources = True
    assert bpy.ops.lumenray.analyse_environment() == {"FINISHED"}
    broken = tmp_path / "broken.exr"
    broken.write_bytes(b"no picture")
    with pytest.raises(RuntimeError, match=r"broken\.exr"):
        bpy.ops.lumenray.load_environment(filepath=str(broken))
    assert "broken.exr" not in bpy.data.images
    with pytest.raises(RuntimeError, match=r"none\.hdr"):
        bpy.ops.lumenray.load_environment(filepath=str(tmp_path / "none.hdr"))


def test_the_sky_is_picked_in_the_image_editor(world):
    """The panel stands there while a place of the sky is needed; clicks below the horizon are refused."""
    own = world.lumenray.environment
    assert draw("LUMENRAY_PT_image_sky", context(world=world)) is None
    own.repair = "MODEL"
    assert "lumenray.pick_sky" in draw("LUMENRAY_PT_image_sky", context(world=world))

    class Clicked:
        said = []

        def report(self, kind, text):
            self.said.append(text)

    clicked = Clicked()
    assert Pick.pick(clicked, context(), 0.25, 0.8) == {"FINISHED"}
    assert tuple(own.sky_point) == pytest.approx((0.25, 0.8))
    assert Pick.pick(clicked, context(), 0.25, 0.3) == {"CANCELLED"}
    assert "upper half" in clicked.said[0]
