"""The engine in a process of its own: order, urgency, cancels, and the same numbers as in this process."""

import json
import threading
import time

import numpy as np
import pytest
from small_inks import make_ink
from small_scenes import session_of
from workers import (
    AT_ONCE,
    NORMALS,
    POINTS,
    ROOT,
    begun,
    camera,
    events,
    live,
    measure,
    room,
    view,
    wait_for,
    watch,
)

from lumenray.engine import kernel_cache
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.errors import Cancelled, CodecError, EngineFault, EngineLost, SceneError
from lumenray.engine.requirements.decision import Asked
from lumenray.engine.scene.modelling import Modelling, Switch
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.sensor import SensorSet
from lumenray.engine.session import Session
from lumenray.engine.views import Display, ViewSettings
from lumenray.engine.worker.client import Worker
from lumenray.engine.worker.link import JOB_NAMES
from lumenray.engine.worker.server import JOBS
from lumenray.libraries import cloths


@pytest.fixture(scope="module")
def engine():
    with Worker(ROOT) as made:
        yield made


def test_decisions_come_from_a_worker_as_from_the_session(engine):
    """Nothing has to be compiled for them, so that they come at once."""
    items = (*room(), Modelling((("colours", Switch.OFF),), 0.2))
    asked = Asked(0.01, False, frozenset({"box"}))
    near, far = session_of(*items), engine.session("decisions")
    far.apply(SceneDelta(items))
    told = far.explain("auto", asked, has_trial=False)
    assert told == near.explain("auto", asked, has_trial=False)
    assert told.plan.asked == asked
    switches = {decision.name: decision.switch for decision in told.plan.decisions}
    assert switches["colours"] is Switch.OFF
    assert told.plan.allowed == 0.2 * 0.01
    far.close()


def test_every_job_has_a_name_for_those_who_wait_for_it():
    assert JOB_NAMES.keys() == JOBS.keys()


@pytest.mark.slow
def test_a_pigment_layer_comes_from_a_worker_as_from_the_session(tmp_path, monkeypatch):
    """Each has a folder of its own for what it has solved, so that neither takes the other's."""
    content = make_ink(0.3, absorption=0.1, solution={"band_step_nm": 80, "incidences": 2}).content
    monkeypatch.setenv("LUMENRAY_INK_CACHE", str(tmp_path / "near"))
    near = Session().compute_ink(json.dumps(content), draft=True)
    monkeypatch.setenv("LUMENRAY_INK_CACHE", str(tmp_path / "far"))
    told = []
    with Worker(ROOT) as engine:
        far = engine.session("print")
        made = far.compute_ink(json.dumps(content), draft=True, progress=told.append)
    assert any((tmp_path / "far").iterdir())
    assert (made.key, made.notes, made.realisations) == (near.key, near.notes, near.realisations)
    np.testing.assert_array_equal(made.readings, near.readings)
    there, here = (each.surface.front_reflection.values for each in (made, near))
    np.testing.assert_array_equal(there, here)
    assert any(each.stage == "pigment layer" for each in told)


@pytest.mark.slow
def test_a_cloth_comes_from_a_worker_as_from_the_session(tmp_path, monkeypatch):
    text = cloths.presets()["voile"].read_text(encoding="utf-8")
    monkeypatch.setenv("LUMENRAY_CLOTH_CACHE", str(tmp_path / "near"))
    near = Session().compute_cloth(text, draft=True)
    monkeypatch.setenv("LUMENRAY_CLOTH_CACHE", str(tmp_path / "far"))
    told = []
    with Worker(ROOT) as engine:
        far = engine.session("curtain")
        made = far.compute_cloth(text, draft=True, progress=told.append)
    assert any((tmp_path / "far").iterdir())
    assert (made.key, made.notes, made.rays) == (near.key, near.notes, near.rays)
    assert made.sheet == near.sheet
    for side in ("front_reflection", "front_transmission"):
        there, here = (getattr(each.surface, side).values for each in (made, near))
        np.testing.assert_array_equal(there, here)
    done = [each.done for each in told]
    assert len(set(done)) > 3 and done == sorted(done)


