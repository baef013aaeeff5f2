"""Solids that absorb light: Beer's law along every way inside, however light is found, and what lies within is told."""

from dataclasses import replace

import numpy as np
import pytest
from glass_scenes import BLACK, ball, fresnel, point, slab, sun, through_slab
from live_scenes import frame_at
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import UniformWorld
from lumenray.engine.scene.material import Cauchy, Dielectric, Material, Mix
from lumenray.engine.scene.spectrum import Constant, Rgb, Tabulated
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

INDEX = 1.5
INTERNAL, THICKNESS = 0.5, 0.1
GLASS = Material(
    "glass", "glass", Dielectric(Cauchy(INDEX), 0.0, Constant(1.0), Constant(INTERNAL), THICKNESS)
)
WORLD = UniformWorld(100.0)
FLOOR = quad("floor", (-2, -2, -1), (4, 0, 0), (0, 4, 0), "black")


def passed(way):
    """Share of the light that passes so much of the body. [m -> -]"""
    return INTERNAL ** (way / THICKNESS)


def assert_near(value, error, expected, floor=0.0):
    assert abs(value - expected) < 4.0 * error + floor * expected


def through(reflectance, body):
    """Transmittance of two boundaries with all reflections between them."""
    return (1.0 - reflectance) ** 2 * body / (1.0 - (reflectance * body) ** 2)


def look_down(x=0.0, size=0.02, pixels=16):
    """Camera that sees a small square from above."""
    return Camera(frame_at(x, 0, 5), Projection.ORTHOGRAPHIC, pixels, pixels, size, size)


def luminance(session, camera, samples=64, **more):
    """Mean of a picture with its standard error. [cd/m2]"""
    made = session.render(camera, ViewSettings(StopRule(samples=samples), **more))
    seen = made.tristimulus[..., 1].astype(float)
    return seen.mean(), np.sqrt((made.luminance_error.astype(float) ** 2).sum()) / seen.size


@pytest.mark.parametrize("depth", [0.05, 0.2])
def test_the_sun_comes_through_a_slab_with_all_inner_reflections(depth):
    session = session_of(slab((-1, -1, 0), (1, 1, depth)), GLASS, BLACK, FLOOR, sun((0, 0, -1.0)))
    made = session.measure([[0, 0, -0.5]], [[0, 0, 1]], StopRule(samples=1 << 14))
    face = fresnel(np.array([1e-6]), INDEX)[0][0]
    assert made.standard_error[0] < 0.01 * made.illuminance[0]
    assert_near(
        made.illuminance[0], made.standard_error[0], 1000.0 * through(face, passed(depth)), 2e-3
    )


def test_pictures_see_the_world_through_a_slab(transport):
    session = session_of(slab((-1, -1, 0), (1, 1, 0.1)), GLASS, WORLD)
    face = fresnel(np.array([1e-6]), INDEX)[0][0]
    body = passed(0.1)
    # Reflection outside, and what goes to and fro inside and comes back.
    back = face + (1.0 - face) ** 2 * face * body**2 / (1.0 - (face * body) ** 2)
    value, error = luminance(session, look_down(), transport=transport)
    assert_near(value, error, 100.0 * (through(face, body) + back), 1e-3)


@pytest.mark.parametrize("share", [0.0, 0.6])
def test_a_ball_absorbs_along_its_chords(share):
    """All chords of a ray inside are alike: r + (1 - r)^2 t / (1 - r t)."""
    radius = 0.1
    session = session_of(ball("ball", radius, (0, 0, 0), "glass"), GLASS, WORLD)
    face, inside = fresnel(np.arcsin(np.array([max(share, 1e-6)])), INDEX)
    body = passed(2.0 * radius * np.cos(inside[0]))
    expected = 100.0 * (face[0] + (1.0 - face[0]) ** 2 * body / (1.0 - face[0] * body))
    value, error = luminance(session, look_down(share * radius, 0.002))
    # The triangles' chords are a little shorter.
    assert_near(value, error, expected, 3e-3)


def test_light_traced_from_a_lamp_is_absorbed_on_its_way():
    from lumenray.engine.transport.light_tracing.light_paths import LightTracer

    floor = quad("floor", (-4, -4, 0), (8, 0, 0), (0, 8, 0), "black")
    body = slab((-20, -20, 1.0), (20, 20, 1.1))
    session = session_of(GLASS, BLACK, body, point([0, 0, 1.8]), floor)
    scene = session._prepare("auto", False)
    scene.settle()
    tracer = LightTracer(scene)
    landed = tracer.trace(1 << 19, 3)
    angle = np.linspace(0.0, np.radians(89.0), 100_001)
    middle = 0.5 * (angle[1:] + angle[:-1])
    radius, share = through_slab(middle, 1.7, 0.1)
    way = 0.1 / np.cos(fresnel(middle, INDEX)[1])
    # Of each order of inner reflection as many passes of the slab.
    share = share * passed(way) ** (2 * np.arange(len(share))[:, None] + 1)
    step = 100.0 * 2.0 * np.pi * (np.cos(angle[:-1]) - np.cos(angle[1:]))
    expected = (share * step)[radius < 4.0].sum()
    tracer.close()
    (part,) = [part for key, part, _ in scene.parts() if key == "floor"]
    rows = landed.shape == part.number
    corners, (u, v) = scene.triangles(part)[landed.prim[rows]], landed.uv[rows].T
    places = corners[:, 0] + u[:, None] * (corners[:, 1] - corners[:, 0])
    places += v[:, None] * (corners[:, 2] - corners[:, 0]) + scene.origin
    near = np.hypot(*places[:, :2].T) < 4.0
    assert landed.flux[rows][near].sum() == pytest.approx(expected, rel=0.01)


