"""Wheels that we make ourselves, and packages that a target does without."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import llvm_wheel
import xatlas_wheel
from project import Project
from targets import ANY_PYTHON, Target, all_targets
from wheels import Recorded, cache_folder, fetch_source


@dataclass(frozen=True)
class BuiltWheel:
    """A wheel that is made, not downloaded.

    Parameters
    ----------
    name : str    Of the package; where it is one of the pinned ones, the index is not asked for its wheel.
    targets : frozenset of Target
    make : callable    ``make(target, project, recorded)`` returns the wheel's path, or raises `BuildError`.
    sources : tuple of str    Pinned packages whose recorded source it is made from.
    """

    name: str
    targets: frozenset
    make: Callable[[Target, Project, list[Recorded]], Path]
    sources: tuple = ()


def built_folder() -> Path:
    """Return the folder that keeps what was made, made if need be."""
    folder = cache_folder() / "built"
    folder.mkdir(exist_ok=True)
    return folder


def _make_xatlas(target, project, recorded) -> Path:
    pin = next(pin for pin in project.pins if pin[0] == "xatlas")
    return xatlas_wheel.make(target, pin, fetch_source(pin, recorded), built_folder())


def _make_llvm(target, project, recorded) -> Path:
    return llvm_wheel.make_wheel(target.platform)


BUILT = (
    BuiltWheel(
        llvm_wheel.PACKAGE,
        frozenset(target for target in all_targets() if target.platform in llvm_wheel.SOURCES),
        _make_llvm,
    ),
    BuiltWheel(
        "xatlas", frozenset({Target("linux-x64", "cp314")}), _make_xatlas, sources=("xatlas",)
    ),
)
"""Every wheel of ours."""

LEFT_OUT = {
    (target, "xatlas"): "has no wheel; bent surfaces are cut into charts by their normals alone"
    for target in (Target("windows-x64", "cp314"), Target("macos-arm64", "cp314"))
}
"""Packages that a target does without, and what that means."""


METADATA = ("importlib_metadata", "lazy-importer", "zipp")
"""Packages by which Dask reads what is installed where Python cannot do so well enough itself."""

OWN_METADATA = ("cp313", "cp314")
"""Pythons that can."""


def downloaded_pins(project: Project, target: Target) -> list:
    """Return the pinned packages whose wheels come from the index; without a Python those of the denoiser pack."""
    if target.python == ANY_PYTHON:
        return [project.denoiser]
    made = {each.name for each in BUILT if target in each.targets}
    return [pin for pin in project.pins if pin[0] not in made and (target, pin[0]) not in LEFT_OUT]


def cluster_pins(project: Project, target: Target) -> list:
    """Return the packages of the cluster pack for a target."""
    own = target.python in OWN_METADATA
    return [pin for pin in project.cluster if not (own and pin[0] in METADATA)]


def make_wheels(project: Project, target: Target, recorded) -> list[Path]:
    """Make the wheels of ours for a target."""
    return [each.make(target, project, recorded) for each in BUILT if target in each.targets]
