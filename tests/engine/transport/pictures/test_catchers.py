"""Shadow catchers: what is behind everything, times the illuminance with over that without what stands there."""

from dataclasses import replace

import numpy as np
import pytest
from glass_scenes import ball, slab
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.light_mix import Level, LightMix, mix
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import ImageWorld, Output, Quantity, SunLight, UniformWorld
from lumenray.engine.scene.light_groups import LightGroup
from lumenray.engine.scene.material import (
    Cauchy,
    Dielectric,
    Diffuse,
    Emission,
    Glossy,
    Material,
    Transparent,
)
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Constant, Rgb
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.views import Display, DisplayMode, LiveSettings, ViewSettings

pytestmark = pytest.mark.mitsuba

SIDE, FAR = 8, 400.0
WORLD = UniformWorld(100.0, seen=UniformWorld(7.0))


def camera(height=1.0, width=1.0):
    """Looks down on what lies at the height 0."""
    frame = np.eye(4)
    frame[2, 3] = height
    return Camera(frame, Projection.ORTHOGRAPHIC, SIDE, SIDE, width, width)


def floor(material="black", **more):
    """Catcher that fills the picture and faces up."""
    made = quad("floor", (-FAR, -FAR, 0), (2 * FAR, 0, 0), (0, 2 * FAR, 0), material)
    return replace(made, **{"is_catcher": True, **more})


def wall(material="black", x=0.6):
    """Upright and without end, beside the picture; it hides half of the sky of the floor's middle."""
    return quad("wall", (x, -FAR, 0), (0, 2 * FAR, 0), (0, 0, FAR), material)


BLACK = paint(0.0, "black")


def look(session, method="paths", samples=256, view=None, **more):
    settings = ViewSettings(StopRule(samples=samples), method=method, **more)
    return session.render(view or camera(), settings)


def luminance(picture):
    return picture.tristimulus[..., 1]


@pytest.mark.parametrize("method", ["paths", pytest.param("cells", marks=pytest.mark.slow)])
def test_half_the_sky_is_half_of_what_is_behind(method):
    """A wall without end takes half of an even sky, so the ratio is 1/2; the camera sees 7 cd/m2 behind all."""
    session = session_of(BLACK, floor(), wall(), WORLD)
    made = look(session, method, samples=1024)
    assert luminance(made).mean() == pytest.approx(3.5, rel=0.01)
    assert made.coverage == pytest.approx(1.0, abs=1e-6)
    clear = look(session, method, samples=1024, transparent=True)
    # What the film shows is black, and covers as much as is shaded.
    shown = clear.tristimulus - clear.backdrop
    assert np.abs(shown).max() < 1e-5
    assert clear.coverage.mean() == pytest.approx(0.5, abs=0.005)
    assert luminance(clear).mean() == pytest.approx(3.5, rel=0.01)


def test_a_sun_half_hidden_shades_by_the_part_of_its_disk():
    """A screen 0.2 m over the floor ends at x = 0; at x its edge cuts the disk of the sun at x / (0.2 tan a) radii."""
    angle, height = 0.1, 0.2
    radius = height * np.tan(angle)
    sun = SunLight(
        "sun", "sun", Output(Quantity.ILLUMINANCE, 5e4), np.array([0, 0, -1.0]), 2 * angle
    )
    screen = quad("screen", (-9, -9, height), (9, 0, 0), (0, 18, 0), "black")
    view = camera(0.1, 2.5 * radius)
    made = look(
        session_of(BLACK, floor(), screen, sun, UniformWorld(0.0, seen=UniformWorld(7.0))),
        samples=2048,
        view=view,
    )
    x = ((np.arange(20 * SIDE) + 0.5) / (20 * SIDE) - 0.5) * 2.5
    inside = np.clip(x, -1.0, 1.0)
    open_part = 1.0 - (np.arccos(inside) - inside * np.sqrt(1.0 - inside**2)) / np.pi
    expected = 7.0 * open_part.reshape(SIDE, 20).mean(axis=1)
    # The pixel filter reaches into the neighbours, whose slope differs little within the disk.
    assert luminance(made).mean(axis=0) == pytest.approx(expected, abs=0.12)
    assert luminance(made).mean() == pytest.approx(3.5, rel=0.01)


