"""Light traced over glass and mirrors: against Snell's and Fresnel's laws and the conservation of flux."""

import math
from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake_in
from glass_scenes import (
    BLACK,
    CANDELA,
    GLASS,
    INDEX,
    MIRROR,
    ball,
    fresnel,
    point,
    slab,
    sun,
    through_slab,
)
from small_scenes import box, paint, quad, session_of

from lumenray.engine.scene.distribution import IntensityDistribution
from lumenray.engine.scene.light import (
    AreaLight,
    Luminaire,
    Output,
    PointLight,
    Quantity,
    SpotLight,
)
from lumenray.engine.scene.material import (
    Black,
    Cauchy,
    Dielectric,
    Diffuse,
    Emission,
    Material,
    Mix,
    ThinGlass,
    Transparent,
)
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.spectrum import Constant, Illuminant

pytestmark = pytest.mark.mitsuba

PATHS = 1 << 19


def tracer_of(*items, transport="auto"):
    from lumenray.engine.transport.light_tracing.light_paths import LightTracer

    session = session_of(*items)
    scene = session._prepare(transport, False)
    scene.settle()
    made = LightTracer(scene)
    made.session = session
    return made


def landings(tracer, deposits, material):
    """Places in the scene's frame (m, 3) and fluxes (m,) of what landed on a material, and its rows."""
    for _, part, item in tracer.scene.parts():
        if item.id == material:
            rows = np.flatnonzero(deposits.shape == part.number)
            corners = tracer.scene.triangles(part).astype(float)[deposits.prim[rows]]
            v, w = deposits.uv[rows].astype(float).T
            weights = np.stack([1.0 - v - w, v, w], axis=1)
            places = np.einsum("mk,mki->mi", weights, corners) + tracer.scene.origin
            return places, deposits.flux[rows], rows
    raise KeyError(material)


def assert_near(flux, expected, systematic=1e-3):
    """Compare a sum of independent fluxes with its expectation: within 4.5 standard errors and a share of it."""
    error = np.sqrt((flux**2).sum())
    assert abs(flux.sum() - expected) < 4.5 * error + systematic * expected, (
        f"{flux.sum()} against {expected} with a standard error of {error}"
    )


def test_all_light_of_a_lamp_in_a_glass_ball_comes_out(transport):
    """From within two thirds of the radius nothing is totally reflected, so the glass holds nothing back."""
    room = replace(box(4, 4, 4, "black"), id="room", name="room")
    lamp = point([2.0, 2.0, 2.15])
    tracer = tracer_of(
        GLASS, BLACK, room, ball("ball", 0.5, (2, 2, 2), "glass"), lamp, transport=transport
    )
    deposits = tracer.trace(PATHS, 3)
    # Every path lands with its whole flux.
    assert deposits.flux.sum() == pytest.approx(400.0 * np.pi, rel=2e-3)
    assert not deposits.back.any()


def test_light_that_meets_a_glass_ball_lands_somewhere(transport):
    room = replace(box(4, 4, 4, "black"), id="room", name="room")
    lamp = point([2.0, 2.0, 3.2])
    tracer = tracer_of(
        GLASS, BLACK, room, ball("ball", 0.5, (2, 2, 2), "glass"), lamp, transport=transport
    )
    solid_angle = 2.0 * np.pi * (1.0 - np.sqrt(1.0 - (0.5 / 1.2) ** 2))
    assert tracer.trace(PATHS, 3).flux.sum() == pytest.approx(100.0 * solid_angle, rel=3e-3)


