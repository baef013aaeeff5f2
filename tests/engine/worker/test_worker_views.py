"""Live views of a worker: what is shown, when, and what of it reaches the caller."""

import time

import pytest
from workers import begun, events, live, measure, open_files, room, wait_for, watch

from lumenray.engine.errors import Cancelled
from lumenray.engine.scene.scene import SceneDelta


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
    job = jobs.submit(measure, session, 100_000, progress=states.append)
    wait_for(begun(states))
    for number in range(100):
        watch(session, live(5, seed=number))
    session.cancel()
    with pytest.raises(Cancelled):
        job.result(60)
    wait_for(lambda: not session.has_view_work)
    story = events(worker)
    assert [event for event in story if event.startswith("watch")] == ["watch 99"]


def test_a_live_view_takes_half_the_time_of_a_job_at_most(worker, jobs):
    states, view_session = [], worker.session("view")
    watch(view_session, live(100_000))
    wait_for(view_session.frame)
    job = jobs.submit(measure, worker.session("a"), 150, progress=states.append)
    wait_for(begun(states))
    wait_for(view_session.frame)
    job.result(60)
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
