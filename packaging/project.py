"""What the repository says of itself: where it lies, its version and the packages that are pinned."""

import tomllib
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
"""Root of the repository, which is the root of the extension too."""


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
    rooms : tuple of str    Folders of the root that hold packages.
    """

    version: str
    pins: tuple
    denoiser: tuple
    rooms: tuple


def read_project() -> Project:
    """Read ``pyproject.toml``."""
    data = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project = data["project"]
    packages = data["tool"]["setuptools"]["packages"]
    return Project(
        version=project["version"],
        pins=tuple(_pin(entry) for entry in project["dependencies"] if "==" in entry),
        denoiser=_pin(project["optional-dependencies"]["denoiser"][0]),
        rooms=tuple(sorted({name.split(".")[1] for name in packages if "." in name})),
    )


def _pin(entry: str) -> tuple[str, str]:
    name, version = entry.split("==")
    return name.strip(), version.strip()