@pytest.mark.parametrize(("scale", "offset"), [(1e-3, 0.0), (1.0, 1e4), (1e3, 0.0)])
def test_flux_is_kept_at_every_scale_and_place(scale, offset):
    def moved(mesh):
        return replace(mesh, vertices=scale * mesh.vertices + offset)

    room = moved(replace(box(4, 4, 4, "black"), id="room", name="room"))
    glass = moved(ball("ball", 0.5, (2, 2, 2), "glass"))
    lamp = point(scale * np.array([2.0, 2.0, 3.2]) + offset)
    tracer = tracer_of(GLASS, BLACK, room, glass, lamp)
    solid_angle = 2.0 * np.pi * (1.0 - np.sqrt(1.0 - (0.5 / 1.2) ** 2))
    assert tracer.trace(PATHS, 3).flux.sum() == pytest.approx(100.0 * solid_angle, rel=3e-3)


def test_balls_one_behind_the_other_get_their_light_once():
    """Two balls fill the same part of the sky of the lamp in part, so that every direction must count once."""
    room = replace(box(6, 6, 6, "black"), id="room", name="room")
    first = ball("a", 0.3, (3, 3, 3), "glass")
    second = ball("b", 0.8, (3.1, 3, 1.5), "glass")
    lamp = point([3.0, 3.0, 4.5])
    tracer = tracer_of(GLASS, BLACK, room, first, second, lamp)
    rng = np.random.default_rng(1)
    away = rng.normal(size=(4_000_000, 3))
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    met = np.zeros(len(away), bool)
    for centre, radius in (((3, 3, 3), 0.3), ((3.1, 3, 1.5), 0.8)):
        towards = np.asarray(centre, float) - lamp.position
        along = away @ towards
        met |= (along > 0) & (towards @ towards - along**2 <= radius**2)
    share = met.mean()
    error = np.sqrt(share * (1 - share) / len(away)) / share
    made = tracer.trace(PATHS, 5).flux
    assert made.sum() == pytest.approx(400.0 * np.pi * share, rel=4.5 * error + 5e-3)


def test_a_spot_and_a_point_like_luminaire_send_what_they_state():
    room = replace(box(4, 4, 4, "black"), id="room", name="room")
    glass = ball("ball", 0.5, (2, 2, 1), "glass")
    spot = SpotLight("s", "s", Output(Quantity.LUMINOUS_FLUX, 500.0), np.array([2.0, 2.0, 3.0]),
                     np.array([0.0, 0.0, -1.0]), np.radians(8.0), 0.5)  # fmt: skip
    polar = np.radians(np.arange(0.0, 181.0))
    beam = IntensityDistribution(
        np.zeros(1), polar, np.where(polar < np.radians(9.5), 1.0, 0.0)[None]
    )
    frame = np.eye(4)
    frame[:3, 3] = (2.0, 2.0, 3.0)
    downlight = Luminaire("d", "d", Output(Quantity.LUMINOUS_FLUX, 300.0), frame, beam)
    # Both beams, to 10 degrees, lie within the 14.5 degrees that the ball fills.
    for lamp, flux in ((spot, 500.0), (replace(spot, radius=0.05), 500.0), (downlight, 300.0)):
        tracer = tracer_of(GLASS, BLACK, room, glass, lamp)
        made = tracer.trace(PATHS, 2)
        assert_near(made.flux, flux, 2e-3)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("name", ["sphere", "disk", "mesh", "both sides"])
def test_a_small_luminous_surface_in_a_glass_ball_sends_out_all_its_light(name, transport):
    """Nothing is absorbed: what the glass reflects comes back to the lamp, which lets it pass, or is black and small."""
    room = replace(box(4, 4, 4, "black"), id="room", name="room")
    glass, flux = ball("ball", 0.5, (2, 2, 2), "glass"), Output(Quantity.LUMINOUS_FLUX, 300.0)
    place, radius = np.array([2.0, 2.0, 2.15]), 0.01
    frame = np.eye(4)
    frame[:3, 3] = place
    square = quad("lamp", place - radius, (2 * radius, 0, 0), (0, 2 * radius, 0), "glow")
    sides, luminance = 1, 300.0 / (4.0 * np.pi * radius**2)
    if name == "both sides":
        sides, luminance = 2, 0.5 * luminance
    glow = Material("glow", "glow", Black(), Emission(Constant(1.0), luminance, None, sides == 2))
    lamp = {
        "sphere": (PointLight("lamp", "lamp", flux, place, radius),),
        "disk": (AreaLight("lamp", "lamp", flux, frame, 2 * radius, 2 * radius, "ellipse"),),
    }.get(name, (glow, square))
    tracer = tracer_of(GLASS, BLACK, room, glass, *lamp, transport=transport)
    made = tracer.trace(PATHS, 3)
    assert_near(made.flux, 300.0, 2e-3)
    assert tracer.left_out is not None and not tracer.left_out.suns


