"""Checks of a zip by reading it: names, manifest, wheels, and what every native library asks of its system."""

import io
import lzma
import re
import stat
import struct
import tomllib
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from binaries import Library, read_library
from manifest_checks import check_manifest
from project import BuildError
from system_libraries import KINDS, LIMITS, MACHINES, is_of_system
from targets import ANY_PYTHON, PLATFORM_TAGS, Target, runs_on
from wheels import tags_of

ZIP_NAME = (
    r"lumenray(?:-(?P<pack>denoiser|cluster))?-(?P<version>\d[^-]*)"
    rf"-(?P<platform>{'|'.join(PLATFORM_TAGS)})(?:-(?P<python>cp\d+))?\.zip"
)
"""How a zip tells what it is for; the denoiser pack serves every Python."""

LARGEST = 1 << 30
"""What a zip or a wheel holds is no larger when it is unpacked. [byte]"""

UNREADABLE = (
    zipfile.BadZipFile, zlib.error, lzma.LZMAError, struct.error, EOFError, OSError, RuntimeError, ValueError,
)  # fmt: skip
"""What `zipfile` raises over a broken or encrypted zip, or one squeezed in a way that it does not know."""


@dataclass(frozen=True)
class Inspection:
    """What was found in a zip that has no fault.

    Parameters
    ----------
    pack : str    Which one it is, such as ``denoiser-``; empty for the extension itself.
    target : Target    With ``py3`` for the Python where any will do.
    size : int    Of the zip. [byte]
    files : int    That Blender writes when it installs the zip, those of the wheels included.
    libraries : tuple of Library
    needs : dict    The oldest system that will do: what, and its version.
    newer : tuple of str    Where that is newer than what Blender 4.2 asks for or brings: one sentence for each kind.
    """

    name: str
    pack: str
    target: Target
    size: int
    files: int
    libraries: tuple
    needs: dict
    newer: tuple


def target_of(path: Path) -> tuple[str, Target]:
    """Return the version and the target that a zip's name tells."""
    named = re.fullmatch(ZIP_NAME, path.name)
    if named is None:
        raise BuildError(f"{path.name} is not named as lumenray-VERSION-PLATFORM-PYTHON.zip")
    return named["version"], Target(named["platform"], named["python"] or ANY_PYTHON)


def check_zip(path: Path, version: str) -> Inspection:
    """Check a zip of ours as far as that goes without running it.

    Raises
    ------
    BuildError    It has a fault; one sentence tells where, and what was expected.
    """
    stated, target = target_of(path)
    with _opened(path.name, path) as archive:
        names = safe_names(path.name, archive)
        for needed in ("blender_manifest.toml", "__init__.py"):
            if needed not in names:
                raise BuildError(f"{path.name}: no {needed} at the top")
        manifest = _read_manifest(path.name, archive)
        if not version == stated == manifest["version"]:
            raise BuildError(
                f"{path.name}: the manifest is version {manifest['version']}, pyproject.toml {version}"
            )
        if manifest["platforms"] != [target.platform]:
            raise BuildError(f"{path.name}: the manifest is for {', '.join(manifest['platforms'])}")
        wheels = sorted(name for name in names if name.endswith(".whl"))
        if sorted(each.removeprefix("./") for each in manifest["wheels"]) != wheels:
            raise BuildError(f"{path.name}: the manifest lists other wheels than the zip holds")
        files, libraries = len(names), []
        for wheel in wheels:
            held, own = _check_wheel(
                path.name, PurePosixPath(wheel).name, archive.read(wheel), target
            )
            files += held
            libraries += own
    _check_imports(path.name, libraries, target)
    needs, newer = _measure_needs(libraries)
    pack = re.fullmatch(ZIP_NAME, path.name)["pack"]
    pack = f"{pack}-" if pack else ""
    size = path.stat().st_size
    return Inspection(path.name, pack, target, size, files, tuple(libraries), needs, newer)


