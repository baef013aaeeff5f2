"""Scenes of users, as the database has them. What is in their files is found by a job of the kind ``open``."""

import json
import time
from dataclasses import dataclass

from ..blender_addon.scene_edits import check_edits
from ..engine.errors import SceneError
from .accounts import User, new_id
from .database import Database
from .folders import Folders, remove
from .jobs import DONE, OPEN, RUNNING, Job, insert_job, write_end
from .jobs import FAILED as JOB_FAILED
from .refusals import bad, conflict, missing

OPENING, READY, FAILED = "opening", "ready", "failed"
"""States of a scene."""

LONGEST_NAME = 120
"""Of a scene. [character]"""


@dataclass(frozen=True)
class Scene:
    """A scene of a user.

    Parameters
    ----------
    id, user, name : str
    state, note : str    ``opening``, ``ready`` or ``failed``, and why.
    content : dict or None    What is in it, once it was opened.
    edits : dict    See `blender_addon.scene_edits`.
    revision : int    Grows with every change of the edits.
    weather : str    What the weather file was called; empty without one.
    bytes : int
    created : float    [s]
    """

    id: str
    user: str
    name: str
    state: str
    note: str
    content: dict | None
    edits: dict
    revision: int
    weather: str
    bytes: int
    created: float


def check_name(name: str) -> str:
    """Return what a scene is to be called; refuse what is no name."""
    name = name.strip()
    if not name or len(name) > LONGEST_NAME or not name.isprintable():
        raise bad(f"a scene's name has 1 to {LONGEST_NAME} printable characters")
    return name


def check_content(found) -> dict:
    """Return what was told of a scene; it comes from a process that other people's files may rule.

    Raises
    ------
    SceneError    It has not the form of `blender_addon.scene_edits.describe`.
    """
    if not isinstance(found, dict):
        raise SceneError("what is in the scene is not told in the expected form")
    made = {"has_camera": found.get("has_camera") is True}
    for key in ("objects", "surfaces", "sensors", "materials", "problems"):
        made[key] = [each for each in _list(found, key) if isinstance(each, str)]
    made["lights"] = [_light(each) for each in _list(found, "lights") if _is_light(each)]
    return made


def _list(found: dict, key: str) -> list:
    value = found.get(key, [])
    return value if isinstance(value, list) else []


def _is_light(each) -> bool:
    if not isinstance(each, dict):
        return False
    amount = each.get("amount")
    return (
        isinstance(each.get("name"), str)
        and isinstance(amount, int | float)
        and 0.0 <= amount < 1e30
        and each.get("unit") in {"lm", "lx"}
    )


def _light(each: dict) -> dict:
    count = each.get("count")
    return {
        "name": each["name"],
        "amount": float(each["amount"]),
        "unit": each["unit"],
        "count": count if isinstance(count, int) else 1,
        "is_on": each.get("is_on") is not False,
    }


def add_scene(database: Database, user: User, key: str, name: str, size: int) -> Scene:
    """Take in a scene whose upload lies in its folder, and order that it is opened. [byte]"""
    with database.change() as connection:
        connection.execute(
            "insert into scenes (id, user, name, state, bytes, created) values (?, ?, ?, ?, ?, ?)",
            (key, user.id, name, OPENING, size, time.time()),
        )
        insert_job(connection, new_id(), user, key, OPEN, {}, {}, None)
    return find_scene(database, user, key)


def end_opening(database: Database, job: Job, note: str, content: dict | None, size: int) -> None:
    """Write down what was found in an upload, or why it cannot be used if nothing was; its job is done with. [byte]"""
    state, job_state = (FAILED, JOB_FAILED) if content is None else (READY, DONE)
    with database.change() as connection:
        if not write_end(connection, job, job_state, note):
            return
        connection.execute(
            "update scenes set state = ?, note = ?, content = ?, bytes = ? where id = ?",
            (state, note, None if content is None else json.dumps(content), size, job.scene),
        )


def scenes_of(database: Database, user: User) -> list[Scene]:
    """Return a user's scenes, newest first."""
    return [
        _scene(row)
        for row in database.rows(
            "select * from scenes where user = ? order by created desc", user.id
        )
    ]


def find_scene(database: Database, user: User, key: str) -> Scene:
    """Return a scene of a user; refuse what is not this user's."""
    row = database.row("select * from scenes where id = ? and user = ?", key, user.id)
    if row is None:
        raise missing("scene")
    return _scene(row)


def find_ready(database: Database, user: User, key: str) -> Scene:
    """Return a scene that was opened; refuse others."""
    scene = find_scene(database, user, key)
    if scene.state == FAILED:
        raise conflict(f"the scene cannot be used: {scene.note}")
    if scene.state != READY:
        raise conflict("the scene is being opened; wait until its state is 'ready'")
    return scene


def change_edits(database: Database, user: User, key: str, edits, library) -> Scene:
    """Put edits in place of those of before; refuse what is not understood."""
    scene = find_ready(database, user, key)
    try:
        checked = check_edits(edits, scene.content, library)
    except SceneError as error:
        raise bad(str(error)) from None
    with database.change() as connection:
        connection.execute(
            "update scenes set edits = ?, revision = revision + 1 where id = ?",
            (json.dumps(checked), key),
        )
    return find_scene(database, user, key)


def change_weather(database: Database, user: User, key: str, name: str, grown: int) -> None:
    """State how a scene's weather file was called, and by how much the scene has grown with it. [byte]"""
    with database.change() as connection:
        connection.execute(
            "update scenes set weather = ?, bytes = bytes + ? where id = ? and user = ?",
            (name, grown, key, user.id),
        )


def remove_scene(database: Database, folders: Folders, user: User, key: str) -> None:
    """Remove a scene with all its jobs and results; refuse it while one of these runs."""
    find_scene(database, user, key)
    with database.change() as connection:
        running = "select 1 from jobs where scene = ? and state = ?"
        if connection.execute(running, (key, RUNNING)).fetchone():
            raise conflict("a job of this scene is running; cancel it first")
        jobs = connection.execute("select id from jobs where scene = ?", (key,)).fetchall()
        connection.execute("delete from scenes where id = ?", (key,))
    # What is left of files after a sudden end is removed at the next start.
    for (job,) in jobs:
        remove(folders.results(user.id, job))
    remove(folders.scene(user.id, key))


def _scene(row) -> Scene:
    content = None if row["content"] is None else json.loads(row["content"])
    edits = json.loads(row["edits"])
    names = ("id", "user", "name", "state", "note")
    return Scene(
        *(row[name] for name in names),
        content,
        edits,
        row["revision"],
        row["weather"],
        row["bytes"],
        row["created"],
    )
