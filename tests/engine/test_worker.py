"""The engine in a process of its own: order, urgency, cancels, and the same numbers as in this process."""

import gc
import re
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.errors import Cancelled, CodecError, EngineFault, EngineLost, SceneError
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.sensor import SensorSet
from lumenray.engine.session import Display, ViewSettings
from lumenray.engine.worker import faults
from lumenray.engine.worker.client import Worker
from lumenray.engine.worker.process import Process
from small_scenes import session_of
from workers import (
    NORMALS,
    POINTS,
    ROOT,
    camera,
    children,
    fake_worker,
    is_running,
    live,
    measure,
    nothing_left,
    open_files,
    room,
    view,
    wait_for,
    watch,
)


@pytest.fixture
def worker():
    with nothing_left(), fake_worker() as made:
        yield made


@pytest.fixture
def jobs():
    """Threads for jobs that are to run side by side."""
    with ThreadPoolExecutor(8) as pool:
        yield pool


@pytest.fixture(scope="module")
def engine():
    with Worker(ROOT) as made:
        yield made


def order(steps=20, transport="auto"):
    return BakeOrder(("box",), StopRule(samples=steps), transport=transport)


def events(worker):
    return measure(worker.session("asks"), 1).provenance.decisions


def places(worker, *names):
    """Where events lie in the worker's story."""
    story = events(worker)
    return [story.index(name) for name in names]


def begun(states):
    """Progress that tells when a job has begun to run."""
    return lambda: any("waiting" not in state.stage for state in list(states))


def test_a_worker_starts_fast_and_ends_without_a_trace():
    with nothing_left():
        worker = fake_worker()
        assert not worker.is_alive
        assert worker.pid is None
        with pytest.raises(EngineLost, match="not running"):
            worker.session("a")
        start = time.monotonic()
        worker.start()
        assert time.monotonic() - start < 5.0
        assert worker.is_alive
        assert str(worker.pid) in children()
        worker.start()
        worker.close()
        assert not worker.is_alive
        worker.close()


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


def test_idle_is_called_often_even_when_nothing_comes(worker):
    calls = []
    measure(worker.session("a"), 100, "deaf", idle=lambda: calls.append(time.monotonic()))
    assert len(calls) > 5
    assert np.diff(calls).max() < 0.1 + 0.15


def test_a_cancel_from_idle_ends_the_job(worker):
    session = worker.session("a")
    start = time.monotonic()
    with pytest.raises(Cancelled):
        measure(session, 100_000, idle=session.cancel)
    assert time.monotonic() - start < 2.0
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
    bake = jobs.submit(calm.bake_objects, order(300), states.append)
    wait_for(begun(states))
    measured = jobs.submit(measure, worker.session("lux"), 60)
    time.sleep(0.1)
    rendered = jobs.submit(worker.session("render").render, camera(), view(20))
    rendered.result(10)
    assert not measured.done()
    measured.result(10)
    assert not bake.done()
    bake.result(10)
    names = ["begin bake", "begin measure", "begin render", "end render", "end measure", "end bake"]
    assert places(worker, *names) == sorted(places(worker, *names))
    assert any(state.stage.startswith("paused for the") for state in states)


def test_jobs_of_one_kind_run_in_order_and_say_what_they_wait_for(worker, jobs):
    first, second = [], []
    a = jobs.submit(measure, worker.session("a"), 100, progress=first.append)
    wait_for(begun(first))
    b = jobs.submit(measure, worker.session("b"), 5, progress=second.append)
    a.result(10)
    b.result(10)
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
    assert render.done()


def test_a_delta_waits_for_the_job_of_its_own_session(worker, jobs):
    session, states = worker.session("a"), []
    session.apply(SceneDelta(room()))
    render = jobs.submit(session.render, camera(), view(60), lambda state, _: states.append(state))
    wait_for(begun(states))
    session.apply(SceneDelta(room()))
    worker.session("b").apply(SceneDelta(room()))
    assert render.result(10).depth.max() == 1.0
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
        assert np.array_equal(job.result(10).tristimulus, expected)


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
        job.result(5)
    assert time.monotonic() - start < 0.5
    assert not long.done()
    long.result(10)
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
    render.result(10)
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
    long.result(10)


