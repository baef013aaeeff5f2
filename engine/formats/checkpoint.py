"""State of an interrupted job in an archive of arrays (`reading.array_archive`), and fingerprints of scenes and orders."""

import dataclasses
import hashlib
from enum import Enum
from pathlib import Path

import numpy as np

from .. import VERSION
from ..errors import FileFormatError
from ..reading.array_archive import (
    ArrayArchive,
    Schema,
    refuse_damage,
    starts_archive,
    write_archive,
)
from ..reading.content import open_file
from ..reading.whole_file import write_whole

OLDER = b"Lumenray checkpoint "
"""What files of versions before the archive begin with."""

SCHEMA = Schema(
    ("|b1", "|i1", "|u1", "<i2", "<u2", "<i4", "<u4", "<i8", "<u8", "<f2", "<f4", "<f8"),
    largest=None,
    longest=1 << 24,
    most=4096,
)

WHOSE = {
    "engine": "another version of Lumenray ({found}; this is {wanted})",
    "scene": "another state of the scene",
    "order": "a bake with other settings",
}
"""Facts that must agree, and what a file comes from where they do not."""


TABLES = {"scene": "items", "order": "settings"}
"""Facts whose parts are known by name."""

MOST_NAMES = 4
"""Parts that are named where many differ."""


def write_checkpoint(path, state: dict[str, np.ndarray], facts: dict) -> Path:
    """Write arrays and facts; a file that was there before stays whole until the new one is.

    Parameters
    ----------
    path : str or Path
    state : dict of str to array    Numbers or truth values.
    facts : dict
        What JSON can hold (tuples come back as lists). ``scene`` and ``order`` are digests that `read_checkpoint` compares;
        ``engine`` is added.

    Raises
    ------
    FileFormatError    It cannot be written; nothing is left behind.
    """
    with write_whole(path, is_synced=True) as file:
        write_archive(file, SCHEMA, {**facts, "engine": VERSION}, state)
    return Path(path)


def read_checkpoint(
    path, scene: str | None = None, order: str | None = None, wanted: dict | None = None
) -> tuple[dict[str, np.ndarray], dict]:
    """Read arrays and facts.

    Parameters
    ----------
    path : str or Path
    scene, order : str or None    Digests that the file's facts must have; None: any.
    wanted : dict or None    Facts as of `write_checkpoint`, with which a refusal says what differs: tables of digests by
        name, ``items`` of the scene and ``settings`` of the order.

    Returns
    -------
    dict of str to array, dict    State and facts, bit by bit what was written.

    Raises
    ------
    FileFormatError    No checkpoint, damaged, or of another version, scene or order.
    """
    path = Path(path)
    try:
        with open_file(path) as file, refuse_damage(path, "delete it and start anew"):
            head = file.read(64)
            if head.startswith(OLDER):
                raise FileFormatError(
                    path,
                    "the checkpoint is of another version of Lumenray: delete it and start anew",
                )
            if not starts_archive(head):
                raise FileFormatError(path, "this is no checkpoint of Lumenray")
            archive = ArrayArchive(file, SCHEMA)
            if "engine" not in archive.facts:
                raise FileFormatError(path, "this is no checkpoint of Lumenray")
            digests = {"engine": VERSION, "order": order, "scene": scene}
            _compare(path, archive.facts, digests, wanted or {})
            return archive.arrays(), archive.facts
    except OSError as error:
        raise FileFormatError(path, f"cannot be read ({error.strerror or error})") from None
    except MemoryError:
        raise FileFormatError(path, "the checkpoint is larger than this machine's memory") from None


def digest(value, without: tuple[str, ...] = ()) -> str:
    """Fingerprint of plain data: dataclasses, tables with names, sequences, arrays, texts and numbers.

    Parameters
    ----------
    value
    without : tuple of str    Fields of ``value`` itself, or names of the table that it is, that make no difference.

    Returns
    -------
    str    64 hexadecimal digits; the same in every process and on every machine.

    Raises
    ------
    TypeError    It holds something else.
    """
    if dataclasses.is_dataclass(value):
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    if isinstance(value, dict):
        value = {name: entry for name, entry in value.items() if name not in without}
    sum_ = hashlib.sha256()
    _feed(sum_, value)
    return sum_.hexdigest()


def _feed(sum_, value) -> None:
    """Put a value into a fingerprint; every kind with its name and length, so that no two values read alike."""
    if dataclasses.is_dataclass(value):
        sum_.update(type(value).__name__.encode() + b"\0")
        value = {field.name: getattr(value, field.name) for field in dataclasses.fields(value)}
    if isinstance(value, Enum):
        value = value.name
    if isinstance(value, dict):
        sum_.update(b"table %d\0" % len(value))
        for name in sorted(value):
            _feed(sum_, name)
            _feed(sum_, value[name])
    elif isinstance(value, list | tuple):
        sum_.update(b"sequence %d\0" % len(value))
        for entry in value:
            _feed(sum_, entry)
    elif isinstance(value, np.ndarray):
        array = np.ascontiguousarray(value)
        array = array.astype(array.dtype.newbyteorder("<"), copy=False)
        sum_.update(f"array {array.dtype.str} {value.shape}\0".encode() + array.tobytes())
    elif value is None or isinstance(value, bool | int | float | str | np.generic):
        plain = value.item() if isinstance(value, np.generic) else value
        # A whole number is the same setting whether it was typed as 8 or as 8.0.
        is_whole = isinstance(plain, float) and plain.is_integer()
        text = repr(int(plain) if is_whole else plain)
        sum_.update(f"{len(text)} {text}\0".encode("utf-8", "surrogatepass"))
    else:
        raise TypeError(f"a {type(value).__name__} has no fingerprint")


def _compare(path: Path, facts: dict, digests: dict, wanted: dict) -> None:
    """Refuse a file of another version, scene or order."""
    for name, value in digests.items():
        if value is not None and facts.get(name) != value:
            whose = WHOSE[name].format(found=str(facts.get(name))[:40], wanted=value)
            table = TABLES.get(name)
            what = _differences(facts.get(table), wanted.get(table))
            raise FileFormatError(
                path, f"the checkpoint comes from {whose}{what}: delete it or name another file"
            )


def _differences(found, wanted) -> str:
    """Names by which two tables differ, in brackets; nothing where they are not known."""
    if not isinstance(found, dict) or not isinstance(wanted, dict) or not found or not wanted:
        return ""
    names = [name for name in {**found, **wanted} if found.get(name) != wanted.get(name)]
    if not names:
        return ""
    more = f" and {len(names) - MOST_NAMES} others" if len(names) > MOST_NAMES else ""
    return f" ({', '.join(str(name)[:60] for name in names[:MOST_NAMES])}{more})"
