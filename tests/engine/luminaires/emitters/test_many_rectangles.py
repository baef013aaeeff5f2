"""Rectangular area lights, which share an emitter: each gives its own light whatever others there are, and costs no more."""

from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake
from glass_scenes import BLACK, GLASS, ball
from luminaires import OPENINGS, frame_of, luminaire, turn
from ray_lamps import floor, lumels_of
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import AreaLight, Output, PointLight, Quantity
from lumenray.engine.scene.material import Black, Emission, Material
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Blackbody, Illuminant
from lumenray.engine.session import Session
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

PLACES = np.array([[0.3, 0.2, 0.0], [1.4, 1.1, 0.0], [2.6, 0.7, 0.3], [0.9, 2.5, 0.1]])
UP = np.tile([0.0, 0.0, 1.0], (4, 1))


def lamp(name, place, size=(0.3, 0.2), lumens=500.0, rotation=None, spectrum=None, **more):
    output = Output(Quantity.LUMINOUS_FLUX, lumens, spectrum or Illuminant("D65"))
    return AreaLight(name, name, output, frame_of(place, rotation), *size, **more)


def lamps():
    """No two alike. They shine along -z of their frames, so that all places see the front of all but the last."""
    quarter = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    return {
        "small": lamp("small", (0.5, 0.5, 2.0), (0.05, 0.08), 300.0),
        "long": lamp("long", (2.0, 1.5, 1.8), (1.6, 0.1), 2500.0, quarter),
        "warm": lamp("warm", (1.5, 2.0, 2.5), lumens=900.0, spectrum=Blackbody(2700.0)),
        "square": lamp("square", (2.5, 0.3, 1.2), (0.4, 0.4), 50.0),
        "upwards": lamp("upwards", (1.0, 1.0, 3.0), rotation=np.diag([1.0, -1.0, -1.0])),
    }


def illuminance_of(light, place):
    """From a Lambertian rectangle over a level place that it sees (J. H. Lambert, 1760). [lx]"""
    if light.frame[2, 2] < 0.0:
        return 0.0
    half = 0.5 * np.array([light.size_x, light.size_y])
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    corners = light.frame[:3, 3] + (signs * half) @ light.frame[:3, :2].T
    towards = corners - place
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    crossed = np.cross(towards, np.roll(towards, -1, axis=0))
    sines = np.linalg.norm(crossed, axis=1)
    angles = np.arctan2(sines, (towards * np.roll(towards, -1, axis=0)).sum(axis=1))
    luminance = light.output.value / (np.pi * light.area)
    return 0.5 * luminance * abs(float((angles * crossed[:, 2] / sines).sum()))


def test_each_of_many_gives_its_own_light(transport):
    lights = lamps()
    others = (
        lamp("disk", (0.7, 2.2, 1.5), (0.3, 0.3), 400.0, shape="ellipse"),
        PointLight("point", "point", Output(Quantity.LUMINOUS_FLUX, 600.0), (2.2, 2.2, 2.0), 0.0),
        luminaire("batwing", OPENINGS["rectangle"], (1.2, 0.4, 2.2), turn(2), 700.0, "fitting"),
    )
    rule = StopRule(samples=1 << 13)
    beside, made = (
        session_of(*items).measure(PLACES, UP, rule, transport=transport)
        for items in (others, (*lights.values(), *others))
    )
    expected = beside.illuminance + [
        sum(illuminance_of(light, place) for light in lights.values()) for place in PLACES
    ]
    error = np.hypot(made.standard_error, beside.standard_error)
    assert (np.abs(made.illuminance - expected) < 4.5 * error + 5e-4 * expected).all()
    assert (error < 0.05 * expected).all()


def test_rays_that_meet_them_find_the_same_light():
    """In a room, where scattered rays run into lamps: what they find there competes with next-event, lamp by lamp."""
    lights = list(lamps().values())
    room = (paint(0.8), box(3.0, 3.0, 3.2))
    rule = StopRule(samples=1 << 13)
    whole = session_of(*room, *lights).measure(PLACES, UP, rule)
    alone = [session_of(*room, light).measure(PLACES, UP, rule) for light in lights]
    total = sum(each.illuminance for each in alone)
    error = np.sqrt(whole.standard_error**2 + sum(each.standard_error**2 for each in alone))
    assert (np.abs(whole.illuminance - total) < 4.5 * error).all()
    assert (error < 0.05 * total).all()


def test_the_second_witness_agrees_about_each_of_them():
    """It sends rays from the lamps: of the wrong one they would carry another flux."""
    session = Session()
    session.apply(SceneDelta((paint(0.5), box(3.0, 3.0, 3.2), *lamps().values())))
    edge = np.linspace(0.2, 2.8, 12)
    x, y = (each.ravel() for each in np.meshgrid(edge, edge))
    places = np.column_stack([x, y, np.full_like(x, 0.01)])
    made = session.measure(places, np.tile(UP[0], (len(x), 1)), StopRule(samples=1 << 12))
    emitted = made.balance["emitted"]
    flux = sum(light.output.value for light in lamps().values())
    assert abs(emitted["value"] - flux) < 4.5 * emitted["standard_error"]
    assert not made.floors.any(), made.provenance.notes
    assert (made.standard_error < 0.05 * made.illuminance).all()