@contextmanager
def _opened(name: str, file) -> Iterator[zipfile.ZipFile]:
    try:
        with zipfile.ZipFile(file) as archive:
            yield archive
    except UNREADABLE as error:
        raise BuildError(f"{name} cannot be read as a zip: {error}") from error


def safe_names(where: str, archive: zipfile.ZipFile) -> set[str]:
    """Return the names of an archive's files, none of which leads outside the folder it is unpacked into."""
    names = set()
    for info in archive.infolist():
        path = PurePosixPath(info.filename)
        if path.is_absolute() or ".." in path.parts or re.search(r"[\\:\0]", info.orig_filename):
            raise BuildError(
                f"{where}: the name '{info.filename}' leads outside; such a zip is refused"
            )
        if stat.S_ISLNK(info.external_attr >> 16):
            raise BuildError(f"{where}: '{info.filename}' is a link; such a zip is refused")
        if info.filename.lower() in names:
            raise BuildError(f"{where}: '{info.filename}' is there twice")
        names.add(info.filename.lower())
    if sum(info.file_size for info in archive.infolist()) > LARGEST:
        raise BuildError(f"{where} holds more than 1 GiB")
    return {info.filename for info in archive.infolist() if not info.is_dir()}


def _read_manifest(where: str, archive: zipfile.ZipFile) -> dict:
    try:
        manifest = tomllib.loads(archive.read("blender_manifest.toml").decode())
    except (UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        raise BuildError(f"{where}: blender_manifest.toml cannot be read: {error}") from error
    check_manifest(where, manifest)
    return manifest


def _check_wheel(
    where: str, name: str, content: bytes, target: Target
) -> tuple[int, list[Library]]:
    """Check a wheel's tags and names; return how many files it has, and its native libraries."""
    if name.startswith("numpy-"):
        raise BuildError(f"{where}: numpy is Blender's own and must not be shipped")
    if not runs_on(tags_of(name), target):
        raise BuildError(f"{where}: the wheel {name} is not for {target}")
    with _opened(f"{where}: the wheel {name}", io.BytesIO(content)) as wheel:
        names = safe_names(name, wheel)
        if not any(re.search(r"\.dist-info/.*(LICENSE|COPYING)", each) for each in names):
            raise BuildError(f"{where}: the wheel {name} has no text of its licence")
        libraries = [read_library(each, wheel.read(each)) for each in sorted(names)]
    return len(names), [each for each in libraries if each is not None]


def _check_imports(where: str, libraries, target: Target) -> None:
    """See that every library is for the target, and finds what it asks for."""
    fold = str.lower if target.platform == "windows-x64" else str
    held = {fold(name) for each in libraries for name in (each.name, PurePosixPath(each.path).name)}
    for library in libraries:
        if (
            library.kind != KINDS[target.platform]
            or MACHINES[target.platform] not in library.machines
        ):
            raise BuildError(
                f"{where}: {library.path} is {library.kind} for {', '.join(library.machines)}, "
                f"expected {KINDS[target.platform]} for {MACHINES[target.platform]}"
            )
        for wanted in library.imports:
            if fold(PurePosixPath(wanted).name) not in held and not is_of_system(wanted, target):
                raise BuildError(
                    f"{where}: {library.path} asks for {wanted}, which neither the zip nor the system has"
                )


def _measure_needs(libraries) -> tuple[dict, tuple]:
    needs, beyond = {}, {}
    for library in libraries:
        for what, version in library.needs.items():
            needs[what] = max(needs.get(what, version), version)
            if version > LIMITS[what]:
                beyond.setdefault(what, []).append(PurePosixPath(library.path).name)
    newer = tuple(
        f"{what} {as_text(needs[what])} is needed, with Blender 4.2 it may be {as_text(LIMITS[what])}: "
        + ", ".join(names)
        for what, names in beyond.items()
    )
    return needs, newer


def as_text(version: tuple) -> str:
    """Return a version with points between its numbers."""
    return ".".join(map(str, version))
