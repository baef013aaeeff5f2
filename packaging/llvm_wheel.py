"""Make the wheel ``lumenray_llvm``: the shared LLVM library that Dr.Jit compiles kernels with.

The library comes out of wheels of the package index whose sums ``packaging/llvm/sources.txt``
records; pip refuses others. What Dr.Jit does not need is left behind: headers, bindings, and the
symbols of the debugger. The wheel serves every Python version, and the same sources give the same
bytes (with the same zlib).
"""

import argparse
import hashlib
import re
import struct
import sys
import tempfile
import zipfile
from dataclasses import dataclass, field
from pathlib import Path

import archive
from package_index import download
from project import BuildError
from wheels import cache_folder

FOLDER = Path(__file__).resolve().parent / "llvm"
"""What goes into the wheel beside the library, and the list of its sources."""

REVISION = 1
"""To be raised when the wheel's content changes and LLVM's version does not: Blender keeps a wheel whose version it has."""

PACKAGE = "lumenray_llvm"
"""Name of the wheel and of the package in it."""


@dataclass(frozen=True)
class Source:
    """Where a platform's library comes from.

    Parameters
    ----------
    package, version, tag : str    Wheel of the package index, its version and platform tag.
    python : str    A Python version that the wheel is made for.
    library : str    The library, by its path in the wheel.
    beside : dict    Path in the wheel of each library that it needs, by the name it is looked for under.
    """

    package: str
    version: str
    tag: str
    python: str
    library: str
    beside: dict[str, str] = field(default_factory=dict)


_KARELLEN = "karellen_llvm_core-23.1.4.data/data/lib"

SOURCES = {
    "linux-x64": Source(
        "karellen-llvm-core",
        "23.1.4",
        "manylinux_2_28_x86_64",
        "3.13",
        f"{_KARELLEN}/libLLVM.so.23.1",
        {
            f"{name}.so.1": f"{_KARELLEN}/x86_64-unknown-linux-gnu/{name}.so.1.0"
            for name in ("libc++", "libc++abi", "libunwind")
        },
    ),
    "windows-x64": Source("llvm-nanobind", "21.1.6.3", "win_amd64", "3.13", "llvm/LLVM.dll"),
}
"""Platforms, as Blender names them, that get a library. On macOS Mitsuba computes with Metal."""


def version_of(source):
    """Return the version of the wheel made from a source."""
    return f"{source.version}.post{REVISION}"


def wheel_name(platform):
    """Return the file name of a platform's wheel."""
    source = SOURCES[platform]
    return f"{PACKAGE}-{version_of(source)}-py3-none-{source.tag}.whl"


def make_wheel(platform, folder=None):
    """Return the path of a platform's wheel, which is made if it is not in the folder yet.

    Parameters
    ----------
    platform : str    A key of `SOURCES`.
    folder : Path    Where it goes; default: the cache. A name holds the sum of all that it is made of.
    """
    source = SOURCES[platform]
    folder = folder or cache_folder() / f"llvm-{_sum_of_making()}"
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / wheel_name(platform)
    if path.exists():
        return path
    with tempfile.TemporaryDirectory(dir=folder) as place:
        archive.write_wheel(path, _contents(source, _download(source, Path(place))))
    return path


def _sum_of_making():
    """Return some digits of the sum of what makes a wheel, and of what goes into it."""
    digest = hashlib.sha256()
    for path in (Path(__file__), Path(archive.__file__), *sorted(FOLDER.iterdir())):
        digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def _download(source, folder):
    """Let pip put the source's wheel into a folder; it checks the recorded sum."""
    pin = f"{source.package}=={source.version}"
    lines = (FOLDER / "sources.txt").read_text(encoding="utf-8").splitlines()
    line = next((line for line in lines if line.startswith(pin + " ")), None)
    if line is None:
        raise BuildError(f"packaging/llvm/sources.txt records no sum of {pin}")
    # The marker is for people: the wheel is fetched for any platform from any other.
    wanted = folder / "wanted.txt"
    wanted.write_text(re.sub(r" ;.*? --hash", " --hash", line) + "\n", encoding="utf-8")
    options = ["--only-binary=:all:", "--require-hashes", "--platform", source.tag]
    options += ["--python-version", source.python, "-r", str(wanted)]
    download(options, folder, f"{pin}, which holds LLVM")
    return next(folder.glob("*.whl"))


def _contents(source, origin) -> dict[str, bytes]:
    """Return all files of the wheel but its record, by their path in it."""
    name = Path(source.library).name
    with zipfile.ZipFile(origin) as wheel:
        libraries = {
            f"{PACKAGE}/lib/{new}": without_symbols(wheel.read(old))
            for new, old in {name: source.library, **source.beside}.items()
        }
    version = ".".join(source.version.split(".")[:2])
    loader = (FOLDER / "loader.py").read_text(encoding="utf-8")
    loader = loader.replace("@LIBRARY@", name).replace("@VERSION@", version)
    info = f"{PACKAGE}-{version_of(source)}.dist-info"
    metadata = (
        f"Metadata-Version: 2.4\nName: {PACKAGE}\nVersion: {version_of(source)}\n"
        f"Summary: LLVM as a shared library for Dr.Jit, taken from {source.package}\n"
        "License-Expression: Apache-2.0 WITH LLVM-exception\nLicense-File: LICENSE.txt\n"
    )
    tags = (
        "Wheel-Version: 1.0\nGenerator: lumenray\nRoot-Is-Purelib: false\n"
        f"Tag: py3-none-{source.tag}\n"
    )
    return {
        f"{PACKAGE}/__init__.py": loader.encode(),
        **dict(sorted(libraries.items())),
        f"{info}/licenses/LICENSE.txt": (FOLDER / "LICENSE.txt").read_bytes(),
        f"{info}/METADATA": metadata.encode(),
        f"{info}/WHEEL": tags.encode(),
    }


def without_symbols(library):
    """Return an ELF library without what follows all that is loaded, others as they are.

    There the symbols for the debugger lie, and the table of sections, which no loader reads. The tools that
    strip are not on every machine, and each version of them writes other bytes.
    """
    if library[:6] != b"\x7fELF\x02\x01":
        return library
    first, _ = struct.unpack_from("<QQ", library, 0x20)
    size, count = struct.unpack_from("<HH", library, 0x36)
    end = 0
    for number in range(count):
        kind, _, offset, _, _, length = struct.unpack_from(
            "<IIQQQQ", library, first + number * size
        )
        if kind == 1:
            end = max(end, offset + length)
    head = bytearray(library[:end])
    struct.pack_into("<Q", head, 0x28, 0)
    struct.pack_into("<HHH", head, 0x3A, 0, 0, 0)
    return bytes(head)


def main(arguments=None):
    """Make one wheel and print its path; return the exit status."""
    parser = argparse.ArgumentParser(description="Make the wheel that holds LLVM.")
    parser.add_argument("platform", choices=SOURCES)
    parser.add_argument("--output", type=Path, help="folder; default: the cache")
    options = parser.parse_args(arguments)
    try:
        print(make_wheel(options.platform, options.output))
    except BuildError as error:
        print(f"llvm_wheel: {error}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
