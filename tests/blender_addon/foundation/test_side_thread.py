"""Work beside Blender: in order, with its faults told, and begun without letting go of the interpreter."""

import sys
import threading

import pytest

from lumenray.blender_addon.foundation.side_thread import SideThread


@pytest.fixture
def side():
    made = SideThread("test")
    yield made
    made.shutdown()


def test_work_is_done_in_order_on_one_thread(side):
    done = []
    names = [
        side.submit(lambda k=k: done.append(k) or threading.current_thread().name)
        for k in range(20)
    ]
    assert {each.result(10.0) for each in names} == {"test"}
    assert done == list(range(20))


def test_a_fault_is_told_to_whoever_asks_and_work_goes_on(side):
    fault = side.submit(lambda: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        fault.result(10.0)
    assert side.submit(max, 2, 3).result(10.0) == 3


def test_it_is_begun_without_letting_go_of_the_interpreter():
    """As panels are drawn: with the interpreter kept for long nothing else runs until whoever draws lets go."""
    interval = sys.getswitchinterval()
    has_run = []
    sys.setswitchinterval(60.0)
    try:
        side = SideThread("test")
        future = side.submit(has_run.append, True)
        before = list(has_run)
    finally:
        sys.setswitchinterval(interval)
    future.result(10.0)
    side.shutdown()
    assert before == [] and has_run == [True]


def test_what_has_not_begun_is_cancelled_at_the_end():
    side, go_on, begun = SideThread("test"), threading.Event(), threading.Event()
    first = side.submit(lambda: begun.set() or go_on.wait(10.0))
    second = side.submit(lambda: None)
    assert begun.wait(10.0)
    ender = threading.Thread(target=side.shutdown)
    ender.start()
    while not second.cancelled():
        pass
    go_on.set()
    ender.join(10.0)
    assert first.result(0.0) is True and second.cancelled() and not ender.is_alive()


def test_a_thread_that_never_began_ends_at_once():
    SideThread("test").shutdown()
