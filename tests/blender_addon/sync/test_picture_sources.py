"""Bright sources of a world's picture as lights of their own: illuminances, shadows, and suns mended."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from conversion import converted_scene
from picture_worlds import image_of, show

from lumenray.benchmarks.environment.drawn_maps import Spot, make_map
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import ImageWorld, SunLight
from lumenray.engine.scene.texture import Pixels
from lumenray.engine.session import Session
from lumenray.engine.sky.picture import find_illuminance

UP = np.array([0.0, 0.0, 1.0])


def sunny(light=40.0, **options):
    """A map of an even sky of luminance 1 over a ground of 0.2 with a sun at 40 degrees; light facing it: ``light``."""
    return make_map(128, [Spot(40.0, 120.0, 2.5, light)], sky=1.0, ground=0.2, **options)


def parts():
    """World, suns and report of the scene."""
    converted = converted_scene()
    (world,) = [item for item in converted.delta.changed if isinstance(item, ImageWorld)]
    pixels = {item.id: item.values for item in converted.delta.changed if isinstance(item, Pixels)}
    image = world.image
    if isinstance(image.pixels, str):
        image = replace(image, pixels=pixels[image.pixels])
    suns = [item for item in converted.delta.changed if isinstance(item, SunLight)]
    said = " | ".join(f"{row.message}; {row.remedy}" for row, _ in converted.report.rows)
    return replace(world, image=image), suns, said


def horizontal(world, suns):
    """Horizontal illuminance by the picture and by the lights. [lx]"""
    by_picture = world.luminance_per_unit * find_illuminance(world.image, world.rotation, UP)
    return by_picture, sum(sun.output.value * max(-sun.direction[2], 0.0) for sun in suns)


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.0, 0.0, 2.0), (0.2, -0.1, 1.0)])
def test_a_sun_becomes_a_light_and_the_illuminance_stays(turn):
    world, node = show(image_of(sunny()), turn)
    world.lumenray.unit = "LUMINANCE"
    before, suns, _ = parts()
    assert suns == []
    world.lumenray.environment.use_sources = True
    after, suns, _ = parts()
    (sun,) = suns
    assert sum(horizontal(after, suns)) == pytest.approx(horizontal(before, [])[0], rel=1e-5)
    # Where the nodes show it: from the world's directions to the picture's.
    towards = before.rotation.T @ Spot(40.0, 120.0).towards
    # A tenth of a pixel.
    assert np.degrees(np.arccos(-sun.direction @ towards)) < 0.1 * 180.0 / 128.0
    assert np.degrees(sun.angle) == pytest.approx(0.533, abs=0.01)
    assert node.image.size[0] == 256


def test_both_units_and_the_strength_hold_for_picture_and_lights():
    world, _ = show(image_of(sunny()))
    world.lumenray.environment.use_sources = True
    own = world.lumenray
    own.unit, own.illuminance = "ILLUMINANCE", 50000.0
    assert sum(horizontal(*parts()[:2])) == pytest.approx(50000.0, rel=1e-5)
    # A meter that faces the sun.
    own.environment.meter_elevation = np.radians(40.0)
    own.environment.meter_azimuth = np.radians(120.0)
    shown, suns, _ = parts()
    normal = Spot(40.0, 120.0).towards
    facing = shown.luminance_per_unit * find_illuminance(shown.image, shown.rotation, normal)
    facing += suns[0].output.value * max(-suns[0].direction @ normal, 0.0)
    assert facing == pytest.approx(50000.0, rel=1e-5)
    own.unit = "RADIANCE"
    radiance = sum(horizontal(*parts()[:2]))
    own.unit, own.white = "WHITE", 2.0 * 179.0
    assert sum(horizontal(*parts()[:2])) == pytest.approx(2.0 * radiance, rel=1e-5)
    background = next(n for n in world.node_tree.nodes if n.type == "BACKGROUND")
    background.inputs["Strength"].default_value = 0.5
    assert sum(horizontal(*parts()[:2])) == pytest.approx(radiance, rel=1e-5)


def test_a_sun_is_mended_by_the_sky():
    world, _ = show(image_of(sunny(0.5)))
    own = world.lumenray
    own.unit, own.environment.use_sources = "LUMINANCE", True
    sky, sun = horizontal(*parts()[:2])
    assert sun < 0.5 * sky
    own.environment.repair = "RATIO"
    sky, sun = horizontal(*parts()[:2])
    assert sun == pytest.approx(4.0 * sky, rel=1e-5)
    own.environment.sun_ratio = 2.5
    own.unit, own.illuminance = "ILLUMINANCE", 7000.0
    sky, sun = horizontal(*parts()[:2])
    assert (sky, sun) == pytest.approx((2000.0, 5000.0), rel=1e-5)
    # Lamps are never mended.
    own.environment.sun = "NONE"
    _, suns, said = parts()
    assert "shows no sun to mend" in said
    assert "bright source" in suns[0].name


def test_a_sun_is_mended_by_a_place_of_the_sky():
    world, _ = show(image_of(sunny(0.5)))
    own = world.lumenray
    own.unit, own.environment.use_sources = "LUMINANCE", True
    own.environment.repair = "MODEL"
    _, suns, said = parts()
    assert "no place of the sky is picked" in said
    plain = suns[0].output.value
    # 60 degrees high, opposite the sun: u counts against the azimuth from +x towards +y.
    own.environment.sky_point = ((0.5 - (90.0 - 300.0) / 360.0) % 1.0, 0.5 + 60.0 / 180.0)
    _, suns, said = parts()
    assert "picked" not in said
    assert suns[0].output.value > 3.0 * plain
    own.environment.sky_point = (0.3, 0.2)
    _, suns, said = parts()
    assert "below the horizon" in said
    assert suns[0].output.value == pytest.approx(plain)


def test_pictures_that_nodes_change_are_taken_apart_as_they_are_shown():
    """Also where the camera alone sees another world, which keeps its own."""
    world, texture = show(image_of(sunny()))
    world.lumenray.unit = "LUMINANCE"
    tree = world.node_tree
    background = next(n for n in tree.nodes if n.type == "BACKGROUND")
    twice = tree.nodes.new("ShaderNodeHueSaturation")
    twice.inputs["Value"].default_value = 2.0
    tree.links.new(texture.outputs["Color"], twice.inputs["Color"])
    tree.links.new(twice.outputs["Color"], background.inputs["Color"])
    whole = horizontal(parts()[0], [])[0]
    world.lumenray.environment.use_sources = True
    shown, suns, _ = parts()
    assert len(suns) == 1
    assert sum(horizontal(shown, suns)) == pytest.approx(whole, rel=1e-5)
    mix, path = tree.nodes.new("ShaderNodeMixShader"), tree.nodes.new("ShaderNodeLightPath")
    black = tree.nodes.new("ShaderNodeBackground")
    black.inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
    tree.links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
    tree.links.new(background.outputs[0], mix.inputs[1])
    tree.links.new(black.outputs[0], mix.inputs[2])
    output = next(n for n in tree.nodes if n.type == "OUTPUT_WORLD")
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    shown, suns, said = parts()
    assert sum(horizontal(shown, suns)) == pytest.approx(whole, rel=1e-5)
    assert shown.seen is not None
    assert "hide the sun from the camera" in said


@pytest.mark.mitsuba
def test_sensors_see_the_light_that_was_there_and_a_sharp_shadow():
    """A plate over the sensor hides the sun's disk and nearly none of the sky."""
    world, _ = show(image_of(sunny(40.0)))
    own = world.lumenray
    own.unit, own.illuminance = "ILLUMINANCE", 10000.0
    own.environment.use_sources = True
    shown, suns, _ = parts()
    towards = -suns[0].direction
    mesh = bpy.data.meshes.new("Plate")
    corners = [(-0.1, -0.1, 0), (0.1, -0.1, 0), (0.1, 0.1, 0), (-0.1, 0.1, 0)]
    mesh.from_pydata(corners, [], [(0, 1, 2, 3)])
    plate = bpy.data.objects.new("Plate", mesh)
    plate.location = 2.0 * towards
    bpy.context.scene.collection.objects.link(plate)
    bpy.context.view_layer.update()
    session = Session()
    session.apply(converted_scene().delta)
    places = np.array([[0.0, 0.0, 0.0], [0.0, -3.0, 0.0]])
    made = session.measure(places, np.tile(UP, (2, 1)), StopRule(samples=1 << 16))
    picture, sun = horizontal(shown, suns)
    assert picture + sun == pytest.approx(10000.0, rel=1e-5)
    allowed = 4.0 * made.standard_error
    assert made.illuminance[1] == pytest.approx(10000.0, abs=allowed[1] + 20.0)
    assert made.illuminance[0] == pytest.approx(picture, abs=allowed[0] + 0.02 * picture)


def test_a_picture_without_sources_lights_as_it_is():
    world, _ = show(image_of(make_map(32, [], sky=1.0, ground=0.2)))
    before = parts()[0]
    world.lumenray.environment.use_sources = True
    after, suns, said = parts()
    assert suns == []
    assert "holds no bright source" in said
    assert np.array_equal(before.image.pixels, after.image.pixels)