@pytest.mark.parametrize("transparent", [False, True])
def test_what_nothing_shades_is_as_if_there_were_no_catcher(transparent):
    """A picture behind all, a catcher, and a ball of nothing but a pane far away: pixel by pixel as without, to 1e-3."""
    draw = np.random.default_rng(4)
    pixels = draw.uniform(0.5, 20.0, (16, 32, 3)).astype(np.float32)
    world = ImageWorld(ImageTexture(pixels), 3.0)
    plain = look(session_of(BLACK, world), transparent=transparent)
    caught = look(session_of(BLACK, floor(), world), transparent=transparent)
    assert caught.tristimulus == pytest.approx(plain.tristimulus, rel=1e-3)
    if transparent:
        assert caught.coverage == pytest.approx(0.0, abs=1e-3)
        assert caught.backdrop == pytest.approx(plain.backdrop, rel=1e-3)


def test_what_a_wall_throws_on_the_floor_counts():
    """Of reflectance 0.8 before a black floor it sends 0.8 / 2 of the sky's luminance over half of the sky: 0.7 in all."""
    white = paint(0.8, "white")
    made = look(session_of(BLACK, white, floor(), wall("white"), WORLD), samples=1024)
    assert luminance(made).mean() == pytest.approx(0.7 * 7.0, rel=0.01)


@pytest.mark.slow
def test_shade_has_the_colour_of_the_light_that_is_left():
    """A red wall throws red light alone: of red 1/2 + 0.8 / 4 is left, of blue 1/2."""
    red = Material("red", "red", Diffuse(Rgb(0.8, 0.0, 0.0)))
    made = look(session_of(BLACK, red, floor(), wall("red"), WORLD), samples=2048)
    x, y, z = made.tristimulus.reshape(-1, 3).mean(axis=0)
    # The sky's light is the same at all wavelengths, so all three are alike.
    assert z / 7.0 == pytest.approx(0.5, abs=0.015)
    assert 0.55 < x / 7.0 < 0.7
    assert 0.5 < y / 7.0 < x / 7.0


def test_catchers_shade_each_other_in_the_picture_behind_already():
    session = session_of(paint(0.8), floor("paint"), replace(wall("paint"), is_catcher=True), WORLD)
    assert luminance(look(session)) == pytest.approx(7.0, rel=1e-3)


@pytest.mark.slow
def test_what_glows_of_objects_is_no_lamp():
    """A wall that glows like the sky that it hides leaves the floor as it was."""
    glow = Material("glow", "glow", Diffuse(Constant(0.0)), Emission(luminance=100.0))
    made = look(session_of(BLACK, glow, floor(), wall("glow"), WORLD), samples=1024)
    assert luminance(made).mean() == pytest.approx(7.0, rel=0.01)


@pytest.mark.slow
def test_a_veil_before_a_catcher_takes_its_share():
    veil = Material("veil", "veil", Transparent(Constant(0.5)))
    over = quad("over", (-9, -9, 0.5), (18, 0, 0), (0, 18, 0), "veil")
    made = look(session_of(BLACK, veil, floor(), over, wall(), WORLD), samples=1024)
    # Half of the sky is hidden and the rest comes through the veil; the way to the camera too.
    assert luminance(made).mean() == pytest.approx(7.0 * 0.5 * 0.5 * 0.5, rel=0.02)
    clear = look(
        session_of(BLACK, veil, floor(), over, wall(), WORLD), samples=1024, transparent=True
    )
    assert clear.coverage.mean() == pytest.approx(1.0 - 0.5 * 0.25, abs=0.01)


def test_things_below_a_catcher_do_not_show():
    glow = Material("glow", "glow", Diffuse(Constant(0.0)), Emission(luminance=1e4))
    below = quad("below", (-9, -9, -1), (18, 0, 0), (0, 18, 0), "glow")
    made = luminance(look(session_of(BLACK, glow, floor(), below, WORLD)))
    assert made == pytest.approx(7.0, rel=1e-3)


