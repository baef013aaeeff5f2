"""Values as JSON text beside a block of arrays, and back. Nothing but the data named here passes, and no code with it.

A plain value stands for itself; anything else is a list that begins with its kind.
"""

import binascii
import inspect
import json
import math
from dataclasses import fields, is_dataclass
from enum import Enum

import numpy as np

from .. import light_mix, measurements, views
from ..accuracy import extremes, history, stopping
from ..analysis import explanation
from ..baking import lumel_sheet, mixed_maps, order
from ..cloth import surface as woven_surface
from ..daylight import coefficients
from ..errors import CodecError, LumenrayError
from ..ink import surface as print_surface
from ..paint import surface
from ..requirements import decision, plan
from ..scene import (
    camera,
    distribution,
    film,
    light,
    light_groups,
    material,
    mesh,
    modelling,
    provenance,
    ray_emission,
    relief,
    scattering,
    scene,
    sensor,
    spectrum,
    texture,
)
from ..transport import backend

SMALL = 64
"""Arrays of up to so many elements stand in the text."""

ALIGNMENT = 64
"""Arrays in a block begin at multiples of this. [byte]"""

DIMENSIONS = 16
"""No array has more."""

DTYPES = {
    kind.str: kind
    for kind in map(
        np.dtype,
        ("|b1", "|i1", "|u1", "<i2", "<u2", "<i4", "<u4", "<i8", "<u8", "<f2", "<f4", "<f8"),
    )
}
"""Kinds of numbers that arrays may hold."""

_MODULES = (
    camera, distribution, film, light, light_groups, material, mesh, modelling, provenance, ray_emission, relief, scattering,
    scene, sensor, spectrum, texture, light_mix, measurements, views, extremes, history, stopping, order, backend,
    coefficients, lumel_sheet, mixed_maps, decision, plan, explanation, surface, print_surface,
    woven_surface,
)  # fmt: skip


def _known(accept) -> dict[str, type]:
    """Classes that the modules define, by name."""
    found = {}
    for module in _MODULES:
        for name, kind in inspect.getmembers(module, inspect.isclass):
            own = kind.__module__ == module.__name__ and not name.startswith("_")
            if own and accept(kind) and kind is not scene.Scene:
                if name in found:
                    raise CodecError(f"two kinds of data have the name {name}")
                found[name] = kind
    return found


RECORDS = _known(is_dataclass)
"""Dataclasses that may be sent, by name."""

ENUMS = _known(lambda kind: issubclass(kind, Enum))
"""Enumerations that may be sent, by name."""

_FIELDS = {name: tuple(entry.name for entry in fields(kind)) for name, kind in RECORDS.items()}


def encode(value) -> tuple[object, list[tuple[int, np.ndarray]], int]:
    """Return the JSON tree of a value, the arrays that go into a block, by offset, and the block's size. [byte]

    Raises
    ------
    CodecError    The value holds something that cannot be sent.
    """
    writer = _Writer()
    try:
        return writer.write(value), writer.parts, writer.size
    except RecursionError as error:
        raise CodecError("a value is nested too deeply to be sent") from error


def decode(tree, block=b""):
    """Return the value of a JSON tree; its arrays are read-only and lie in the block, which they keep alive.

    Raises
    ------
    CodecError    The tree does not describe a value.
    """
    try:
        return _Reader(block).read(tree)
    except RecursionError as error:
        raise CodecError("a message is nested too deeply") from error


def to_text(tree) -> bytes:
    """Return the text of a JSON tree."""
    try:
        return json.dumps(tree, separators=(",", ":")).encode()
    except (ValueError, RecursionError) as error:
        raise CodecError(f"a message cannot be written: {error}") from error


def from_text(text: bytes):
    """Return the JSON tree of a text.

    Raises
    ------
    CodecError    It is not JSON.
    """
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:
        raise CodecError(f"a message cannot be read: {error}") from error


