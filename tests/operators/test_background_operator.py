"""The frame of operators whose job runs in the background: what they answer Blender, and what they say."""

from types import SimpleNamespace

import pytest

from lumenray.engine.errors import Cancelled, SceneError
from lumenray.operators.background_operator import BackgroundOperator

TIMER, ESCAPE = SimpleNamespace(type="TIMER", value=""), SimpleNamespace(type="ESC", value="PRESS")


class Running:
    """A job under way."""

    def __init__(self, error=None):
        self.error, self.is_alive, self.shown, self.ended = error, True, 0, 0

    def show(self, context):
        self.shown += 1

    def end(self, context):
        self.ended += 1


class Operator(BackgroundOperator):
    what = "Counting"

    def __init__(self, error=None):
        self.told, self.is_cancelled = [], False
        self._job = SimpleNamespace(cancel=lambda: setattr(self, "is_cancelled", True))
        self._running = Running(error)

    def report(self, kind, text):
        self.told.append((*kind, text))

    def _finish(self, context):
        return {"FINISHED"}


def test_the_window_stays_alive_until_the_job_has_ended():
    operator = Operator()
    assert operator.modal(None, SimpleNamespace(type="MOUSEMOVE", value="")) == {"PASS_THROUGH"}
    assert operator.modal(None, TIMER) == {"PASS_THROUGH"}
    assert (operator._running.shown, operator._running.ended) == (1, 0)
    operator._running.is_alive = False
    assert operator.modal(None, TIMER) == {"FINISHED"}
    assert operator._running.ended == 1 and not operator.told


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (Cancelled("cancelled"), ("WARNING", "Counting cancelled")),
        (SceneError("nothing to count"), ("ERROR", "nothing to count")),
    ],
)
def test_what_goes_wrong_is_told(error, told):
    operator = Operator(error)
    operator.modal(None, ESCAPE)
    assert operator.is_cancelled
    operator._running.is_alive = False
    assert operator.modal(None, TIMER) == {"CANCELLED"}
    assert operator.told == [told]
    assert operator._running.ended == 1


def test_a_file_that_is_loaded_ends_the_job():
    operator = Operator()
    operator.cancel(None)
    assert operator._running.ended == 1
