"""Jobs in chunks: the same bits in whatever order, right by closed forms and beside one machine."""

from dataclasses import replace

import numpy as np
import pytest
from baking_rooms import furnished_room, lamp
from cluster_fakes import RoomCrew
from small_scenes import box, paint

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.cluster import session as cluster
from lumenray.engine.cluster.chunks import Grain
from lumenray.engine.cluster.session import ClusterSession
from lumenray.engine.daylight.coefficients import DaylightOrder
from lumenray.engine.errors import Cancelled, SceneError
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.session import Session
from lumenray.engine.views import ViewSettings

pytestmark = pytest.mark.mitsuba

PLACES = np.array([[0.5, 0.5, 0.4], [1.5, 0.5, 0.4], [1.0, 1.5, 0.4]])
UP = np.tile([0.0, 0.0, 1.0], (3, 1))

INTENSITY = 100.0
LAMP = np.array([1.0, 1.0, 1.5])


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    """Chunks of few samples, so that small jobs have several."""
    monkeypatch.setattr(cluster, "LEAST_PATHS", 1)
    monkeypatch.setattr(cluster, "MOST_PATHS", 1)
    monkeypatch.setattr(cluster, "LUX_GRAIN", Grain(32, 32))


def room(reflectance=0.5, intensity=INTENSITY):
    output = Output(Quantity.LUMINOUS_INTENSITY, intensity)
    return SceneDelta(
        changed=(box(2, 2, 2), paint(reflectance), PointLight("lamp", "lamp", output, LAMP))
    )


def session_of(delta, **crew):
    session = ClusterSession(RoomCrew(**crew))
    session.apply(delta)
    return session


def measure(session, rule=None, **more):
    rule = rule or StopRule(samples=4096)
    return session.measure(PLACES, UP, rule, 3, method="paths", witness=False, **more)


@pytest.fixture(scope="module")
def alone():
    """The room measured by one machine."""
    session = Session(witness=False)
    session.apply(room())
    return measure(session)


def direct():
    """Illuminance by the lamp alone. [lx]"""
    way = LAMP - PLACES
    distance = np.linalg.norm(way, axis=1)
    return INTENSITY * way[:, 2] / distance**3


def test_measurements_have_the_same_bits_in_whatever_order(alone):
    made = [measure(session_of(room(), names="abc"[:count], seed=count)) for count in (1, 2, 3)]
    for other in made[1:]:
        np.testing.assert_array_equal(other.illuminance, made[0].illuminance)
        np.testing.assert_array_equal(other.standard_error, made[0].standard_error)
    assert made[0].provenance.samples == 4096
    assert made[0].provenance.seed == 3
    error = np.hypot(made[0].standard_error, alone.standard_error)
    assert (np.abs(made[0].illuminance - alone.illuminance) < 4.0 * error).all()
    assert made[0].standard_error.mean() == pytest.approx(alone.standard_error.mean(), rel=0.5)


def test_a_black_room_has_the_light_of_its_lamp():
    made = measure(session_of(room(reflectance=0.0)), StopRule(samples=2048))
    np.testing.assert_allclose(made.illuminance, direct(), rtol=1e-4)


def test_changes_of_the_scene_reach_workers_that_hold_it():
    session = session_of(room(reflectance=0.0))
    measure(session, StopRule(samples=1024))
    session.apply(room(reflectance=0.0, intensity=2.0 * INTENSITY))
    made = measure(session, StopRule(samples=1024))
    np.testing.assert_allclose(made.illuminance, 2.0 * direct(), rtol=1e-4)
    np.testing.assert_array_equal(
        made.illuminance,
        measure(session_of(room(0.0, 2.0 * INTENSITY)), StopRule(samples=1024)).illuminance,
    )


def test_an_error_ends_the_job_at_the_same_chunk_for_all():
    made = [
        measure(session_of(room(), names="abc"[:count], seed=count), StopRule(error=0.01))
        for count in (1, 3)
    ]
    assert made[0].provenance.samples == made[1].provenance.samples
    np.testing.assert_array_equal(made[0].illuminance, made[1].illuminance)
    found = np.sqrt((made[0].standard_error ** 2).mean()) / made[0].illuminance.mean()
    assert found <= 0.01


