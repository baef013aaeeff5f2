"""Work is dealt out so that no process packs particles that another one has packed, as long as there is other work."""

from lumenray.engine.ink.crew import Waiting


def deal(tasks, processes):
    """Let processes take tasks in turns; what each did."""
    waiting, done = Waiting(tasks), [[] for _ in range(processes)]
    for _ in tasks:
        for own in done:
            task = waiting.take(own[-1] if own else None)
            if task is not None:
                own.append(task)
    return done


def test_a_process_stays_with_the_particles_that_it_has_packed():
    tasks = [(k, band, False) for k in range(4) for band in range(3)]
    first, second = deal(tasks, 2)
    assert sorted(first + second) == tasks
    assert {k for k, *_ in first}.isdisjoint(k for k, *_ in second)
    assert len(first) == len(second)


def test_the_last_realisation_is_shared():
    tasks = [(k, band, False) for k in range(3) for band in range(4)]
    first, second = deal(tasks, 2)
    assert sorted(first + second) == tasks
    assert len(first) == len(second) == 6


def test_more_processes_than_realisations_all_have_work():
    tasks = [(0, band, False) for band in range(6)] + [(0, 1, True)]
    done = deal(tasks, 3)
    assert sorted(task for own in done for task in own) == sorted(tasks)
    assert all(len(own) >= 2 for own in done)
