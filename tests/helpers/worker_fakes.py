"""A session that computes nothing, for tests of the worker: the transport's name says how a job behaves."""

import os
import signal
import sys
import threading
import time

import numpy as np

from lumenray.engine.accuracy.history import History
from lumenray.engine.accuracy.stopping import Progress
from lumenray.engine.baking.order import BakeResult, Departure, Seams
from lumenray.engine.errors import BackendError, Cancelled, SceneError
from lumenray.engine.measurements import Measurement
from lumenray.engine.scene.provenance import Provenance
from lumenray.engine.views import Commit, Frame, Picture

STEP = 0.005
"""Duration of a step of a job. [s]"""

BUSY = 5.0
"""Time for which the job "busy" keeps the interpreter to itself. [s]"""

EVENTS = []
"""What happened in this process, in order, over all sessions."""


class Rubbish:
    """Garbage that only a collection finds; it tells which thread has freed it."""

    def __init__(self):
        self.itself = self

    def __del__(self):
        EVENTS.append(f"freed by {threading.current_thread().name}")


class FakeSession:
    """Keeps what it is sent. Every job takes as many steps as its rule has samples."""

    def __init__(self, interrupt):
        self._interrupt = interrupt
        self._cancel = self._stop = False
        self._view = None
        self._shown = 0
        self.items = {}
        self.revision = 0
        EVENTS.append("session")

    def apply(self, delta):
        if "refuse" in delta.removed:
            raise SceneError("the delta was refused")
        if "rubbish" in delta.removed:
            Rubbish()
        self.items |= {item.id: item for item in delta.changed}
        self.revision += 1
        EVENTS.append(f"apply {self.revision}")

    def cancel(self):
        self._cancel = True

    def stop(self):
        self._stop = True

    def render(self, camera, settings, progress=None):
        small = np.full((camera.height, camera.width), self.revision, np.float32)
        preview = lambda: np.stack([small] * 3, axis=-1)  # noqa: E731
        self._work("render", settings.rule.samples, settings.transport, progress, (preview,))
        colour = np.random.default_rng(settings.seed).random((*small.shape, 3), np.float32)
        return Picture(colour, small, 0.1, small, colour, small, small, _provenance(settings.seed))

    def measure(self, positions, normals, rule, seed=0, transport="auto", progress=None, **more):
        self._work("measure", rule.samples, transport, progress)
        return Measurement(positions.sum(axis=1), normals.sum(axis=1), _provenance(seed))

    def measure_sensors(self, key, rule, seed=0, transport="auto", progress=None, method="auto"):
        item = self.items[key]
        return self.measure(item.positions, item.normals, rule, seed, transport, progress)

    def bake_objects(self, order, progress=None):
        self._work("bake", order.rule.samples, order.transport, progress)
        events = Departure("x", ", ".join(EVENTS), "")
        seams = Seams(0, 0.0, 0.0, 0.0)
        return BakeResult((), (), (events,), order.objects, History(), 0.0, 0.0, 0.0, 1.0, seams)

    def watch(self, camera, settings, display):
        EVENTS.append(f"watch {settings.seed}")
        self._view = (camera, settings, display)
        self._shown = 0

    def unwatch(self):
        EVENTS.append("unwatch")
        self._view = None

    @property
    def has_view_work(self):
        return self._view is not None and self._shown < self._view[1].samples

    def refine(self):
        camera, settings, _ = self._view
        time.sleep(STEP)
        _misbehave(settings.transport)
        self._interrupt()
        self._shown += 1
        EVENTS.append("slice")
        pixels = np.full((camera.height, camera.width, 4), self._shown, np.float32)
        final = self._shown == settings.samples
        return Frame(
            pixels,
            False,
            False,
            0.0,
            1.0,
            "cd/m2",
            self.revision,
            self._shown,
            0.1,
            final,
            Commit(),
        )

    def _work(self, name, steps, transport, progress, more=()):
        self._cancel = False
        EVENTS.append(f"begin {name}")
        for step in range(steps):
            _misbehave(transport)
            if transport != "deaf":
                self._interrupt()
                if self._cancel:
                    raise Cancelled("cancelled")
            if self._stop:
                self._stop = False
                EVENTS.append(f"stop {name}")
                return
            time.sleep(STEP)
            if progress is not None and (transport != "deaf" or step == 0):
                progress(Progress((step + 1) / steps, step, 0.1, 0.0, None, name), *more)
        EVENTS.append(f"end {name}")


def _provenance(seed):
    return Provenance("0", "fake", "", seed, 1, 0.0, tuple(EVENTS))


def _misbehave(kind):
    match kind:
        case "fault":
            raise ValueError("something is odd")
        case "memory":
            raise MemoryError
        case "native memory":
            raise RuntimeError("std::bad_alloc")
        case "unloadable":
            raise BackendError("Mitsuba cannot be loaded: a library is missing; reinstall")
        case "abort":
            os.write(2, b"terminate called after throwing an instance of 'std::bad_alloc'\n")
            os.abort()
        case "segment":
            os.kill(os.getpid(), signal.SIGSEGV)
        case "exit":
            os._exit(7)
        case "busy":
            # As native code that lets no other thread run.
            sys.setswitchinterval(1000.0)
            end = time.monotonic() + BUSY
            while time.monotonic() < end:
                pass
            sys.setswitchinterval(0.005)
        case "noise":
            sys.stdout.write("noise\n" * 100)
            os.write(1, b"native noise\n" * 100)