def order(steps=20, transport="auto"):
    return BakeOrder(("box",), StopRule(samples=steps), transport=transport)


def places(worker, *names):
    """Where events lie in the worker's story."""
    story = events(worker)
    return [story.index(name) for name in names]


def test_jobs_answer_what_the_session_answers(worker):
    session = worker.session("a")
    session.apply(SceneDelta((SensorSet("s", "s", np.array(POINTS), np.array(NORMALS)),)))
    assert session.revision == 1
    made = measure(session, 2)
    assert np.allclose(made.illuminance, 2.7)
    assert made.provenance.seed == 3
    again = session.measure_sensors("s", StopRule(samples=2))
    assert np.array_equal(again.illuminance, made.illuminance)
    picture = session.render(camera(300, 200), view(2, seed=5))
    expected = np.random.default_rng(5).random((200, 300, 3), np.float32)
    assert np.array_equal(picture.tristimulus, expected)
    assert session.bake_objects(order(2)).files == ("box",)


def test_sessions_are_told_apart_by_name(worker):
    a, b = worker.session("a"), worker.session("b")
    assert worker.session("a") is a
    a.apply(SceneDelta(room()))
    assert a.render(camera(), view(1)).depth.max() == 1.0
    assert b.render(camera(), view(1)).depth.max() == 0.0
    a.close()
    assert a.is_lost
    with pytest.raises(EngineLost, match="closed"):
        measure(a)
    assert worker.session("a").render(camera(), view(1)).depth.max() == 0.0


def test_progress_and_pictures_come_on_the_callers_thread(worker):
    states, pictures, threads = [], [], set()

    def progress(state, preview):
        states.append(state.done)
        threads.add(threading.current_thread())
        if preview is not None:
            pictures.append((time.monotonic(), preview()))

    session = worker.session("a")
    session.apply(SceneDelta(room()))
    start = time.monotonic()
    session.render(camera(), view(160), progress, preview_interval=0.3)
    seconds = time.monotonic() - start
    assert threads == {threading.current_thread()}
    assert states == sorted(states)
    assert 3 <= len(states) <= 10 * seconds + 2
    assert 2 <= len(pictures) <= seconds / 0.3 + 2
    assert pictures[0][1].shape == (6, 8, 3)
    pictures.clear()
    session.render(camera(), view(20), progress, preview_interval=None)
    assert pictures == []


