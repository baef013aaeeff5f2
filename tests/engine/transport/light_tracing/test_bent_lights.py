"""Light over glass and curved mirrors at sensors and in pictures: against closed forms and rooms without the glass."""

import math
from dataclasses import replace

import numpy as np
import pytest
from glass_scenes import BLACK, GLASS, INDEX, MIRROR, ball, fresnel, point, slab, sun, through_slab
from small_scenes import box, paint, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.material import Black, Emission, Material
from lumenray.engine.scene.spectrum import Constant
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

UP = (0.0, 0.0, 1.0)
RULE = StopRule(samples=1 << 17)


def measure(items, places, normals=UP, rule=RULE, **more):
    places = np.asarray(places, float).reshape(-1, 3)
    return session_of(*items).measure(places, np.broadcast_to(normals, places.shape), rule, **more)


def assert_agrees(made, expected, systematic=2e-3):
    """Within 4.5 standard errors and a share of the value, and no error that is too large to tell anything."""
    expected = np.broadcast_to(expected, made.illuminance.shape)
    apart = np.abs(made.illuminance - expected)
    allowed = 4.5 * made.standard_error + systematic * expected
    assert (apart <= allowed).all(), (made.illuminance, made.standard_error, expected)
    assert (made.standard_error < 0.05 * expected).all(), made.standard_error / expected


def bulb_room(lamp, *more):
    """Room of 3 m with a clear ball of glass about the lamp's place."""
    room = replace(box(3, 3, 3), id="room", name="room")
    return (paint(0.5), GLASS, room, ball("bulb", 0.03, (1.5, 1.5, 1.6), "glass", 96), lamp, *more)


def round_lamp(radius):
    return PointLight(
        "lamp", "lamp", Output(Quantity.LUMINOUS_FLUX, 1000.0), np.array([1.5, 1.5, 1.6]), radius
    )


PLACES = [(1.3, 1.1, 0.0), (0.4, 2.2, 0.0), (2.2, 0.9, 1.0)]


@pytest.mark.parametrize("radius", [0.0, 1e-3, 1e-2])
@pytest.mark.slow
def test_a_lamp_in_the_middle_of_a_glass_ball_lights_sensors_as_without_it(radius):
    """Light leaves at right angles and nothing is absorbed: what is reflected passes the lamp and comes out elsewhere."""
    lamp = round_lamp(radius)
    items = bulb_room(lamp)
    bare = session_of(*[item for item in items if item.id not in {"bulb", "glass"}])
    normals = np.broadcast_to(UP, (3, 3))
    expected = bare.measure(np.array(PLACES), normals, StopRule(samples=1 << 18)).illuminance
    assert_agrees(measure(items, PLACES), expected, 4e-3)


@pytest.mark.slow
def test_a_glowing_mesh_in_a_glass_ball_lights_sensors():
    """A black lamp takes back the four hundredths that the glass reflects to it."""
    radius = 0.005
    glow = Material(
        "glow", "glow", Black(), Emission(Constant(1.0), 1000.0 / (2.0 * np.pi * radius) ** 2)
    )
    glow = replace(glow, emission=replace(glow.emission, two_sided=False))
    mesh = ball("lamp", radius, (1.5, 1.5, 1.6), "glow", 48)
    items = bulb_room(mesh, glow)
    bare = session_of(*[item for item in items if item.id not in {"bulb", "glass"}])
    normals = np.broadcast_to(UP, (3, 3))
    expected = bare.measure(np.array(PLACES), normals, StopRule(samples=1 << 18)).illuminance
    reflected = ((INDEX - 1.0) / (INDEX + 1.0)) ** 2
    assert_agrees(measure(items, PLACES), (1.0 - reflected) * expected, 4e-3)


@pytest.mark.slow
def test_a_point_through_a_slab_lights_sensors_by_snell_and_fresnel(transport):
    items = (GLASS, slab((-6, -6, 0.5), (6, 6, 1.0)), point([0, 0, 2.2]))
    angle = np.linspace(1e-4, np.radians(88.0), 200_001)
    radius, share = through_slab(angle, 1.7, 0.5)
    places = np.array([0.3, 1.0, 2.0])
    expected = np.zeros(3)
    for r, s in zip(radius, share, strict=True):
        density = 100.0 * s * np.sin(angle) / np.maximum(r * np.gradient(r, angle), 1e-12)
        expected += np.interp(places, r, density)
    made = measure(items, [(r, 0.0, 0.0) for r in places], transport=transport)
    assert_agrees(made, expected)
    assert any("'lamp'" in note and "sphere of" in note for note in made.provenance.notes)


