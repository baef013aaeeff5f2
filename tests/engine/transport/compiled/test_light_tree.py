"""Choice among many lights: drawn as stated, unbiased, of little noise however many there are."""

from dataclasses import replace

import numpy as np
import pytest
from luminaires import DISTRIBUTIONS, frame_of, luminaire, turn
from scipy import stats
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.distribution import Opening
from lumenray.engine.scene.light import (
    AreaLight,
    Luminaire,
    Output,
    PointLight,
    Quantity,
    SpotLight,
    UniformWorld,
)
from lumenray.engine.scene.scene import Scene, SceneDelta
from lumenray.engine.transport import backend

pytestmark = pytest.mark.mitsuba

HALL = 50.0
"""Side of the hall. [m]"""

SIGNIFICANCE = 1e-4


@pytest.fixture(autouse=True)
def _mono():
    backend.start(spectral=False)


def compiled(*items):
    from lumenray.engine.requirements.plan import make_plan
    from lumenray.engine.transport.compiled.compile import CompiledScene

    scene = Scene()
    scene.apply(SceneDelta(changed=tuple(items)))
    return CompiledScene(scene, make_plan(scene, transport="mono"))


def flux(value):
    return Output(Quantity.LUMINOUS_FLUX, float(value))


def places(count, seed, low=2.5, high=6.0):
    return np.random.default_rng(seed).uniform([0, 0, low], [HALL, HALL, high], (count, 3))


def mixed_lights():
    """Lights of all kinds, flat and narrow ones turned anyhow, under a sky."""
    rng = np.random.default_rng(4)
    made = [UniformWorld(3.0)]
    for i, place in enumerate(places(90, 5)):
        key, output, axes = f"l{i}", flux(10.0 * rng.lognormal()), turn(i)
        match i % 5:
            case 0:
                made.append(PointLight(key, key, output, place))
            case 1:
                made.append(PointLight(key, key, output, place, 0.2))
            case 2:
                made.append(AreaLight(key, key, output, frame_of(place, axes), 0.6, 0.3))
            case 3:
                made.append(SpotLight(key, key, output, place, axes[:, 2], 0.5, 0.3))
            case 4:
                made.append(luminaire("asymmetric", Opening(), place, axes, key=key))
    return made


def downlights(count, seed=1):
    """Lambertian points under the ceiling of the hall, of different fluxes, and their axial intensities and places."""
    rng = np.random.default_rng(seed)
    where = places(count, seed, 5.5, 5.5)
    amounts = rng.uniform(200.0, 2000.0, count)
    lights = [
        Luminaire(f"d{i}", f"d{i}", flux(amount), frame_of(place), DISTRIBUTIONS["lambertian"])
        for i, (amount, place) in enumerate(zip(amounts, where, strict=True))
    ]
    return lights, amounts / np.pi, where


def device_points(scene, points):
    import mitsuba as mi

    from lumenray.engine.arrays import upload

    local = scene.local(points)
    return mi.Point3f(*(upload(mi.Float, local[:, i]) for i in range(3)))


