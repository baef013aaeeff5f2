"""What the repository says of itself: where it lies, its version and the packages that are pinned."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
"""Root of the repository, which is the root of the extension too."""


CLUSTER = (
    "dask", "distributed", "click", "cloudpickle", "fsspec", "importlib_metadata", "Jinja2", "lazy-importer", "locket",
    "MarkupSafe", "msgpack", "packaging", "partd", "psutil", "PyYAML", "sortedcontainers", "tblib", "toolz", "tornado",
    "zict", "zipp",
)  # fmt: skip
"""Packages of the cluster pack: Dask, and what it needs."""


class BuildError(Exception):
    """What was asked for cannot be built; the message says why and what helps."""


@dataclass(frozen=True)
class Project:
    """What ``pyproject.toml`` says.

    Parameters
    ----------
    version : str
    pins : tuple of (name, version)    Packages that the extension ships as wheels; numpy is each Blender's own.
    denoiser : (name, version)    The package that the denoiser pack ships.
    cluster : tuple of (name, version)    Packages that the cluster pack ships, what Dask needs included.
    rooms : tuple of str    Folders of the root that hold packages.
    """

    version: str
    pins: tuple
    denoiser: tuple
    cluster: tuple
    rooms: tuple


def read_project() -> Project:
    """Read ``pyproject.toml``, and what it does not pin in ``requirements.lock``."""
    data = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project = data["project"]
    packages = data["tool"]["setuptools"]["packages"]
    lines = (ROOT / "requirements.lock").read_text(encoding="utf-8").splitlines()
    locked = dict(_pin(line) for line in lines if "==" in line)
    return Project(
        version=project["version"],
        pins=tuple(_pin(entry) for entry in project["dependencies"] if "==" in entry),
        denoiser=_pin(project["optional-dependencies"]["denoiser"][0]),
        cluster=tuple((name, locked[name]) for name in CLUSTER),
        rooms=tuple(sorted({name.split(".")[1] for name in packages if "." in name})),
    )


def _pin(entry: str) -> tuple[str, str]:
    name, version = entry.split("==")
    return name.strip(), version.strip()
