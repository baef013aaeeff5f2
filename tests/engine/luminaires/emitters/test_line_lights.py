"""Luminous tubes against integrals over their surface, and the closed form of a Lambertian line."""

from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake_in
from small_scenes import box, paint, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.light import LineLight, Output, Quantity
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.session import Session

pytestmark = pytest.mark.mitsuba

FLUX, LENGTH, RADIUS = 3000.0, 1.2, 0.013
"""Of a fluorescent tube T8."""


def turned(axis, place):
    """Frame whose x goes along an axis."""
    x = np.asarray(axis, float) / np.linalg.norm(axis)
    y = np.cross(x, [0.0, 0.0, 1.0] if abs(x[2]) < 0.9 else [1.0, 0.0, 0.0])
    y /= np.linalg.norm(y)
    made = np.eye(4)
    made[:3, :3] = np.stack([x, y, np.cross(x, y)], axis=1)
    made[:3, 3] = place
    return made


def tube(
    axis=(1, 0, 0), place=(0, 0, 0), radius=RADIUS, quantity=Quantity.LUMINOUS_FLUX, amount=FLUX
):
    return LineLight("tube", "tube", Output(quantity, amount), turned(axis, place), LENGTH, radius)


def illuminance_of(light, position, normal):
    """Integral over the curved side by the midpoint rule. [lx]"""
    along, around = 3000, 400
    x = light.length * ((np.arange(along) + 0.5) / along - 0.5)
    phi = 2.0 * np.pi * (np.arange(around) + 0.5) / around
    ring = np.outer(np.cos(phi), light.frame[:3, 1]) + np.outer(np.sin(phi), light.frame[:3, 2])
    total = 0.0
    for out in ring:
        place = light.frame[:3, 3] + np.outer(x, light.frame[:3, 0]) + light.radius * out
        away = place - position
        square = (away**2).sum(axis=1)
        facing = np.maximum(-(away @ out), 0.0) * np.maximum(away @ normal, 0.0) / square**2
        total += facing.sum()
    luminance = light.output.value / (np.pi * light.area)
    return luminance * total * light.area / (along * around)


PLACES = {
    "across": ((0.0, 0.0, -1.0), (0.0, 0.0, 1.0)),
    "close": ((0.2, 0.0, -0.03), (0.0, 0.0, 1.0)),
    "far": ((3.0, 4.0, -9.0), (0.0, 0.0, 1.0)),
    "beyond its end": ((1.5, 0.0, -0.5), (-1.0, 0.0, 0.0)),
    "askew": ((-0.4, 0.7, 0.3), (0.48, -0.6, -0.64)),
}


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("radius", [RADIUS, 0.2])
def test_a_tube_gives_what_its_surface_integrates_to(place, radius):
    position, normal = (np.array(each) for each in PLACES[place])
    light = tube(radius=radius)
    if place == "close":
        position = position - [0.0, 0.0, radius]
    rule = StopRule(samples=1 << 15)
    made = session_of(light).measure([position], [normal], rule, seed=5)
    expected = illuminance_of(light, position, normal)
    error = made.standard_error[0]
    assert error < 0.003 * expected
    assert abs(made.illuminance[0] - expected) < 4.0 * error + 3e-4 * expected


def test_a_thin_tube_is_a_lambertian_line():
    """Facing its middle at the distance d: E = I' / d (atan q + q / (1 + q^2)), q = L / (2 d), I' = flux / (pi^2 L)."""
    distance = 0.7
    light = tube(radius=1e-4, axis=(1, 2, 0.5), place=(3.0, -1.0, 2.0))
    down = light.frame[:3, 2]
    position = light.frame[:3, 3] - distance * down
    made = session_of(light).measure([position], [down], StopRule(samples=1 << 14), seed=2)
    q = 0.5 * LENGTH / distance
    expected = FLUX / (np.pi**2 * LENGTH * distance) * (np.arctan(q) + q / (1.0 + q * q))
    assert made.standard_error[0] < 0.003 * expected
    assert abs(made.illuminance[0] - expected) < 4.0 * made.standard_error[0] + 1e-3 * expected