def test_who_waits_is_told_that_kernels_are_compiled(worker, monkeypatch, tmp_path):
    monkeypatch.setenv("DRJIT_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(kernel_cache, "LOOK", 0.0)
    (tmp_path / "old.llvm.bin").touch()
    stages = []
    session = worker.session("a")
    session.apply(SceneDelta(room()))

    def compile_one():
        known = len(list(tmp_path.iterdir()))
        (tmp_path / f"{min(known, 3)}.llvm.bin").touch()

    def progress(state, _preview):
        stages.append(state.stage)

    session.render(camera(), view(40), progress, idle=compile_one)
    told = [stage for stage in stages if "compiling" in stage]
    assert told[-1] == "compiling kernels, 3 so far, which are kept for next time"
    assert len(told) <= 3


def test_idle_is_called_often_even_when_nothing_comes(worker):
    calls = []
    measure(worker.session("a"), 100, "deaf", idle=lambda: calls.append(time.monotonic()))
    assert len(calls) > 5
    assert np.median(np.diff(calls)) < 0.25


def test_a_cancel_from_idle_ends_the_job(worker):
    session = worker.session("a")
    start = time.monotonic()
    with pytest.raises(Cancelled):
        measure(session, 100_000, idle=session.cancel)
    assert time.monotonic() - start < AT_ONCE
    assert len(measure(session, 2).illuminance) == 5


def test_what_progress_raises_ends_the_job(worker):
    session = worker.session("a")

    def progress(state):
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough"):
        measure(session, 100_000, progress=progress)
    assert len(measure(session, 2).illuminance) == 5


def test_urgent_jobs_run_inside_the_others(worker, jobs):
    states, calm = [], worker.session("bake")
    bake = jobs.submit(calm.bake_objects, order(500), states.append)
    wait_for(begun(states))
    measuring = []
    measured = jobs.submit(measure, worker.session("lux"), 200, progress=measuring.append)
    wait_for(begun(measuring))
    rendered = jobs.submit(worker.session("render").render, camera(), view(20))
    for job in (rendered, measured, bake):
        job.result(60)
    names = ["begin bake", "begin measure", "begin render", "end render", "end measure", "end bake"]
    assert places(worker, *names) == sorted(places(worker, *names))
    assert any(state.stage.startswith("paused for the") for state in states)


def test_jobs_of_one_kind_run_in_order_and_say_what_they_wait_for(worker, jobs):
    first, second = [], []
    a = jobs.submit(measure, worker.session("a"), 100, progress=first.append)
    wait_for(begun(first))
    b = jobs.submit(measure, worker.session("b"), 5, progress=second.append)
    a.result(60)
    b.result(60)
    texts = [state.text() for state in second]
    assert any(text.startswith("waiting for the measurement, ") for text in texts)
    assert not any(state.stage.startswith("waiting") for state in first)


def test_a_bake_waits_for_a_render(worker, jobs):
    states = []
    render = jobs.submit(
        worker.session("a").render, camera(), view(100), lambda state, _: states.append(state)
    )
    wait_for(begun(states))
    worker.session("b").bake_objects(order(2))
    render.result(60)
    names = ["begin render", "end render", "begin bake", "end bake"]
    assert places(worker, *names) == sorted(places(worker, *names))


def test_a_delta_waits_for_the_job_of_its_own_session(worker, jobs):
    session, states = worker.session("a"), []
    session.apply(SceneDelta(room()))
    render = jobs.submit(session.render, camera(), view(60), lambda state, _: states.append(state))
    wait_for(begun(states))
    session.apply(SceneDelta(room()))
    worker.session("b").apply(SceneDelta(room()))
    assert render.result(60).depth.max() == 1.0
    assert session.render(camera(), view(1)).depth.max() == 2.0
    story = events(worker)
    # The other session's delta was done meanwhile.
    assert story.index("apply 1", story.index("begin render")) < story.index("end render")
    assert story.index("apply 2") > story.index("end render")


def test_two_jobs_of_one_session_do_not_mix(worker, jobs):
    session = worker.session("a")
    session.apply(SceneDelta(room()))
    made = [jobs.submit(session.render, camera(), view(10, seed=seed)) for seed in range(6)]
    for seed, job in enumerate(made):
        expected = np.random.default_rng(seed).random((6, 8, 3), np.float32)
        assert np.array_equal(job.result(60).tristimulus, expected)


def test_a_waiting_job_is_cancelled_at_once_and_never_runs(worker, jobs):
    states, waiting = [], worker.session("b")
    long = jobs.submit(measure, worker.session("a"), 200, progress=states.append)
    wait_for(begun(states))
    told = []
    job = jobs.submit(waiting.bake_objects, order(10), told.append)
    wait_for(lambda: told)
    start = time.monotonic()
    waiting.cancel()
    with pytest.raises(Cancelled):
        job.result(AT_ONCE)
    assert time.monotonic() - start < AT_ONCE
    assert not long.done()
    long.result(60)
    assert "begin bake" not in events(worker)


def test_a_paused_job_is_cancelled_at_once(worker, jobs):
    states, more, calm = [], [], worker.session("bake")
    bake = jobs.submit(calm.bake_objects, order(10_000), states.append)
    wait_for(begun(states))
    render = jobs.submit(
        worker.session("a").render, camera(), view(150), lambda state, _: more.append(state)
    )
    wait_for(begun(more))
    calm.cancel()
    with pytest.raises(Cancelled):
        bake.result(0.5)
    assert not render.done()
    render.result(60)
    assert len(measure(calm, 2).illuminance) == 5
    assert "end bake" not in events(worker)


def test_a_bake_that_is_stopped_answers_with_what_it_has(worker, jobs):
    states, session = [], worker.session("bake")
    bake = jobs.submit(session.bake_objects, order(10_000), states.append)
    wait_for(begun(states))
    session.stop()
    made = bake.result(5)
    assert made.departures[0].message.endswith("stop bake")
    # The word is for that bake alone.
    assert session.bake_objects(order(3)).departures[0].message.endswith("end bake")
    session.stop()
    assert session.bake_objects(order(3)).departures[0].message.endswith("end bake")


def test_a_bake_that_waits_has_nothing_to_keep(worker, jobs):
    states, told, waiting = [], [], worker.session("b")
    long = jobs.submit(measure, worker.session("a"), 200, progress=states.append)
    wait_for(begun(states))
    job = jobs.submit(waiting.bake_objects, order(10), told.append)
    wait_for(lambda: told)
    waiting.stop()
    with pytest.raises(Cancelled):
        job.result(5)
    long.result(60)


def test_a_cancel_hits_only_its_own_session_and_no_later_job(worker, jobs):
    a, b, states = worker.session("a"), worker.session("b"), []
    running = jobs.submit(measure, a, 60, progress=states.append)
    wait_for(begun(states))
    b.cancel()
    assert len(running.result(60).illuminance) == 5
    for _ in range(30):
        job = jobs.submit(measure, a, 3)
        a.cancel()
        try:
            job.result(5)
        except Cancelled:
            continue
        finally:
            assert len(measure(a, 1).illuminance) == 5


def test_errors_come_back_as_they_are(worker):
    session = worker.session("a")
    with pytest.raises(
        EngineFault, match=r"failed at the measure \(ValueError: something is odd\)"
    ):
        measure(session, 1, "fault")
    assert any("Traceback" in line for line in worker.log())
    for kind in ("memory", "native memory"):
        with pytest.raises(EngineFault, match="out of memory; lower the density"):
            measure(session, 1, kind)
    with pytest.raises(EngineFault, match="failed at the measure"):
        session.measure_sensors("nobody", StopRule(samples=1))
    with pytest.raises(CodecError, match="object cannot be sent"):
        session.apply(SceneDelta((object(),)))
    assert len(measure(session, 1).illuminance) == 5


def test_a_refused_delta_is_told_by_the_next_job_that_waits(worker):
    session = worker.session("a")
    session.apply(SceneDelta(room()))
    session.apply(SceneDelta(removed=("refuse",)))
    session.apply(SceneDelta(room()))
    with pytest.raises(SceneError, match="refused"):
        measure(session, 1)
    assert session.revision == 2
    assert session.render(camera(), view(1)).depth.max() == 2.0


def test_what_libraries_print_does_not_disturb_the_line(worker):
    assert len(measure(worker.session("a"), 300, "noise").illuminance) == 5
    wait_for(lambda: "native noise" in worker.log())
    assert len(worker.log()) == 50


def test_garbage_is_freed_on_the_thread_that_computes(worker):
    """Dr.Jit ends the process when objects of its are freed by another thread while it makes a kernel."""
    session = worker.session("view")
    point = np.array(POINTS[:1])
    many = tuple(SensorSet(f"s{k}", "s", point, point) for k in range(500))
    for _ in range(20):
        session.apply(SceneDelta(removed=("rubbish",)))
        session.apply(SceneDelta(many))
    freed = [event for event in events(worker) if event.startswith("freed")]
    assert len(freed) >= 10
    assert set(freed) == {"freed by MainThread"}


def test_many_threads_may_use_one_worker(worker, jobs):
    def use(number):
        session = worker.session(f"s{number % 4}")
        for step in range(10):
            session.apply(SceneDelta(room()))
            points = np.full((100, 3), number * 100.0 + step)
            made = session.measure(points, points, StopRule(samples=1))
            assert np.allclose(made.illuminance, 3.0 * (number * 100.0 + step))

    for job in [jobs.submit(use, number) for number in range(8)]:
        job.result(30)


# ---- with the engine itself ----


@pytest.mark.mitsuba
def test_the_engine_tells_its_status(engine):
    status = engine.status()
    assert status.usable, status.cause


@pytest.mark.mitsuba
@pytest.mark.slow
def test_answers_are_those_of_a_session_in_this_process(engine):
    session = engine.session("same")
    session.apply(SceneDelta(room()))
    here = session_of(*room())
    made, expected = measure(session, 4096), measure(here, 4096)
    assert np.array_equal(made.illuminance, expected.illuminance)
    assert made.provenance.scene_hash == expected.provenance.scene_hash
    settings = ViewSettings(StopRule(samples=16), 2, illuminance=True)
    made, expected = (each.render(camera(32, 24), settings) for each in (session, here))
    for name in ("tristimulus", "depth", "normal", "illuminance"):
        assert np.array_equal(getattr(made, name), getattr(expected, name)), name
    asked = BakeOrder(("box",), StopRule(samples=64), density=4.0)
    made, expected = (each.bake_objects(asked) for each in (session, here))
    for name in ("illuminance", "standard_error", "covered", "object"):
        assert np.array_equal(getattr(made.pages[0], name), getattr(expected.pages[0], name)), name
    assert np.array_equal(made.maps[0].layout.uv, expected.maps[0].layout.uv)
    assert made.maps[0].mean == expected.maps[0].mean
    session.close()


@pytest.mark.mitsuba
@pytest.mark.slow
def test_a_view_a_render_and_a_bake_of_the_engine_go_on_together(engine, jobs):
    view_session, bake_session = engine.session("view"), engine.session("bake")
    for session in (view_session, bake_session):
        session.apply(SceneDelta(room()))
    asked = BakeOrder(("box",), StopRule(samples=2048), density=8.0)
    alone = bake_session.bake_objects(asked)
    states = []
    bake = jobs.submit(bake_session.bake_objects, asked, states.append)
    wait_for(begun(states), 30)
    view_session.watch(camera(64, 48), live(1 << 16), Display())
    assert np.isfinite(wait_for(view_session.frame, 30).pixels).all()
    assert np.array_equal(bake.result(60).pages[0].illuminance, alone.pages[0].illuminance)
    view_session.close()
    bake_session.close()


@pytest.mark.mitsuba
def test_a_job_of_the_engine_is_cancelled(engine):
    session = engine.session("cancel")
    session.apply(SceneDelta(room()))
    states = []

    def progress(state, _):
        states.append(state)
        if state.samples:
            session.cancel()

    start = time.monotonic()
    with pytest.raises(Cancelled):
        session.render(camera(128, 96), ViewSettings(StopRule(samples=1 << 24)), progress)
    assert states
    assert time.monotonic() - start < 60.0
    session.close()


def test_a_closed_session_leaves_nothing_to_another_of_its_name(worker):
    session = worker.session("view")
    for _ in range(3):
        session.apply(SceneDelta())
    watch(session, live(1000))
    wait_for(session.frame)
    session.close()
    again = worker.session("view")
    assert again.revision == 0
    assert again.frame() is None
    again.apply(SceneDelta())
    watch(again, live(20))
    frame = wait_for(again.frame)
    assert frame.revision == again.revision == 1