@pytest.mark.parametrize("degrees", [0.0, 45.0])
@pytest.mark.parametrize("angle", [0.0, math.radians(0.53)])
@pytest.mark.slow
def test_a_sun_through_a_slab_lights_sensors(degrees, angle):
    tilt = np.radians(degrees)
    items = (
        GLASS,
        slab((-6, -6, 0.5), (6, 6, 0.55)),
        sun([np.sin(tilt), 0, -np.cos(tilt)], angle),
    )
    reflected, _ = fresnel(tilt, INDEX)
    expected = 1000.0 * np.cos(tilt) * (1.0 - reflected) / (1.0 + reflected)
    assert_agrees(measure(items, [(0.1, 0.2, 0.0)]), expected)


@pytest.mark.slow
def test_a_mirror_ball_lights_sensors_from_a_point():
    """Virtual image by reflection in a convex mirror, exact beyond the paraxial range, on the ceiling over the lamp."""
    radius, lamp_height, ceiling = 0.5, 1.5, 3.0
    shiny = ball("ball", radius, (0, 0, 0), "mirror", rings=192)
    alpha = np.linspace(1e-4, np.radians(35.0), 20_001)
    normal = np.stack([np.sin(alpha), np.cos(alpha)])
    away = radius * normal - np.array([[0.0], [lamp_height]])
    away /= np.linalg.norm(away, axis=0)
    out = away - 2.0 * (away * normal).sum(axis=0) * normal
    reach = radius * normal[0] + (ceiling - radius * normal[1]) * out[0] / out[1]
    cosine = -away[1]
    density = 0.9 * 100.0 * -np.gradient(cosine, alpha) / (reach * np.gradient(reach, alpha))
    places = np.array([0.5, 1.2, 2.0])
    straight = 100.0 * (ceiling - lamp_height) / (places**2 + (ceiling - lamp_height) ** 2) ** 1.5
    expected = np.interp(places, reach, density)
    made = measure(
        (MIRROR, shiny, point([0, 0, lamp_height])),
        [(0.6 * r, 0.8 * r, ceiling) for r in places],
        (0, 0, -1),
        StopRule(samples=1 << 20),
    )
    made = replace(made, illuminance=made.illuminance - straight)
    assert_agrees(made, expected, 1e-2)


@pytest.mark.slow
def test_light_of_many_bulbs_adds_up():
    """Each of four lamps in its own ball gives what it gives alone."""
    centres = [(0.8, 0.8, 1.6), (2.2, 0.8, 1.7), (0.8, 2.2, 1.8), (2.2, 2.2, 1.5)]
    items, fluxes = [BLACK, GLASS, replace(box(3, 3, 3, "black"), id="room", name="room")], []
    expected = np.zeros(1)
    place = np.array([1.5, 1.5, 0.0])
    for number, centre in enumerate(centres):
        flux = 100.0 * (number + 1)
        items.append(ball(f"ball {number}", 0.04, centre, "glass", 96))
        items.append(
            PointLight(
                f"lamp {number}",
                f"lamp {number}",
                Output(Quantity.LUMINOUS_FLUX, flux),
                np.array(centre),
                2e-3 * number,
            )
        )
        away = np.array(centre) - place
        expected += flux / (4.0 * np.pi) * away[2] / np.linalg.norm(away) ** 3
        fluxes.append(flux)
    assert_agrees(measure(items, [place]), expected, 5e-3)


@pytest.mark.slow
def test_reflections_are_counted_over_bends_too():
    """No light passes a slab without a bend, and no more than two are needed to pass it."""
    items = (GLASS, slab((-6, -6, 0.5), (6, 6, 0.55)), sun([0, 0, -1.0], np.radians(0.53)))
    place = [(0.1, 0.2, 0.0)]
    assert measure(items, place, reflections=1).illuminance[0] == 0.0
    made = measure(items, place, reflections=2)
    reflected = ((INDEX - 1.0) / (INDEX + 1.0)) ** 2
    assert_agrees(made, 1000.0 * (1.0 - reflected) ** 2)


