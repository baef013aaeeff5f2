"""The engine's process from its start to its end."""

import gc
import re
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from workers import (
    AT_ONCE,
    ROOT,
    children,
    fake_worker,
    is_running,
    measure,
    nothing_left,
    open_files,
    wait_for,
)

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import EngineLost
from lumenray.engine.scene.scene import SceneDelta
from lumenray.engine.scene.sensor import SensorSet
from lumenray.engine.worker import faults
from lumenray.engine.worker.client import Worker
from lumenray.engine.worker.process import Process


def test_a_worker_starts_fast_and_ends_without_a_trace():
    with nothing_left():
        worker = fake_worker()
        assert not worker.is_alive
        assert worker.pid is None
        with pytest.raises(EngineLost, match="not running"):
            worker.session("a")
        start = time.monotonic()
        worker.start()
        assert time.monotonic() - start < AT_ONCE
        assert worker.is_alive
        assert str(worker.pid) in children()
        worker.start()
        worker.close()
        assert not worker.is_alive
        worker.close()


@pytest.mark.slow
def test_files_and_threads_do_not_grow():
    with nothing_left():
        worker = fake_worker()
        for turn in range(20):
            worker.close()
            worker.start()
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
    assert done.stdout == "other.engine.measurements\n", done.stderr


def test_nobody_else_can_read_the_key():
    process = Process(ROOT, [], None, "", None)
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