@pytest.mark.slow
def test_a_small_lamp_in_a_glass_ball_lights_a_room_as_its_lumens_say():
    """A closed room of reflectance 0.5 takes in twice the lumens, however its lamp is wrapped in clear glass."""
    room = replace(box(3, 3, 3), id="room", name="room")
    bulb = ball("bulb", 0.03, (1.5, 1.5, 1.6), "glass", 48)
    lamp = PointLight(
        "lamp", "lamp", Output(Quantity.LUMINOUS_FLUX, 1000.0), np.array([1.5, 1.5, 1.6]), 0.001
    )
    made = bake_in(session_of(paint(0.5), GLASS, room, bulb, lamp), ("room",), 64)
    told = made.maps[0]
    assert abs(told.mean - 2000.0 / 54.0) < 4.0 * told.mean_standard_error + 2e-3 * told.mean


def test_every_light_has_its_share_and_hidden_ones_none():
    room = replace(box(4, 4, 4, "black"), id="room", name="room")
    cell = replace(slab((0.1, 0.1, 0.1), (0.6, 0.6, 0.6), "black"), id="cell", name="cell")
    lamps = [
        PointLight("a", "a", CANDELA, np.array([2.0, 2.0, 3.2])),
        PointLight("b", "b", Output(Quantity.LUMINOUS_INTENSITY, 30.0), np.array([2.0, 3.2, 2.0])),
        PointLight("c", "c", Output(Quantity.LUMINOUS_INTENSITY, 900.0), np.array([0.3, 0.3, 0.3])),
    ]
    glass = ball("ball", 0.5, (2, 2, 2), "glass")
    tracer = tracer_of(GLASS, BLACK, room, cell, glass, *lamps)
    made = tracer.trace(PATHS, 2)
    flux = np.bincount(made.light, weights=made.flux, minlength=3)
    solid_angle = 2.0 * np.pi * (1.0 - np.sqrt(1.0 - (0.5 / 1.2) ** 2))
    by_intensity = {
        round(light.source.flux / (4 * np.pi)): k for k, light in enumerate(tracer.lights)
    }
    assert flux[by_intensity[100]] == pytest.approx(100.0 * solid_angle, rel=5e-3)
    assert flux[by_intensity[30]] == pytest.approx(30.0 * solid_angle, rel=1e-2)
    assert flux[by_intensity[900]] == 0.0