def test_a_cancel_hits_only_its_own_session_and_no_later_job(worker, jobs):
    a, b, states = worker.session("a"), worker.session("b"), []
    running = jobs.submit(measure, a, 60, progress=states.append)
    wait_for(begun(states))
    b.cancel()
    assert len(running.result(10).illuminance) == 5
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


def test_a_live_view_goes_on_to_its_end(worker):
    session = worker.session("view")
    assert session.frame() is None
    watch(session, live(30))
    assert session.has_view_work
    frame = wait_for(session.frame)
    assert frame.pixels.shape == (6, 8, 4)
    wait_for(lambda: not session.has_view_work)
    last = session.frame()
    assert last.samples == 30
    assert last.is_final
    assert session.frame() is None
    session.apply(SceneDelta(room()))
    assert session.has_view_work
    watch(session, live(2))
    wait_for(lambda: not session.has_view_work)
    assert session.frame().revision == 1
    session.unwatch()
    assert not session.has_view_work


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


def test_no_frame_comes_after_the_end_of_a_view(worker):
    session = worker.session("view")
    watch(session)
    wait_for(session.frame)
    session.unwatch()
    assert session.frame() is None
    time.sleep(0.1)
    assert session.frame() is None
    watch(session)
    assert wait_for(session.frame).samples < 50


def test_only_the_newest_of_waiting_views_is_computed(worker, jobs):
    session, states = worker.session("a"), []
    job = jobs.submit(measure, session, 40, progress=states.append)
    wait_for(begun(states))
    for number in range(100):
        watch(session, live(5, seed=number))
    job.result(10)
    wait_for(lambda: not session.has_view_work)
    story = events(worker)
    assert [event for event in story if event.startswith("watch")] == ["watch 99"]


def test_a_live_view_takes_half_the_time_of_a_job_at_most(worker, jobs):
    states, view_session = [], worker.session("view")
    watch(view_session, live(100_000))
    wait_for(view_session.frame)
    job = jobs.submit(measure, worker.session("a"), 150, progress=states.append)
    wait_for(begun(states))
    wait_for(view_session.frame, 0.5)
    job.result(10)
    story = events(worker)
    inside = story[story.index("begin measure") : story.index("end measure")].count("slice")
    assert 50 <= inside <= 160


def test_two_live_views_take_turns(worker):
    first, second = worker.session("a"), worker.session("b")
    watch(first, live(60))
    watch(second, live(60))
    counts = [0, 0]

    def one_is_nearly_done():
        for number, session in enumerate((first, second)):
            frame = session.frame()
            counts[number] = frame.samples if frame else counts[number]
        return max(counts) >= 50

    wait_for(one_is_nearly_done)
    assert min(counts) > 40


def test_a_live_view_that_fails_says_so_and_can_be_mended(worker):
    session = worker.session("view")
    watch(session, live(transport="fault"))
    assert "failed at the live view (ValueError" in wait_for(session.view_error)
    assert not session.has_view_work
    watch(session)
    wait_for(session.frame)
    assert session.view_error() is None
    session.apply(SceneDelta(removed=("refuse",)))
    assert "refused" in wait_for(session.view_error)


def test_a_slow_reader_gets_the_newest_frame_and_nothing_piles_up(worker):
    session = worker.session("view")
    watch(session, live(100_000), width=1000)
    time.sleep(0.5)
    files = open_files()
    time.sleep(1.0)
    assert open_files() <= files + 3
    story = events(worker)
    assert session.frame().samples >= story.count("slice") - 20


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


