"""Rays of cameras: projections and apertures against closed forms, clipping and what lies outside an image circle."""

from dataclasses import replace

import numpy as np
import pytest
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import UniformWorld
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

PIXELS = 256

# What each camera sees, as a share of all directions.
PANORAMAS = {
    "equirectangular": (
        Camera(np.eye(4), Projection.EQUIRECTANGULAR, PIXELS, PIXELS, 2 * np.pi, np.pi),
        1.0,
    ),
    "part": (
        Camera(
            np.eye(4),
            Projection.EQUIRECTANGULAR,
            PIXELS,
            PIXELS,
            extent_x=1.5,
            extent_y=0.7,
            shift_x=0.25,
            shift_y=0.55,
        ),
        1.5 * (np.sin(0.9) - np.sin(0.2)) / (4.0 * np.pi),
    ),
    "cylinder": (
        Camera(np.eye(4), Projection.CENTRAL_CYLINDRICAL, PIXELS, PIXELS, np.pi, 3.0, shift_y=0.5),
        0.25 * (np.sin(np.arctan(2.0)) + np.sin(np.arctan(1.0))),
    ),
    "cube face": (
        Camera(np.eye(4), Projection.CUBE_FACE, PIXELS, PIXELS, np.pi / 2, np.pi / 2),
        1.0 / 6.0,
    ),
    "equidistant": (
        Camera(np.eye(4), Projection.EQUIDISTANT, PIXELS, PIXELS, 4.0, 4.0, field=4.0),
        0.5 * (1.0 - np.cos(2.0)),
    ),
    "equisolid": (
        Camera(np.eye(4), Projection.EQUISOLID, PIXELS, PIXELS, 3.5, 4.0, field=3.0),
        0.5 * (1.0 - np.cos(1.5)),
    ),
    "mirror ball": (Camera(np.eye(4), Projection.MIRROR_BALL, PIXELS, PIXELS, 2.0, 2.0), 1.0),
}


@pytest.fixture(autouse=True)
def _mono():
    from lumenray.engine.transport import backend

    backend.start(False)


def film_of(camera):
    from lumenray.engine.transport.paths.film import Film

    return Film(camera, np.zeros(3))


def rays_of(camera, x, y, lens=(0.5, 0.5)):
    """Starts, directions and lengths of rays through places on the film. (n, 3), (n, 3), (n,)"""
    import drjit as dr
    import mitsuba as mi

    lens = np.broadcast_to(np.asarray(lens, dtype=float), (len(x), 2)).T
    ray = film_of(camera).ray(mi.Float(x), mi.Float(y), mi.Point2f(*map(mi.Float, lens)))
    zero = dr.zeros(mi.Float, len(x))
    start, direction = (
        np.stack([np.array(part + zero) for part in each], axis=1) for each in (ray.o, ray.d)
    )
    return start, direction, np.array(ray.maxt + zero)


def grid():
    """Middles of all pixels."""
    x, y = (each.ravel() + 0.5 for each in np.meshgrid(np.arange(PIXELS), np.arange(PIXELS)))
    return x, y


def places_of(camera, direction):
    import mitsuba as mi

    vector = mi.Vector3f(*map(mi.Float, direction.T))
    places, density, seen = film_of(camera).panorama.places(vector)
    wide = np.ones(len(direction))
    places = [tuple(np.array(part) * wide for part in place) for place in places]
    return places, np.array(density) * wide, np.array(seen) & (wide > 0)


@pytest.mark.parametrize("name", PANORAMAS)
def test_solid_angles_of_pixels_add_up_to_what_is_seen(name):
    """By the densities of the way back, in the directions of the way out."""
    camera, share = PANORAMAS[name]
    _, direction, length = rays_of(camera, *grid())
    seen = length > 0.0
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1.0, rtol=1e-5)
    _, density, known = places_of(camera, direction[seen])
    assert known.mean() > 0.999
    area = abs(film_of(camera).extent.x[0] * film_of(camera).extent.y[0]) / PIXELS**2
    assert (area / density).sum() / (4.0 * np.pi) == pytest.approx(share, rel=3e-3)


@pytest.mark.parametrize("name", PANORAMAS)
def test_directions_come_from_the_places_that_look_there(name):
    camera, _ = PANORAMAS[name]
    x, y = (each[::97] for each in grid())
    _, direction, length = rays_of(camera, x, y)
    seen = length > 0.0
    places, _, _ = places_of(camera, direction[seen])
    px = (x[seen] / PIXELS - 0.5) * camera.extent_x + camera.shift_x
    py = (y[seen] / PIXELS - 0.5) * camera.extent_y + camera.shift_y
    away = np.min([np.hypot(a - px, b - py) for a, b in places], axis=0)
    assert away.max() < 2e-3