@pytest.mark.slow
def test_pictures_show_what_a_point_in_a_bulb_lights():
    """The floor's luminance is its illuminance times 0.5 / pi."""
    items = bulb_room(round_lamp(0.0))
    frame = np.eye(4)
    frame[:3, 3] = (0.6, 0.7, 1.0)
    camera = Camera(
        frame=frame,
        projection=Projection.PERSPECTIVE,
        width=32,
        height=32,
        extent_x=0.02,
        extent_y=0.02,
    )
    session = session_of(*items)
    picture = session.render(camera, ViewSettings(StopRule(samples=1 << 7)))
    luminance = picture.tristimulus[..., 1].mean()
    bare = session_of(*[item for item in items if item.id not in {"bulb", "glass"}])
    lux = bare.measure(np.array([[0.6, 0.7, 0.0]]), np.array([UP]), StopRule(samples=1 << 17))
    assert luminance == pytest.approx(0.5 / np.pi * lux.illuminance[0], rel=0.02)


@pytest.mark.slow
def test_light_that_is_still_to_be_gathered_reaches_sensors():
    """A ball that would gather a lamp's light behind the floor: sensors look up to the ball and not down to its image.

    On the axis the point's light would have no bound, and the error tells that the sphere which stands for it has one.
    """
    from lumenray.engine.transport.light_tracing.light_paths import LightTracer

    floor = slab((-0.6, -0.6, -0.1), (0.6, 0.6, 0.0), "black", "floor")
    items = (BLACK, GLASS, ball("ball", 0.15, (0, 0, 0.4), "glass", 96), point([0, 0, 0.7]), floor)
    session = session_of(*items)
    scene = session._prepare("auto", False)
    scene.settle()
    landed = LightTracer(scene).trace(1 << 19, 3)
    corners = {p.number: scene.triangles(p).astype(float) for _, p, _ in scene.parts()}
    (number,) = {int(n) for n in np.unique(landed.shape)} & {
        p.number for _, p, item in scene.parts() if item.id == "black"
    }
    own = landed.shape == number
    weights = np.column_stack([1.0 - landed.uv.sum(axis=1), landed.uv])[own]
    places = np.einsum("mk,mki->mi", weights, corners[number][landed.prim[own]]) + scene.origin
    radius = np.hypot(places[:, 0], places[:, 1])
    edges = np.linspace(0.008, 0.024, 5)
    lux = np.histogram(radius, edges, weights=landed.flux[own])[0] / np.diff(np.pi * edges**2)
    middle = np.sqrt(0.5 * (edges[1:] ** 2 + edges[:-1] ** 2))
    turns = 2.0 * np.pi * (np.arange(8) + 0.5) / 8
    rings = [(r * np.cos(t), r * np.sin(t), 0.0) for r in middle for t in turns]
    made = measure(items, [(0.0, 0.0, 0.0), *rings], rule=StopRule(samples=1 << 16))
    assert made.standard_error[0] > 0.15 * made.illuminance[0]
    found = made.illuminance[1:].reshape(4, 8).mean(axis=1)
    error = np.sqrt((made.standard_error[1:].reshape(4, 8) ** 2).sum(axis=1)) / 8
    assert (error < 0.1 * lux).all(), error / lux
    assert (np.abs(found - lux) < 4.5 * error + 0.02 * lux).all(), (found, lux, error)


@pytest.mark.slow
def test_edges_of_the_pilot_lose_no_light():
    """A lamp in front of a lens, off its axis: the sum over the floor is what traced paths bring there."""
    from lumenray.engine.transport.light_tracing.light_paths import LightTracer

    lens = ball("lens", 0.3, (0, 0, 1.2), "glass", 128)
    items = (BLACK, GLASS, lens, point([0.15, 0.1, 2.0], radius=0.02))
    floor = slab((-1.5, -1.5, -0.1), (1.5, 1.5, 0.0), "black", "floor")
    session = session_of(*items, floor)
    scene = session._prepare("auto", False)
    scene.settle()
    tracer = LightTracer(scene)
    flux = tracer.trace(1 << 19, 3).flux
    # Bent light alone, on the floor's top.
    edge = (np.arange(24) + 0.5) / 8.0 - 1.5
    x, y = (each.ravel() for each in np.meshgrid(edge, edge))
    places = np.stack([x, y, np.zeros_like(x)], axis=1)
    normals = np.broadcast_to(UP, places.shape)
    rule = StopRule(samples=1 << 12)
    whole = session.measure(places, normals, rule)
    straight = session.measure(places, normals, rule, reflections=0)
    made = (whole.illuminance - straight.illuminance).sum() / 64.0
    error = np.sqrt((whole.standard_error**2 + straight.standard_error**2).sum()) / 64.0
    traced = flux.sum()
    assert abs(made - traced) < 4.5 * error + 0.03 * traced, (made, traced, error)
