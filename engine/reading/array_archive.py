"""Named arrays and facts in a zip archive: ``facts.json``, and every array as ``<name>.npy``, without pickled objects.

NumPy's own ``numpy.load`` reads the arrays. What comes from a file is checked as if a stranger had written it: no size that
it claims is believed before the file is found to be as large, and archive and unpacking bear checksums.
"""

import io
import json
import math
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import BinaryIO

import numpy as np

from ..errors import FileFormatError, LumenrayError

FACTS = "facts.json"
"""Entry of the facts, the first one."""

MOST_SIDES = 8
"""Most dimensions of an array."""

PIECE = 1 << 24
"""What is read or written at once. [byte]"""

_NPY = ".npy"
_END = struct.Struct("<4s6xH10x")
"""Of the archive: a signature, and the number of entries."""
_PACKINGS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
_DAMAGE = (
    zipfile.BadZipFile, zlib.error, struct.error, ValueError, KeyError, IndexError, TypeError, AttributeError,
    OverflowError, NotImplementedError, RuntimeError, SyntaxError, EOFError, tokenize.TokenError,
)  # fmt: skip
"""What Python says of archives, texts and arrays that are not what they should be."""


@dataclass(frozen=True)
class Schema:
    """What an archive may hold.

    Parameters
    ----------
    kinds : tuple of str    Of numbers, as `numpy.dtype.str` names them.
    largest : int or None    Of all entries together, unpacked; None: no more than the file itself has. [byte]
    longest : int    Text of the facts. [byte]
    most : int    Arrays.
    """

    kinds: tuple[str, ...]
    largest: int | None
    longest: int
    most: int = 64


class TooLargeError(LumenrayError):
    """A schema has no room for it."""


def starts_archive(data: bytes) -> bool:
    """Whether a content may be an archive of arrays."""
    return data[:4] == b"PK\x03\x04" and FACTS.encode() in data[:64]


@contextmanager
def refuse_damage(path, advice: str) -> Iterator[None]:
    """Turn what Python says of an archive, and of facts and arrays that do not fit, into one sentence.

    Raises
    ------
    FileFormatError    With what is wrong, and ``advice``: what was expected, and what to do.
    """
    try:
        yield
    except TooLargeError as error:
        raise FileFormatError(path, str(error)) from None
    except _DAMAGE as error:
        raise FileFormatError(path, f"is damaged ({error}), {advice}") from None


def write_archive(
    file: BinaryIO, schema: Schema, facts: dict, arrays: dict[str, np.ndarray], level: int = 0
) -> None:
    """Write an archive; the same content makes the same bytes.

    Parameters
    ----------
    file : binary file
    schema : Schema
    facts : dict    What JSON can hold.
    arrays : dict of str to array    Written little-endian.
    level : int    Of packing, up to 9; 0: nothing is packed.

    Raises
    ------
    LumenrayError    The schema has no place for it.
    """
    text = json.dumps(facts, ensure_ascii=False).encode("utf-8", "surrogatepass")
    plain = {name: _plain(array) for name, array in arrays.items()}
    _check_size(schema, len(text), sum(array.nbytes for array in plain.values()), len(plain))
    for name, array in plain.items():
        if array.dtype.str not in schema.kinds or array.ndim > MOST_SIDES:
            raise LumenrayError(f"'{name}' is an array of {array.dtype}, which no file can keep")
    packing = zipfile.ZIP_DEFLATED if level else zipfile.ZIP_STORED
    with zipfile.ZipFile(file, "w", packing, compresslevel=level or None) as archive:
        with archive.open(FACTS, "w") as entry:
            entry.write(text)
        for name, array in plain.items():
            with archive.open(name + _NPY, "w", force_zip64=array.nbytes >= 1 << 30) as entry:
                head = np.lib.format.header_data_from_array_1_0(array)
                np.lib.format.write_array_header_1_0(entry, head)
                for piece in _pieces(array):
                    entry.write(piece)


