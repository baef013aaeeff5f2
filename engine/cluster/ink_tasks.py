"""Realisations of dense pigment layers by the workers of a cluster, in place of processes of this machine."""

import json
from collections.abc import Callable, Iterator

from ..ink.crew import Task, archive
from .chunks import Chunk
from .crew import Crew
from .dispatch import Dispatcher, Job


def solve_with(crew: Crew) -> Callable[[dict, list[Task], int], Iterator]:
    """Return what does tasks as `ink.crew.run_tasks` does, by the workers of a crew, however many processes are asked for.

    Each task has the same bits whoever solves it. A worker that is told to leave a task ends it first.
    """

    def solve_tasks(order: dict, tasks: list[Task], _processes: int) -> Iterator:
        stated = json.dumps(order["content"]), json.dumps(order["plan"])

        def task_of(chunk: Chunk) -> dict:
            return {
                "method": "solve_ink",
                "arguments": (*stated, tuple(tasks[chunk.number])),
            }

        chunks = (Chunk(number, 0, 1) for number in range(len(tasks)))
        running = Dispatcher(crew).run(Job(lambda _: b"", 0, task_of), chunks)
        try:
            for answer in running:
                if answer is None:
                    yield None
                else:
                    chunk, arrays = answer
                    yield tasks[chunk.number], archive(arrays)
        finally:
            running.close()

    return solve_tasks