@pytest.mark.parametrize("transport", ["mono", pytest.param("spectral", marks=pytest.mark.slow)])
def test_illuminance_under_a_slab_follows_snell_and_fresnel(transport):
    """A lamp 0.7 m over a slab of 0.5 m that is 1 m over the floor, to 62 degrees; polarisation is not followed."""
    items = (GLASS, BLACK, slab((-20, -20, 1.0), (20, 20, 1.5)), point([0, 0, 2.2]))
    floor = quad("floor", (-4, -4, 0), (8, 0, 0), (0, 8, 0), "black")
    tracer = tracer_of(*items, floor, transport=transport)
    places, flux, rows = landings(tracer, deposits := tracer.trace(4 * PATHS, 11), "black")
    distance = np.hypot(*places[:, :2].T)
    edges = np.array([0.0, 0.2, 0.5, 1.0, 1.8, 2.6, 3.6])
    angle = np.linspace(0.0, np.radians(89.0), 400_001)
    radius, share = through_slab(0.5 * (angle[1:] + angle[:-1]), 1.7, 0.5)
    step = 100.0 * 2.0 * np.pi * (np.cos(angle[:-1]) - np.cos(angle[1:]))
    expected, _ = np.histogram(radius, edges, weights=share * step)
    for low, high, amount in zip(edges[:-1], edges[1:], expected, strict=True):
        assert_near(flux[(distance >= low) & (distance < high)], amount)
    # The direct pass, the strongest at its place, arrives at the angle at which it left.
    assert np.all(deposits.cosine[rows] <= 1.0 + 1e-6)
    near = distance < 0.1
    assert np.average(deposits.cosine[rows][near], weights=flux[near]) > 0.99


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("degrees", [0.0, 45.0])
@pytest.mark.parametrize("angle", [0.0, math.radians(0.53)])
def test_sun_through_a_slab(degrees, angle):
    tilt = np.radians(degrees)
    items = (
        GLASS,
        BLACK,
        slab((-6, -6, 0.5), (6, 6, 0.55)),
        sun([np.sin(tilt), 0, -np.cos(tilt)], angle),
    )
    floor = quad("floor", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "black")
    tracer = tracer_of(*items, floor)
    _, flux, _ = landings(tracer, tracer.trace(4 * PATHS, 1), "black")
    reflected, _ = fresnel(tilt, INDEX)
    assert_near(flux, 4.0 * 1000.0 * np.cos(tilt) * (1.0 - reflected) / (1.0 + reflected))


def test_light_comes_to_glass_by_a_plane_mirror():
    """A lamp that a screen hides from the slab reaches it from its image behind the mirror."""
    mirror = quad("mirror", (4, -4, -1), (0, 0, 8), (0, 8, 0), "mirror")
    screen = quad("screen", (0, -3, 1.8), (3.4, 0, 0), (0, 6, 0), "screen")
    glass = slab((1.0, -2.0, 0.5), (3.99, 2.0, 0.6))
    floor = quad("floor", (2.0, -0.5, 0), (0.8, 0, 0), (0, 1, 0), "black")
    lamp = point([2.5, 0.0, 3.0])
    tracer = tracer_of(
        GLASS, BLACK, MIRROR, paint(0.0, "screen"), mirror, screen, glass, floor, lamp
    )
    assert tracer.scene.mirrors is not None
    _, flux, _ = landings(tracer, tracer.trace(4 * PATHS, 1), "black")
    image = np.array([5.5, 0.0])
    x, y = np.meshgrid(2.0 + (np.arange(400) + 0.5) / 500.0, (np.arange(400) + 0.5) / 400.0 - 0.5)
    away = np.hypot(x - image[0], y - image[1])
    angle = np.linspace(0.0, np.radians(85.0), 200_001)
    radius, share = through_slab(angle, 2.9, 0.1)
    lux = np.zeros_like(x)
    for r, s in zip(radius, share, strict=True):
        density = 100.0 * s * np.sin(angle) / np.maximum(r * np.gradient(r, angle), 1e-12)
        lux += np.interp(away, r, density)
    assert_near(flux, 0.9 * lux.mean() * 0.8, 3e-3)


@pytest.mark.slow
def test_a_mirror_ball_spreads_light_of_a_point():
    """Virtual image by reflection in a convex mirror, exact beyond the paraxial range, on the ceiling over the lamp."""
    radius, lamp_height, ceiling = 0.5, 1.5, 3.0
    shiny = ball("ball", radius, (0, 0, 0), "mirror", rings=192)
    top = quad("top", (-6, -6, ceiling), (0, 12, 0), (12, 0, 0), "black")
    tracer = tracer_of(MIRROR, BLACK, shiny, top, point([0, 0, lamp_height]))
    places, flux, _ = landings(tracer, tracer.trace(4 * PATHS, 4), "black")
    alpha = np.linspace(1e-6, np.radians(35.0), 20_001)
    normal = np.stack([np.sin(alpha), np.cos(alpha)])
    away = radius * normal - np.array([[0.0], [lamp_height]])
    away /= np.linalg.norm(away, axis=0)
    out = away - 2.0 * (away * normal).sum(axis=0) * normal
    reach = radius * normal[0] + (ceiling - radius * normal[1]) * out[0] / out[1]
    edges = np.array([0.05, 0.3, 0.8, 1.5, 2.5, 4.0])
    cosine = np.interp(edges, reach, -away[1])
    distance = np.hypot(*places[:, :2].T)
    for k in range(len(edges) - 1):
        inside = (distance >= edges[k]) & (distance < edges[k + 1])
        assert_near(flux[inside], 0.9 * 200.0 * np.pi * (cosine[k] - cosine[k + 1]), 3e-3)