def test_fisheyes_turn_away_from_the_axis_as_their_formulas_say():
    x = np.array([PIXELS / 2 + 1e-3, 0.6 * PIXELS, 0.9 * PIXELS])
    r = 2.0 * x / PIXELS - 1.0
    y = np.full(3, PIXELS / 2)
    common = np.eye(4), PIXELS, PIXELS
    angles = {
        Projection.EQUIDISTANT: r,
        Projection.EQUISOLID: 2.0 * np.arcsin(r / 2.0),
        Projection.MIRROR_BALL: 2.0 * np.arcsin(r),
        Projection.POLYNOMIAL: 0.01 + 0.8 * r + 0.1 * r**2 - 0.2 * r**3 + 0.05 * r**4,
    }
    for projection, expected in angles.items():
        camera = Camera(
            common[0],
            projection,
            *common[1:],
            2.0,
            2.0,
            polynomial=(-0.01, -0.8, -0.1, 0.2, -0.05),
        )
        _, direction, _ = rays_of(camera, x, y)
        np.testing.assert_allclose(direction[:, 0], np.sin(expected), atol=2e-6)
        np.testing.assert_allclose(direction[:, 1], 0.0, atol=1e-6)
        np.testing.assert_allclose(direction[:, 2], -np.cos(expected), atol=2e-6)


def test_nothing_is_seen_outside_the_circle():
    camera = replace(PANORAMAS["equidistant"][0], clip_end=5.0, clip_start=1.0)
    x, y = grid()
    start, _, length = rays_of(camera, x, y)
    radius = np.hypot(x - PIXELS / 2, y - PIXELS / 2)
    inside = radius < 0.4999 * PIXELS
    np.testing.assert_allclose(np.linalg.norm(start[inside], axis=1), 1.0, rtol=1e-5)
    np.testing.assert_allclose(length[inside], 4.0, rtol=1e-6)
    assert (length[radius > 0.5001 * PIXELS] == 0.0).all()


# ---- apertures ----


def opening(count=1 << 14, **more):
    """Points of an aperture of the radius 1. (n, 2)"""
    import mitsuba as mi

    from lumenray.engine.transport.paths.aperture import Aperture

    camera = Camera(np.eye(4), Projection.PERSPECTIVE, 4, 4, aperture_radius=1.0, **more)
    sample = np.random.default_rng(5).random((2, count))
    return np.stack(
        [np.array(part) for part in Aperture(camera).sample(mi.Point2f(*map(mi.Float, sample)))],
        axis=1,
    )


@pytest.mark.parametrize("blades", [3, 4, 6, 11])
def test_points_of_a_polygon_lie_within_and_are_even_over_it(blades):
    rotation, half = 0.3, np.pi / blades
    points = opening(aperture_blades=blades, aperture_rotation=rotation)
    sides = rotation + 2.0 * half * np.arange(blades)
    # Across the sides: at most as far as these, the middle one of which is turned by the rotation.
    height = (points @ np.stack([np.cos(sides), np.sin(sides)])).max(axis=1)
    assert height.max() <= np.cos(half) * (1.0 + 1e-5)
    assert height.max() > 0.99 * np.cos(half)
    # Polygons of half the size hold a quarter, and every side has its share.
    inner = height / np.cos(half)
    assert (inner < 0.5).mean() == pytest.approx(0.25, abs=4 * np.sqrt(0.1875 / len(points)))
    turn = (np.arctan2(points[:, 1], points[:, 0]) - rotation + half) % (2.0 * np.pi)
    counts = np.bincount((turn / (2.0 * half)).astype(int) % blades, minlength=blades)
    expected = len(points) / blades
    assert ((counts - expected) ** 2 / expected).sum() < blades + 5.0 * np.sqrt(2.0 * blades)
    square = (points**2).sum(axis=1)
    error = 4.0 * square.std() / np.sqrt(len(points))
    assert square.mean() == pytest.approx((2.0 + np.cos(2.0 * half)) / 6.0, abs=error)


def test_a_round_aperture_is_made_narrower_by_its_ratio():
    points = opening(aperture_ratio=2.0)
    assert (np.hypot(2.0 * points[:, 0], points[:, 1]) <= 1.0 + 1e-6).all()
    assert (2.0 * points[:, 0]).var() == pytest.approx(0.25, rel=0.04)
    assert points[:, 1].var() == pytest.approx(0.25, rel=0.04)


LENSES = {
    "perspective": Camera(np.eye(4), Projection.PERSPECTIVE, PIXELS, PIXELS),
    "orthographic": Camera(np.eye(4), Projection.ORTHOGRAPHIC, PIXELS, PIXELS),
    "equidistant": PANORAMAS["equidistant"][0],
    "mirror ball": PANORAMAS["mirror ball"][0],
}


