"""The queue: jobs as the database has them. Each is claimed, ended and counted once, whatever ends the service meanwhile."""

import json
import sqlite3
import time
from dataclasses import dataclass

from .accounts import User, new_id
from .database import Database
from .folders import Folders, remove
from .orders import check_order
from .refusals import RefusalError, bad, conflict, missing

QUEUED, RUNNING, DONE, FAILED, CANCELLED = "queued", "running", "done", "failed", "cancelled"
"""States of a job."""

ENDED = (DONE, FAILED, CANCELLED)

OPEN = "open"
"""Kind of the job that opens what was uploaded; users do not order it."""

MOST_ATTEMPTS = 5
"""A job that the service has not survived so often is given up: it may be what ends the service."""

LONGEST_REQUEST = 200
"""Of the name that a user gives a request. [character]"""

MOST_LISTED = 500
"""Jobs in one answer."""


@dataclass(frozen=True)
class Job:
    """Something that a user has ordered.

    Parameters
    ----------
    number : int    In the order of orders.
    id, user, scene, kind : str
    options, edits : dict    As they were when it was ordered.
    state, note : str    The note says why it failed, or what has to be known beside the results.
    attempts : int    How often it was begun.
    code : int or None    Exit code of the command: 0, or 3 and 4 where results are not all that was asked for.
    bytes : int    Of the results.
    created, started, ended : float or None    [s]
    """

    number: int
    id: str
    user: str
    scene: str
    kind: str
    options: dict
    edits: dict
    state: str
    note: str
    attempts: int
    code: int | None
    bytes: int
    created: float
    started: float | None
    ended: float | None


def submit(database: Database, user: User, scene, kind, options, request: str | None = None) -> Job:
    """Order a job.

    Parameters
    ----------
    scene : scenes.Scene    Of this user, and ready; it is computed with the edits that it has now.
    kind, options
        Data of JSON.
    request : str or None    The user's own name of this request: said again, it gives the job that it has given before.

    Raises
    ------
    RefusalError    The order is not understood, or the user has too many jobs or too little room left.
    """
    if request is not None and not (0 < len(request) <= LONGEST_REQUEST and request.isprintable()):
        raise bad(f"Idempotency-Key: expected 1 to {LONGEST_REQUEST} printable characters")
    options = check_order(kind, options)
    with database.change() as connection:
        if request is not None:
            # Asked for within the change: of two equal requests at once, one finds the other's job.
            same = "select * from jobs where user = ? and request = ?"
            row = connection.execute(same, (user.id, request)).fetchone()
            if row is not None:
                return _same(_job(row), scene.id, kind, options)
        _check_quota(connection, user)
        key = new_id()
        try:
            insert_job(connection, key, user, scene.id, kind, options, scene.edits, request)
        except sqlite3.IntegrityError:
            raise missing("scene") from None
    return find_job(database, user, key)


def insert_job(connection, key, user: User, scene, kind, options, edits, request) -> None:
    """Write a new job down."""
    connection.execute(
        "insert into jobs (id, user, scene, kind, options, edits, request, state, created) "
        "values (?, ?, ?, ?, ?, ?, ?, ?, ?)",
        (
            key,
            user.id,
            scene,
            kind,
            json.dumps(options),
            json.dumps(edits),
            request,
            QUEUED,
            time.time(),
        ),
    )


def disk_of(database: Database, user: User) -> int:
    """What a user's scenes, results and edits, which every job keeps with it, take. [byte]"""
    return _disk(database.row, user)


def _disk(ask, user: User) -> int:
    question = (
        "select coalesce((select sum(bytes) from scenes where user = ?1), 0) + "
        "coalesce((select sum(bytes + length(edits) - 2) from jobs where user = ?1), 0)"
    )
    return ask(question, user.id)[0]


def _check_quota(connection, user: User) -> None:
    waiting = "select count(*) from jobs where user = ? and state in (?, ?)"
    (count,) = connection.execute(waiting, (user.id, QUEUED, RUNNING)).fetchone()
    if count >= user.quota.jobs:
        raise RefusalError(
            429, f"{count} of your jobs wait or run, which is all you may have; wait for one to end"
        )
    used = _disk(lambda sql, *values: connection.execute(sql, values).fetchone(), user)
    if used >= user.quota.disk:
        raise RefusalError(
            413, f"your scenes and results take all of your {user.quota.disk} bytes; remove some"
        )