@pytest.mark.parametrize("distance", [1.5, pytest.param(3.0, marks=pytest.mark.slow)])
def test_a_ball_lens_brings_parallel_light_together(distance):
    """At 1.5 radii from the centre of a ball of index 1.5 lies the paraxial focus; at 3 the beam is as wide as before."""
    half = 0.15
    lens = ball("ball", 1.0, (0, 0, 0), "glass", rings=256)
    screens = [
        replace(quad(str(k), corner, u, v, "screen"), id=str(k))
        for k, (corner, u, v) in enumerate(
            (
                ((-3, -3, 2), (3 - half, 0, 0), (0, 6, 0)),
                ((half, -3, 2), (3 - half, 0, 0), (0, 6, 0)),
                ((-half, -3, 2), (2 * half, 0, 0), (0, 3 - half, 0)),
                ((-half, half, 2), (2 * half, 0, 0), (0, 3 - half, 0)),
            )
        )
    ]
    floor = quad("floor", (-3, -3, -distance), (6, 0, 0), (0, 6, 0), "black")
    tracer = tracer_of(GLASS, BLACK, paint(0.0, "screen"), lens, floor, *screens, sun([0, 0, -1]))
    places, _, _ = landings(tracer, tracer.trace(8 * PATHS, 4), "black")
    reached = np.sort(np.hypot(*places[:, :2].T))
    x, y = np.meshgrid(*2 * [half * (np.arange(1000) + 0.5) / 1000.0])
    height = np.hypot(x, y).ravel()
    turned = 2.0 * (np.arcsin(height) - np.arcsin(height / INDEX))
    landed = np.sort(np.abs(height / np.sin(turned) - distance) * np.tan(turned))
    # Light that is reflected inside is spread far; a third of it would not move these ranks by much.
    for share in (0.25, 0.5, 0.75):
        expected = landed[int(share * len(landed))]
        measured = reached[int(share * len(reached))]
        assert measured == pytest.approx(expected, rel=0.03, abs=4e-4)


