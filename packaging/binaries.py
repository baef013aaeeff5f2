"""What a native library asks of its system, read from its file: ELF, PE and Mach-O."""

import io
import re
import struct
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import pefile
from elftools.elf.elffile import ELFFile
from macholib.mach_o import CPU_TYPE_NAMES, LC_BUILD_VERSION, LC_ID_DYLIB, LC_VERSION_MIN_MACOSX
from macholib.MachO import MachO
from project import BuildError

ELF, PE, MACH_O = "ELF", "PE", "Mach-O"

FAT_MAGIC = b"\xca\xfe\xba\xbe"
"""Of several architectures in one file; it is Java's magic too."""

MACH_O_MAGICS = (b"\xcf\xfa\xed\xfe", FAT_MAGIC)
"""The first is 64-bit little endian."""

MOST_PARTS = 32
"""Architectures in one file. Java's files have their version in this place, which is larger."""

MOST_ENTRIES = 10_000
"""Rows of a table of an ELF library that are read, so that a broken one comes to an end."""

LONGEST_NAME = 128
"""Bytes of the name of a version, at most."""

MACHINES_OF_ELF = {"EM_X86_64": "x86_64", "EM_AARCH64": "arm64"}

MUTEX_CHANGE = (14, 40)
"""Mutexes made by this version of Visual C++ or a later one end the process in the hands of an older msvcp140.dll."""


@dataclass(frozen=True)
class Library:
    """A native library or program.

    Parameters
    ----------
    path : str    Where it lies in its wheel.
    kind : str    ELF, PE or Mach-O.
    machines : tuple of str    x86_64 or arm64.
    name : str    By which others ask for it.
    imports : tuple of str    Libraries that it asks for, by their last name.
    needs : dict    Oldest versions of what the system has: GLIBC, GLIBCXX, CXXABI, GCC, macOS, Windows, MSVCP140.
    """

    path: str
    kind: str
    machines: tuple
    name: str
    imports: tuple
    needs: dict = field(default_factory=dict)


def read_library(path: str, content: bytes) -> Library | None:
    """Read what a file asks for; None if it is no native library or program.

    Raises
    ------
    BuildError    It begins like one and cannot be read.
    """
    if content[:4] == b"\x7fELF":
        kind, read = ELF, _read_elf
    elif content[:2] == b"MZ":
        kind, read = PE, _read_pe
    elif content[:4] in MACH_O_MAGICS and not _is_of_java(content):
        kind, read = MACH_O, _read_mach_o
    else:
        return None
    try:
        return read(path, content)
    except Exception as error:
        # Each of the three packages that read has exceptions of its own, and lets others through.
        cause = str(error) or type(error).__name__
        raise BuildError(f"{path} begins like {kind} and cannot be read: {cause:.200}") from error


def _is_of_java(content: bytes) -> bool:
    return content[:4] == FAT_MAGIC and int.from_bytes(content[4:8], "big") > MOST_PARTS


def _read_elf(path: str, content: bytes) -> Library:
    """Read what is loaded, as the system does; a library may have lost its table of sections."""
    file = ELFFile(io.BytesIO(content))
    machine = MACHINES_OF_ELF.get(file["e_machine"], file["e_machine"])
    name, imports, needs = Path(path).name, [], {}
    segment = next(file.iter_segments("PT_DYNAMIC"), None)
    if segment is not None:
        rows = list(islice(segment.iter_tags(), MOST_ENTRIES))
        tags = {tag.entry.d_tag: tag.entry.d_val for tag in rows}
        for tag in rows:
            if tag.entry.d_tag == "DT_NEEDED":
                imports.append(tag.needed)
            elif tag.entry.d_tag == "DT_SONAME":
                name = tag.soname
        for version in islice(_versions_needed(file, tags, content), MOST_ENTRIES):
            matched = re.fullmatch(r"(GLIBC|GLIBCXX|CXXABI|GCC)_([\d.]+)", version)
            if matched:
                _raise_to(needs, matched[1], matched[2])
    return Library(path, ELF, (machine,), name, tuple(imports), needs)


