"""Runs the jobs of the queue, some at a time, and carries what they have made to where users find it.

Results are written beside, and put in their place by one renaming, after which the database says that the job is done.
Whoever starts the service again after a sudden end finds each job either with all of its results or with none, and begins
the latter anew.
"""

import json
import logging
import os
import shutil
import signal
import threading
from pathlib import Path

from ..engine import VERSION
from ..engine.errors import LumenrayError
from ..engine.reading.printable import printable
from . import jobs, scenes
from .accounts import User, user_of_id, users
from .changes import Changes
from .confinement import Limits
from .database import Database
from .folders import (
    UPLOADS,
    Folders,
    find_upload,
    list_files,
    make,
    remove,
    size,
    take_file,
    take_folder,
)
from .jobs import Job
from .orders import SCENE_FILE, command_of
from .processes import Confined, Outcome

LOGGER = logging.getLogger(__name__)

PROGRAM = "lumenray.command_line.main"
"""What every job runs: a command with its arguments."""

ACCOUNT = "job.json"
"""Of the results: what was ordered, and how it ended."""

CANCELLED = "cancelled"

LARGEST_CONTENT = 16 << 20
"""Of what is told of a scene. [byte]"""

WRITTEN = (0, 3, 4)
"""Exit codes of the command with which results are there, see `blender_addon.assumptions.CODES`."""

IDLE = 5.0
"""Between looks into the queue if nobody says that something is new. [s]"""

NO_MEMORY = ("Malloc returns null", "MemoryError")
"""What Blender and Python say, somewhere, when they get no memory."""

LONGEST_NOTE = 4000
"""[character]"""