@pytest.mark.slow
def test_files_and_threads_do_not_grow():
    with nothing_left():
        worker = fake_worker()
        for turn in range(20):
            worker.restart()
            measure(worker.session("a"), 1)
            if turn == 2:
                gc.collect()
                files, threads = open_files(), threading.active_count()
        session = worker.session("a")
        large = np.zeros((100_000, 3))
        for _ in range(200):
            session.apply(SceneDelta((SensorSet("s", "s", large, large),)))
        made = session.measure(large, large, StopRule(samples=1))
        assert len(made.illuminance) == 100_000
        assert threading.active_count() == threads
        gc.collect()
        # What the last answer's arrays are mapped from.
        assert open_files() <= files + 1
        worker.close()


def test_a_worker_that_is_forgotten_ends():
    with nothing_left():
        worker = fake_worker()
        worker.start()
        session = worker.session("a")
        pid = worker.pid
        del worker
        gc.collect()
        assert is_running(pid)
        assert len(measure(session, 1).illuminance) == 5
        del session
        gc.collect()
        wait_for(lambda: not is_running(pid) and str(pid) not in children())


def test_another_version_of_the_engine_is_refused(monkeypatch):
    from lumenray.engine.worker import link

    monkeypatch.setattr(link, "VERSION", "0.0.0")
    with nothing_left(), pytest.raises(EngineLost, match=r"of version .*, 0\.0\.0 is needed"):
        fake_worker().start()


def test_a_worker_that_cannot_start_says_why():
    with nothing_left():
        with pytest.raises(EngineLost, match=r"ended by itself .*No module named"):
            Worker(ROOT, search_path=[]).start()
        with pytest.raises(EngineLost, match="No module named 'nothing'"):
            Worker(ROOT, factory="nothing:at_all").start()


UNDER_ANOTHER_NAME = """
import importlib.util, sys
root = sys.argv[1]
spec = importlib.util.spec_from_file_location(
    "other", root + "/__init__.py", submodule_search_locations=[root]
)
sys.modules["other"] = importlib.util.module_from_spec(spec)
from other.engine.scene.scene import SceneDelta
from other.engine.scene.sensor import SensorSet
from other.engine.worker.client import Worker
import numpy as np, pathlib
with Worker(pathlib.Path(root), search_path=sys.path + [sys.argv[2]], factory="worker_fakes:FakeSession") as worker:
    session = worker.session("a")
    session.apply(SceneDelta((SensorSet("s", "s", np.ones((9, 3)), np.ones((9, 3))),)))
    from other.engine.accuracy.stopping import StopRule
    print(type(session.measure_sensors("s", StopRule(samples=1))).__module__)
"""


def test_the_package_may_have_another_name_here_than_there():
    """Inside Blender it is an extension."""
    helpers = str(ROOT / "tests" / "helpers")
    done = subprocess.run(
        [sys.executable, "-c", UNDER_ANOTHER_NAME, str(ROOT), helpers],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.stdout == "other.engine.session\n", done.stderr


def test_nobody_else_can_read_the_key():
    process = Process(ROOT, [], None, None)
    shown = Path(f"/proc/{process.pid}/cmdline").read_bytes()
    shown += Path(f"/proc/{process.pid}/environ").read_bytes()
    assert process._key.hex().encode() not in shown
    assert process._key not in shown
    process.kill()
    process.wait(5.0)
    process.close()
    process.output.close()


@pytest.mark.parametrize(
    ("code", "log", "text"),
    [
        (-9, (), "ended from outside"),
        (-6, (), r"crashed \(SIGABRT\), because memory is short or a library failed; if"),
        (-11, ("bad luck", "", "Fatal Python error: x", "more"), r"\(SIGSEGV, .*: bad luck\)"),
        (-6, ("what():  std::bad_alloc",), "ran out of memory; lower the density"),
        (7, ("bye",), r"exit code 7, its last words: bye"),
        (0xC0000005, (), "exit code 0xc0000005"),
        (None, (), "exit code unknown"),
    ],
)
def test_the_end_of_a_process_is_put_into_words(code, log, text):
    told = faults.describe_end(code, log)
    assert re.search(text, told)
    assert told.endswith("start again: the scene is sent anew, nothing is lost")


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
    assert time.monotonic() - start < 20.0
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