def _versions_needed(file, tags: dict, content: bytes) -> Iterator[str]:
    """Read the names of the versions that a library asks others for."""
    if "DT_VERNEED" not in tags:
        return
    names = next(file.address_offsets(tags["DT_STRTAB"]))
    place = next(file.address_offsets(tags["DT_VERNEED"]))
    for _ in range(tags["DT_VERNEEDNUM"]):
        _, count, _, first, following = struct.unpack_from("<HHIII", content, place)
        entry = place + first
        for _ in range(count):
            _, _, _, text, step = struct.unpack_from("<IHHII", content, entry)
            start = names + text
            yield content[start : start + LONGEST_NAME].partition(b"\0")[0].decode()
            entry += step
        place += following


def _read_pe(path: str, content: bytes) -> Library:
    file = pefile.PE(data=content, fast_load=True)
    tables = ("IMAGE_DIRECTORY_ENTRY_IMPORT", "IMAGE_DIRECTORY_ENTRY_DELAY_IMPORT")
    file.parse_data_directories([pefile.DIRECTORY_ENTRY[each] for each in tables])
    imports = [
        row.dll.decode("ascii", "replace")
        for table in ("DIRECTORY_ENTRY_IMPORT", "DIRECTORY_ENTRY_DELAY_IMPORT")
        for row in getattr(file, table, [])
    ]
    machine = {0x8664: "x86_64", 0xAA64: "arm64", 0x14C: "x86"}.get(
        file.FILE_HEADER.Machine, "unknown"
    )
    head = file.OPTIONAL_HEADER
    needs = {"Windows": (head.MajorSubsystemVersion, head.MinorSubsystemVersion)}
    if _has_new_mutexes(file):
        needs["MSVCP140"] = MUTEX_CHANGE
    return Library(path, PE, (machine,), Path(path).name, tuple(imports), needs)


def _has_new_mutexes(file) -> bool:
    """Tell whether a library has mutexes locked by the C++ runtime that this runtime did not make."""
    head = file.OPTIONAL_HEADER
    used = [
        each.name or b""
        for row in getattr(file, "DIRECTORY_ENTRY_IMPORT", [])
        if row.dll.lower() == b"msvcp140.dll"
        for each in row.imports
    ]
    is_new = (head.MajorLinkerVersion, head.MinorLinkerVersion) >= MUTEX_CHANGE
    return any(b"Mtx_lock" in name for name in used) and (
        # Linkers other than Visual C++ tell no version; older headers always asked the runtime to make a mutex.
        is_new or not any(b"Mtx_init" in name for name in used)
    )


def _read_mach_o(path: str, content: bytes) -> Library:
    with tempfile.NamedTemporaryFile() as copy:
        copy.write(content)
        copy.flush()
        file = MachO(copy.name)
    machines, name, imports, needs = [], Path(path).name, [], {}
    for header in file.headers:
        machine = CPU_TYPE_NAMES.get(header.header.cputype, "unknown").lower()
        machines.append(machine)
        imports += [each for _, _, each in header.walkRelocatables()]
        for command, detail, data in header.commands:
            if command.cmd == LC_ID_DYLIB:
                name = data.rstrip(b"\0").decode().rpartition("/")[2]
            elif command.cmd in (LC_BUILD_VERSION, LC_VERSION_MIN_MACOSX) and machine == "arm64":
                packed = int(detail.minos if command.cmd == LC_BUILD_VERSION else detail.version)
                _raise_to(needs, "macOS", f"{packed >> 16}.{packed >> 8 & 255}")
    return Library(path, MACH_O, tuple(machines), name, tuple(dict.fromkeys(imports)), needs)


def _raise_to(needs: dict, what: str, version: str) -> None:
    needs[what] = max(needs.get(what, (0,)), tuple(map(int, version.split("."))))