def test_a_prism_turns_each_wavelength_by_its_own_angle():
    dense = Material("glass", "glass", Dielectric(Cauchy(1.5, 0.012)))
    apex = np.radians(40.0)
    # Light along x meets the vertical face at right angles and leaves by the sloping one.
    side = np.array([[0, 0, 0], [np.tan(apex), 0, 0], [0, 0, 1.0]])
    depth = np.array([0.0, 1.0, 0.0])
    vertices = np.concatenate([side - depth, side + depth])
    faces = [(0, 1, 2), (3, 5, 4), (0, 2, 5), (0, 5, 3), (1, 4, 5), (1, 5, 2), (0, 3, 4), (0, 4, 1)]
    triangles = np.array(faces, np.int32)
    prism = Mesh("p", "p", vertices, triangles, ("glass",), np.zeros(len(faces), np.int32))
    # A slit at half height keeps the beam narrow.
    screens = [
        replace(quad(k, (-0.5, -2, low), (0, 4, 0), (0, 0, high - low), "screen"), id=k)
        for k, low, high in (("a", -3.0, 0.499), ("b", 0.501, 4.0))
    ]
    wall = quad("wall", (3, -2, -6), (0, 4, 0), (0, 0, 10), "black")
    items = (dense, BLACK, paint(0.0, "screen"), prism, wall, *screens)
    tracer = tracer_of(
        *items, sun([1, 0, 0], output=Output(Quantity.ILLUMINANCE, 1000.0, Illuminant("D65")))
    )
    deposits = tracer.trace(8 * PATHS, 6)
    places, flux, rows = landings(tracer, deposits, "black")
    hero = deposits.wavelengths[rows, 0].astype(float)
    assert np.abs(deposits.parts[rows, 1:]).max() == 0.0
    np.testing.assert_allclose(deposits.parts[rows].sum(axis=1), flux, rtol=1e-5)
    index = 1.5 + 0.012 / (hero * 1e-3) ** 2
    turned = np.arcsin(index * np.sin(apex)) - apex
    start = 0.5 * np.tan(apex)
    expected = 0.5 - (3.0 - start) * np.tan(turned)
    # Among all that lands is light that is reflected inside; the main beam is the rest of it by far.
    off = np.abs(places[:, 2] - expected)
    assert np.average(off < 0.003, weights=flux) > 0.9
    blue, red = hero < 470.0, hero > 630.0
    assert np.median(places[blue, 2]) < np.median(places[red, 2]) - 0.1


def test_light_in_flat_panes_is_left_to_next_event():
    pane = quad("pane", (-2, -2, 1), (4, 0, 0), (0, 4, 0), "pane")
    clear = Material("pane", "pane", ThinGlass(INDEX))
    tracer = tracer_of(clear, pane, point([0, 0, 1.5]))
    assert tracer.scene.mirrors is not None
    assert not tracer.is_needed


def test_light_straight_through_a_pane_that_is_no_mirror_is_left_to_next_event():
    pane = quad("pane", (-2, -2, 1), (4, 0, 0), (0, 4, 0), "pane")
    floor = quad("floor", (-2, -2, 0), (4, 0, 0), (0, 4, 0), "black")
    top = quad("top", (-9, -9, 2), (0, 18, 0), (18, 0, 0), "top")
    # Next-event aims at lights over panes that are nothing else.
    clear = Material("pane", "pane", Mix(ThinGlass(INDEX), ThinGlass(INDEX), 0.5))
    tracer = tracer_of(clear, BLACK, paint(0.0, "top"), pane, floor, top, point([0, 0, 1.5]))
    deposits = tracer.trace(4 * PATHS, 1)
    assert len(landings(tracer, deposits, "black")[1]) == 0
    # Its reflection lights the ceiling like an image, times the reflectance of both faces.
    places, flux, _ = landings(tracer, deposits, "top")
    edges = np.radians([0.0, 20.0, 40.0, 60.0])
    radius = np.hypot(*places[:, :2].T)
    for low, high in zip(edges[:-1], edges[1:], strict=True):
        edge = np.linspace(low, high, 2001)
        angle = 0.5 * (edge[1:] + edge[:-1])
        share = np.zeros_like(angle)
        inside = np.arcsin(np.sin(angle) / INDEX)
        a, b = np.cos(angle), np.cos(inside)
        for r in ((a - INDEX * b) / (a + INDEX * b), (INDEX * a - b) / (INDEX * a + b)):
            share += 0.5 * 2.0 * r**2 / (1.0 + r**2)
        expected = 200.0 * np.pi * (share * -np.diff(np.cos(edge))).sum()
        there = (radius >= 1.5 * np.tan(low)) & (radius < 1.5 * np.tan(high))
        assert_near(flux[there], expected)