class _Writer:
    def __init__(self):
        self.parts: list[tuple[int, np.ndarray]] = []
        self.size = 0
        # The array is kept with its place: an id is only good while its owner lives.
        self._sent: dict[int, tuple[np.ndarray, list]] = {}

    def write(self, value):
        if isinstance(value, np.ndarray):
            return self._array(value)
        if isinstance(value, np.generic):
            return ["number", *_inline(_plain(np.asarray(value)))]
        if isinstance(value, Enum):
            if ENUMS.get(type(value).__name__) is not type(value):
                raise _unknown(value)
            return ["enum", type(value).__name__, value.name]
        if value is None or isinstance(value, bool | int | float | str):
            return value
        if isinstance(value, list):
            return ["list", *map(self.write, value)]
        if isinstance(value, tuple):
            return ["tuple", *map(self.write, value)]
        if isinstance(value, frozenset) and all(isinstance(entry, str) for entry in value):
            return ["names", *sorted(value)]
        if isinstance(value, dict):
            if not all(isinstance(key, str) for key in value):
                raise CodecError("a table has a key that is no text")
            return ["dict", {key: self.write(entry) for key, entry in value.items()}]
        name = type(value).__name__
        if RECORDS.get(name) is not type(value):
            raise _unknown(value)
        return ["record", name, {key: self.write(getattr(value, key)) for key in _FIELDS[name]}]

    def _array(self, array):
        if array.size <= SMALL:
            return ["array", *_inline(_plain(array))]
        known = self._sent.get(id(array))
        if known is None:
            plain = _plain(array)
            offset = -(-self.size // ALIGNMENT) * ALIGNMENT
            self.parts.append((offset, np.ascontiguousarray(plain)))
            self.size = offset + plain.nbytes
            known = (array, ["array", plain.dtype.str, list(plain.shape), offset])
            self._sent[id(array)] = known
        return known[1]


class _Reader:
    def __init__(self, block):
        self._block = memoryview(block)
        self._read: dict[tuple, np.ndarray] = {}

    def read(self, node):
        if node is None or isinstance(node, bool | int | float | str):
            return node
        if isinstance(node, list) and node and isinstance(node[0], str):
            # Looked up in the class: methods kept in the reader would keep it, and the block, alive.
            kind = _READERS.get(node[0])
            if kind is not None:
                return kind(self, node[1:])
        raise CodecError("a message holds something that is no value")

    def _list(self, rest):
        return [self.read(entry) for entry in rest]

    def _tuple(self, rest):
        return tuple(self.read(entry) for entry in rest)

    def _names(self, rest):
        if not all(isinstance(entry, str) for entry in rest):
            raise CodecError("a message holds a set of names with one that is no text")
        return frozenset(rest)

    def _dict(self, rest):
        (table,) = _expect(rest, dict)
        return {key: self.read(entry) for key, entry in table.items()}

    def _record(self, rest):
        name, values = _expect(rest, str, dict)
        kind = RECORDS.get(name)
        if kind is None:
            raise CodecError(f"a message holds an unknown kind of data: {name[:80]}")
        if set(values) != set(_FIELDS[name]):
            raise CodecError(f"a message holds a {name} with other fields than it has")
        arguments = {key: self.read(entry) for key, entry in values.items()}
        try:
            return kind(**arguments)
        except LumenrayError:
            raise
        except (TypeError, ValueError, ArithmeticError) as error:
            raise CodecError(f"a message holds a {name} that cannot be: {error}") from error

    def _enum(self, rest):
        name, member = _expect(rest, str, str)
        kind = ENUMS.get(name)
        if kind is None or member not in kind.__members__:
            raise CodecError(f"a message holds an unknown choice: {name[:80]}.{member[:80]}")
        return kind[member]

    def _array(self, rest):
        if len(rest) == 3 and isinstance(rest[2], str):
            return _from_inline(rest)
        name, sizes, offset = _expect(rest, str, list, int)
        kind, count = _shape(name, sizes)
        key = (name, tuple(sizes), offset)
        if key not in self._read:
            if offset < 0 or offset + count * kind.itemsize > len(self._block):
                raise CodecError("a message holds an array that reaches beyond its block")
            self._read[key] = _view(self._block, kind, count, offset, sizes)
        return self._read[key]

    def _number(self, rest):
        array = _from_inline(rest)
        if array.ndim != 0:
            raise CodecError("a message holds a number that is an array")
        return array[()]


_READERS = {
    "list": _Reader._list,
    "tuple": _Reader._tuple,
    "names": _Reader._names,
    "dict": _Reader._dict,
    "record": _Reader._record,
    "enum": _Reader._enum,
    "array": _Reader._array,
    "number": _Reader._number,
}


def _unknown(value) -> CodecError:
    return CodecError(f"a {type(value).__name__} cannot be sent between Blender and the engine")


def _expect(rest: list, *kinds: type) -> list:
    """Check number and types of what a value is made of."""
    fits = len(rest) == len(kinds) and all(
        isinstance(entry, kind) and not isinstance(entry, bool)
        for entry, kind in zip(rest, kinds, strict=True)
    )
    if not fits:
        raise CodecError("a message holds a value of the wrong make")
    return rest


def _shape(name: str, sizes: list) -> tuple[np.dtype, int]:
    """Check and return an array's kind of number and their count."""
    kind = DTYPES.get(name)
    if kind is None:
        raise CodecError(f"a message holds an array of unknown numbers: {name[:80]}")
    if len(sizes) > DIMENSIONS or not all(type(size) is int and size >= 0 for size in sizes):
        raise CodecError("a message holds an array of an impossible shape")
    # numpy counts in 64 bits, also what is multiplied by a side of length zero.
    if math.prod(max(size, 1) for size in sizes) * kind.itemsize >= 1 << 62:
        raise CodecError("a message holds an array of an impossible shape")
    return kind, math.prod(sizes)


def _plain(array: np.ndarray) -> np.ndarray:
    """Return an array in the byte order of the messages."""
    plain = np.asarray(array)
    plain = plain.astype(plain.dtype.newbyteorder("<"), copy=False)
    if plain.dtype.str not in DTYPES or plain.ndim > DIMENSIONS:
        raise CodecError(f"an array of {array.dtype} cannot be sent between Blender and the engine")
    return plain


def _inline(array: np.ndarray) -> list:
    text = binascii.b2a_base64(array.tobytes(), newline=False).decode()
    return [array.dtype.str, list(array.shape), text]


def _from_inline(rest: list) -> np.ndarray:
    name, sizes, text = _expect(rest, str, list, str)
    kind, count = _shape(name, sizes)
    try:
        data = binascii.a2b_base64(text)
    except ValueError as error:
        raise CodecError("a message holds a garbled array") from error
    if count > SMALL or len(data) != count * kind.itemsize:
        raise CodecError("a message holds an array that does not fill its shape")
    return _view(data, kind, count, 0, sizes)


def _view(data, kind: np.dtype, count: int, offset: int, sizes: list) -> np.ndarray:
    flat = np.frombuffer(data, kind, count, offset) if count else np.empty(0, kind)
    flat.flags.writeable = False
    return flat.reshape(sizes)
