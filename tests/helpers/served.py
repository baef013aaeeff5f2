"""Services for tests: a folder with users, and a program that stands for the command in their jobs."""

import json
import time
from contextlib import contextmanager

from lumenray.service import accounts, jobs, scenes
from lumenray.service.changes import Changes
from lumenray.service.database import Database
from lumenray.service.folders import UPLOADS, Folders
from lumenray.service.supervisor import Supervisor

PROGRAM = "served_program"
"""Module beside this one."""

CONTENT = {
    "lights": [
        {"name": "Lamp", "amount": 800.0, "unit": "lm", "count": 1},
        {"name": "Sun", "amount": 50000.0, "unit": "lx", "count": 1},
    ],
    "objects": ["Chair", "Lamp", "Sun"],
    "materials": ["Wall"],
}


class Served:
    """A service without its door."""

    def __init__(self, root, count=1, seconds=60.0, quota=None, program=PROGRAM):
        self.folders = Folders(root)
        self.database = Database(self.folders.database)
        self.changes = Changes()
        self.supervisor = Supervisor(
            self.database, self.folders, self.changes, count, seconds, program
        )
        self.user = self.add_user("Ada", quota)

    def add_user(self, name, quota=None):
        """The user of that name, who may be there from before."""
        known = {each.name: each for each in accounts.users(self.database)}
        return known.get(name) or accounts.add_user(self.database, name, quota)

    def add_scene(self, user=None, upload=b"BLENDER", kind="blend"):
        """A scene that waits to be opened."""
        user, key = user or self.user, accounts.new_id()
        folder = self.folders.scene(user.id, key)
        folder.mkdir(parents=True)
        (folder / UPLOADS[kind]).write_bytes(upload)
        return scenes.add_scene(self.database, user, key, "Room", len(upload))

    def add_ready_scene(self, user=None):
        """A scene that was opened, without the job that does it: what runs jobs may be running."""
        user, key = user or self.user, accounts.new_id()
        folder = self.folders.scene(user.id, key)
        folder.mkdir(parents=True)
        (folder / "scene.blend").write_bytes(b"BLENDER")
        values = (key, user.id, "Room", scenes.READY, json.dumps(CONTENT), 7, time.time())
        with self.database.change() as connection:
            connection.execute(
                "insert into scenes (id, user, name, state, content, bytes, created) "
                "values (?, ?, ?, ?, ?, ?, ?)",
                values,
            )
        return scenes.find_scene(self.database, user, key)

    def submit(self, scene, user=None, kind="measure", request=None, **options):
        """Order a job."""
        user = user or self.user
        ready = scenes.find_ready(self.database, user, scene.id)
        return jobs.submit(self.database, user, ready, kind, options, request)

    def wait(self, job, seconds=60.0):
        """The job once it has ended."""
        return self._wait(jobs.find_job, job, lambda found: found.state in jobs.ENDED, seconds)

    def wait_until_opened(self, scene, seconds=60.0):
        """The scene once it is known what is in it."""
        return self._wait(
            scenes.find_scene, scene, lambda found: found.state != scenes.OPENING, seconds
        )

    def _wait(self, find, thing, has_ended, seconds):
        end = time.monotonic() + seconds
        while not has_ended(found := find(self.database, self.user, thing.id)):
            assert time.monotonic() < end, f"still {found.state}"
            time.sleep(0.05)
        return found


@contextmanager
def running(served):
    """Let a service run jobs."""
    served.supervisor.start()
    try:
        yield served
    finally:
        served.supervisor.close()
        served.database.close()
