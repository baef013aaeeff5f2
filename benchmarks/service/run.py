"""Measures a service under load, and writes the document."""

import hashlib
import random
import threading
import time
from pathlib import Path

import numpy as np

from ...engine.reading.whole_file import write_whole
from ...libraries import scenes
from ..common.bars import Bar
from ..common.document import make_table, tell_demands
from ..common.machine import describe_machine
from ..common.output import write_numbers
from .client import Client, make_server

USERS, JOBS, KILLS = 20, 500, 10
"""Users at once, jobs in all, and how often the service is killed."""

SLOWEST = 0.2
"""95 % of the reads are answered sooner. [s]"""

AT_ONCE = 2
"""Jobs that run together."""

THINKING = 0.5
"""Between two requests of one user, on average. [s]"""

SEED = 7

ENDED = {"done", "failed", "cancelled"}

TEXT = """# The service under load

*Made by `lumenray benchmark service`; do not edit by hand.*

{users} users on this machine ask for scenes, jobs and progress, hide objects and order jobs (lux maps of a small scene at
few samples: the command `lumenray bake` in a confined process each), {at_once} of which run at once. The service is killed
(`SIGKILL`) {kills} times at random moments and started again; users say again what was not answered, under the same
`Idempotency-Key`. *Lost*: orders that were answered and have no job, or whose job has not ended with its results. *Doubled*:
orders with more than one job, or results that have changed after they were there. *Reads*: from asking to the whole answer,
while jobs run; waiting for a service that has just been killed is left out. {cpu}, {cores} cores.

"""


def run(users: int = USERS, count: int = JOBS, kills: int = KILLS, say=None) -> dict:
    """Measure.

    Parameters
    ----------
    users, count, kills : int    Users, jobs in all, and ends of the service.
    say : callable or None    Told of progress in words.

    Returns
    -------
    dict    Plain data for JSON: ``p95_ms``, ``jobs``, ``lost``, ``doubled`` and more.
    """
    say = say or (lambda _line: None)
    with make_server(AT_ONCE) as (server, folder):
        clients = [Client(server, server.add_user(f"user {i}")) for i in range(users)]
        server.start()
        say(f"{users} users upload a scene each")
        content = scenes.scene_path("closed_box").read_bytes()
        rooms = [each.send("POST", "/scenes?name=Room", content)["id"] for each in clients]
        for client, room in zip(clients, rooms, strict=True):
            while client.get(f"/scenes/{room}")["state"] == "opening":
                time.sleep(0.2)
        for client in clients:
            client.times.clear()
        ordered = [{} for _ in clients]
        is_over = threading.Event()
        threads = [
            threading.Thread(
                target=_use,
                args=(i, client, rooms[i], ordered[i], _share(count, users, i), is_over),
            )
            for i, client in enumerate(clients)
        ]
        begin = time.perf_counter()
        for thread in threads:
            thread.start()
        seen: dict[Path, str] = {}
        changed = 0
        for number in range(kills):
            # Spread over the queue, so that there is always something to lose.
            _wait_for(folder, (number + 0.5) * count / (kills + 1))
            server.kill()
            changed += look_at_results(folder, seen)
            server.start()
            say(f"killed {number + 1} times, {len(seen)} jobs have results")
        while not all(
            map(_have_ended, clients, ordered, [_share(count, users, i) for i in range(users)])
        ):
            time.sleep(1.0)
        seconds = time.perf_counter() - begin
        is_over.set()
        for thread in threads:
            thread.join()
        changed += look_at_results(folder, seen)
        found = [_list_jobs(client) for client in clients]
        server.stop()
    times = np.array([each for client in clients for each in client.times])
    lost, doubled = count_faults(ordered, found, seen)
    return {
        "machine": describe_machine(),
        "users": users,
        "kills": kills,
        "jobs": count,
        "lost": lost,
        "doubled": doubled + changed,
        "begun_anew": sum(job["attempts"] > 1 for jobs in found for job in jobs.values()),
        "seconds": seconds,
        "reads": len(times),
        "p50_ms": 1e3 * float(np.quantile(times, 0.5)),
        "p95_ms": 1e3 * float(np.quantile(times, 0.95)),
        "p99_ms": 1e3 * float(np.quantile(times, 0.99)),
    }


def _share(count: int, users: int, number: int) -> int:
    """Jobs of one user."""
    return count // users + (number < count % users)


