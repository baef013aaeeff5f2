"""Edits of luminaires in a live scene: the answers of a fresh start, and no kernel that was not there before."""

from dataclasses import replace

import numpy as np
import pytest
from luminaires import DISTRIBUTIONS, OPENINGS, frame_of, luminaire, turn
from small_scenes import paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.distribution import Opening
from lumenray.engine.scene.light import Output, Quantity
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.spectrum import Blackbody, Constant
from lumenray.engine.session import Session
from lumenray.engine.views import Display, LiveSettings
from lumenray.engine.worker import codec

pytestmark = pytest.mark.mitsuba

PLACES = np.array([[0.5, 0.5, 0.0], [2.0, 1.0, 0.0], [3.0, 3.0, 0.0], [1.0, 2.0, 1.5]])
UP = np.tile([0.0, 0.0, 1.0], (4, 1))
ROOM = (
    paint(0.5),
    quad("floor", [0, 0, -0.01], [4, 0, 0], [0, 4, 0], "paint"),
    quad("wall", [0, 4, 0], [4, 0, 0], [0, 0, 3], "paint"),
    # Kinds of openings are parts of kernels: with all of them there, few have to be made for the edits below.
    luminaire("irregular", OPENINGS["box"], (3.5, 0.5, 2.0), turn(5), 20.0, "first"),
    luminaire("irregular", OPENINGS["cylinder"], (3.5, 3.5, 2.0), turn(6), 20.0, "second"),
    luminaire("irregular", OPENINGS["ellipse"], (0.5, 2.5, 2.0), turn(8), 20.0, "third"),
    luminaire("spot", OPENINGS["rectangle"], (0.5, 3.5, 2.0), turn(7), 20.0, "fourth"),
)


def readings(session, transport="mono"):
    return session.measure(PLACES, UP, StopRule(samples=64), seed=3, transport=transport)


def first_lights():
    return {
        "a": luminaire("batwing", OPENINGS["rectangle"], (2.0, 2.0, 2.8), key="a"),
        "b": luminaire("spot", OPENINGS["ellipse"], (1.0, 1.0, 2.8), turn(2), key="b"),
        "c": luminaire("type A", Opening(), (3.0, 1.0, 2.5), turn(3), key="c"),
    }


def edits():
    """Name and change of the lights, by key; None takes one away."""
    a, b, c = first_lights().values()
    dimmed = replace(a, output=replace(a.output, value=123.0))
    return {
        "power": {"a": dimmed},
        "unit": {"a": replace(a, output=Output(Quantity.RADIANT_FLUX, 3.0))},
        "zero": {"b": replace(b, output=replace(b.output, value=0.0))},
        "move": {"a": replace(a, frame=frame_of((1.5, 2.5, 2.6)))},
        "rotate": {"c": replace(c, frame=frame_of((3.0, 1.0, 2.5), turn(8)))},
        "other distribution": {"a": replace(a, distribution=DISTRIBUTIONS["up and down"])},
        "one that is known": {"c": replace(c, distribution=DISTRIBUTIONS["batwing"])},
        "other size": {"a": replace(a, opening=Opening("rectangle", (0.2, 0.0, 1.1), "y"))},
        "other opening": {"a": replace(a, opening=OPENINGS["cylinder"])},
        "from an opening to a point": {"b": replace(b, opening=Opening())},
        "one more": {"d": luminaire("type B", OPENINGS["box"], (1.0, 3.0, 2.5), key="d")},
        "one less": {"a": None},
        "none": {"a": None, "b": None, "c": None, "d": luminaire("batwing", Opening(), key="d")},
        "spectrum": {"a": replace(a, output=replace(a.output, spectrum=Blackbody(2700.0)))},
    }


@pytest.mark.parametrize("name", edits())
@pytest.mark.slow
def test_an_edit_ends_where_a_fresh_start_does(name):
    lights = first_lights()
    session = session_of(*ROOM, *lights.values())
    readings(session)
    change = edits()[name]
    changed = tuple(item for item in change.values() if item is not None)
    removed = tuple(lights[key].id for key, item in change.items() if item is None)
    session.apply(SceneDelta(changed, removed))
    lights = {k: v for k, v in {**lights, **change}.items() if v is not None}
    transport = "spectral" if name == "spectrum" else "mono"
    live = readings(session, transport)
    # Kernels know how many emitters live.
    del session
    fresh = readings(session_of(*ROOM, *lights.values()), transport)
    np.testing.assert_array_equal(live.illuminance, fresh.illuminance)
    assert live.provenance.scene_hash == fresh.provenance.scene_hash
    assert (live.illuminance > 0.0).any()


