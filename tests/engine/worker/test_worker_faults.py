"""The engine killed, stopped, out of memory or left alone: nothing is left, nobody waits, the next job is right."""

import os
import random
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from small_scenes import session_of
from worker_fakes import BUSY
from workers import (
    AT_ONCE,
    ROOT,
    camera,
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

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.errors import BackendError, Cancelled, EngineFault, EngineLost
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.views import Display, ViewSettings
from lumenray.engine.worker.client import Worker

AGAIN = "start again: the scene is sent anew, nothing is lost"


def resync(worker):
    """Start the worker if need be and send a whole scene, as a host does."""
    worker.start()
    session = worker.session("main")
    session.apply(SceneDelta(room()))
    return session


def check_lost(worker, session, *calls):
    """Check that everything says at once that the engine is gone, in the same words."""
    wait_for(lambda: worker.lost)
    start = time.monotonic()
    for call in (
        lambda: session.apply(SceneDelta()),
        lambda: measure(session),
        lambda: session.render(camera(), view()),
        lambda: watch(session),
        worker.status,
        lambda: worker.session("other"),
        *calls,
    ):
        with pytest.raises(EngineLost) as caught:
            call()
        assert AGAIN in str(caught.value)
    assert time.monotonic() - start < AT_ONCE
    assert session.is_lost
    assert not worker.is_alive
    assert AGAIN in session.view_error()
    session.cancel()
    session.unwatch()
    assert session.frame() is None
    session.close()


def kill_at_random_moments(worker, jobs, times, longest, is_right):
    """Kill the engine again and again in the middle of jobs.

    Parameters
    ----------
    jobs : list of callable    Long jobs, each begun with a session; one that returns at once goes on by itself.
    times : int    How often.
    longest : float    Longest time from the job's begin to the kill. [s]
    is_right : callable    Whether a job of a new session gives what it should.
    """
    rng = random.Random(11)  # noqa: S311
    for turn in range(times):
        session = resync(worker)
        assert is_right(session), turn
        pid, delay = worker.pid, rng.uniform(0.0, longest)
        killer = threading.Timer(delay, os.kill, (pid, signal.SIGKILL))
        killer.start()
        try:
            with pytest.raises(EngineLost, match="ended from outside"):
                jobs[turn % len(jobs)](session)
                while True:
                    # The live view goes on by itself: look at it until its engine is gone.
                    session.frame()
                    session.apply(SceneDelta(room()))
                    time.sleep(0.01)
        finally:
            killer.join()
        check_lost(worker, session)
        assert not is_running(pid)
    assert is_right(resync(worker))


@pytest.mark.slow
def test_killed_at_many_moments_of_a_session_that_computes_nothing():
    def is_right(session):
        picture = session.render(camera(), view(1, seed=4))
        expected = np.random.default_rng(4).random((6, 8, 3), np.float32)
        return np.array_equal(picture.tristimulus, expected) and picture.depth.max() == 1.0

    bake = BakeOrder(("box",), StopRule(samples=100_000))
    jobs = [
        lambda session: session.render(camera(200, 200), view(100_000), lambda *_: None, 0.0),
        lambda session: session.bake_objects(bake),
        lambda session: watch(session, width=300),
    ]
    files = open_files()
    with nothing_left(), fake_worker() as worker:
        kill_at_random_moments(worker, jobs, 35, 0.4, is_right)
    assert open_files() == files


@pytest.mark.mitsuba
@pytest.mark.slow
def test_killed_at_many_moments_of_the_engine():
    expected = measure(session_of(*room()), 256).illuminance
    bake = BakeOrder(("box",), StopRule(samples=1 << 24), density=20.0)
    endless = ViewSettings(StopRule(samples=1 << 24))
    jobs = [
        lambda session: session.render(camera(300, 200), endless, lambda *_: None, 0.1),
        lambda session: session.bake_objects(bake),
        lambda session: session.watch(camera(300, 200), live(1 << 20), Display()),
    ]

    def is_right(session):
        return np.array_equal(measure(session, 256).illuminance, expected)

    with nothing_left(), Worker(ROOT) as worker:
        kill_at_random_moments(worker, jobs, 15, 2.0, is_right)


def test_all_that_wait_are_told():
    with nothing_left(), fake_worker() as worker, ThreadPoolExecutor(4) as pool:
        session = resync(worker)
        jobs = [
            pool.submit(measure, session, 100_000),
            pool.submit(worker.session("b").render, camera(), view(100_000)),
            pool.submit(measure, worker.session("c"), 100_000),
        ]
        time.sleep(0.2)
        os.kill(worker.pid, signal.SIGKILL)
        check_lost(worker, session, *(lambda job=job: job.result(1.0) for job in jobs))


@pytest.mark.parametrize(
    ("kind", "text"),
    [
        ("abort", "the engine ran out of memory; lower the density"),
        ("segment", r"the engine crashed \(SIGSEGV\), because memory is short or a library failed"),
        ("exit", r"the engine ended by itself \(exit code 7\)"),
    ],
)
def test_a_process_that_ends_says_how(kind, text):
    with nothing_left(), fake_worker() as worker:
        session = resync(worker)
        with pytest.raises(EngineLost, match=text):
            measure(session, 1, kind)
        check_lost(worker, session)
        assert len(measure(resync(worker), 1).illuminance) == 5


def test_a_stopped_process_counts_as_hung():
    with nothing_left(), fake_worker(hung_after=3.0) as worker:
        session = resync(worker)
        pid, start = worker.pid, time.monotonic()
        threading.Timer(0.3, os.kill, (pid, signal.SIGSTOP)).start()
        with pytest.raises(EngineLost, match=r"did not answer for [0-9]+ s and was ended"):
            measure(session, 100_000)
        assert 2.5 < time.monotonic() - start < AT_ONCE
        check_lost(worker, session)
        assert not is_running(pid)
        assert len(measure(resync(worker), 1).illuminance) == 5


def test_an_idle_stopped_process_is_noticed_too():
    with nothing_left(), fake_worker(hung_after=1.5) as worker:
        session = resync(worker)
        os.kill(worker.pid, signal.SIGSTOP)
        wait_for(lambda: worker.lost)
        check_lost(worker, session)


def test_a_short_stop_is_survived():
    with nothing_left(), fake_worker(hung_after=15.0) as worker:
        session = resync(worker)
        threading.Timer(0.1, os.kill, (worker.pid, signal.SIGSTOP)).start()
        threading.Timer(1.8, os.kill, (worker.pid, signal.SIGCONT)).start()
        assert len(measure(session, 200).illuminance) == 5
        assert worker.is_alive


def test_native_code_that_keeps_the_interpreter_is_not_hung():
    with nothing_left(), fake_worker(hung_after=0.7 * BUSY) as worker:
        session = resync(worker)
        measure(session, 1, "busy")
        assert worker.is_alive


def test_a_job_that_does_not_heed_a_cancel_is_ended():
    with nothing_left(), fake_worker(cancel_patience=1.0) as worker:
        session = resync(worker)
        start = time.monotonic()
        with pytest.raises(EngineLost, match="did not stop within 1 s"):
            # Cancelled once it has begun.
            measure(session, 100_000, "deaf", progress=lambda *_: session.cancel())
        assert time.monotonic() - start < AT_ONCE
        check_lost(worker, session)
        with pytest.raises(Cancelled):
            measure(resync(worker), 100_000, idle=lambda: worker.session("main").cancel())


def test_a_picture_may_be_given_more_time_to_heed_a_cancel():
    with nothing_left(), fake_worker(cancel_patience=0.3) as worker:
        session = resync(worker)
        with pytest.raises(Cancelled):
            # Deaf for a second and a half once it has begun; nobody waits for it any longer.
            session.render(camera(), view(300, "deaf"), stop_waiting, patience=60.0)
        time.sleep(1.0)
        assert worker.is_alive
        assert len(measure(session, 2).illuminance) == 5


def stop_waiting(*_):
    raise Cancelled("cancelled")


def test_a_worker_that_is_closed_lets_nobody_wait():
    with nothing_left(), fake_worker() as worker, ThreadPoolExecutor(2) as pool:
        session = resync(worker)
        job = pool.submit(measure, session, 100_000)
        time.sleep(0.1)
        start = time.monotonic()
        worker.close()
        with pytest.raises(EngineLost, match="the engine was closed"):
            job.result(AT_ONCE)
        assert time.monotonic() - start < AT_ONCE
        assert session.is_lost
        assert not worker.is_alive
        worker.close()


def test_a_stopped_process_can_be_closed():
    with nothing_left(), fake_worker() as worker:
        resync(worker)
        os.kill(worker.pid, signal.SIGSTOP)
        start = time.monotonic()
        worker.close(0.5)
        assert time.monotonic() - start < AT_ONCE


def points(count):
    return np.tile([[0.7, 1.2, 0.8]], (count, 1)), np.tile([[0.0, 0.0, 1.0]], (count, 1))


@pytest.mark.mitsuba
@pytest.mark.parametrize(
    ("gibibytes", "job"),
    [
        (0.75, lambda session: session.measure(*points(1_000_000), StopRule(samples=16))),
        (0.75, lambda session: session.measure(*points(8_000_000), StopRule(samples=16))),
        (0.75, lambda session: session.bake_objects(HUGE_BAKE)),
        # Native libraries crash here where others say that memory is short.
        (0.75, lambda session: session.render(camera(6000, 4000), view(1))),
    ],
    ids=["measure", "transfer", "bake", "render"],
)
@pytest.mark.slow
def test_a_job_too_large_for_the_memory_says_so(gibibytes, job):
    expected = measure(session_of(*room()), 64).illuminance
    with nothing_left(), Worker(ROOT, memory_limit=int(gibibytes * 2**30)) as worker:
        session = resync(worker)
        # What is sent may leave no room for the libraries.
        told = r"memory.*lower the density|memory left .* raise the engine's memory limit"
        with pytest.raises((EngineFault, EngineLost, BackendError), match=told):
            job(session)
        assert np.array_equal(measure(resync(worker), 64).illuminance, expected)


HUGE_BAKE = BakeOrder(("box",), StopRule(samples=4), density=400.0, largest=4096)


@pytest.mark.mitsuba
def test_a_memory_too_small_for_the_libraries_says_so():
    with nothing_left(), Worker(ROOT, memory_limit=7 << 26) as worker:
        for _ in range(2):
            session = resync(worker)
            with pytest.raises(BackendError, match="left for the engine's libraries; raise the"):
                measure(session)
            check_lost(worker, session)


def test_an_engine_whose_libraries_do_not_load_makes_way_for_another():
    """They may have been loaded in part, or be there for the next one."""
    with nothing_left(), fake_worker() as worker:
        session = resync(worker)
        with pytest.raises(BackendError, match=r"a library is missing; reinstall$"):
            measure(session, 1, "unloadable")
        check_lost(worker, session)
        assert len(measure(resync(worker), 1).illuminance) == 5


PARENT = """
import sys, threading, time
sys.path[:0] = {path!r}
from workers import *
from lumenray.engine.scene.scene import SceneDelta
worker = {worker}
worker.start()
session = worker.session("a")
session.apply(SceneDelta(room()))
large = np.zeros((100_000, 3))
threading.Thread(target={job}, daemon=True).start()
{then}
"""

JOBS = {
    "fake": ("fake_worker()", "lambda: measure(session, 100_000)"),
    "deaf": ("fake_worker()", "lambda: measure(session, 100_000, 'deaf')"),
    "busy": ("fake_worker()", "lambda: measure(session, 100_000, 'busy')"),
    "engine": ("Worker(ROOT)", "lambda: measure(session, 1 << 26)"),
}

WAIT = 'time.sleep(0.5); print("pid", worker.pid, flush=True); time.sleep(60)'


def start_parent(kind, then=WAIT):
    worker, job = JOBS[kind]
    text = PARENT.format(
        path=[path for path in sys.path if path], worker=worker, job=job, then=then
    )
    return subprocess.Popen([sys.executable, "-c", text], stdout=subprocess.PIPE, text=True)


def engine_of(parent):
    for line in parent.stdout:
        if line.startswith("pid "):
            return int(line.split()[1])
    raise AssertionError("the parent ended early")


@pytest.mark.parametrize("kind", ["fake", "deaf", "busy", pytest.param("engine", marks=pytest.mark.mitsuba)])  # fmt: skip
def test_the_engine_ends_with_its_parent(kind):
    with nothing_left():
        parent = start_parent(kind)
        engine = engine_of(parent)
        assert is_running(engine)
        parent.kill()
        parent.wait()
        parent.stdout.close()
        wait_for(lambda: not is_running(engine), 5.0)


def test_a_stopped_engine_ends_with_its_parent():
    with nothing_left():
        parent = start_parent("fake")
        engine = engine_of(parent)
        os.kill(engine, signal.SIGSTOP)
        parent.kill()
        parent.wait()
        parent.stdout.close()
        wait_for(lambda: not is_running(engine), 5.0)


@pytest.mark.parametrize(
    "then", ["", "raise SystemExit(3)", "1 / 0", "import os; os._exit(4)", "worker.close()"]
)
def test_the_engine_ends_however_its_parent_ends(then):
    with nothing_left():
        parent = start_parent("fake", f'print("pid", worker.pid, flush=True)\n{then}')
        engine = engine_of(parent)
        parent.wait(10.0)
        parent.stdout.close()
        wait_for(lambda: not is_running(engine), 5.0)
