"""Bakes and measurements before a second witness: what gathering misses stands in the error, and the light is named."""

import json
from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import bake_in, furnished_room, lamp
from glass_scenes import ball
from small_scenes import box, paint, quad

from lumenray.benchmarks.rooms.random_rooms import make_room
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import Output, PointLight, Quantity, SunLight
from lumenray.engine.scene.material import Cauchy, Dielectric, Material
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.sensor import SensorKind
from lumenray.engine.session import Session
from lumenray.engine.transport.light_tracing.bent_lights import bent_lights
from lumenray.engine.transport.light_tracing.bright_spots import bright_spots
from lumenray.engine.transport.paths.illuminance import Receivers, compute
from lumenray.engine.transport.witness import sensors as witness
from lumenray.engine.transport.witness.pilot import Witness
from lumenray.engine.transport.witness.sensors import hear_sensors
from lumenray.engine.transport.witness.sheets import Sheets

pytestmark = pytest.mark.mitsuba

GLASS = Material("glass", "glass", Dielectric(Cauchy(1.5)))
BULB = ball("bulb", 0.05, (1, 1, 1), "glass", rings=16)
ROOM = box(2, 2, 2)
FLUX = 555.0
MEAN = 2.0 * FLUX / 24.0
"""A closed room of reflectance 1/2 that loses nothing elsewhere receives twice the flux."""


def session_with(*items):
    session = Session()
    session.apply(SceneDelta(changed=tuple(items)))
    return session


def baked(items, objects=("box",), samples=64, **more):
    return bake_in(session_with(*items), objects, samples, **more)


def messages(result):
    return " ".join(each.message for each in result.departures)


def assert_covered(made, truth, errors=3.0):
    assert abs(made.mean - truth) < errors * made.mean_standard_error, (
        f"{made.mean} ± {made.mean_standard_error} for {truth}"
    )
    least = made.mean_standard_error / errors
    assert made.mean == 0.0 or made.relative_standard_error * made.mean >= least


@pytest.mark.parametrize("radius", [0.001, 0.01])
@pytest.mark.slow
def test_the_error_of_a_bulb_holds_the_light_that_comes_through_its_glass(radius):
    """A lamp in a closed glass body, without tracing from the lights: 60 % of the light was missing with an error of 3 %."""
    result = baked([GLASS, paint(0.5), ROOM, BULB, lamp((1, 1, 1), FLUX, radius)], caustics="off")
    assert_covered(result.maps[0], MEAN)
    page = result.lumels(0)
    area = (page.standard_error.astype(float) ** 2 * page.area).sum() / page.area.sum()
    # Single values and the whole carry it too.
    assert np.sqrt(area) > abs(result.maps[0].mean - MEAN) / 3.0
    assert result.relative_standard_error >= 0.99 * result.maps[0].relative_standard_error


def test_light_that_gathering_never_finds_is_named(tmp_path):
    result = baked(
        [GLASS, paint(0.5), ROOM, BULB, lamp((1, 1, 1), FLUX, 0.0)],
        caustics="off",
        folder=str(tmp_path),
    )
    assert result.maps[0].mean == 0.0
    assert_covered(result.maps[0], MEAN)
    assert "light of 'lamp' through 'bulb' (material 'glass') is not found in full" in messages(result)  # fmt: skip
    content = json.loads((tmp_path / "report.json").read_text())
    assert any("light of 'lamp' through 'bulb'" in row["message"] for row in content["conversion"])


@pytest.mark.slow
def test_a_lamp_close_to_a_wall_is_covered():
    near = PointLight("lamp", "lamp", Output(Quantity.LUMINOUS_FLUX, FLUX), np.array([1, 1, 2 - 1e-4]))  # fmt: skip
    result = baked([paint(0.5), ROOM, near])
    assert_covered(result.maps[0], MEAN)
    assert abs(result.maps[0].mean - MEAN) < 1.0 or "begins very near a surface" in messages(result)