@pytest.mark.parametrize("name", LENSES)
def test_rays_through_all_of_a_lens_meet_in_focus(name):
    camera = replace(LENSES[name], focus_distance=3.0, clip_start=0.5, clip_end=4.0)
    lens = np.random.default_rng(2).random((64, 2))
    x, y = np.full(64, 0.6 * PIXELS), np.full(64, 0.7 * PIXELS)
    start, direction, _ = rays_of(camera, x[:1], y[:1])
    open_lens = replace(camera, aperture_radius=0.2, aperture_blades=5)
    starts, directions, lengths = rays_of(open_lens, x, y, lens)
    if camera.projection.is_panoramic:
        focus = direction * 3.0
        near, far = 0.5, None
    else:
        focus = start + direction * ((-3.0 - start[:, 2:]) / direction[:, 2:])
        near, far = starts[:, 2], (starts + directions * lengths[:, None])[:, 2]
        np.testing.assert_allclose(near, -0.5, rtol=1e-5)
        np.testing.assert_allclose(far, -4.0, rtol=1e-5)
    away = focus - starts
    past = away - directions * (away * directions).sum(axis=1)[:, None]
    assert np.linalg.norm(past, axis=1).max() < 1e-5
    assert np.ptp(starts, axis=0).max() > 0.2


def test_places_in_focus_are_seen_at_one_place_by_all_of_an_orthographic_lens():
    import mitsuba as mi

    from lumenray.engine.transport.light_tracing.camera_places import CameraPlaces
    from lumenray.engine.transport.paths.sampler import random_stream

    camera = replace(LENSES["orthographic"], focus_distance=3.0, aperture_radius=0.4, clip_end=3.5)
    rng = np.random.default_rng(3)
    points = np.stack([*(rng.random((2, 32)) - 0.5), np.full(32, -3.0)])
    stream = random_stream(mi.UInt32(np.arange(32)), mi.UInt32(1))
    places = CameraPlaces(film_of(camera))
    link = places.link(mi.Point3f(*map(mi.Float, points)), stream)
    ((x, y),) = link.places
    np.testing.assert_allclose(np.array(x), (points[0] + 0.5) * PIXELS, atol=1e-3)
    np.testing.assert_allclose(np.array(y), (points[1] + 0.5) * PIXELS, atol=1e-3)
    direction = np.stack([np.array(part) for part in link.direction], axis=1)
    start = np.stack([np.array(part) for part in link.start], axis=1)
    np.testing.assert_allclose(start[:, 2], 0.0, atol=1e-6)
    np.testing.assert_allclose(np.array(link.density) * direction[:, 2], PIXELS**2, rtol=1e-5)
    assert np.array(link.seen).all()
    beyond = places.link(mi.Point3f(0.0, 0.0, -4.0), stream)
    assert not np.array(beyond.seen).any()


# ---- pictures ----

FLOOR = quad("floor", (-9, -9, -2), (18, 0, 0), (0, 18, 0), "paint")
NEAR = quad("near", (-9, -9, -1), (9, 0, 0), (0, 18, 0), "paint")
WORLD = UniformWorld(10.0)


def render(session, camera, **more):
    settings = ViewSettings(StopRule(samples=16), transport="mono", transparent=True, **more)
    return session.render(camera, settings)


def picture_of(camera, *items, **more):
    return render(session_of(paint(0.0), WORLD, *items), camera, **more)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("method", ["paths", "cells"])
@pytest.mark.parametrize(
    "projection", [Projection.PERSPECTIVE, Projection.ORTHOGRAPHIC, Projection.EQUIDISTANT]
)
def test_surroundings_show_beyond_the_end_of_the_clipping(projection, method):
    """A black floor 2 m below the camera, half covered by one at 1 m."""
    camera = Camera(np.eye(4), projection, 16, 16, 0.3, 0.3, clip_start=0.1)
    session = session_of(paint(0.0), WORLD, FLOOR, NEAR)
    ends = ((None, 0.0, 0.0), (3.0, 0.0, 0.0), (1.8, 0.0, 10.0), (0.9, 10.0, 10.0))
    for end, left, right in ends if method == "paths" else ends[2:3]:
        made = render(session, replace(camera, clip_end=end), method=method)
        luminance = made.tristimulus[..., 1]
        np.testing.assert_allclose(luminance[:, :7], left, rtol=1e-4)
        np.testing.assert_allclose(luminance[:, 9:], right, rtol=1e-4)
        np.testing.assert_allclose(made.coverage[:, 9:], 1.0 - right / 10.0, atol=1e-4)
        assert (made.depth[:, :7] > 1e9).all() == (left > 0.0)
    made = render(session, replace(camera, clip_start=1.1, clip_end=1.9), method=method)
    np.testing.assert_allclose(made.tristimulus[..., 1], 10.0, rtol=1e-4)