def _same(job: Job, scene: str, kind: str, options: dict) -> Job:
    if (job.scene, job.kind, job.options) != (scene, kind, options):
        raise conflict("Idempotency-Key: the same name was given to another order")
    return job


def jobs_of(database: Database, user: User, before: int | None = None) -> list[Job]:
    """Return a user's newest jobs, newest first; those before a number."""
    question = "select * from jobs where user = ? and kind != ? and number < ? order by number desc limit ?"
    limit = (1 << 62) if before is None else before
    return [_job(row) for row in database.rows(question, user.id, OPEN, limit, MOST_LISTED)]


def find_job(database: Database, user: User, key: str) -> Job:
    """Return a job of a user; refuse what is not this user's."""
    row = database.row("select * from jobs where id = ? and user = ?", key, user.id)
    if row is None:
        raise missing("job")
    return _job(row)


def cancel(database: Database, user: User, key: str) -> Job:
    """End a job that waits; one that runs is ended by who runs it. Nothing happens to what has ended."""
    with database.change() as connection:
        connection.execute(
            "update jobs set state = ?, note = 'cancelled', ended = ? where id = ? and user = ? and state = ?",
            (CANCELLED, time.time(), key, user.id, QUEUED),
        )
    return find_job(database, user, key)


def remove_job(database: Database, folders: Folders, user: User, key: str) -> None:
    """Remove an ended job with its results."""
    if find_job(database, user, key).state not in ENDED:
        raise conflict("the job has not ended; cancel it first")
    with database.change() as connection:
        connection.execute("delete from jobs where id = ?", (key,))
    remove(folders.results(user.id, key))


def claim(database: Database) -> Job | None:
    """Take the next job to run: of the user who has fewest running the oldest; opened scenes first, people wait for them."""
    with database.change() as connection:
        row = connection.execute(
            "select id from jobs as waiting where state = ? order by kind != ?, "
            "(select count(*) from jobs as other where other.user = waiting.user and other.state = ?), number limit 1",
            (QUEUED, OPEN, RUNNING),
        ).fetchone()
        if row is None:
            return None
        connection.execute(
            "update jobs set state = ?, attempts = attempts + 1, started = ? where id = ?",
            (RUNNING, time.time(), row["id"]),
        )
        found = connection.execute("select * from jobs where id = ?", (row["id"],)).fetchone()
    return _job(found)


def end(
    database: Database, job: Job, state: str, note: str, code: int | None = None, size: int = 0
) -> bool:
    """Write down how a running job ended; False if it was ended before. [byte]"""
    with database.change() as connection:
        return write_end(connection, job, state, note, code, size)


def recover(database: Database) -> tuple[list[Job], list[Job]]:
    """Return jobs that ran when the service ended, and of these such as were begun too often; nothing is changed.

    Who starts the service puts the first back with `requeue` once it has seen that no results of theirs are there.
    """
    ran = [
        _job(row)
        for row in database.rows("select * from jobs where state = ? order by number", RUNNING)
    ]
    return [job for job in ran if job.attempts < MOST_ATTEMPTS], [
        job for job in ran if job.attempts >= MOST_ATTEMPTS
    ]


def requeue(database: Database, job: Job) -> None:
    """Let a job that ran wait again, in its old place."""
    with database.change() as connection:
        connection.execute(
            "update jobs set state = ?, started = null where id = ? and state = ?",
            (QUEUED, job.id, RUNNING),
        )


def write_end(
    connection, job: Job, state: str, note: str, code: int | None = None, size: int = 0
) -> bool:
    """Write down how a running job ended, within a change; False if it was ended before. [byte]"""
    done = connection.execute(
        "update jobs set state = ?, note = ?, code = ?, bytes = ?, ended = ? where id = ? and state = ?",
        (state, note, code, size, time.time(), job.id, RUNNING),
    )
    return done.rowcount == 1


def _job(row) -> Job:
    return Job(
        row["number"],
        row["id"],
        row["user"],
        row["scene"],
        row["kind"],
        json.loads(row["options"]),
        json.loads(row["edits"]),
        row["state"],
        row["note"],
        row["attempts"],
        row["code"],
        row["bytes"],
        row["created"],
        row["started"],
        row["ended"],
    )