@pytest.mark.slow
def test_the_sun_through_a_keyhole_is_covered():
    side, b = 5e-3, 0.515
    a = b - side
    walls = [
        quad("roof a", (0, 0, 1), (0, 1, 0), (a, 0, 0), "paint"),
        quad("roof b", (b, 0, 1), (0, 1, 0), (1 - b, 0, 0), "paint"),
        quad("roof c", (a, 0, 1), (0, a, 0), (side, 0, 0), "paint"),
        quad("roof d", (a, b, 1), (0, 1 - b, 0), (side, 0, 0), "paint"),
        quad("floor", (0, 0, 0), (1, 0, 0), (0, 1, 0), "paint"),
        quad("left", (0, 0, 0), (0, 1, 0), (0, 0, 1), "paint"),
        quad("right", (1, 0, 0), (0, 0, 1), (0, 1, 0), "paint"),
        quad("front", (0, 0, 0), (0, 0, 1), (1, 0, 0), "paint"),
        quad("back", (0, 1, 0), (1, 0, 0), (0, 0, 1), "paint"),
    ]
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 1e5), np.array([0.0, 0.0, -1.0]), 0.0)
    names = tuple(wall.id for wall in walls)
    result = baked([paint(0.5), *walls, sun], names, density=10.0)
    flux = sum(made.mean * made.area for made in result.maps)
    errors = [made.mean_standard_error * made.area for made in result.maps]
    # What falls in, twice.
    assert abs(flux - 1e5 * side**2 * 2.0) < 3.0 * sum(errors)


def test_a_room_that_gathering_finds_in_full_keeps_its_errors():
    room, block = furnished_room()
    items = [paint(0.5), room, block, lamp((0.5, 1.0, 1.7), 1000.0)]
    more = {"method": "paths", "density": 12.0}
    heard = baked(items, ("room", "block"), **more)
    alone = baked(items, ("room", "block"), witness=False, **more)
    assert heard.departures == alone.departures == ()
    for made, plain in zip(heard.maps, alone.maps, strict=True):
        assert made.mean == plain.mean
        assert made.samples == plain.samples
        assert made.mean_standard_error == plain.mean_standard_error
    assert alone.balance is None


def test_energy_of_the_whole_is_part_of_every_report(tmp_path):
    room, block = furnished_room()
    items = [paint(0.5), room, block, lamp((0.5, 1.0, 1.7), 1000.0)]
    result = baked(items, ("room",), folder=str(tmp_path))
    energy = json.loads((tmp_path / "report.json").read_text())["energy"]
    assert energy == result.balance
    assert energy["unit"] == "lm"
    assert energy["emitted"]["value"] == pytest.approx(1000.0, rel=1e-4)
    kept = energy["absorbed"]
    assert abs(kept["value"] - 1000.0) < 4.0 * kept["standard_error"] + 0.1
    assert energy["left_the_scene"]["value"] < 0.1
    assert any("light paths from the lights bring" in each for each in result.maps[0].provenance.decisions)  # fmt: skip


# ---- sensors ----

PLACES = [[0.3, 0.3, 0.0], [1.0, 1.0, 0.0], [1.5, 0.5, 0.0], [2.0, 1.0, 1.3]]
FACING = [[0, 0, 1], [0, 0, 1], [0, 0, 1], [-1, 0, 0]]


def test_sensors_without_light_say_what_comes_through_the_glass():
    items = [GLASS, paint(0.5), ROOM, BULB, lamp((1, 1, 1), FLUX, 0.001)]
    session = session_with(*items)
    made = session.measure(PLACES, FACING, StopRule(samples=1 << 10))
    # Without the glass, which keeps nothing, nearly the same comes.
    clear = session_with(*items[1:3], items[4])
    truth = clear.measure(PLACES, FACING, StopRule(samples=1 << 12), witness=False)
    assert (np.abs(made.illuminance - truth.illuminance) < 3.0 * made.standard_error).all()
    if (made.illuminance < 0.5 * truth.illuminance).all():
        assert "light of 'lamp' through 'bulb'" in " ".join(made.provenance.notes)
    assert made.balance["emitted"]["value"] == pytest.approx(FLUX, rel=1e-4)


