"""Ray sets near sensors and what cameras see: their own rays, against closed forms, traced light and lux maps."""

from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake
from ray_lamps import BLACK, exact_disk, floor, lamp_at, lumels_of
from small_scenes import paint, session_of

from lumenray.benchmarks.common.ray_sources import disk, helix, sphere
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Quantity
from lumenray.engine.scene.sensor import SensorKind
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

SIDE, CELLS = 0.6, 4


def grid(count):
    edge = (np.arange(count) + 0.5) / count * SIDE - 0.5 * SIDE
    x, y = (each.ravel() for each in np.meshgrid(edge, edge))
    return np.stack([x, y, np.zeros_like(x)], axis=1)


def by_cells(places, values, weights=None):
    """Means of values in squares of the floor. (CELLS, CELLS)"""
    weights = np.ones(len(values)) if weights is None else weights
    cell = np.minimum(((places[:, :2] / SIDE + 0.5) * CELLS).astype(int), CELLS - 1)
    number = cell[:, 1] * CELLS + cell[:, 0]
    sums = np.bincount(number, weights * values, CELLS**2)
    return (sums / np.bincount(number, weights, CELLS**2)).reshape(CELLS, CELLS)


def quarters(values):
    return values.reshape(2, CELLS // 2, 2, CELLS // 2).mean(axis=(1, 3))


def measure(items, places, samples=1 << 13, normal=(0, 0, 1.0), **more):
    rule = StopRule(samples=samples)
    return session_of(*items).measure(places, np.broadcast_to(normal, places.shape), rule, **more)


def scatter(made):
    """Standard errors but for what the file leaves open. [lx]"""
    return np.sqrt(made.standard_error**2 - made.floors**2)


def test_sensors_near_a_disk_get_its_exact_light(transport):
    """At 1.5 sizes a point would be wrong by a tenth."""
    centre = np.array([0.0, 0.0, 0.15])
    places = grid(8)
    made = measure((BLACK, floor(SIDE), lamp_at(centre)), places, transport=transport)
    exact = exact_disk(places, centre)
    apart = np.abs(made.illuminance - exact)
    assert (apart < 4.5 * scatter(made) + 0.02 * exact).all()
    assert (scatter(made) < 0.03 * exact).all()
    assert (made.illuminance.sum() / exact_disk(places, centre).sum()) == pytest.approx(
        1.0, abs=0.005
    )


@pytest.mark.parametrize("source", [disk, sphere, helix])
@pytest.mark.slow
def test_sensors_get_what_rays_bring(source):
    """From a plane with an axis, a sphere and a hull, close enough for all of the body to matter."""
    from lumenray.engine.transport.light_tracing.light_paths import LightTracer

    items = (BLACK, floor(SIDE), lamp_at(np.array([0.0, 0.0, 0.12]), source))
    places = grid(16)
    made = measure(items, places, 1 << 14)
    session = session_of(*items)
    scene = session._prepare("auto", False)
    scene.settle()
    tracer = LightTracer(scene)
    # All of the light, wherever a bake would leave it to the point.
    tracer.rays._palette.set_limits(np.full(scene.lights.palette.count, 10.0))
    (cloud,) = tracer.rays._clouds
    cloud.upload(scene, [1.0], [10.0])
    cloud.weight = 1.0
    landed = tracer.trace(1 << 21, 3)
    tracer.close()
    weights = np.column_stack([1.0 - landed.uv.sum(axis=1), landed.uv])
    ((_, part, _),) = scene.parts()
    corners = scene.triangles(part).astype(float)[landed.prim]
    at = np.einsum("mk,mki->mi", weights, corners) + scene.origin
    cell = np.minimum(((at[:, :2] / SIDE + 0.5) * CELLS).astype(int), CELLS - 1)
    number = cell[:, 1] * CELLS + cell[:, 0]
    lux = np.bincount(number, landed.flux, CELLS**2) / (SIDE / CELLS) ** 2
    many = np.bincount(number, minlength=CELLS**2)
    ratio = by_cells(places, made.illuminance).ravel() / lux
    assert (np.abs(ratio - 1.0) < 4.5 / np.sqrt(many) + 0.01).all(), ratio
    assert made.illuminance.mean() == pytest.approx(lux.mean(), rel=0.005)


def camera(height=0.5, pixels=32):
    frame = np.eye(4)
    frame[:3, 3] = 0.0, 0.0, height
    return Camera(
        frame=frame,
        projection=Projection.ORTHOGRAPHIC,
        width=pixels,
        height=pixels,
        extent_x=SIDE,
        extent_y=SIDE,
    )


def seen(items, samples=64, **more):
    """Luminance of the floor by squares, over its reflectance over pi. [lx]"""
    picture = session_of(*items).render(camera(**more), ViewSettings(StopRule(samples=samples)))
    luminance = picture.tristimulus[..., 1]
    step = luminance.shape[0] // CELLS
    return luminance.reshape(CELLS, step, CELLS, step).mean(axis=(1, 3)) * np.pi / 0.5


@pytest.mark.slow
def test_pictures_and_maps_agree_about_a_ray_set_30_cm_from_a_wall():
    centre, wall = np.array([0.05, 0.0, 0.3]), floor(SIDE, material="paint")
    items = (paint(0.5), wall, lamp_at(centre))
    result = bake(items, ("floor",), 4096, density=40.0, margin=1)
    values, places = lumels_of(result, wall)
    lux = by_cells(places, values.illuminance.astype(float), values.area.astype(float))
    made = measure(items, grid(16), 1 << 14)
    for found in (seen(items, 1024), by_cells(grid(16), made.illuminance)):
        # The map takes the light for a point where that is right within half a percent of the whole.
        np.testing.assert_allclose(quarters(found), quarters(lux), rtol=0.01)
        np.testing.assert_allclose(found, lux, rtol=0.02)


def test_light_near_by_is_linear_and_mirrored():
    """Twice the flux is twice the light; a mirror behind the lamp shows it a second time, at the place of its image."""
    from glass_scenes import MIRROR
    from small_scenes import quad

    centre = np.array([0.0, 0.0, 0.15])
    lamp = lamp_at(centre)
    places = grid(8)
    once = measure((BLACK, floor(SIDE), lamp), places)
    double = replace(lamp, output=replace(lamp.output, value=2.0 * lamp.output.value))
    twice = measure((BLACK, floor(SIDE), double), places)
    np.testing.assert_allclose(twice.illuminance, 2.0 * once.illuminance, rtol=1e-5)
    assert lamp.output.quantity is Quantity.LUMINOUS_FLUX
    mirror = quad("mirror", (0.1, -2, -1), (0, 0, 3.0), (0, 4.0, 0), "mirror")
    lit = places[:, 0] < 0.05
    # Most of the light comes straight, so what it is must be known well.
    once = measure((BLACK, floor(SIDE), lamp), places[lit], 1 << 14)
    mirrored = measure((BLACK, MIRROR, floor(SIDE), mirror, lamp), places[lit], 1 << 14)
    added = (mirrored.illuminance - once.illuminance).sum()
    expected = 0.9 * exact_disk(places[lit], np.array([0.2, 0.0, 0.15])).sum()
    errors = np.hypot(scatter(once), scatter(mirrored))
    error = np.sqrt((errors**2).sum())
    assert error < 0.04 * expected
    assert abs(added - expected) < 4.0 * error + 0.02 * expected


def test_spheres_of_sensors_get_the_light_of_rays():
    """At a place on the axis the mean illuminance of a small ball is a quarter of all that arrives."""
    centre = np.array([0.0, 0.0, 0.2])
    items = (BLACK, floor(SIDE), lamp_at(centre))
    place = np.array([[0.0, 0.0, 0.05]])
    made = measure(items, place, 1 << 16, kind=SensorKind.SPHERICAL)
    # A disk of luminance L under the half angle a: 2 pi L (1 - cos a) / 4.
    luminance = 100.0 / (np.pi**2 * 0.05**2)
    expected = 0.5 * np.pi * luminance * (1.0 - 0.15 / np.hypot(0.15, 0.05))
    assert made.illuminance[0] == pytest.approx(expected, rel=0.02)


def test_scenes_without_anything_near_a_ray_set_keep_their_point():
    from lumenray.engine.transport.light_tracing.near_rays import near_rays

    far = session_of(BLACK, floor(SIDE), lamp_at(np.array([0.0, 0.0, 3.0])))
    scene = far._prepare("auto", False)
    with near_rays(scene, np.array([[0.0, 0.0, -1.0]])) as notes:
        assert scene.lights.palette.near is None
        assert notes == ()
    near = far.scene.lights["led"].rays.near
    with near_rays(scene, scene.local([[0.0, 0.0, 3.0 - 0.9 * near]])):
        assert scene.lights.palette.near is not None
    assert scene.lights.palette.near is None