class ArrayArchive:
    """An archive that is read: the facts at once, the arrays when they are asked for.

    Parameters
    ----------
    file : binary file    Open as long as arrays are read.
    schema : Schema

    Raises
    ------
    ValueError and others, which `refuse_damage` knows
        It is no archive, or not one of the schema.
    """

    def __init__(self, file: BinaryIO, schema: Schema):
        self._schema = schema
        self._archive = zipfile.ZipFile(file)
        entries = self._archive.infolist()
        size = file.seek(0, io.SEEK_END)
        # Python does not miss entries that damage hides.
        file.seek(size - _END.size)
        signature, count = _END.unpack(file.read(_END.size))
        if signature != b"PK\5\6" or count != len(entries):
            raise ValueError("not the entries that it was written with")
        if any(entry.compress_type not in _PACKINGS for entry in entries):
            raise ValueError("entries packed in an unusual way")
        if len({entry.filename for entry in entries}) < len(entries):
            raise ValueError("two entries of the same name")
        facts = self._archive.getinfo(FACTS)
        self._entries = {entry.filename.removesuffix(_NPY): entry for entry in entries}
        del self._entries[FACTS]
        unpacked = sum(entry.file_size for entry in entries)
        _check_size(schema, facts.file_size, unpacked, len(self._entries))
        packed = sum(entry.compress_size for entry in entries)
        if packed > size or (schema.largest is None and unpacked > size):
            raise ValueError(f"more than the {size} bytes that it has")
        # No more is read than the stated size, whatever is packed in it.
        self.facts = json.loads(self._archive.open(facts).read(facts.file_size))
        if not isinstance(self.facts, dict):
            raise TypeError("its facts are no table")

    def arrays(self) -> dict[str, np.ndarray]:
        """All arrays, in their order."""
        return {name: self._read_array(name, entry) for name, entry in self._entries.items()}

    def _read_array(self, name: str, entry: zipfile.ZipInfo) -> np.ndarray:
        with self._archive.open(entry) as packed:
            if np.lib.format.read_magic(packed) != (1, 0):
                raise ValueError(f"array '{name}' is of an unknown version")
            shape, is_fortran, kind = np.lib.format.read_array_header_1_0(packed)
            size, left = math.prod(shape) * kind.itemsize, entry.file_size - packed.tell()
            if is_fortran or kind.str not in self._schema.kinds or len(shape) > MOST_SIDES:
                raise ValueError(f"array '{name}' is of {len(shape)} sides and {kind}")
            if size != left:
                raise ValueError(f"array '{name}' of {left} bytes does not have the shape {shape}")
            array = np.empty(shape, kind)
            for piece in _pieces(array):
                if packed.readinto(piece) != len(piece):
                    raise EOFError(f"array '{name}' is cut short")
        return array


def _check_size(schema: Schema, text: int, size: int, count: int) -> None:
    """Refuse facts, arrays and numbers of arrays that are larger than the schema allows."""
    what = None
    if text > schema.longest:
        what = f"facts of {text} bytes, expected at most {schema.longest}"
    elif count > schema.most:
        what = f"{count} arrays, expected at most {schema.most}"
    elif schema.largest is not None and size > schema.largest:
        what = f"{size >> 20} MiB of arrays, expected at most {schema.largest >> 20}"
    if what is not None:
        raise TooLargeError(f"too large a file: {what}")


def _plain(array) -> np.ndarray:
    """An array as it stands in the file: little-endian, the last index the fastest."""
    array = np.asarray(array)
    return array.astype(array.dtype.newbyteorder("<"), order="C", copy=False)


def _pieces(array: np.ndarray) -> Iterator[memoryview]:
    """Bytes of an array, to be read or filled, piece by piece."""
    data = array.reshape(-1).view(np.uint8)
    for first in range(0, len(data), PIECE):
        yield data[first : first + PIECE].data