@pytest.mark.parametrize("kind", list(SensorKind))
def test_sensors_that_find_all_light_keep_their_errors(kind):
    room, block = furnished_room()
    session = session_with(paint(0.5), room, block, lamp((0.5, 1.0, 1.7), 1000.0))
    # Near a wall, in the shadow of the block, on it, and a little below a surface.
    places = [[0.02, 1.0, 1.0], [1.9, 1.3, 0.0], [1.45, 1.35, 0.8], [0.5, 0.5, -5e-5]]
    facing = [[1, 0, 0.01], [0.01, 0, 1], [0.01, 0, 1], [0.01, 0, 1]]
    if kind is not SensorKind.PLANAR:
        places, facing = places[:3], facing[:3]
    found = [
        session.measure(places, facing, StopRule(samples=1 << 10), kind=kind, witness=witness)
        for witness in (True, False)
    ]
    assert found[0].provenance.notes == ()
    np.testing.assert_array_equal(found[0].illuminance, found[1].illuminance)
    np.testing.assert_array_equal(found[0].standard_error, found[1].standard_error)
    assert found[1].balance is None


@pytest.mark.parametrize("kind", [SensorKind.PLANAR, SensorKind.SPHERICAL])
@pytest.mark.slow
def test_sensors_that_were_not_looked_at_carry_what_those_beside_them_lack(kind):
    """Gathering alone, without what is asked over bends, finds next to nothing of a small lamp in glass."""
    session = session_with(GLASS, paint(0.5), ROOM, BULB, lamp((1, 1, 1), FLUX, 0.001))
    x, y = np.meshgrid(np.linspace(0.2, 1.8, 12), np.linspace(0.2, 1.8, 10))
    places = np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 1e-4)])
    facing = np.broadcast_to([0.0, 0.0, 1.0], places.shape)
    whole = session.measure(places, facing, StopRule(samples=1 << 10), kind=kind, witness=False)
    with session._engine("auto") as scene:
        receivers = Receivers.at_points(places, facing, kind)
        found = compute(scene, receivers, StopRule(samples=256), 1, 16)
        heard = hear_sensors(scene, places, facing, kind, found, 1)
    lacks = whole.illuminance - found.mean
    # Between two that were looked at, the lack of the nearer one stands for it.
    held = np.abs(lacks) <= 3.0 * np.hypot(heard.floors, found.standard_error)
    assert held.all()
    assert (heard.floors > 0.25 * lacks).all()


@pytest.mark.parametrize(
    ("number", "seeds"), [(213, (213, 2, 3)), (225, (225, 1, 3, 1005, 1007))], ids=["bulb", "hole"]
)
@pytest.mark.slow
def test_rare_light_that_a_lucky_sensor_has_not_met_is_covered(number, seeds):
    """Images of bright spots in a mirror ball: some sensors meet none of them and state a hundredth of what they lack."""
    room = make_room(number)
    session = session_with(*room.items)
    with session._engine("auto") as scene:
        sheets = Sheets(scene, room.places, room.normals)
        truth = Witness(scene, 9, set(), sheets).run(1 << 21)
        for seed in seeds:
            receivers = sheets.receivers(seed)
            seen = scene.local(receivers.positions), receivers.normals
            with bent_lights(scene), bright_spots(scene, *seen):
                found = compute(scene, receivers, StopRule(samples=1 << 13), seed, 16)
                kind = SensorKind.PLANAR
                heard = hear_sensors(scene, room.places, room.normals, kind, found, seed)
            stated = np.hypot(found.standard_error, heard.floors)
            assert bool(heard.notes) == (heard.floors > 0.0).any()
            allowed = 4.0 * np.hypot(stated, truth.sheet_errors) + 0.01 * truth.sheets
            assert (np.abs(found.mean - truth.sheets) < allowed).all()


