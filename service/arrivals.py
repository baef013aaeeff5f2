"""What is coming over the line and stands in no account yet, so that uploads at once take no more room than a user may."""

import shutil
import threading
from contextlib import contextmanager

from .accounts import User
from .database import Database
from .folders import Folders
from .jobs import disk_of
from .refusals import RefusalError

LEAST_FREE = 1 << 30
"""What uploads leave of the disk for the database and the jobs of others. [byte]"""


class Arrivals:
    """Bytes of each user's uploads until they are counted in the database; from any thread.

    Parameters
    ----------
    database : Database    With what users have.
    folders : Folders    Where it all is written.
    """

    def __init__(self, database: Database, folders: Folders):
        self._database = database
        self._folders = folders
        self._lock = threading.Lock()
        self._coming: dict[str, int] = {}

    def room(self, user: User) -> int:
        """Return what a user may still upload; not above 0 if nothing. [byte]"""
        with self._lock:
            coming = self._coming.get(user.id, 0)
        return user.quota.disk - disk_of(self._database, user) - coming

    @contextmanager
    def receive(self, user: User):
        """Give a function that is told how many bytes are to be written next, and refuses them where there is no room.

        They count until the end of the block, within which they are to be written into the database.
        """
        taken = 0

        def take(length: int) -> None:
            nonlocal taken
            taken += length
            self._add(user, length)
            self._check(user)

        try:
            yield take
        finally:
            self._add(user, -taken)

    def _add(self, user: User, length: int) -> None:
        with self._lock:
            self._coming[user.id] = self._coming.get(user.id, 0) + length
            if not self._coming[user.id]:
                del self._coming[user.id]

    def _check(self, user: User) -> None:
        if self.room(user) < 0:
            raise no_room()
        if shutil.disk_usage(self._folders.root).free < LEAST_FREE:
            raise RefusalError(507, "the service has no room left for uploads; tell who keeps it")


def no_room() -> RefusalError:
    """All that a user may have is taken."""
    return RefusalError(413, "your scenes and results take all the room that you have; remove some")