def test_a_holdout_that_catches_shadows_is_a_hole_and_filters_of_noise_are_told_of_none():
    made = look(session_of(BLACK, floor(is_holdout=True), wall(), WORLD), samples=32)
    assert luminance(made) == pytest.approx(0.0, abs=1e-6)
    assert made.coverage == pytest.approx(0.0, abs=1e-6)
    guided = look(session_of(BLACK, floor(), WORLD), samples=32, guides=True)
    assert guided.denoising_albedo == pytest.approx(1.0, abs=1e-5)


def test_edits_make_catchers_and_unmake_them():
    session = session_of(paint(0.5), floor("paint", is_catcher=False), WORLD)
    assert luminance(look(session)).mean() == pytest.approx(50.0, rel=0.01)
    session.apply(SceneDelta(changed=(floor("paint"),)))
    assert luminance(look(session)) == pytest.approx(7.0, rel=1e-3)
    session.apply(SceneDelta(changed=(floor("paint", is_catcher=False),)))
    assert luminance(look(session)).mean() == pytest.approx(50.0, rel=0.01)


SKY_AND_SUN = (LightGroup("sky", ("world",)), LightGroup("sun", ("sun",)))


def lit_by_sky_and_sun():
    """As much light of the sun, which nothing shades, as of the sky, of which the wall takes half."""
    sun = SunLight(
        "sun", "sun", Output(Quantity.ILLUMINANCE, 100.0 * np.pi), np.array([0, 0, -1.0]), 1e-3
    )
    return BLACK, floor(), wall(), WORLD, sun


@pytest.mark.parametrize("transparent", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_light_groups_have_their_parts_of_the_light_there(transparent):
    """Sky: half of its light is left, which is a quarter of all; the sun has the other half."""
    made = look(
        session_of(*lit_by_sky_and_sun()), samples=1024, groups=SKY_AND_SUN, transparent=transparent
    )
    parts = {group.name: luminance(group).mean() for group in made.groups}
    assert parts["sky"] == pytest.approx(7.0 * 0.25, rel=0.01)
    assert parts["sun"] == pytest.approx(7.0 * 0.5, rel=0.01)
    assert made.coverage.mean() == pytest.approx(0.25 if transparent else 1.0, abs=0.005)
    whole = sum(group.tristimulus.astype(float) for group in made.groups)
    assert made.tristimulus == pytest.approx(whole, rel=1e-6)
    # On another film catchers are a part of what stands before the surroundings.
    backdrop = made.tristimulus if transparent else 0.0
    assert made.backdrop == pytest.approx(backdrop, abs=1e-5)
    assert made.groups[0].backdrop == pytest.approx(
        made.groups[0].tristimulus if transparent else 0.0, abs=1e-5
    )
    # The error is that of the sum, whose parts are divided by the same light.
    assert mix(made.groups).luminance_error == pytest.approx(made.luminance_error, rel=1e-5)
    # Half of the flux of one is half of its part.
    dimmed = made.mixed(LightMix((Level("sun", 0.5),)))
    assert luminance(dimmed).mean() == pytest.approx(7.0 * 0.5, rel=0.01)


@pytest.mark.slow
def test_light_groups_change_nothing_where_nothing_is_shaded():
    """Few samples of each group, whose shares of the light are noisy: their sum is the picture behind all the same."""
    draw = np.random.default_rng(4)
    pixels = draw.uniform(0.5, 20.0, (16, 32, 3)).astype(np.float32)
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 50.0), np.array([0.3, 0.1, -1.0]))
    world = ImageWorld(ImageTexture(pixels), 3.0)
    plain = look(session_of(BLACK, world, sun), samples=1024)
    made = look(session_of(BLACK, floor(), world, sun), samples=16, groups=SKY_AND_SUN)
    assert all(luminance(group).min() > 0.0 for group in made.groups)
    error = np.hypot(made.luminance_error, plain.luminance_error)
    away = luminance(made).astype(float) - luminance(plain)
    assert np.sqrt((away**2).mean()) < 1.5 * np.sqrt((error**2).mean())
    assert made.luminance_error.max() < 0.3 * luminance(made).mean()