def test_lucky_sensors_that_were_not_looked_at_state_what_places_about_them_know(monkeypatch):
    """And honest ones beside lucky ones keep their errors, as all do where many events make those of the places."""
    from lumenray.engine.accuracy.estimate import Estimate
    from lumenray.engine.transport.witness import sensors as sensor_witness

    session = session_with(paint(0.5), ROOM, lamp((1.0, 1.0, 1.7), 1000.0))
    apart = np.random.default_rng(1).uniform(-1e-3, 1e-3, (200, 3))
    beside, facing = PLACES[0] + apart * [1.0, 1.0, 0.0], np.tile(FACING[0], (200, 1))
    is_lucky = np.arange(200) % 2 == 0
    errors = np.where(is_lucky, 0.1, 10.0)
    with session._engine("auto") as scene:
        count = len(Sheets(scene, beside, facing))
        light = Witness(scene, 1, set(), Sheets(scene, beside, facing)).run(1 << 17).sheets
        for events, expected in ((2.0, np.where(is_lucky, 10.0, 0.0)), (1e3, np.zeros(200))):
            # As far from the light paths as leaves doubt, but not on the mean.
            off = 9.0 * (-1.0) ** np.arange(count)
            made = Estimate(light + off, np.full(count, 5.0), 1 << 12, np.full(count, events))
            monkeypatch.setattr(sensor_witness, "compute", lambda *_, made=made, **__: made)
            monkeypatch.setattr(sensor_witness, "DOUBT", 0.9)
            found = Estimate(np.full(200, light.mean()), errors, 1 << 10)
            heard = hear_sensors(scene, beside, facing, SensorKind.PLANAR, found, 3)
            np.testing.assert_allclose(heard.floors, expected)
            assert any("100 of 200 sensors" in note for note in heard.notes) == (events < 10.0)


def test_direct_light_alone_is_compared_with_direct_light():
    session = session_with(paint(0.5), ROOM, lamp((1.0, 1.0, 1.7), 1000.0))
    made = session.measure(PLACES, FACING, StopRule(samples=1 << 10), reflections=0)
    assert made.provenance.notes == ()


def test_a_dark_sensor_is_dark_within_what_the_pilot_can_tell():
    closed = replace(box(0.5, 0.5, 0.5), id="closed", name="closed")
    session = session_with(paint(0.5), ROOM, closed, lamp((1.5, 1.5, 1.0), 1000.0))
    made = session.measure([[0.25, 0.25, 0.0]], [[0, 0, 1]], StopRule(samples=1 << 10))
    assert made.illuminance[0] == 0.0
    assert 0.0 < made.standard_error[0] < 0.01


def test_colour_carries_the_same_errors():
    items = [GLASS, paint(0.5), ROOM, BULB, lamp((1, 1, 1), FLUX, 0.0)]
    made = session_with(*items).measure(PLACES, FACING, StopRule(samples=1 << 10), colour=True)
    if not made.illuminance.any():
        assert (made.tristimulus_error[:, 1] > 10.0).all()
    np.testing.assert_array_equal(made.tristimulus_error[:, 1], made.standard_error)


def test_the_witness_is_part_of_what_a_measurement_says_is_left():
    """It begins when samples end, and what it does is known beforehand but for looks that doubt asks for."""
    states = []
    session_with(paint(0.5), ROOM, lamp((1, 1, 1.5))).measure(
        PLACES, FACING, StopRule(samples=1 << 14), progress=states.append
    )
    assert states[-1].stage == "second witness"
    assert states[-1].seconds_left > 0.0
    assert {each.stage for each in states[:-1]} == {"illuminance"}
    alone = []
    session_with(paint(0.5), ROOM, lamp((1, 1, 1.5))).measure(
        PLACES, FACING, StopRule(samples=1 << 14), progress=alone.append, witness=False
    )
    assert {each.stage for each in alone} == {"illuminance"}
    assert alone[-1].seconds_left == 0.0


def test_the_work_of_the_witness_is_foretold(monkeypatch):
    """As many paths, and samples on as many squares, as its first look makes; weighed, for each sensor."""
    made, run, gather = {}, Witness.run, witness.compute

    def count_paths(self, paths, *rest):
        made.setdefault("paths", paths)
        return run(self, paths, *rest)

    def count_samples(scene, receivers, rule, *rest, **named):
        made.setdefault("samples", rule.samples * len(receivers.start))
        return gather(scene, receivers, rule, *rest, **named)

    monkeypatch.setattr(Witness, "run", count_paths)
    monkeypatch.setattr(witness, "compute", count_samples)
    session = session_with(paint(0.5), ROOM, lamp((1, 1, 1.5)))
    session.measure(PLACES, FACING, StopRule(samples=1 << 11))
    work = witness.PATH * made["paths"] + witness.GATHERED * made["samples"]
    assert witness.expect_work(1 << 11, len(PLACES)) * len(PLACES) == pytest.approx(work)
