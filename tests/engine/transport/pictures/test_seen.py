"""What the camera sees in place of what light meets: holdouts, materials and worlds of its own, by both methods."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import (
    AreaLight,
    ImageWorld,
    Output,
    PointLight,
    Quantity,
    SunLight,
    UniformWorld,
)
from lumenray.engine.scene.light_groups import LightGroup
from lumenray.engine.scene.material import (
    Dielectric,
    Diffuse,
    Emission,
    Glossy,
    Holdout,
    Material,
    Transparent,
)
from lumenray.engine.scene.mesh import Geometry, Placement
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.views import Display, DisplayMode, LiveSettings, ViewSettings

pytestmark = pytest.mark.mitsuba

SIDE = 8


def camera(height=1.0, width=1.0):
    """Looks down on what lies at the height 0."""
    frame = np.eye(4)
    frame[2, 3] = height
    return Camera(frame, Projection.ORTHOGRAPHIC, SIDE, SIDE, width, width)


def floor(material="paint", half=0.5, **more):
    """Square about the origin that faces up; by default it fills the picture."""
    made = quad("floor", (-half, -half, 0), (2 * half, 0, 0), (0, 2 * half, 0), material)
    return replace(made, **more)


def look(session, method="paths", samples=64, **more):
    return session.render(camera(), ViewSettings(StopRule(samples=samples), method=method, **more))


def luminance(picture):
    return picture.tristimulus[..., 1]


METHODS = pytest.mark.parametrize("method", ["paths", "cells"])
PATHS_FIRST = pytest.mark.parametrize(
    "method", ["paths", pytest.param("cells", marks=pytest.mark.slow)]
)


@METHODS
def test_the_camera_sees_its_own_world_and_surfaces_are_lit_by_the_other(method):
    """A floor on the left half sends 0.5 of what lights it; beside it the camera sees what is behind."""
    world = UniformWorld(100.0, seen=UniformWorld(7.0))
    left = quad("floor", (-9, -9, 0), (9, 0, 0), (0, 18, 0), "paint")
    session = session_of(paint(0.5), left, world)
    made = luminance(look(session, method))
    assert made[:, :3].mean() == pytest.approx(50.0, rel=0.01)
    assert made[:, 5:] == pytest.approx(7.0, rel=1e-3)
    session.apply(SceneDelta(changed=(replace(world, seen=UniformWorld(0.0)),)))
    assert luminance(look(session, method))[:, 5:] == pytest.approx(0.0, abs=1e-6)
    session.apply(SceneDelta(changed=(replace(world, seen=None),)))
    assert luminance(look(session, method))[:, 5:] == pytest.approx(100.0, rel=1e-3)


@PATHS_FIRST
def test_a_backdrop_alone_lights_nothing(method):
    left = quad("floor", (-9, -9, 0), (9, 0, 0), (0, 18, 0), "paint")
    session = session_of(paint(0.5), left, UniformWorld(0.0, seen=UniformWorld(7.0)))
    made = look(session, method)
    assert luminance(made)[:, :3] == pytest.approx(0.0, abs=1e-6)
    assert luminance(made)[:, 5:] == pytest.approx(7.0, rel=1e-3)
    # By its own spectrum, although there is no light.
    assert made.tristimulus[0, 7] == pytest.approx([7.0, 7.0, 7.0], rel=2e-3)
    measured = session.measure([(0, 0, 0.5)], [(0, 0, 1)], StopRule(samples=64))
    assert measured.illuminance[0] == 0.0


def test_mirrors_show_the_world_that_gives_light_and_openings_that_of_the_camera():
    world = UniformWorld(100.0, seen=UniformWorld(7.0))
    mirror = Material("paint", "mirror", Glossy(Constant(0.8), 0.0))
    made = luminance(look(session_of(mirror, floor(half=9.0), world)))
    assert made == pytest.approx(80.0, rel=1e-3)
    hole = Material("paint", "hole", Transparent(Constant(0.5)))
    made = luminance(look(session_of(hole, floor(half=9.0), world)))
    assert made == pytest.approx(3.5, rel=1e-3)


def test_a_transparent_film_lacks_the_backdrop_of_the_camera():
    world = UniformWorld(100.0, seen=UniformWorld(7.0))
    hole = Material("paint", "hole", Transparent(Constant(0.5)))
    made = look(session_of(hole, floor(half=9.0), world), transparent=True)
    assert made.backdrop[..., 1] == pytest.approx(3.5, rel=1e-3)
    assert made.coverage == pytest.approx(0.5, abs=1e-4)


def test_a_backdrop_may_be_a_picture_and_suns_stay_in_view():
    """The camera looks straight into the sun, which covers a quarter of a degree about its axis."""
    pixels = np.full((4, 8, 3), 3.0, np.float32)
    seen = ImageWorld(ImageTexture(pixels), 2.0)
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1000.0), np.array([0, 0, 1.0]), 2.0)
    session = session_of(paint(0.5), floor(half=0.001), UniformWorld(1.0, seen=seen), sun)
    made = luminance(look(session))
    expected = 6.0 + 1000.0 / (np.pi * np.sin(1.0) ** 2)
    assert np.median(made) == pytest.approx(expected, rel=0.02)


@PATHS_FIRST
def test_the_camera_sees_its_own_material_and_light_follows_the_other(method):
    """A ceiling of 0.2 over a floor whose light half is 0.9 and whose seen half is 0.1, in an even world from the sides."""
    split = paint(0.9, seen=paint(0.1, "paint/seen"))
    plain = paint(0.9)
    world = UniformWorld(100.0)
    sensor = ([(0, 0, 0.2)], [(0, 0, -1)], StopRule(samples=1 << 12))
    found = []
    for material in (plain, split):
        session = session_of(material, floor(half=9.0), world)
        made = look(session, method)
        found.append((luminance(made).mean(), session.measure(*sensor).illuminance[0]))
    (white, sent), (dark, sent_too) = found
    assert white == pytest.approx(90.0, rel=0.01)
    assert dark == pytest.approx(10.0, rel=0.01)
    assert sent == pytest.approx(90.0 * np.pi, rel=0.01)
    assert sent_too == pytest.approx(sent, rel=0.01)


@PATHS_FIRST
def test_what_glows_for_the_camera_alone_lights_nothing(method):
    glow = Material("paint/seen", "glow", Diffuse(Constant(0.0)), Emission(luminance=30.0))
    session = session_of(paint(0.5, seen=glow), floor(half=9.0), UniformWorld(10.0))
    assert luminance(look(session, method)) == pytest.approx(30.0, rel=1e-3)
    measured = session.measure([(0, 0, 0.2)], [(0, 0, -1)], StopRule(samples=1 << 12))
    assert measured.illuminance[0] == pytest.approx(5.0 * np.pi, rel=0.01)


def test_edits_of_what_is_seen_give_what_a_new_scene_gives():
    world, session = UniformWorld(10.0), session_of(paint(0.5), floor(half=9.0))
    session.apply(SceneDelta(changed=(world,)))
    glow = Material("paint/seen", "glow", Diffuse(Constant(0.0)), Emission(luminance=30.0))
    steps = [
        paint(0.5, seen=paint(0.2, "paint/seen")),
        paint(0.5, seen=paint(0.3, "paint/seen")),
        paint(0.5, seen=glow),
        paint(0.5, seen=replace(glow, emission=Emission(luminance=40.0))),
        paint(0.7),
        paint(0.7, seen=Material("paint/seen", "hole", Holdout())),
    ]
    found = []
    for material in steps:
        session.apply(SceneDelta(changed=(material,)))
        found.append(luminance(look(session)).mean())
    assert found == pytest.approx([2.0, 3.0, 30.0, 40.0, 7.0, 0.0], rel=0.01, abs=1e-6)
    session.apply(SceneDelta(changed=(paint(0.5), floor(half=9.0, is_holdout=True))))
    assert luminance(look(session)).max() == pytest.approx(0.0, abs=1e-6)
    session.apply(SceneDelta(changed=(floor(half=9.0),)))
    assert luminance(look(session)).mean() == pytest.approx(5.0, rel=0.01)


@pytest.mark.one_at_a_time
@METHODS
@pytest.mark.parametrize("transparent", [False, True])
def test_holdouts_are_holes_to_the_camera_and_as_ever_to_light(method, transparent):
    """A holdout fills the left half, a floor the right one; a veil of one half lies over all."""
    hole = quad("hole", (-9, -9, 0), (9, 0, 0), (0, 18, 0), "paint")
    right = quad("right", (0, -9, 0), (9, 0, 0), (0, 18, 0), "paint")
    veil = Material("veil", "veil", Transparent(Constant(0.5)))
    over = quad("over", (-9, -9, 0.5), (18, 0, 0), (0, 18, 0), "veil")
    session = session_of(
        paint(0.5), veil, replace(hole, is_holdout=True), right, over, UniformWorld(100.0)
    )
    made = look(session, method, transparent=transparent)
    assert luminance(made)[:, :3] == pytest.approx(0.0, abs=1e-6)
    assert made.coverage[:, :3] == pytest.approx(0.5, abs=1e-4)
    assert made.coverage[:, 5:] == pytest.approx(1.0, abs=1e-4)
    assert luminance(made)[:, 5:].mean() == pytest.approx(0.5 * 0.5 * 50.0, rel=0.03)
    measured = session.measure([(-1.0, 0, 0.2)], [(0, 0, -1)], StopRule(samples=1 << 12))
    assert measured.illuminance[0] == pytest.approx(0.5 * 50.0 * np.pi, rel=0.02)


def test_holdouts_that_the_camera_does_not_see_are_none():
    hidden = floor(half=9.0, is_holdout=True, visible_to_camera=False)
    made = look(session_of(paint(0.5), hidden, UniformWorld(100.0)))
    assert made.coverage is None
    assert luminance(made) == pytest.approx(100.0, rel=1e-3)


@pytest.mark.slow
def test_the_live_view_shows_what_the_camera_sees():
    world = UniformWorld(100.0, seen=UniformWorld(7.0))
    left = quad("floor", (-9, -9, 0), (9, 0, 0), (0, 18, 0), "paint")
    session = session_of(paint(0.5, seen=paint(0.1, "paint/seen")), left, world)
    session.watch(camera(), LiveSettings(samples=64), Display(DisplayMode.LUMINANCE, white=1.0))
    frame = None
    while session.has_view_work:
        frame = session.refine() or frame
    assert frame.pixels[:, :3, 1].mean() == pytest.approx(10.0, rel=0.02)
    assert frame.pixels[:, 5:, 1] == pytest.approx(7.0, rel=1e-3)


def test_light_groups_add_up_to_what_the_camera_sees():
    """A backdrop belongs to the world's group, and what glows for the camera alone to the rest."""
    glow = Material("paint/seen", "glow", Diffuse(Constant(0.0)), Emission(luminance=30.0))
    left = quad("floor", (-9, -9, 0), (9, 0, 0), (0, 18, 0), "paint")
    lamp = PointLight("lamp", "lamp", Output(Quantity.LUMINOUS_FLUX, 100.0), np.array([0, 0, 3.0]))
    world = UniformWorld(100.0, seen=UniformWorld(7.0))
    session = session_of(paint(0.5, seen=glow), left, lamp, world)
    made = look(session, groups=(LightGroup("sky", ("world",)), LightGroup("lamp", ("lamp",))))
    shares = {group.name: group.tristimulus[..., 1] for group in made.groups}
    assert shares["sky"][:, 5:] == pytest.approx(7.0, rel=1e-3)
    assert shares["sky"][:, :3] == pytest.approx(0.0, abs=1e-6)
    assert shares["rest"][:, :3] == pytest.approx(30.0, rel=1e-3)
    assert sum(shares.values()) == pytest.approx(luminance(made), rel=1e-3)