@pytest.mark.slow
def test_the_errors_of_light_groups_hold_their_scatter():
    """Pictures of other seeds scatter as their sum says, which is far less than its parts do."""
    session = session_of(*lit_by_sky_and_sun())
    made = [look(session, samples=32, seed=seed, groups=SKY_AND_SUN) for seed in range(12)]
    for tell in (lambda each: each, lambda each: each.groups[0], lambda each: each.groups[1]):
        scatter = np.std([luminance(tell(each)) for each in made], axis=0, ddof=1)
        stated = np.sqrt(np.mean([tell(each).luminance_error ** 2 for each in made], axis=0))
        ratio = np.sqrt((scatter**2).mean() / (stated**2).mean())
        assert 0.6 < ratio < 1.6


@pytest.mark.slow
def test_the_stated_error_holds_the_scatter_of_the_shade():
    """Pictures of other seeds scatter about as much as each says."""
    session = session_of(BLACK, floor(), wall(), WORLD)
    made = [look(session, samples=32, seed=seed) for seed in range(12)]
    scatter = np.std([luminance(each) for each in made], axis=0, ddof=1)
    stated = np.sqrt(np.mean([each.luminance_error**2 for each in made], axis=0))
    ratio = np.sqrt((scatter**2).mean() / (stated**2).mean())
    assert 0.7 < ratio < 1.4


@pytest.mark.slow
def test_the_live_view_shows_the_shade():
    session = session_of(BLACK, floor(), wall(), WORLD)
    session.watch(camera(), LiveSettings(samples=256), Display(DisplayMode.LUMINANCE, white=1.0))
    frame = None
    while session.has_view_work:
        frame = session.refine() or frame
    assert frame.pixels[..., 1].mean() == pytest.approx(3.5, rel=0.02)


@pytest.mark.slow
def test_the_live_view_mixes_light_groups_on_catchers():
    """With the sun off a quarter of what is behind is left, as in pictures."""
    session = session_of(*lit_by_sky_and_sun())
    settings = LiveSettings(samples=512, groups=SKY_AND_SUN)
    off = LightMix((Level("sun", is_on=False),))
    session.watch(camera(), settings, Display(DisplayMode.LUMINANCE, white=1.0, mix=off))
    frame = None
    while session.has_view_work:
        frame = session.refine() or frame
    assert frame.pixels[..., 1].mean() == pytest.approx(7.0 * 0.25, rel=0.02)
    assert 0.0 < frame.relative_error < 0.1


MIRROR = Material("mirror", "mirror", Glossy(Constant(0.9), 0.0))
SATIN = Material("satin", "satin", Glossy(Constant(0.9), 0.05))
GLASS = Material("glass", "glass", Dielectric(Cauchy(1.5)))


def ahead():
    """Camera at the height 1 that looks along y."""
    frame = np.array([[1.0, 0, 0, 0], [0, 0, -1, -1], [0, 1, 0, 1], [0, 0, 0, 1]])
    return Camera(frame, Projection.ORTHOGRAPHIC, SIDE, SIDE, 0.04, 0.04)


def slanted(material):
    """Small plate that shows the ground below it to that camera."""
    return quad("plate", (-0.03, -0.03, 1.03), (0.06, 0, 0), (0, 0.06, -0.06), material)