def test_rough_boundaries_absorb_what_comes_from_inside():
    # Without a step of the index rough boundaries change no direction.
    clear = Dielectric(Cauchy(1.0001), 0.5, Constant(1.0), Constant(INTERNAL), THICKNESS)
    session = session_of(slab((-1, -1, 0), (1, 1, 0.1)), replace(GLASS, surface=clear), WORLD)
    value, error = luminance(session, look_down())
    assert_near(value, error, 100.0 * INTERNAL, 5e-3)


@pytest.mark.parametrize("roughness", [0.0, 0.15])
def test_boundaries_that_only_refract_absorb_too(roughness):
    """Nothing is reflected, so along the normal one way through is all there is; rough ones make it little longer."""
    surface = replace(GLASS.surface, reflects=False, roughness=roughness)
    session = session_of(slab((-9, -9, 0), (9, 9, 0.1)), Material("glass", "glass", surface), WORLD)
    value, error = luminance(session, look_down(), 256)
    assert_near(value, error, 100.0 * passed(0.1), 1e-3 if roughness == 0.0 else 0.01)


def test_each_wavelength_follows_its_own_law():
    steps = Tabulated(np.array([380.0, 579.9, 580.1, 780.0]), np.array([0.9, 0.9, 0.3, 0.3]))
    glass = replace(GLASS, surface=replace(GLASS.surface, ior=Cauchy(1.0001), internal=steps))
    session = session_of(slab((-1, -1, 0), (1, 1, 0.25)), glass, WORLD)
    rule = StopRule(samples=256)
    made = session.render(look_down(pixels=8), ViewSettings(rule, bands=4))
    bare = session_of(WORLD).render(look_down(pixels=8), ViewSettings(rule, bands=4))
    ratio = made.bands.mean(axis=(0, 1)) / bare.bands.mean(axis=(0, 1))
    np.testing.assert_allclose(ratio, np.array([0.9, 0.9, 0.3, 0.3]) ** 2.5, rtol=0.04)


def test_a_body_without_a_law_is_computed_as_before():
    clear = Material("glass", "glass", Dielectric(Cauchy(INDEX)))
    whole = replace(GLASS, surface=replace(GLASS.surface, internal=Constant(1.0)))
    plain, full = (
        session_of(ball("ball", 0.1, (0, 0, 0), "glass"), glass, WORLD).render(
            look_down(size=0.15), ViewSettings(StopRule(samples=4))
        )
        for glass in (clear, whole)
    )
    np.testing.assert_allclose(full.tristimulus, plain.tristimulus, rtol=1e-5)


def notes_of(*items):
    return [note for note in session_of(*items).explain().notes if "lies within" in note]


@pytest.mark.parametrize("surface", [GLASS.surface, Mix(GLASS.surface, GLASS.surface, 0.5)])
def test_what_lies_within_is_told_and_what_stands_beside_is_not(surface):
    glass = replace(GLASS, surface=surface)
    body = slab((-0.5, -0.5, 0.0), (0.5, 0.5, 1.0))
    floor = quad("floor", (-2, -2, 0), (4, 0, 0), (0, 4, 0), "paint")
    beside = replace(box(0.2, 0.2, 0.2, inwards=False), id="beside", name="beside")
    beside = replace(beside, vertices=beside.vertices + np.array([0.5, 0, 0]))
    assert notes_of(body, glass, floor, beside, paint(0.5), point([0, 0, 2])) == []
    stick = replace(
        beside, id="stick", name="stick", vertices=beside.vertices - np.array([0.6, 0, -0.4])
    )
    (note,) = notes_of(body, glass, stick, paint(0.5), point([0, 0, 2]))
    assert note.startswith("'stick' lies within 'slab', which absorbs light")
    (note,) = notes_of(body, glass, paint(0.5), floor, point([0, 0, 0.5]))
    assert note.startswith("'lamp' lies within 'slab'")


@pytest.mark.parametrize(
    "values",
    [{"thickness": 0.0}, {"internal": Constant(1.2)}, {"internal": Rgb(0.5, 1.5, 0.5)}],
)
def test_a_body_that_would_make_light_is_refused(values):
    glass = replace(GLASS, surface=replace(GLASS.surface, **values))
    with pytest.raises(SceneError, match="internal transmittance"):
        session_of(slab((-1, -1, 0), (1, 1, 1)), glass, WORLD).explain()
