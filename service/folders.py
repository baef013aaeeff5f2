"""Where the files of the service lie. Every name in a path is made here, none comes from a user.

::

    DIR/service.sqlite
    DIR/lock
    DIR/users/USER/cache/                kernels that this user's jobs have made
    DIR/users/USER/scenes/SCENE/         upload, scene.blend, content.json, weather.epw
    DIR/users/USER/jobs/JOB/             results, put there whole
    DIR/users/USER/work/JOB/             of a running job: what it writes, and its temporary files
"""

import os
import re
import shutil
import stat
from pathlib import Path

_ID = re.compile(r"[0-9a-f]{32}")

PRIVATE = 0o700
"""Mode of folders: nobody else on the machine reads them."""


class Folders:
    """Paths below the service's own folder."""

    def __init__(self, root: Path):
        self.root = root.resolve()
        self.users = self.root / "users"
        self.database = self.root / "service.sqlite"
        self.lock = self.root / "lock"
        for folder in (self.root, self.users):
            folder.mkdir(mode=PRIVATE, parents=True, exist_ok=True)

    def user(self, user: str) -> Path:
        """All that is a user's."""
        return self.users / _checked(user)

    def cache(self, user: str) -> Path:
        """Kept between jobs of one user; kernels are code, so that no user has another's."""
        return _made(self.user(user) / "cache")

    def scene(self, user: str, scene: str) -> Path:
        """Files of a scene."""
        return self.user(user) / "scenes" / _checked(scene)

    def results(self, user: str, job: str) -> Path:
        """Of a finished job."""
        return self.user(user) / "jobs" / _checked(job)

    def work(self, user: str, job: str) -> Path:
        """Of a job that runs."""
        return self.user(user) / "work" / _checked(job)


UPLOADS = {"blend": "upload.blend", "gltf": "upload.glb"}
"""Of a scene's folder: what came over the line, by its kind."""


def find_upload(folder: Path) -> Path:
    """Return what was uploaded for a scene and was not opened yet."""
    return next(path for path in map(folder.joinpath, UPLOADS.values()) if path.exists())


def make(folder: Path) -> Path:
    """Make a folder anew, with nothing in it."""
    remove(folder)
    return _made(folder)


def remove(folder: Path) -> None:
    """Remove a folder with all that is in it, if it is there."""
    if folder.exists():
        # A half-removed folder is no result any more.
        aside = folder.with_name(f".{folder.name}.removed")
        if aside.exists():
            shutil.rmtree(aside)
        folder.rename(aside)
        shutil.rmtree(aside)


def take_file(source: Path, target: Path, most: int | None = None) -> None:
    """Copy what a confined process has made, if it is a plain file; links of its making are not followed.

    Raises
    ------
    OSError    It is none, or larger than ``most``. [byte]
    """
    handle = os.open(source, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    with os.fdopen(handle, "rb") as stream, target.open("xb") as copy:
        state = os.fstat(handle)
        if not stat.S_ISREG(state.st_mode) or (most is not None and state.st_size > most):
            raise OSError(f"{source.name} is no file that can be taken over")
        shutil.copyfileobj(stream, copy)


def take_folder(source: Path, target: Path) -> None:
    """Copy all plain files of a folder that a confined process has made, as `take_file`, into a new one.

    Raises
    ------
    OSError    It is no folder any more.
    """
    target.mkdir(mode=PRIVATE)
    if source.is_symlink():
        raise OSError(f"{source.name} is no folder")
    for parent, _, names in os.walk(source):
        own = target / Path(parent).relative_to(source)
        own.mkdir(mode=PRIVATE, exist_ok=True)
        for name in names:
            path = Path(parent, name)
            if stat.S_ISREG(path.lstat().st_mode):
                take_file(path, own / name)


def list_files(folder: Path) -> list[tuple[str, int]]:
    """Names, with slashes, and sizes of the plain files of a folder; links and devices are none. [byte]"""
    found = []
    for parent, _, names in os.walk(folder):
        for name in names:
            path = Path(parent, name)
            if path.is_file() and not path.is_symlink():
                found.append((path.relative_to(folder).as_posix(), path.stat().st_size))
    return sorted(found)


def size(folder: Path) -> int:
    """Of all plain files of a folder, some of which may vanish meanwhile. [byte]"""
    total = 0
    for parent, _, names in os.walk(folder):
        for name in names:
            try:
                total += Path(parent, name).lstat().st_size
            except FileNotFoundError:
                continue
    return total


def _made(folder: Path) -> Path:
    folder.mkdir(mode=PRIVATE, parents=True, exist_ok=True)
    return folder


def _checked(name: str) -> str:
    if not _ID.fullmatch(name):
        raise ValueError(f"'{name[:40]}' is no id")
    return name