def probabilities(scene, points):
    """Stated probabilities of all lights at points. (k, n)"""
    import drjit as dr
    import mitsuba as mi

    lights = scene.lights
    lane = dr.arange(mi.UInt32, len(points) * lights.count)
    many = dr.opaque(mi.UInt32, lights.count)
    at = dr.gather(mi.Point3f, device_points(scene, points), lane // many)
    index = lane % many
    found = lights.probability(lights.pointer(index), at, mi.Bool(True), lights.row(index))
    return np.array(found, dtype=np.float64).reshape(len(points), lights.count)


def towards(scene, points):
    """Squared distances from lights to points and cosines to their nadir, (k, n) each, in the table's order."""
    where = np.array([source.centre + scene.origin for source in scene.lights.sources])
    away = points[:, None] - where
    squared = (away**2).sum(axis=-1)
    return squared, np.maximum(-away[..., 2] / np.sqrt(squared), 0.0)


# ---- the tree ----


@pytest.mark.parametrize("count", [17, 100, 1000, 5000])
def test_every_light_has_one_place(count):
    from lumenray.engine.transport.compiled.light_tree import LEAF, arrange

    rng = np.random.default_rng(count)
    found = arrange(rng.normal(size=(count, 3)), rng.random(count) + 0.1)
    assert found.shape[1] == LEAF
    assert sorted(found[found >= 0]) == list(range(count))


def test_no_leaf_holds_lights_of_two_houses():
    from lumenray.engine.transport.compiled.light_tree import arrange

    rng = np.random.default_rng(2)
    sizes = [61, 13, 26, 5, 45]
    house = np.repeat(np.arange(len(sizes)), sizes)
    centres = rng.random((len(house), 3)) * 10.0 + 1000.0 * rng.random((len(sizes), 3))[house]
    leaves = arrange(centres, np.ones(len(house)))
    for leaf in leaves:
        assert len(set(house[leaf[leaf >= 0]])) <= 1


# ---- the choice ----


@pytest.mark.slow
def test_lights_are_drawn_with_the_stated_probabilities():
    import drjit as dr
    import mitsuba as mi

    scene = compiled(*mixed_lights())
    lights = scene.lights
    points = places(12, 8, 0.0, 8.0)
    stated = probabilities(scene, points)
    np.testing.assert_allclose(stated.sum(axis=1), 1.0, atol=2e-6)
    assert stated.min() > 0.0
    lanes = 1 << 18
    at = device_points(scene, points)
    for k in range(len(points)):
        u = mi.PCG32(size=lanes, initstate=k + 1).next_float32()
        point = dr.gather(mi.Point3f, at, dr.full(mi.UInt32, k, lanes))
        index, share, rest = lights.sample(u, point)
        index, rest = np.array(index), np.array(rest, dtype=np.float64)
        np.testing.assert_allclose(np.array(share), stated[k, index], rtol=2e-5)
        found = np.bincount(index, minlength=lights.count)
        expected = stated[k] * (lanes / stated[k].sum())
        # Rare lights are counted together.
        order = np.argsort(expected)
        group = np.empty(len(order), dtype=int)
        group[order] = np.cumsum(expected[order]) // 25
        found, expected = np.bincount(group, found), np.bincount(group, expected)
        kept = expected > 0.0
        _, p = stats.chisquare(found[kept], expected[kept])
        assert p > SIGNIFICANCE
        # What is left of the number serves to draw a point of the light.
        assert stats.kstest(rest[::16], "uniform").pvalue > SIGNIFICANCE


def test_probabilities_sum_to_one_wherever_the_point_is():
    lights, _, where = downlights(300)
    scene = compiled(*lights)
    points = np.concatenate(
        [places(50, 3, -50.0, 50.0), where[:20], where[:20] + np.array([0.0, 0.0, 1e-4])]
    )
    far = np.array([[1e5, -2e5, 3e4]])
    found = probabilities(scene, np.concatenate([points, far]))
    np.testing.assert_allclose(found.sum(axis=1), 1.0, atol=3e-6)
    assert found.min() > 0.0


def test_lights_at_one_place_share_evenly():
    lights = [PointLight(f"l{i}", f"l{i}", flux(5.0), np.array([1.0, 2.0, 3.0])) for i in range(50)]
    found = probabilities(compiled(*lights), np.array([[0.0, 0.0, 0.0], [1.0, 2.0, 3.0]]))
    np.testing.assert_allclose(found.sum(axis=1), 1.0, atol=3e-6)
    assert found.min() > 0.2 / 50


@pytest.mark.parametrize("count", [100, 1000])
def test_noise_does_not_grow_with_the_number_of_lights(count):
    lights, intensities, where = downlights(count)
    scene = compiled(*lights)
    points = places(100, 9, 0.8, 0.8)
    squared, cosine = towards(scene, points)
    # The table has its own order.
    places_found = np.array([s.centre + scene.origin for s in scene.lights.sources])
    nearest = ((places_found[:, None] - where) ** 2).sum(axis=-1).argmin(axis=1)
    given = intensities[nearest] * cosine**2 / squared
    total = given.sum(axis=1)
    variance = (given**2 / probabilities(scene, points)).sum(axis=1) / total**2 - 1.0
    # One choice for all points has 15 at best: at each point, few of the lights of a hall count. With perfect knowledge
    # of the intensities alone, cosines to the floor aside, 0.15 are left.
    assert variance.mean() < 0.6


def test_learning_finds_lights_behind_a_wall():
    from lumenray.engine.transport.paths.light_learning import learn

    lights, _, _ = downlights(400)
    wall = quad("wall", [25, -1, -1], [0, 52, 0], [0, 0, 8], "paint")
    scene = compiled(paint(0.5), wall, *lights)
    points = places(500, 3, 0.8, 0.8) * [0.45, 1.0, 1.0]
    up = np.tile(np.float32([0, 0, 1]), (len(points), 1))
    is_hidden = np.array([s.centre[0] + scene.origin[0] > 25.0 for s in scene.lights.sources])
    near_wall = np.column_stack([np.full(50, 23.0), np.linspace(1, 49, 50), np.full(50, 0.8)])
    before = probabilities(scene, near_wall)[:, is_hidden].sum(axis=1).mean()
    learn(scene, scene.local(points), up, None)
    found = probabilities(scene, near_wall)
    assert before > 0.3
    assert found[:, is_hidden].sum(axis=1).mean() < 0.2 * before
    assert found.min() > 0.02 / 400


# ---- results ----


@pytest.mark.parametrize("kind", ["points", "spheres", "luminaires"])
@pytest.mark.slow
def test_a_thousand_lights_give_the_sum_of_each(kind):
    count = 1000 if kind != "spheres" else 200
    rng = np.random.default_rng(6)
    where, amounts = places(count, 2), rng.lognormal(size=count) * 100.0
    points = places(24, 7, 0.0, 2.0)
    normals = rng.normal(size=(24, 3)) + np.array([0.0, 0.0, 2.0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    away = where - points[:, None]
    distance = np.linalg.norm(away, axis=-1)
    cosine = np.maximum((away * normals[:, None]).sum(axis=-1) / distance, 0.0)
    intensity = amounts / (4.0 * np.pi)
    if kind == "luminaires":
        lights, intensity, where = downlights(count)
        away = where - points[:, None]
        distance = np.linalg.norm(away, axis=-1)
        cosine = np.maximum((away * normals[:, None]).sum(axis=-1) / distance, 0.0)
        intensity = intensity * away[..., 2] / distance
    else:
        # A sphere of even luminance above the horizon gives what a point gives.
        radius = 0.1 if kind == "spheres" else 0.0
        if radius:
            normals = np.tile([0.0, 0.0, 1.0], (24, 1))
            cosine = away[..., 2] / distance
        lights = [
            PointLight(f"l{i}", f"l{i}", flux(a), p, radius)
            for i, (a, p) in enumerate(zip(amounts, where, strict=True))
        ]
    expected = (intensity * cosine / distance**2).sum(axis=1)
    made = session_of(*lights).measure(points, normals, StopRule(samples=1 << 15), seed=2)
    score = (made.illuminance - expected) / made.standard_error
    assert np.abs(score).max() < 4.5
    assert np.sqrt((score**2).mean()) < 1.6
    assert (made.standard_error / expected).max() < 0.03


@pytest.mark.slow
def test_ids_decide_nothing():
    lights = mixed_lights()
    renamed = [
        light if isinstance(light, UniformWorld) else replace(light, id=f"x{97 * i % 101}")
        for i, light in enumerate(lights)
    ]
    room = paint(0.4), box(HALL, HALL, 7.0)
    points, up = places(16, 1, 0.5, 1.0), np.tile([0.0, 0.0, 1.0], (16, 1))
    results = []
    for items in (lights, renamed[::-1]):
        session = session_of(*room, *items)
        results.append(session.measure(points, up, StopRule(samples=256), seed=5).illuminance)
        # Kernels know how many emitters live.
        del session
    np.testing.assert_array_equal(*results)


@pytest.mark.slow
def test_edits_meet_known_kernels():
    import drjit as dr

    lights, _, _ = downlights(40)
    session = session_of(paint(0.5), box(HALL, HALL, 6.0), *lights)
    points, up = places(16, 1, 0.5, 1.0), np.tile([0.0, 0.0, 1.0], (16, 1))

    def edits(k):
        yield replace(lights[3], output=flux(77.0 + k))
        yield replace(lights[4], frame=frame_of((9.0 + k, 8.0, 4.0)))
        # From 40 lights to well beyond the next power of two and of four; none at a wall, whose spot paths would ask for.
        for i in range(60 * k):
            place = ((i + 1) / 3.1, 5.0 * k, 5.0)
            yield replace(lights[0], id=f"more {k} {i}", frame=frame_of(place))

    dr.set_flag(dr.JitFlag.KernelHistory, True)
    try:
        for k in range(3):
            dr.kernel_history_clear()
            session.apply(SceneDelta(tuple(edits(k))))
            session.measure(points, up, StopRule(samples=64), seed=3)
            kernels = [e for e in dr.kernel_history() if e["type"] == dr.KernelType.JIT]
            assert kernels
            if k:
                assert not [e["size"] for e in kernels if e["cache_disk"] or not e["cache_hit"]]
    finally:
        dr.set_flag(dr.JitFlag.KernelHistory, False)