@pytest.mark.parametrize(
    ("material", "groups"),
    [
        (MIRROR, ()),
        pytest.param(SATIN, (), marks=pytest.mark.slow),
        pytest.param(MIRROR, (LightGroup("sky", ("world",)),), marks=pytest.mark.slow),
    ],
)
@pytest.mark.slow
def test_a_mirror_shows_the_shadows_of_a_ground(material, groups):
    """Of a ground that is but seen a wall takes half of the sky's light; its picture has the sky's 100 cd/m2."""
    ground = floor(meets_light=False)
    # The sample of a mirror's picture is its own: what it shows there is 0.9 of half of the luminance.
    items = (BLACK, material, ground, slanted(material.id), UniformWorld(100.0))
    plain = look(session_of(*items), view=ahead(), samples=512)
    made = look(session_of(*items, wall()), view=ahead(), samples=512, groups=groups)
    assert luminance(plain).mean() == pytest.approx(90.0, rel=0.015)
    assert luminance(made).mean() == pytest.approx(45.0, rel=0.015)
    away = np.abs(luminance(made) - 45.0)
    assert np.sqrt((away**2).mean()) < 3.0 * np.sqrt((made.luminance_error**2).mean()) + 0.5


@pytest.mark.slow
def test_a_mirror_shows_an_object_that_catches_shadows_and_nothing_below_it():
    """A black one hides the ground below it, whose shadows take nothing from what is not seen."""
    ground = quad("ground", (-FAR, -FAR, -0.5), (2 * FAR, 0, 0), (0, 2 * FAR, 0), "black")
    ground = replace(ground, is_catcher=True, meets_light=False)
    items = (BLACK, MIRROR, floor(), ground, slanted("mirror"), UniformWorld(100.0), wall())
    made = look(session_of(*items), view=ahead(), samples=64)
    assert luminance(made) == pytest.approx(0.0, abs=1e-4)


@pytest.mark.slow
def test_a_body_of_glass_shows_the_shadows_of_a_ground():
    """Through a slab: what it reflects of the sky stays, and of what comes through one half is left."""
    plate = slab((-0.1, -0.1, 0.9), (0.1, 0.1, 0.95))
    items = (BLACK, GLASS, floor(meets_light=False), plate, UniformWorld(100.0), wall())
    made = look(session_of(*items), view=camera(width=0.1), samples=2048)
    once = ((1.5 - 1.0) / (1.5 + 1.0)) ** 2
    reflected = 2.0 * once / (1.0 + once)
    expected = 100.0 * (reflected + 0.5 * (1.0 - reflected))
    # The slab stands before a little of the sky.
    assert luminance(made).mean() == pytest.approx(expected, rel=0.01)


@pytest.mark.parametrize("is_lit", [False, pytest.param(True, marks=pytest.mark.slow)])
@pytest.mark.slow
def test_caustics_of_the_sun_fall_on_a_catcher(is_lit):
    """As bright beside what is behind as on a matt floor beside that floor in the open, which the cosine tells."""
    lens = ball("ball", 0.15, (-0.2, 0.0, 0.18), "glass", 24)
    towards = np.array([1.5, 0.0, -1.0]) / np.hypot(1.5, 1.0)
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 5e4), towards, 0.009)
    dark = UniformWorld(0.0, seen=UniformWorld(7.0))
    # Beside the ball, so that pixels show nothing of it.
    view = camera(width=0.2)
    view.frame[0, 3] = 0.08
    made = look(session_of(BLACK, GLASS, floor(meets_light=is_lit), lens, sun, dark), view=view)
    real = floor("paint", is_catcher=False)
    full = look(session_of(paint(0.05), GLASS, real, lens, sun, UniformWorld(0.0)), view=view)
    without = 0.05 / np.pi * 5e4 * -towards[2]
    expected = 7.0 * luminance(full) / without
    error = np.hypot(made.luminance_error, 7.0 / without * full.luminance_error)
    away = luminance(made) - expected
    assert expected.max() > 3.0 * 7.0
    assert expected.min() < 0.7 * 7.0
    assert away.mean() == pytest.approx(0.0, abs=0.01 * expected.mean())
    assert np.sqrt((away**2).mean()) < 2.0 * np.sqrt((error**2).mean()) + 0.01 * expected.max()
    assert not any("caustics" in note for note in made.provenance.notes)
    assert is_lit == any("objects that catch shadows" in note for note in made.provenance.notes)
    assert is_lit != any("its shadow is too light" in note for note in made.provenance.notes)