def test_a_hundred_cost_no_more_to_trace_than_twenty(monkeypatch):
    from lumenray.engine.luminaires.emitters.rectangle_plugin import RectangleTable

    asked = []
    draw = RectangleTable.rectangle
    monkeypatch.setattr(RectangleTable, "rectangle", lambda *a: asked.append(1) or draw(*a))

    def count(many):
        asked.clear()
        lights = [
            lamp(f"lamp {k}", (0.3 * (k % 10), 0.3 * (k // 10), 2.0), (0.1, 0.1))
            for k in range(many)
        ]
        made = session_of(paint(0.5), box(3, 3, 3), *lights).measure(
            PLACES, UP, StopRule(samples=64)
        )
        assert made.illuminance.all()
        return len(asked)

    assert 0 < count(100) <= count(20)


def edits():
    small, long = lamps()["small"], lamps()["long"]
    return {
        "power": {"small": replace(small, output=replace(small.output, value=77.0))},
        "spectrum": {
            "small": replace(small, output=replace(small.output, spectrum=Blackbody(4000.0)))
        },
        "spread": {"small": replace(small, spread=1.0)},
        "move": {"long": replace(long, frame=frame_of((1.0, 1.0, 2.6)))},
        "other size": {"long": replace(long, size_x=0.4)},
        "to an ellipse": {"small": replace(small, shape="ellipse")},
        "zero": {"long": replace(long, output=replace(long.output, value=0.0))},
        "one more": {"more": lamp("more", (0.1, 2.9, 1.0))},
        "one less": {"small": None},
        "none": dict.fromkeys(lamps()),
    }


@pytest.mark.parametrize("name", edits())
def test_an_edit_ends_where_a_fresh_start_does(name):
    transport = "spectral" if name == "spectrum" else "mono"
    room = (paint(0.5), box(3, 3, 3.2), luminaire("batwing", place=(1.5, 1.5, 2.0), key="fitting"))

    def readings(session):
        return session.measure(PLACES, UP, StopRule(samples=64), seed=3, transport=transport)

    session = session_of(*room, *lamps().values())
    readings(session)
    change = edits()[name]
    changed = tuple(item for item in change.values() if item is not None)
    session.apply(SceneDelta(changed, tuple(k for k, item in change.items() if item is None)))
    live = readings(session)
    # Kernels know how many emitters live.
    del session
    left = {k: v for k, v in {**lamps(), **change}.items() if v is not None}
    fresh = readings(session_of(*room, *left.values()))
    np.testing.assert_array_equal(live.illuminance, fresh.illuminance)
    assert (live.illuminance > 0.0).any()


@pytest.mark.slow
def test_lamps_near_a_floor_give_lumels_what_falls_on_each_half():
    """Light is traced from both, each with its own flux, and left to next-event where it is not."""
    left = lamp("left", (-0.13, 0.02, 0.02), (0.004, 0.004), 100.0)
    right = lamp("right", (0.11, -0.05, 0.03), (0.006, 0.002), 300.0)
    ground = floor(0.6)
    result = bake((BLACK, ground, left, right), (ground.id,), 256, density=40.0, margin=1)
    values, places = lumels_of(result, ground)
    area = values.area.astype(float)
    grid = (np.arange(600) + 0.5) / 1000.0 - 0.3
    x, y = np.meshgrid(grid, grid)
    fine = np.zeros_like(x)
    for light in (left, right):
        away = np.stack([x, y, 0.0 * x], axis=-1) - light.frame[:3, 3]
        squared = (away**2).sum(axis=-1)
        fine += light.output.value / np.pi * light.frame[2, 3] ** 2 / squared**2
    for is_half, there in ((places[:, 0] < 0.0, x < 0.0), (places[:, 0] >= 0.0, x >= 0.0)):
        found = (values.illuminance * area)[is_half].sum() / area[is_half].sum()
        assert found == pytest.approx(fine[there].mean(), rel=0.01)


def in_squares(values):
    """Means of 4 x 4 pixels. (16, 16) to (4, 4)"""
    return values.reshape(4, 4, 4, 4).mean(axis=(1, 3))


@pytest.mark.slow
def test_light_through_glass_adds_up_for_a_lamp_that_is_traced_and_one_that_is_not():
    """What scattered rays find of the former over glass is left out, of the latter it is not."""
    items = (
        paint(0.5),
        GLASS,
        ball("ball", 0.2, (0.0, 0.0, 0.5), "glass"),
        floor(0.6, material="paint"),
    )
    lights = (
        lamp("tiny", (-0.3, 0.0, 1.6), (0.004, 0.004), 100.0),
        lamp("wide", (0.2, 0.1, 1.3), (0.8, 0.8), 2000.0),
    )
    glow = Emission(luminance=100.0 / (np.pi * 0.004**2), two_sided=False)
    mesh = quad("mesh", (-0.302, -0.002, 1.6), (0.0, 0.004, 0.0), (0.004, 0.0, 0.0), "glow")
    alike = mesh, Material("glow", "glow", Black(), glow)
    # Below the ball.
    camera = Camera(frame_of((0.0, 0.0, 0.25)), Projection.ORTHOGRAPHIC, 16, 16, 0.6, 0.6)
    views = ViewSettings(StopRule(samples=1 << 12), shares=False)
    pictures = [
        session_of(*items, *some).render(camera, views)
        for some in (lights, lights[:1], lights[1:], alike)
    ]
    whole, tiny, wide, other = (in_squares(each.tristimulus[..., 1]) for each in pictures)
    errors = [in_squares(each.luminance_error**2) / 16.0 for each in pictures]
    total = tiny + wide
    error = np.sqrt(sum(errors[:3]))
    assert (np.abs(whole - total) < 4.5 * error + 2e-3 * total).all(), (whole, total, error)
    assert (error < 0.02 * total).all()
    apart = np.abs(tiny - other)
    assert (apart < 4.5 * np.sqrt(errors[1] + errors[3]) + 0.01 * other).all(), (tiny, other)
