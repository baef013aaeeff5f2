"""Shadow catchers: what is behind everything, times the illuminance with over that without what stands there."""

from dataclasses import replace

import numpy as np
import pytest
from glass_scenes import ball
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import ImageWorld, Output, Quantity, SunLight, UniformWorld
from lumenray.engine.scene.light_groups import LightGroup
from lumenray.engine.scene.material import Diffuse, Emission, Glossy, Material, Transparent
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Constant, Rgb
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.views import Display, DisplayMode, LiveSettings, ViewSettings
from small_scenes import paint, quad, session_of

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


def test_light_groups_are_not_kept_apart_and_it_is_said():
    session = session_of(BLACK, floor(), wall(), WORLD)
    made = look(session, groups=(LightGroup("sky", ("world",)),))
    assert made.groups == ()
    assert any("light groups are not kept apart" in note for note in made.provenance.notes)
    assert luminance(made).mean() == pytest.approx(3.5, rel=0.02)


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
def test_caustics_leave_no_specks_on_a_catcher_and_it_is_said():
    """A mirror throws a narrow sun on the floor: nothing is brighter than what is behind, and a note says what lacks."""
    mirror = Material("mirror", "mirror", Glossy(Constant(0.9), 0.0))
    sheet = ball("ball", 0.2, (0.0, 0.0, 0.4), "mirror", 16)
    towards = np.array([0.4, 0.0, -1.0]) / np.hypot(0.4, 1.0)
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 5e4), towards, 0.009)
    made = look(
        session_of(BLACK, mirror, floor(), sheet, sun, UniformWorld(0.0, seen=UniformWorld(7.0)))
    )
    caught = luminance(made)[np.abs(made.depth - 1.0) < 1e-3]
    assert len(caught) > 20
    assert caught.max() <= 7.0 * (1.0 + 1e-3)
    assert caught.min() < 1.0
    for words in ("caustics do not fall", "show shadow catchers as the objects that they are"):
        assert any(words in note for note in made.provenance.notes)