def _use(number: int, client: Client, room: str, ordered: dict, count: int, is_over) -> None:
    """What one user does: orders now and then, and looks and edits until all is over."""
    chance = random.Random(SEED + number)  # noqa: S311 - for a load, not for a secret
    while not is_over.is_set():
        if len(ordered) < count:
            name = f"order {len(ordered)}"
            options = {"samples": 4, "seed": len(ordered), "lumels_per_m": 0.5}
            order = {"kind": "bake", "options": options}
            job = client.send("POST", f"/scenes/{room}/jobs", order, name)
            ordered[name] = job["id"]
        for path in ("/me", "/scenes", f"/scenes/{room}", "/jobs"):
            client.get(path)
        if ordered:
            client.get(f"/jobs/{chance.choice(list(ordered.values()))}")
        if chance.random() < 0.3:
            surfaces = client.get(f"/scenes/{room}")["content"]["surfaces"]
            client.send("PUT", f"/scenes/{room}/edits", {"hidden": [chance.choice(surfaces)]})
        is_over.wait(2.0 * THINKING * chance.random())


def _results(folder: Path) -> list[Path]:
    return [path for path in folder.glob("users/*/jobs/*") if not path.name.startswith(".")]


def _wait_for(folder: Path, count: float) -> None:
    """Wait until so many jobs have results."""
    while len(_results(folder)) < count:
        time.sleep(0.1)


def look_at_results(folder: Path, seen: dict[Path, str]) -> int:
    """Note what results there are; returns how many have changed since they were noted."""
    changed = 0
    for path in _results(folder):
        digest = hashlib.sha256()
        for each in sorted(path.rglob("*")):
            if each.is_file():
                digest.update(each.name.encode() + each.read_bytes())
        told = digest.hexdigest()
        changed += seen.setdefault(path, told) != told
    return changed


def _list_jobs(client: Client) -> dict[str, dict]:
    """All jobs of a user, by their ids."""
    found: dict[str, dict] = {}
    path = "/jobs"
    while rows := client.get(path)["jobs"]:
        found |= {row["id"]: row for row in rows}
        path = f"/jobs?before={rows[-1]['number']}"
    return found


def _have_ended(client: Client, ordered: dict, count: int) -> bool:
    if len(ordered) < count:
        return False
    return all(job["state"] in ENDED for job in _list_jobs(client).values())


def count_faults(ordered, found, seen) -> tuple[int, int]:
    """Orders without a job that is done with its results, and jobs or results that nobody ordered."""
    with_results = {path.name for path in seen}
    lost = doubled = 0
    for orders, jobs in zip(ordered, found, strict=True):
        done = {key for key, job in jobs.items() if job["state"] == "done" and key in with_results}
        lost += len(set(orders.values()) - done)
        doubled += len(set(jobs) - set(orders.values()))
        doubled += len(orders) - len(set(orders.values()))
    known = {key for jobs in found for key in jobs}
    return lost, doubled + len(with_results - known)


def check_bars(result: dict) -> list[Bar]:
    """Judge by the demands."""
    return [
        Bar(
            "95 % of reads, while jobs run",
            f"{1e3 * SLOWEST:g} ms",
            f"{result['p95_ms']:.0f} ms",
            result["p95_ms"] <= 1e3 * SLOWEST,
        ),
        Bar("jobs that were lost", "none", str(result["lost"]), result["lost"] == 0),
        Bar("jobs with two results", "none", str(result["doubled"]), result["doubled"] == 0),
    ]


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the numbers, if ``path`` is named, and the document into a folder."""
    write_numbers(result, path)
    with write_whole(folder / "service.md", "utf-8") as file:
        file.write(_describe(result))


def _describe(result: dict) -> str:
    machine = result["machine"]
    text = TEXT.format(
        users=result["users"],
        kills=result["kills"],
        at_once=AT_ONCE,
        cpu=machine["cpu"],
        cores=machine["cores"],
    )
    rows = [
        f"| users | {result['users']} |",
        f"| jobs | {result['jobs']} |",
        f"| ends of the service | {result['kills']} |",
        f"| jobs that were begun anew | {result['begun_anew']} |",
        f"| reads | {result['reads']} |",
        f"| half of the reads within | {result['p50_ms']:.1f} ms |",
        f"| 95 % within | {result['p95_ms']:.1f} ms |",
        f"| 99 % within | {result['p99_ms']:.1f} ms |",
        f"| all jobs in | {result['seconds']:.0f} s |",
    ]
    return (
        text
        + tell_demands(check_bars(result))
        + "\n## Figures\n\n"
        + make_table("| figure | value |", rows)
    )
