"""Jobs in the background: what they leave behind, whatever ends them."""

import threading
import types

import pytest

from lumenray.blender_addon.foundation.background_work import BackgroundJob
from lumenray.engine.errors import Cancelled, SceneError


class Manager:
    """Blender's window manager, as far as work uses it."""

    def __init__(self):
        self.timers, self.bars = [], 0

    def event_timer_add(self, interval, window):
        self.timers.append(interval)
        return interval

    def event_timer_remove(self, timer):
        self.timers.remove(timer)

    def progress_begin(self, low, high):
        self.bars += 1

    def progress_end(self):
        self.bars -= 1


class Job:
    """Works until it is cancelled, or raises at once."""

    def __init__(self, error=None):
        self._error, self._is_over = error, threading.Event()

    def run(self, session, progress):
        if self._error is not None:
            raise self._error
        assert self._is_over.wait(60.0)
        raise Cancelled("cancelled")

    def cancel(self):
        self._is_over.set()


def begin(job, running):
    closed = []
    session = types.SimpleNamespace(close=lambda: closed.append(True))
    return BackgroundJob(job, session, running, "test", 0.1).start(), closed


def test_a_job_that_is_taken_away_is_cancelled_and_leaves_nothing():
    manager, running = Manager(), []
    work, closed = begin(Job(), running)
    work.wake(manager, None)
    assert running == [work]
    assert work.is_alive
    assert (manager.timers, manager.bars) == ([0.1], 1)
    assert work.leave(manager)
    assert not work.is_alive
    assert isinstance(work.error, Cancelled)
    assert (running, closed, manager.timers, manager.bars) == ([], [True], [], 0)
    assert not work.leave(manager)


@pytest.mark.parametrize("error", [SceneError("no floor"), ZeroDivisionError("ours")])
def test_a_job_that_fails_keeps_why_and_closes_its_session(error):
    running = []
    work, closed = begin(Job(error), running)
    assert work.leave(Manager())
    assert work.error is error
    assert (running, closed) == ([], [True])
