"""Wheels and sources from the package index: recorded in ``wheels.lock``, kept in a cache, refused when they differ.

Which ones is told by the exact pins in ``pyproject.toml``. The lock holds their SHA-256 sums in the format of
``sha256sum`` and is written by ``build_extension.py --update``.
"""

import hashlib
import os
import re
import tempfile
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from package_index import download
from project import ROOT, BuildError
from targets import PLATFORM_TAGS, PYTHONS, Tags, Target, runs_on

LOCK = ROOT / "packaging" / "wheels.lock"
"""SHA-256 sum and file name of every file of the package index that goes into a zip, or that a wheel is made from."""


@dataclass(frozen=True)
class Recorded:
    """One file of the package index: its name and the SHA-256 sum of its bytes."""

    filename: str
    sha256: str

    def fits(self, name: str, version: str, target: Target) -> bool:
        """Tell whether this is the wheel of a pinned package for a target."""
        return (
            self.filename.endswith(".whl")
            and name_and_version(self.filename) == (normalised(name), version)
            and runs_on(tags_of(self.filename), target)
        )

    def is_source_of(self, name: str, version: str) -> bool:
        """Tell whether this is the source of a pinned package."""
        return self.filename == f"{normalised(name)}-{version}.tar.gz"


def normalised(name: str) -> str:
    """Return the name of a package as package indices compare it."""
    return re.sub(r"[-_.]+", "_", name).lower()


def name_and_version(filename: str) -> tuple[str, str]:
    """Return the package and the version that a wheel's name tells."""
    name, version = filename.split("-")[:2]
    return normalised(name), version


def tags_of(filename: str) -> Tags:
    """Return the tags that a wheel's name tells.

    Raises
    ------
    BuildError    It is no name of a wheel.
    """
    parts = filename.removesuffix(".whl").split("-")
    if not filename.endswith(".whl") or len(parts) not in (5, 6):
        raise BuildError(f"{filename} is no name of a wheel: name-version-python-abi-platform.whl")
    pythons, abis, platforms = (part.split(".") for part in parts[-3:])
    return Tags(tuple(product(pythons, abis)), tuple(platforms))


def read_lock() -> list[Recorded]:
    """Return what is recorded."""
    if not LOCK.exists():
        return []
    lines = LOCK.read_text(encoding="utf-8").splitlines()
    rows = [line.split() for line in lines if line and not line.startswith("#")]
    return [Recorded(filename, sha256) for sha256, filename in rows]


def write_lock(files) -> None:
    """Record files, sorted by name."""
    rows = [f"{each.sha256}  {each.filename}" for each in files]
    rows.sort(key=lambda row: row.split()[1])
    LOCK.write_text("\n".join(rows) + "\n", encoding="utf-8")


def cache_folder() -> Path:
    """Return the folder in which wheels are kept, made if need be."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache")
    folder = base / "lumenray" / "wheels"
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def sha256_of(path: Path) -> str:
    """Return the SHA-256 sum of a file in hexadecimal digits."""
    with path.open("rb") as stream:
        return hashlib.file_digest(stream, "sha256").hexdigest()


def download_wheels(pins, target: Target, folder: Path) -> None:
    """Let pip put the wheels of some pinned packages into a folder."""
    options = ["--only-binary=:all:", "--implementation", "cp"]
    options += ["--python-version", PYTHONS.get(target.python, min(PYTHONS.values()))]
    for tag in PLATFORM_TAGS[target.platform]:
        options += ["--platform", tag]
    wanted = ["==".join(pin) for pin in pins]
    download([*options, *wanted], folder, f"{', '.join(wanted)} for {target}")


def download_source(pin, folder: Path) -> None:
    """Let pip put the source of a pinned package into a folder."""
    wanted = "==".join(pin)
    download([f"--no-binary={pin[0]}", wanted], folder, f"the source of {wanted}")


def update_lock(orders, sources, still_wanted) -> None:
    """Download wheels and sources anew and record their sums.

    Parameters
    ----------
    orders : list of (pins, Target)    Wheels to download.
    sources : list of pins    Packages of which the source is wanted.
    still_wanted : callable    Tells of a recorded file whether it stays although nobody asks for it now.
    """
    recorded = {each for each in read_lock() if still_wanted(each)}
    cache = cache_folder()
    for fetch, *order in [
        *((download_wheels, pins, target) for pins, target in orders),
        *((download_source, pin) for pin in sources),
    ]:
        with tempfile.TemporaryDirectory(dir=cache) as fresh:
            fetch(*order, fresh)
            for path in sorted(Path(fresh).iterdir()):
                recorded.add(Recorded(path.name, sha256_of(path)))
                path.replace(cache / path.name)
    write_lock(recorded)


def fetch_wheels(target: Target, pins, recorded) -> list[Path]:
    """Return the paths of a target's wheels in the cache, each with the recorded sum."""
    paths = []
    for pin in pins:
        known = next((each for each in recorded if each.fits(*pin, target)), None)
        if known is None:
            raise _unrecorded(f"wheel of {'=='.join(pin)} for {target}")
        paths.append(_fetch(known, download_wheels, [pin], target))
    return paths


def fetch_source(pin, recorded) -> Path:
    """Return the path of a package's source in the cache, with the recorded sum."""
    known = next((each for each in recorded if each.is_source_of(*pin)), None)
    if known is None:
        raise _unrecorded(f"source of {'=='.join(pin)}")
    return _fetch(known, download_source, pin)


def _unrecorded(what: str) -> BuildError:
    return BuildError(
        f"packaging/wheels.lock records no {what}; run packaging/build_extension.py --update --all "
        "and review what it records"
    )


def _fetch(known: Recorded, fetch, *order) -> Path:
    cache = cache_folder()
    path = cache / known.filename
    if not path.exists():
        with tempfile.TemporaryDirectory(dir=cache) as fresh:
            fetch(*order, fresh)
            arrived = Path(fresh) / known.filename
            if not arrived.exists():
                names = ", ".join(path.name for path in Path(fresh).iterdir())
                raise BuildError(f"expected {known.filename}, but the index gave {names}")
            arrived.replace(path)
    if sha256_of(path) != known.sha256:
        raise BuildError(
            f"{path} is not the file that packaging/wheels.lock records; if it was damaged on "
            "this machine, delete it and build again"
        )
    return path
