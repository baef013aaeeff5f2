"""Chunks handed out to workers that die, stall, slow down and fail: the same answers in the same order, each once."""

import random

import pytest
from cluster_fakes import FakeCrew

from lumenray.engine.cluster import dispatch
from lumenray.engine.cluster.chunks import Chunk
from lumenray.engine.cluster.dispatch import Dispatcher, Job
from lumenray.engine.errors import EngineFault, EngineLost, SceneError

CHUNKS = [Chunk(number, 100 + number, 10) for number in range(12)]

DONE = [chunk.seed**2 for chunk in CHUNKS]


def answer(worker, scene, order):
    """What a worker without faults says; nothing is left to do where it was recalled."""
    if order is None:
        return {"state": "left"}
    return {"state": "done", "value": order["seed"] ** 2, "make": worker}


def scene_of(known):
    return b"" if known == 1 else b"scene"


JOB = Job(scene_of, 1, lambda chunk: {"seed": chunk.seed})


def run(crew, chunks=CHUNKS, host=None):
    host = host or Dispatcher(crew, crew.clock)
    return [made[1] for made in host.run(JOB, iter(chunks)) if made is not None]


def test_all_chunks_come_in_order():
    crew = FakeCrew(["a", "b", "c"], answer)
    assert run(crew) == DONE
    assert len(crew.sent) == len(CHUNKS)


def test_a_scene_is_sent_once_to_each_worker():
    crew = FakeCrew(["a", "b"], answer)
    host = Dispatcher(crew, crew.clock)
    run(crew, host=host)
    run(crew, host=host)
    assert sorted(worker for worker, has_scene, _ in crew.sent if has_scene) == ["a", "b"]


def test_what_a_dead_worker_was_at_is_done_by_others():
    crew = FakeCrew(["a", "b"], answer)
    crew.at(1.5, lambda: crew.kill("a"))
    assert run(crew) == DONE


def test_a_worker_that_joins_gets_work():
    crew = FakeCrew(["a"], answer)
    crew.at(2.5, lambda: crew.names.append("b"))
    assert run(crew) == DONE
    assert {worker for worker, *_ in crew.sent} == {"a", "b"}


def test_a_silent_worker_is_given_up():
    crew = FakeCrew(["a", "b"], answer)
    crew.at(0.1, lambda: crew.stop("a"))
    assert run(crew) == DONE
    assert crew.now < dispatch.SILENCE + 20.0


def test_a_stopped_worker_that_comes_back_counts_once():
    crew = FakeCrew(["a", "b"], answer, paces={"a": 40.0})
    crew.at(0.3, lambda: crew.stopped_since.update(a=0.0))
    crew.at(30.0, lambda: crew.stopped_since.pop("a"))
    assert run(crew) == DONE


def test_who_takes_far_too_long_is_overtaken():
    crew = FakeCrew(["a", "b"], answer, seconds=10.0, paces={"a": 1000.0})
    assert run(crew) == DONE
    assert crew.now < 1000.0
    # It is told to leave what others have done.
    assert crew.recalled


def test_a_worker_without_what_it_needs_is_left_out():
    def fails(worker, scene, order):
        if worker == "a" and order is not None:
            return {"state": "failed", "text": "no LLVM"}
        return answer(worker, scene, order)

    crew = FakeCrew(["a", "b"], fails)
    assert run(crew) == DONE
    assert sum(worker == "a" for worker, *_ in crew.sent) == dispatch.MOST_OF_ONE


def test_workers_that_are_unlike_are_known():
    crew = FakeCrew(["a", "b"], answer)
    host = Dispatcher(crew, crew.clock)
    run(crew, host=host)
    assert host.makes == {"a", "b"}


def test_a_chunk_that_nobody_can_do_ends_the_job():
    crew = FakeCrew(["a", "b", "c"], lambda *_: {"state": "failed", "text": "memory is short"})
    with pytest.raises(EngineFault, match=r"chunk \d of the job failed 4 times.*memory is short"):
        run(crew)


def test_what_is_wrong_with_the_scene_is_said_at_once():
    fault = ["SceneError", "the lamp has a negative flux", {}]
    crew = FakeCrew(["a", "b"], lambda *_: {"state": "refused", "fault": fault})
    with pytest.raises(SceneError, match="negative flux"):
        run(crew)
    assert not crew.under_way


def test_a_worker_that_lost_the_scene_gets_it_again():
    held = set()

    def forgets(worker, scene, order):
        if scene:
            held.add(worker)
        if len(crew.sent) == 5:
            held.discard(worker)
        return answer(worker, scene, order) if worker in held else {"state": "lacks"}

    crew = FakeCrew(["a"], forgets)
    assert run(crew) == DONE
    assert sum(has_scene for _, has_scene, _ in crew.sent) == 2


def test_without_workers_somebody_is_told():
    crew = FakeCrew([], answer)
    with pytest.raises(EngineLost, match="no worker"):
        run(crew)
    assert crew.now >= dispatch.ALONE


def test_ending_early_recalls_what_is_under_way():
    crew = FakeCrew(["a", "b"], answer)
    running = Dispatcher(crew, crew.clock).run(JOB, iter(CHUNKS))
    while next(running) is None:
        pass
    running.close()
    assert not crew.under_way


@pytest.mark.parametrize("seed", range(30))
def test_whatever_happens_the_answers_are_the_same(seed):
    draw = random.Random(seed)  # noqa: S311
    crew = FakeCrew(["a", "b", "c"], answer)
    spare = iter("defghijk")

    def kill():
        if crew.names:
            crew.kill(draw.choice(crew.names))
        crew.names.append(next(spare))

    def stop():
        crew.stop(draw.choice(crew.names))

    def slow():
        crew.paces[draw.choice(crew.names)] = draw.uniform(2.0, 60.0)

    for _ in range(6):
        crew.at(draw.uniform(0.0, 8.0), draw.choice([kill, kill, stop, slow]))
    assert run(crew) == DONE