def test_what_only_the_camera_sees_shows_caustics_as_light_that_falls_on_it():
    """A sun behind a slab of glass over a floor of 0.2 that the camera sees as one of 0.4: twice as bright as it."""
    glass = Material("glass", "glass", Dielectric())
    slab = replace(box(4, 4, 0.1, "glass", inwards=False), id="slab")
    slab = replace(slab, vertices=slab.vertices + np.array([-2.0, -2.0, 0.3]))
    towards = np.array([0.3, 0.2, -1.0]) / np.linalg.norm([0.3, 0.2, -1.0])
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1000.0), towards, 0.005)
    view = replace(camera(height=0.25))
    found = []
    for material in (paint(0.2), paint(0.2, seen=paint(0.4, "paint/seen"))):
        session = session_of(material, glass, floor(half=3.0), slab, sun)
        found.append(luminance(session.render(view, ViewSettings(StopRule(samples=256)))).mean())
    assert found[0] > 10.0
    assert found[1] == pytest.approx(2.0 * found[0], rel=0.05)


def test_layers_and_illuminance_are_those_of_what_the_camera_sees():
    """Not of a lamp and a block over the floor that it does not see; hardly any light comes below the block."""
    frame = np.eye(4)
    frame[2, 3] = 0.9
    lamp = AreaLight(
        "lamp",
        "lamp",
        Output(Quantity.LUMINOUS_FLUX, 1e-3),
        frame,
        0.5,
        0.5,
        visible_to_camera=False,
    )
    block = quad("block", (-30, -30, 0.5), (60, 0, 0), (0, 60, 0), "dark")
    block = replace(block, visible_to_camera=False)
    dark = paint(0.0, "dark")
    session = session_of(paint(0.5), dark, floor(half=9.0), block, lamp, UniformWorld(100.0))
    made = look(session, illuminance=True)
    assert made.depth == pytest.approx(1.0, rel=1e-4)
    assert made.illuminance.max() < 0.05 * 100.0 * np.pi
    assert luminance(made).max() < 0.05 * 50.0


def test_an_object_shows_again_once_the_camera_may_see_it():
    """One that is placed, so that its shapes stay as they are."""
    corners = np.array([[-9, -9, 0], [9, -9, 0], [9, 9, 0], [-9, 9, 0]], np.float32)
    faces = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    shape = Geometry("shape", corners, faces, np.zeros(2, np.int32))
    hidden = Placement("floor", "floor", "shape", np.eye(4), ("paint",), False)
    session = session_of(paint(0.5), shape, hidden, UniformWorld(10.0))
    assert luminance(look(session)).mean() == pytest.approx(10.0, rel=1e-3)
    session.apply(SceneDelta(changed=(replace(hidden, visible_to_camera=True),)))
    assert luminance(look(session)).mean() == pytest.approx(5.0, rel=0.01)
    session.apply(SceneDelta(changed=(hidden,)))
    assert luminance(look(session)).mean() == pytest.approx(10.0, rel=1e-3)
