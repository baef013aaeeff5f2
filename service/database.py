"""The state of the service in one SQLite file, which survives whatever ends the service."""

import sqlite3
import threading
from contextlib import contextmanager
from pathlib import Path

from ..engine.errors import LumenrayError

VERSION = 1
"""Of the tables, as the file states it."""

PATIENCE = 30.0
"""How long a change waits for others. [s]"""

TABLES = """
create table users (
    id text primary key,
    name text not null unique,
    most_jobs integer not null,
    most_disk integer not null,
    most_memory integer not null,
    created real not null
) strict;
create table tokens (
    digest blob primary key,
    user text not null references users on delete cascade,
    created real not null
) strict;
create table scenes (
    id text primary key,
    user text not null references users on delete cascade,
    name text not null,
    state text not null,
    note text not null default '',
    content text,
    edits text not null default '{}',
    revision integer not null default 0,
    weather text not null default '',
    bytes integer not null,
    created real not null
) strict;
create index scenes_by_user on scenes (user);
create table jobs (
    number integer primary key autoincrement,
    id text not null unique,
    user text not null references users on delete cascade,
    scene text not null references scenes on delete cascade,
    kind text not null,
    options text not null,
    edits text not null,
    request text,
    state text not null,
    attempts integer not null default 0,
    note text not null default '',
    code integer,
    bytes integer not null default 0,
    created real not null,
    started real,
    ended real,
    unique (user, request)
) strict;
create index jobs_by_state on jobs (state);
create index jobs_by_user on jobs (user);
create index jobs_by_scene on jobs (scene);
"""


class Database:
    """Connections to the file, one for each thread.

    Raises
    ------
    LumenrayError    The file is of another version, or no database.
    """

    def __init__(self, path: Path):
        self._path = path
        self._own = threading.local()
        self._all: list[sqlite3.Connection] = []
        self._lock = threading.Lock()
        try:
            with self.change() as connection:
                (version,) = connection.execute("pragma user_version").fetchone()
                if version == 0:
                    for statement in TABLES.split(";\n"):
                        connection.execute(statement)
                    connection.execute(f"pragma user_version = {VERSION}")
        except sqlite3.DatabaseError as error:
            raise LumenrayError(f"{path}: is no database of the service ({error})") from None
        if version not in {0, VERSION}:
            raise LumenrayError(
                f"{path}: the service's tables have version {version}, expected {VERSION}; use the version of the service "
                "that made them, or another folder"
            )

    @contextmanager
    def change(self):
        """Change something: all that is done to the connection within holds together, or not at all if it raises."""
        connection = self._connection()
        connection.execute("begin immediate")
        try:
            yield connection
        except BaseException:
            connection.rollback()
            raise
        connection.commit()

    def rows(self, question: str, *values) -> list[sqlite3.Row]:
        """Return all rows of an answer."""
        return self._connection().execute(question, values).fetchall()

    def row(self, question: str, *values) -> sqlite3.Row | None:
        """Return the first row of an answer, if there is one."""
        return self._connection().execute(question, values).fetchone()

    def close(self) -> None:
        """Close the connections of all threads, which must not use them any more."""
        with self._lock:
            for connection in self._all:
                connection.close()
            self._all.clear()
        self._own = threading.local()

    def _connection(self) -> sqlite3.Connection:
        connection = getattr(self._own, "connection", None)
        if connection is None:
            # Closed by another thread at the end.
            connection = sqlite3.connect(
                self._path, timeout=PATIENCE, isolation_level=None, check_same_thread=False
            )
            connection.row_factory = sqlite3.Row
            connection.execute("pragma journal_mode = wal")
            # What was answered to a user outlives a power cut.
            connection.execute("pragma synchronous = full")
            connection.execute("pragma foreign_keys = on")
            self._own.connection = connection
            with self._lock:
                self._all.append(connection)
        return connection