@pytest.mark.parametrize(
    ("items", "is_needed"),
    [
        ((MIRROR, quad("m", (-1, -1, 1), (2, 0, 0), (0, 2, 0), "mirror"), point([0, 0, 2])), False),
        ((GLASS, ball("b", 0.4, (0, 0, 1), "glass", 8), point([0, 0, 2], radius=0.01)), True),
        ((GLASS, ball("b", 0.4, (0, 0, 1), "glass", 8), point([0, 0, 2], radius=0.5)), False),
        ((GLASS, ball("b", 0.4, (0, 0, 1), "glass", 8), point([0, 0, 2])), True),
        ((MIRROR, ball("b", 0.4, (0, 0, 1), "mirror", 8), sun([0, 0, -1])), True),
        ((Material("m", "m", Dielectric(Cauchy(1.5), 0.3)),
          quad("m", (-1, -1, 1), (2, 0, 0), (0, 2, 0), "m"), point([0, 0, 2])), False),
        ((Material("m", "m", Transparent()),
          quad("m", (-1, -1, 1), (2, 0, 0), (0, 2, 0), "m"), point([0, 0, 2])), False),
    ],
)  # fmt: skip
def test_tracing_is_needed_where_ideal_or_small_lights_meet_what_bends(items, is_needed):
    tracer = tracer_of(BLACK, quad("floor", (-2, -2, 0), (4, 0, 0), (0, 4, 0), "black"), *items)
    assert tracer.is_needed is is_needed
    assert (len(tracer.trace(1 << 14, 0).flux) > 0) is is_needed


def test_a_cut_out_receives_light_and_lets_the_rest_pass():
    """Half of a sheet under a slab is a hole: sheet and floor get the same light twice over, the floor half of it."""
    holed = Material("holed", "holed", Mix(Diffuse(Constant(0.2)), Transparent(), 0.5))
    sheet = quad("sheet", (-1, -1, 0.2), (2, 0, 0), (0, 2, 0), "holed")
    floor = quad("floor", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "black")
    items = (GLASS, BLACK, holed, slab((-6, -6, 0.5), (6, 6, 0.55)), sheet, floor, sun([0, 0, -1]))
    tracer = tracer_of(*items)
    deposits = tracer.trace(4 * PATHS, 1)
    through = 4.0 * 1000.0 * 0.96 / 1.04
    assert_near(landings(tracer, deposits, "holed")[1], through)
    assert_near(landings(tracer, deposits, "black")[1], 0.5 * through)


def test_same_seed_gives_the_same_arrays_and_others_scatter_as_stated(transport):
    items = (GLASS, BLACK, slab((-20, -20, 1.0), (20, 20, 1.5)), point([0, 0, 2.2]))
    floor = quad("floor", (-1, -1, 0), (2, 0, 0), (0, 2, 0), "black")
    tracer = tracer_of(*items, floor, transport=transport)
    one, again = tracer.trace(1 << 16, 9), tracer.trace(1 << 16, 9)
    fresh = tracer_of(*reversed((*items, floor)), transport=transport).trace(1 << 16, 9)
    for other in (again, fresh):
        np.testing.assert_array_equal(one.flux, other.flux)
        np.testing.assert_array_equal(one.uv, other.uv)
    totals, errors = [], []
    for seed in range(24):
        flux = tracer.trace(1 << 16, seed).flux
        totals.append(flux.sum())
        errors.append(np.sqrt((flux**2).sum()))
    spread = np.std(totals, ddof=1)
    assert 0.0 < spread < 1.4 * np.mean(errors)
    assert abs(np.mean(totals) - one.flux.sum()) < 5.0 * np.mean(errors)


def test_a_sequence_may_be_traced_in_parts():
    room = replace(box(4, 4, 4, "black"), id="room", name="room")
    glass = ball("ball", 0.5, (2, 2, 2), "glass", 16)
    tracer = tracer_of(GLASS, BLACK, room, glass, point([2.0, 2.0, 3.2]))
    whole = tracer.trace(1 << 15, 9)
    halves = [tracer.trace(1 << 14, 9, index) for index in (0, 1 << 14)]
    np.testing.assert_array_equal(whole.uv, np.concatenate([half.uv for half in halves]))
    assert whole.flux.sum() == pytest.approx(0.5 * sum(half.flux.sum() for half in halves))