def test_the_end_of_the_clipping_holds_behind_panes_and_not_for_light():
    from lumenray.engine.scene.material import Material, Transparent
    from lumenray.engine.scene.spectrum import Constant

    pane = quad("pane", (-9, -9, -1), (18, 0, 0), (0, 18, 0), "foil")
    foil = Material("foil", "foil", Transparent(Constant(1.0)))
    camera = Camera(np.eye(4), Projection.PERSPECTIVE, 8, 8, 0.1, 0.1)
    for end, expected in ((1.8, 10.0), (3.0, 0.0)):
        made = picture_of(replace(camera, clip_end=end), FLOOR, pane, foil)
        np.testing.assert_allclose(made.tristimulus[..., 1], expected, rtol=1e-4)
        np.testing.assert_allclose(made.coverage, 1.0 - expected / 10.0, atol=1e-4)
    # A mirror shows what is farther away than the camera sees.
    from lumenray.engine.scene.material import Glossy

    mirror = quad("mirror", (-9, -9, -1), (18, 0, 0), (0, 18, 0), "mirror")
    roof = quad("roof", (-9, -9, 5), (18, 0, 0), (0, 18, 0), "paint")
    chrome = Material("mirror", "mirror", Glossy(Constant(1.0), 0.0))
    made = picture_of(replace(camera, clip_end=1.5), mirror, chrome, roof)
    np.testing.assert_allclose(made.tristimulus[..., 1], 0.0, atol=1e-6)


@pytest.mark.parametrize("method", ["paths", "cells"])
def test_outside_the_circle_a_picture_is_black_and_transparent(method):
    camera = Camera(np.eye(4), Projection.EQUIDISTANT, 32, 32, 2.0, 2.0, field=2.0)
    grey = quad("floor", (-9, -9, -2), (18, 0, 0), (0, 18, 0), "grey")
    made = picture_of(camera, grey, paint(0.5, "grey"), method=method, guides=True)
    x, y = (each - 15.5 for each in np.meshgrid(np.arange(32), np.arange(32)))
    outside, inside = np.hypot(x, y) > 18.0, np.hypot(x, y) < 14.0
    for field in (made.tristimulus, made.coverage, made.backdrop):
        assert (field[outside] == 0.0).all()
    assert (made.depth[outside] > 1e9).all()
    assert (made.denoising_depth[outside] == 0.0).all()
    assert made.tristimulus[inside, 1].mean() == pytest.approx(5.0, rel=0.02)
    np.testing.assert_allclose(made.coverage[inside], 1.0, atol=1e-6)
    # Pixels on the rim are seen in part: their sum is that of the circle's area.
    assert made.coverage.sum() == pytest.approx(np.pi * 16.0**2, rel=0.01)


def test_another_number_is_no_other_kernel():
    """Clipping, aperture and field are data."""
    import drjit as dr

    from lumenray.engine.transport.paths.film import Film

    def ptr(camera):
        import mitsuba as mi

        ray = Film(camera, np.zeros(3)).ray(
            mi.Float([1.0, 2.0]), mi.Float([1.0, 2.0]), mi.Point2f(0.5)
        )
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory):
            dr.kernel_history_clear()
            dr.eval(ray)
            return [entry["hash"] for entry in dr.kernel_history() if "hash" in entry]

    one = Camera(
        np.eye(4), Projection.EQUISOLID, 8, 8, 2.0, 2.0, aperture_radius=0.1, aperture_blades=5,
        clip_end=10.0, field=2.0,
    )  # fmt: skip
    other = replace(
        one, aperture_radius=0.2, aperture_blades=7, aperture_ratio=2.0, aperture_rotation=1.0,
        clip_end=20.0, clip_start=0.1, field=3.0, extent_x=1.0,
    )  # fmt: skip
    first = ptr(one)
    assert first
    assert ptr(other) == first


def test_live_views_are_black_outside_the_circle_and_clipped_too():
    from lumenray.engine.live import LiveSettings
    from lumenray.engine.transport.paths.live_view import LiveView

    camera = Camera(np.eye(4), Projection.EQUIDISTANT, 32, 32, 2.0, 2.0, field=2.0)
    session = session_of(paint(0.0), WORLD, FLOOR)
    scene = session._prepare("mono", False)
    scene.settle()
    x, y = (each - 15.5 for each in np.meshgrid(np.arange(32), np.arange(32)))
    away = np.hypot(x, y)
    for end, expected in ((None, 0.0), (1.9, 10.0)):
        view = LiveView(scene, replace(camera, clip_end=end), LiveSettings(samples=8))
        while not view.is_complete:
            view.refine()
        luminance = view.image()[..., 1]
        assert (luminance[away > 18.0] == 0.0).all()
        np.testing.assert_allclose(luminance[away < 14.0], expected, rtol=1e-4)