class Supervisor:
    """Threads that each run one job at a time.

    Parameters
    ----------
    database : Database
    folders : Folders
    changes : Changes    Told of all news.
    count : int    Jobs that run at once.
    seconds : float    After which a job is ended. [s]
    program : str    Module that is run with the arguments of a command.
    """

    def __init__(
        self,
        database: Database,
        folders: Folders,
        changes: Changes,
        count: int,
        seconds: float,
        program: str = PROGRAM,
    ):
        self._database = database
        self._folders = folders
        self._changes = changes
        self._seconds = seconds
        self._program = program
        self._news = threading.Condition()
        self._is_ending = False
        self._lock = threading.Lock()
        self._running: dict[str, Confined] = {}
        self._cancelled: set[str] = set()
        self._progress: dict[str, dict] = {}
        self._threads = [
            threading.Thread(target=self._run_jobs, name=f"jobs {i}") for i in range(count)
        ]

    def start(self) -> None:
        """Set right what a sudden end has left, and begin."""
        self._recover()
        for thread in self._threads:
            thread.start()

    def close(self) -> None:
        """End all that runs; it is begun anew at the next start."""
        with self._news:
            self._is_ending = True
            self._news.notify_all()
        with self._lock:
            for process in self._running.values():
                process.stop("the service ends")
        for thread in self._threads:
            if thread.is_alive():
                thread.join()

    def look(self) -> None:
        """Say that there is something new in the queue."""
        with self._news:
            self._news.notify()

    def cancel(self, user: User, key: str) -> Job:
        """Cancel a job of a user, whether it waits or runs."""
        job = jobs.cancel(self._database, user, key)
        if job.state == jobs.RUNNING:
            with self._lock:
                self._cancelled.add(job.id)
                process = self._running.get(job.id)
            if process is not None:
                process.stop(CANCELLED)
        self._changes.tell(user.id)
        return job

    def progress(self, key: str) -> dict | None:
        """What a running job has said of its progress; None if nothing."""
        return self._progress.get(key)

    # ---- after a sudden end ----

    def _recover(self) -> None:
        again, given_up = jobs.recover(self._database)
        for job in [*again, *given_up]:
            results = self._folders.results(job.user, job.id)
            if results.is_dir():
                self._close_account(job, results)
            elif job in again:
                jobs.requeue(self._database, job)
            else:
                self._fail(
                    job, f"it was begun {job.attempts} times, and the service has ended each time"
                )
        for user in users(self._database):
            self._remove_strays(user)

    def _remove_strays(self, user: User) -> None:
        """Remove files that the database does not know of."""
        known = {
            "scenes": {each.id for each in scenes.scenes_of(self._database, user)},
            "jobs": {
                row["id"]
                for row in self._database.rows("select id from jobs where user = ?", user.id)
            },
            "work": set(),
        }
        for part, names in known.items():
            folder = self._folders.user(user.id) / part
            for path in folder.iterdir() if folder.is_dir() else ():
                # What was coming has a name of its own, too.
                if path.name not in names:
                    shutil.rmtree(path)
        for scene in scenes.scenes_of(self._database, user):
            if scene.state == scenes.READY:
                for name in UPLOADS.values():
                    (self._folders.scene(user.id, scene.id) / name).unlink(missing_ok=True)

    # ---- the threads ----

    def _run_jobs(self) -> None:
        while True:
            job = None if self._is_ending else jobs.claim(self._database)
            if job is not None:
                self._run(job)
                continue
            with self._news:
                if self._is_ending:
                    return
                self._news.wait(IDLE)

    def _run(self, job: Job) -> None:
        self._changes.tell(job.user)
        work = self._folders.work(job.user, job.id)
        try:
            user = user_of_id(self._database, job.user)
            make(work)
            if job.kind == jobs.OPEN:
                self._open(job, user, work)
            else:
                self._compute(job, user, work)
        except OSError as error:
            # Its own words name a path of this machine.
            self._fail(job, error.strerror or str(error))
        except (LumenrayError, ValueError) as error:
            self._fail(job, str(error))
        except Exception:
            # A fault of ours ends this job, and not those that wait behind it.
            LOGGER.exception("job %s (%s) has met a fault of the service", job.id, job.kind)
            self._fail(job, "a fault of the service; who keeps it finds it in its log")
        finally:
            with self._lock:
                self._cancelled.discard(job.id)
            self._progress.pop(job.id, None)
            remove(work)
            self._changes.tell(job.user)

    def _open(self, job: Job, user: User, work: Path) -> None:
        folder = self._folders.scene(user.id, job.scene)
        upload, scene, content = find_upload(folder), work / SCENE_FILE, work / "content.json"
        arguments = [
            "scene",
            "take",
            str(upload),
            f"--output={scene}",
            f"--content={content}",
        ]
        outcome = self._confine(job, user, work, arguments, [upload])
        if self._is_put_off(job, outcome):
            return
        note = _why_failed(outcome)
        if note:
            _log(job, outcome)
        if note or not content.is_file():
            scenes.end_opening(
                self._database, job, note or "nothing was found in it", None, size(folder)
            )
            return
        told = folder / "content.json"
        told.unlink(missing_ok=True)
        take_file(content, told, LARGEST_CONTENT)
        found = scenes.check_content(json.loads(told.read_text(encoding="utf-8")))
        told.unlink()
        (folder / SCENE_FILE).unlink(missing_ok=True)
        take_file(scene, folder / SCENE_FILE)
        scenes.end_opening(self._database, job, "", found, (folder / SCENE_FILE).stat().st_size)
        # Not before: what is opened again after a sudden end begins with it.
        upload.unlink()

    def _compute(self, job: Job, user: User, work: Path) -> None:
        folder = self._folders.scene(user.id, job.scene)
        scene, results = folder / SCENE_FILE, work / "results"
        results.mkdir()
        outcome = None
        if job.edits:
            edits, scene = work / "edits.json", work / SCENE_FILE
            edits.write_text(json.dumps(job.edits), encoding="utf-8")
            source = str(folder / SCENE_FILE)
            arguments = ["scene", "edit", source, f"--edits={edits}", f"--output={scene}"]
            outcome = self._confine(job, user, work, arguments, [folder])
        if outcome is None or not (outcome.code or outcome.reason):
            arguments = command_of(job.kind, job.options, scene, folder, results)
            outcome = self._confine(job, user, work, arguments, [folder])
        if self._is_put_off(job, outcome):
            return
        if outcome.reason or outcome.code not in WRITTEN:
            _log(job, outcome)
            state = jobs.CANCELLED if outcome.reason == CANCELLED else jobs.FAILED
            jobs.end(self._database, job, state, _why_failed(outcome), outcome.code)
            return
        account = {
            "lumenray": VERSION,
            "kind": job.kind,
            "options": job.options,
            "edits": job.edits,
            "code": outcome.code,
            "log": list(outcome.log),
        }
        place = self._folders.results(user.id, job.id)
        place.parent.mkdir(exist_ok=True)
        # Where no confined process can reach it; what a sudden end leaves of it is removed at the next start.
        coming = place.with_name(f".{job.id}")
        remove(coming)
        take_folder(results, coming)
        (coming / ACCOUNT).unlink(missing_ok=True)
        (coming / ACCOUNT).write_text(json.dumps(account, indent=1), encoding="utf-8")
        coming.rename(place)
        self._close_account(job, place)

    def _close_account(self, job: Job, results: Path) -> None:
        """Say that a job is done, as its results tell it."""
        account = json.loads((results / ACCOUNT).read_text(encoding="utf-8"))
        note = _notes(account["log"]) if account["code"] else ""
        total = sum(length for _, length in list_files(results))
        jobs.end(self._database, job, jobs.DONE, note, account["code"], total)

    def _fail(self, job: Job, note: str) -> None:
        if job.kind == jobs.OPEN:
            scenes.end_opening(self._database, job, note, None, 0)
        else:
            jobs.end(self._database, job, jobs.FAILED, note)

    def _is_put_off(self, job: Job, outcome: Outcome) -> bool:
        """Whether the job ended only because the service does; it stays in the queue then."""
        if not self._is_ending or outcome.reason == CANCELLED or outcome.code == 0:
            return False
        jobs.requeue(self._database, job)
        return True

    def _confine(self, job: Job, user: User, work: Path, arguments, readable) -> Outcome:
        room = max(user.quota.disk - jobs.disk_of(self._database, user), 0)
        cores = os.cpu_count() or 1
        limits = Limits(user.quota.memory, max(room, 1), int(self._seconds * cores) + 60)
        remove(work / "tmp")
        process = Confined(
            self._program,
            arguments,
            work,
            self._folders.cache(user.id),
            readable,
            limits,
            room,
            self._seconds,
        )
        with self._lock:
            self._running[job.id] = process
            if job.id in self._cancelled:
                process.stop(CANCELLED)
            elif self._is_ending:
                process.stop("the service ends")
        try:
            return process.wait(lambda told: self._note_progress(job, told))
        finally:
            with self._lock:
                del self._running[job.id]

    def _note_progress(self, job: Job, told: dict) -> None:
        self._progress[job.id] = _checked_progress(told)
        self._changes.tell(job.user)


