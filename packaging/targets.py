"""Targets: the platforms and Python versions that the extension is built for."""

import platform
import re
from typing import NamedTuple

PLATFORM_TAGS = {
    "linux-x64": [f"manylinux_2_{minor}_x86_64" for minor in (28, 27, 24, 17)]
    + ["manylinux2014_x86_64"],
    "windows-x64": ["win_amd64"],
    "macos-arm64": [f"macosx_{major}_0_arm64" for major in (14, 13, 12, 11)],
}
"""Platforms as Blender names them, and the platform tags of the wheels that pip is asked for."""

PLATFORM_PATTERNS = {
    "linux-x64": r"manylinux(_\d+_\d+|2014)_x86_64",
    "windows-x64": r"win_amd64",
    "macos-arm64": r"macosx_\d+_\d+_(arm64|universal2)",
}
"""Platform tags that run on a platform, if its system is new enough."""

PYTHONS = {"cp311": "3.11", "cp313": "3.13", "cp314": "3.14"}
"""Python tags: Blender 4.2 to 5.0 bring 3.11; 5.1 and 5.2, and Debian's 4.3, 3.13; Debian's builds after that 3.14."""


ANY_PYTHON = "py3"
"""In place of a Python tag where nothing depends on the version."""


class Target(NamedTuple):
    """A platform as Blender names it, and a Python tag."""

    platform: str
    python: str

    def __str__(self):
        return f"{self.platform}-{self.python}"


def all_targets() -> list[Target]:
    """Return every target."""
    return [Target(name, tag) for name in PLATFORM_TAGS for tag in PYTHONS]


def pack_targets() -> list[Target]:
    """Return every target of the denoiser pack."""
    return [Target(name, ANY_PYTHON) for name in PLATFORM_TAGS]


def current_platform() -> str | None:
    """Return this machine's platform as Blender names it, or None if it is none of ours."""
    system = {"Linux": "linux", "Windows": "windows", "Darwin": "macos"}.get(platform.system())
    machine = {"x86_64": "x64", "AMD64": "x64", "arm64": "arm64"}.get(platform.machine())
    name = f"{system}-{machine}"
    return name if name in PLATFORM_TAGS else None


def runs_on(tags: "Tags", target: Target) -> bool:
    """Tell whether a wheel of these tags runs on a target."""
    platforms = tags.platforms
    return any(_suits(*each, target.python) for each in tags.interpreters) and any(
        tag == "any" or re.fullmatch(PLATFORM_PATTERNS[target.platform], tag) for tag in platforms
    )


class Tags(NamedTuple):
    """Tags of a wheel: pairs of Python and ABI, and platforms."""

    interpreters: tuple
    platforms: tuple


def _suits(python: str, abi: str, wanted: str) -> bool:
    if abi == "none":
        return python in (wanted, ANY_PYTHON)
    if abi == "abi3":
        return re.fullmatch(r"cp3\d+", python) is not None and int(python[3:]) <= int(wanted[3:])
    return python == abi == wanted