@pytest.mark.parametrize(
    ("quantity", "amount"),
    [
        (Quantity.LUMINANCE, FLUX / (2.0 * np.pi**2 * RADIUS * LENGTH)),
        # Across the tube it looks like a rectangle.
        (Quantity.LUMINOUS_INTENSITY, FLUX / np.pi**2),
        (Quantity.ILLUMINANCE, FLUX / np.pi**2),
    ],
)
def test_all_quantities_state_the_same_tube(quantity, amount):
    values = [
        session_of(tube(quantity=each, amount=value))
        .measure([(0.1, 0.2, -0.8)], [(0, 0, 1)], StopRule(samples=256), seed=1)
        .illuminance[0]
        for each, value in ((quantity, amount), (Quantity.LUMINOUS_FLUX, FLUX))
    ]
    assert values[0] == pytest.approx(values[1], rel=1e-5)


@pytest.mark.slow
@pytest.mark.parametrize("reflectance", [0.7])
def test_all_light_of_a_tube_arrives_in_a_closed_room(reflectance):
    """By the energy balance the mean of the map is flux / (area (1 - rho)); the witness finds as much."""
    session = Session()
    items = (box(3.0, 2.5, 2.0), paint(reflectance), tube(place=(1.3, 1.2, 1.9), axis=(1, 0.3, 0)))
    session.apply(SceneDelta(changed=items))
    made = bake_in(session, ("box",), density=8.0, error=0.01)
    area = 2.0 * (3.0 * 2.5 + 3.0 * 2.0 + 2.5 * 2.0)
    found = made.maps[0]
    expected = FLUX / (area * (1.0 - reflectance))
    error = np.hypot(found.mean_standard_error, found.bias_error)
    assert error < 0.01 * expected
    assert abs(found.mean - expected) < 4.0 * error


def test_the_density_of_places_integrates_to_1():
    """Over the part that a receiver sees, by places that are drawn evenly over the whole tube."""
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.luminaires.emitters.tubes import find_tube_density
    from lumenray.engine.transport import backend

    backend.start(spectral=False)
    count = 1 << 20
    draw = np.random.default_rng(3)
    for point in ((0.1, 0.0, -0.05), (0.6, 1.0, -0.4), (5.0, 0.5, 2.0), (0.7, 0.0, 0.021)):
        shape = mi.Point3f(-0.6, 0.0, 0.0), mi.Vector3f(LENGTH, 0.0, 0.0), mi.Float(0.02)
        x, phi = draw.uniform(-0.6, 0.6, count), draw.uniform(0.0, 2.0 * np.pi, count)
        ds = dr.zeros(mi.DirectionSample3f, count)
        normal = np.array([0.0 * phi, np.cos(phi), np.sin(phi)])
        place = 0.02 * normal + np.array([x, 0.0 * x, 0.0 * x])
        ds.n, ds.p = (kind(*(mi.Float(row.astype(np.float32)) for row in rows))
                      for kind, rows in ((mi.Normal3f, normal), (mi.Point3f, place)))  # fmt: skip
        at = mi.Point3f(*point)
        ds.d = ds.p - at
        ds.dist = dr.norm(ds.d)
        ds.d /= ds.dist
        density = np.array(find_tube_density(shape, at, ds)).astype(float)
        facing = np.maximum(-np.array(dr.dot(ds.d, ds.n)), 0.0)
        values = density * facing / np.array(ds.dist) ** 2 * (2.0 * np.pi * 0.02 * LENGTH)
        assert abs(values.mean() - 1.0) < 4.0 * values.std() / np.sqrt(count)


def test_a_tube_without_a_body_is_refused():
    light = tube(radius=0.0)
    with pytest.raises(
        SceneError, match=r"'tube': its tube has a length of 1\.2 m and a radius of 0 m"
    ):
        session_of(light).measure([(0, 0, -1)], [(0, 0, 1)], StopRule(samples=16))


def test_a_tube_that_is_moved_and_resized_gives_what_a_new_one_gives():
    first = tube(place=(0.0, 0.3, 0.5))
    other = tube(axis=(0.2, 1.0, -0.4), place=(-0.3, 0.0, 0.1), radius=0.05)
    other = replace(other, length=0.7)
    rule, where = StopRule(samples=256), ([(0.1, 0.2, -0.8)], [(0.0, 0.0, 1.0)])
    session = session_of(first)
    before = session.measure(*where, rule, seed=1).illuminance[0]
    session.apply(SceneDelta(changed=(other,)))
    after = session.measure(*where, rule, seed=1).illuminance[0]
    assert after != pytest.approx(before, rel=0.01)
    anew = session_of(other).measure(*where, rule, seed=1).illuminance[0]
    # Its edges, as rays meet them, are rounded in another way.
    assert after == pytest.approx(anew, rel=3e-4)