def _log(job: Job, outcome: Outcome) -> None:
    """Tell who keeps the service how a job has failed."""
    LOGGER.warning(
        "job %s (%s) failed with code %d: %s\n%s",
        job.id,
        job.kind,
        outcome.code,
        outcome.reason or "see below",
        "\n".join(printable(line) for line in outcome.log),
    )


def _checked_progress(told: dict) -> dict:
    """What of it has the expected form: it comes from a process that is not trusted."""
    made = {}
    for key in ("title", "text"):
        if isinstance(told.get(key), str):
            made[key] = printable(told[key][:200])
    for key in ("share", "relative_error", "seconds_left"):
        value = told.get(key)
        if isinstance(value, int | float) and not isinstance(value, bool) and 0.0 <= value < 1e9:
            made[key] = float(value)
    return made


def _why_failed(outcome: Outcome) -> str:
    """One sentence for the user; empty if nothing has failed."""
    if outcome.reason:
        return outcome.reason
    if outcome.code == 0:
        return ""
    if any(words in line for words in NO_MEMORY for line in outcome.log):
        # What Blender says of the file then is not true.
        return "the file is broken, or it needs more memory than you may have"
    said = [line for line in outcome.log if line.startswith("lumenray: ")]
    if said:
        return printable(said[-1].removeprefix("lumenray: "))[:LONGEST_NOTE]
    if outcome.code < 0:
        name = signal.Signals(-outcome.code).name
        return f"its process was ended by {name}: the file is broken, or it needs more memory than you may have"
    # A fault of ours, whose last line says most of it; the rest stands in the service's own log.
    last = printable(outcome.log[-1])[:LONGEST_NOTE] if outcome.log else f"exit code {outcome.code}"
    return f"its process failed: {last}"


def _notes(log: list[str]) -> str:
    """What has to be known beside the results."""
    told = [line for line in log if line.startswith(("goal: ", "note: ", "lumenray: "))]
    rows = [line.strip() for line in log if line.startswith("  ")]
    return printable("\n".join([*told, *rows]))[:LONGEST_NOTE]