@pytest.mark.parametrize(
    "rule", [StopRule(error=0.02), StopRule(each=0.02), StopRule(limits=(1.0,) * len(PLACES))]
)
def test_a_job_ends_where_samples_do_not_lower_what_is_left(rule):
    """A file of rays that leaves ten times as much open as is asked: readings say so, and end."""
    from ray_lamps import lamp_at

    led = lamp_at(LAMP)
    led = replace(led, rays=replace(led.rays, information_error=0.2))
    made = measure(session_of(SceneDelta(changed=(box(2, 2, 2), paint(0.5), led))), rule)
    assert (made.floors > 0.02 * made.illuminance).all()
    assert (made.standard_error >= made.floors).all()
    scatter = np.sqrt(made.standard_error**2 - made.floors**2)
    assert np.sqrt((scatter**2).mean()) <= 0.02 * made.illuminance.mean()


def test_the_witness_looks_at_the_whole():
    session = session_of(room())
    made = session.measure(PLACES, UP, StopRule(samples=2048), 3, method="paths")
    assert made.balance is not None
    assert (made.standard_error >= measure(session, StopRule(samples=2048)).standard_error).all()


def test_progress_and_cancel():
    session, states = session_of(room()), []

    def follow(state):
        states.append(state)
        if state.samples >= 2048:
            session.cancel()

    with pytest.raises(Cancelled):
        measure(session, progress=follow)
    assert states[-1].samples < 4096
    assert "2 workers" in states[-1].text()


def test_what_is_wrong_with_an_order_is_said():
    with pytest.raises(SceneError, match="sensor 2 has a position or normal that is not usable"):
        session_of(room()).measure(
            PLACES, [[0, 0, 1], [0, 0, 0], [0, 0, 1]], StopRule(samples=1024)
        )


def test_pictures_have_the_same_bits_in_whatever_order():
    frame = np.eye(4)
    frame[:3, 3] = 1.0, 1.0, 1.2
    camera = Camera(frame, Projection.PERSPECTIVE, 8, 6)
    settings = ViewSettings(StopRule(samples=64), 5, illuminance=True, method="paths")
    made = [
        session_of(room(), names="abc"[:count], seed=count).render(camera, settings)
        for count in (1, 3)
    ]
    np.testing.assert_array_equal(made[0].tristimulus, made[1].tristimulus)
    np.testing.assert_array_equal(made[0].illuminance_error, made[1].illuminance_error)
    one = Session()
    one.apply(room())
    alone = one.render(camera, settings)
    error = np.hypot(made[0].luminance_error, alone.luminance_error).mean()
    difference = made[0].tristimulus[..., 1].mean() - alone.tristimulus[..., 1].mean()
    assert abs(difference) < 4.0 * error / np.sqrt(48)


def test_daylight_has_the_same_bits_in_whatever_order():
    order = DaylightOrder(
        np.array([[0.0, 0.6, 0.8]]), 0.0093, StopRule(samples=5120), steps=4, cells=100, seed=2
    )
    made = [
        session_of(room(), names="ab"[:count], seed=count).find_daylight(PLACES[:1], UP[:1], order)
        for count in (1, 2)
    ]
    np.testing.assert_array_equal(made[0].sky, made[1].sky)
    assert made[0].samples == 5120


@pytest.mark.slow
def test_lux_maps_have_the_same_bits_in_whatever_order():
    delta = SceneDelta(changed=(*furnished_room(), paint(0.5), lamp((1.0, 1.0, 1.7))))
    order = BakeOrder(("room",), StopRule(samples=64), density=4.0, witness=False)
    made = [
        session_of(delta, names="abc"[:count], seed=count).bake_objects(order) for count in (1, 3)
    ]
    np.testing.assert_array_equal(made[0].pages[0].illuminance, made[1].pages[0].illuminance)
    np.testing.assert_array_equal(made[0].pages[0].standard_error, made[1].pages[0].standard_error)
    one = Session()
    one.apply(delta)
    alone = one.bake_objects(order).maps[0]
    found = made[0].maps[0]
    error = np.hypot(found.mean_standard_error, alone.mean_standard_error)
    assert abs(found.mean - alone.mean) < 4.0 * error
    assert found.samples == pytest.approx(64, rel=0.3)
    assert found.relative_standard_error == pytest.approx(alone.relative_standard_error, rel=0.4)
