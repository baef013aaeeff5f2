"""What tests of the worker share: workers, jobs, and a look at what a process leaves behind."""

import os
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from small_scenes import box, paint

import lumenray
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.views import Display, LiveSettings, ViewSettings
from lumenray.engine.worker.client import Worker

ROOT = Path(lumenray.__file__).parent

# What waits for nothing is over within this time on a busy machine too; an engine that is silent
# counts as hung only later. [s]
AT_ONCE = 8.0

POINTS = [[0.7, 1.2, 0.8]] * 5
NORMALS = [[0.0, 0.0, 1.0]] * 5


def fake_worker(**options):
    return Worker(ROOT, factory="worker_fakes:FakeSession", **options)


def camera(width=8, height=6):
    frame = np.eye(4)
    frame[:3, 3] = 1.0, 1.0, 1.9
    return Camera(frame, Projection.PERSPECTIVE, width, height)


def view(steps=20, transport="auto", seed=0):
    return ViewSettings(StopRule(samples=steps), seed, transport=transport)


def live(steps=1000, transport="auto", seed=0):
    return LiveSettings(steps, seed, transport=transport)


def room():
    """Items of a small room with a lamp."""
    output = Output(Quantity.LUMINOUS_INTENSITY, 100.0)
    return (
        box(2, 2, 2),
        paint(0.5),
        PointLight("lamp", "lamp", output, np.array([1.0, 1.0, 1.5])),
    )


def measure(session, steps=20, transport="auto", **options):
    return session.measure(POINTS, NORMALS, StopRule(samples=steps), 3, transport, **options)


def watch(session, settings=None, width=8):
    session.watch(camera(width), settings or live(), Display())


def wait_for(condition, seconds=60.0):
    """Wait until a condition gives something true, and return it."""
    end = time.monotonic() + seconds
    while not (found := condition()):
        assert time.monotonic() < end, "it did not happen in time"
        time.sleep(0.005)
    return found


def children():
    """Process ids of this process's children, the ended ones that nobody reaped included."""
    found = set()
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            fields = (folder / "stat").read_text().rpartition(")")[2].split()
        except (FileNotFoundError, ProcessLookupError):
            continue
        if int(fields[1]) == os.getpid():
            found.add(folder.name)
    return found


def is_running(pid):
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except OSError:
        return False
    return state != "Z"


def shared_memory():
    return set(Path("/dev/shm").iterdir())  # noqa: S108


def open_files():
    """Count this process's open files."""
    return len(list(Path("/proc/self/fd").iterdir()))


@contextmanager
def nothing_left():
    """Check that no process and no shared memory outlives the block."""
    before = children(), shared_memory()
    yield
    assert children() <= before[0]
    assert shared_memory() <= before[1]


def events(worker):
    return measure(worker.session("asks"), 1).provenance.decisions


def begun(states):
    """Progress that tells when a job has begun to run."""
    return lambda: any("waiting" not in state.stage for state in list(states))