@pytest.mark.slow
def test_a_live_view_ends_where_a_fresh_start_does():
    lights = first_lights()
    session = session_of(*ROOM, *lights.values())
    frame = frame_of((2.0, 2.0, 2.9))
    camera = Camera(frame, Projection.PERSPECTIVE, 24, 18, 1.2, 0.9)
    session.watch(camera, LiveSettings(samples=4), Display())
    for change in edits().values():
        for key, item in change.items():
            if item is not None:
                lights[key] = item
                session.apply(SceneDelta((item,)))
            elif key in lights:
                session.apply(SceneDelta(removed=(lights.pop(key).id,)))
        session.refine()
    # Brought back in another order than they came.
    lights = {**lights, **dict(list(first_lights().items())[::-1])}
    session.apply(SceneDelta(tuple(lights.values())))
    session.refine()
    live = readings(session)
    del session
    fresh = readings(session_of(*ROOM, *lights.values()))
    np.testing.assert_array_equal(live.illuminance, fresh.illuminance)


@pytest.mark.slow
def test_edits_of_numbers_meet_known_kernels():
    import drjit as dr

    session = session_of(*ROOM, *first_lights().values())
    a, b, c = first_lights().values()

    def edited(k):
        yield replace(a, output=replace(a.output, value=100.0 + k))
        yield replace(b, frame=frame_of((1.0 + 0.1 * k, 1.0, 2.8), turn(2)))
        yield replace(c, frame=frame_of((3.0, 1.0, 2.5), turn(20 + k)))
        values = DISTRIBUTIONS["batwing"].intensity * (1.0 + 0.1 * k)
        yield replace(a, distribution=replace(DISTRIBUTIONS["batwing"], intensity=values + 1.0))
        yield replace(a, output=replace(a.output, spectrum=Constant(1.0 + k)))

    dr.set_flag(dr.JitFlag.KernelHistory, True)
    try:
        for k in range(3):
            dr.kernel_history_clear()
            for item in edited(k):
                session.apply(SceneDelta(changed=(item,)))
                readings(session)
            kernels = [e for e in dr.kernel_history() if e["type"] == dr.KernelType.JIT]
            assert kernels
            if k:
                assert all(entry["cache_hit"] for entry in kernels)
    finally:
        dr.set_flag(dr.JitFlag.KernelHistory, False)


def test_one_more_of_a_known_kind_meets_known_kernels():
    import drjit as dr

    # Tables grow by powers of two: one beside the room's four leaves room for three.
    lights = [
        luminaire("irregular", OPENINGS["box"], (0.5 * k, 1.0, 2.5), key=f"l{k}") for k in range(4)
    ]
    session = session_of(*ROOM, *lights[:1])
    readings(session)
    dr.set_flag(dr.JitFlag.KernelHistory, True)
    try:
        for light in lights[1:]:
            dr.kernel_history_clear()
            session.apply(SceneDelta((light,)))
            readings(session)
            kernels = [e for e in dr.kernel_history() if e["type"] == dr.KernelType.JIT]
            assert kernels
            # A kernel that only lies on the disk is as new to whoever has never added this many.
            new = [e for e in kernels if e["cache_disk"] or not e["cache_hit"]]
            if light is not lights[1]:
                assert not new
    finally:
        dr.set_flag(dr.JitFlag.KernelHistory, False)


def test_luminaires_may_come_and_go():
    session = Session(witness=False)
    session.apply(SceneDelta(ROOM[:3]))
    assert (readings(session).illuminance == 0.0).all()
    light = first_lights()["a"]
    for _ in range(2):
        session.apply(SceneDelta((light,)))
        assert (readings(session).illuminance > 0.0).any()
        session.apply(SceneDelta(removed=(light.id,)))
        assert (readings(session).illuminance == 0.0).all()


def test_a_luminaire_is_sent_as_it_is():
    light = first_lights()["c"]
    tree, parts, size = codec.encode(SceneDelta((light,)))
    block = bytearray(size)
    for start, values in parts:
        block[start : start + values.nbytes] = values.tobytes()
    sent = codec.decode(codec.from_text(codec.to_text(tree)), block).changed[0]
    assert sent.output == light.output
    assert sent.opening == light.opening
    for name in ("azimuth", "polar", "intensity", "frame"):
        expected = getattr(light.distribution, name)
        np.testing.assert_array_equal(getattr(sent.distribution, name), expected)
    np.testing.assert_array_equal(sent.frame, light.frame)
