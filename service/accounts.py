"""Who may use the service: users, what they may take of the machine, and the tokens by which they are known."""

import hashlib
import secrets
import time
from dataclasses import dataclass

from ..engine.errors import LumenrayError
from .database import Database

PREFIX = "lumenray_"
"""How tokens begin, so that people and programs that look for leaked secrets know them."""

TOKEN_BYTES = 32
"""Of chance in a token, so that a plain hash of it cannot be tried out."""

LONGEST_NAME = 80
"""Of a user. [character]"""


@dataclass(frozen=True)
class Quota:
    """What one user may take of the machine.

    Parameters
    ----------
    jobs : int    Waiting and running at once.
    disk : int    Scenes and results together. [byte]
    memory : int    Of one job's process. [byte]
    """

    jobs: int = 100
    disk: int = 10 << 30
    memory: int = 8 << 30


@dataclass(frozen=True)
class User:
    """Somebody who may use the service.

    Parameters
    ----------
    id, name : str
    quota : Quota
    """

    id: str
    name: str
    quota: Quota


def new_id() -> str:
    """Return an id that nobody can guess. 32 hexadecimal digits."""
    return secrets.token_hex(16)


def add_user(database: Database, name: str, quota: Quota | None = None) -> User:
    """Take in a user, who needs a token then.

    Raises
    ------
    LumenrayError    The name is in use, or none.
    """
    if not name.strip() or len(name) > LONGEST_NAME or not name.isprintable():
        raise LumenrayError(
            f"a user's name has 1 to {LONGEST_NAME} printable characters, found {name[:LONGEST_NAME]!r}"
        )
    user = User(new_id(), name.strip(), quota or Quota())
    with database.change() as connection:
        if connection.execute("select 1 from users where name = ?", (user.name,)).fetchone():
            raise LumenrayError(f"there is a user '{user.name}' already; choose another name")
        quota = user.quota
        values = (user.id, user.name, quota.jobs, quota.disk, quota.memory, time.time())
        connection.execute("insert into users values (?, ?, ?, ?, ?, ?)", values)
    return user


def add_token(database: Database, user: User) -> str:
    """Return a new token of a user; only its hash is kept."""
    token = PREFIX + secrets.token_urlsafe(TOKEN_BYTES)
    with database.change() as connection:
        values = (_digest(token), user.id, time.time())
        connection.execute("insert into tokens values (?, ?, ?)", values)
    return token


def revoke_tokens(database: Database, user: User) -> int:
    """Make all tokens of a user worthless, and return how many there were."""
    with database.change() as connection:
        return connection.execute("delete from tokens where user = ?", (user.id,)).rowcount


def users(database: Database) -> list[User]:
    """Return all users, by name."""
    return [_user(row) for row in database.rows("select * from users order by name")]


def find_user(database: Database, name: str) -> User:
    """Return the user of a name.

    Raises
    ------
    LumenrayError    There is none.
    """
    row = database.row("select * from users where name = ?", name)
    if row is None:
        raise LumenrayError(f"there is no user '{name}'")
    return _user(row)


def user_of_id(database: Database, key: str) -> User:
    """Return the user of an id, who is there: all that is a user's goes with the user."""
    return _user(database.row("select * from users where id = ?", key))


def user_of_token(database: Database, token: str) -> User | None:
    """Return whose token this is, if anybody's.

    It is looked up by its hash, so that how long that takes tells nothing of other tokens.
    """
    row = database.row(
        "select users.* from tokens join users on users.id = tokens.user where digest = ?",
        _digest(token),
    )
    return None if row is None else _user(row)


def _digest(token: str) -> bytes:
    return hashlib.sha256(token.encode("utf-8", "surrogateescape")).digest()


def _user(row) -> User:
    return User(
        row["id"], row["name"], Quota(row["most_jobs"], row["most_disk"], row["most_memory"])
    )
