"""Values as single strings of bytes, in the codec of the engine's worker: nothing that is unpacked can run."""

import struct

from ..errors import CodecError
from ..worker import codec

_HEAD = struct.Struct("<8sQQ")

_MARK = b"lumenray"


def pack(value) -> bytes:
    """Return a value as bytes.

    Raises
    ------
    CodecError    It holds something that cannot be sent.
    """
    tree, parts, size = codec.encode(value)
    text = codec.to_text(tree)
    packed = bytearray(_HEAD.size + len(text) + size)
    packed[: _HEAD.size] = _HEAD.pack(_MARK, len(text), size)
    packed[_HEAD.size : _HEAD.size + len(text)] = text
    start = _HEAD.size + len(text)
    for offset, array in parts:
        first = start + offset
        packed[first : first + array.nbytes] = array.reshape(-1).view("u1").data
    return bytes(packed)


def unpack(data: bytes):
    """Return the value that `pack` packed; its arrays are read-only.

    Raises
    ------
    CodecError    The bytes are no parcel.
    """
    if len(data) < _HEAD.size:
        raise CodecError(f"a parcel has {len(data)} bytes, expected {_HEAD.size} at least")
    mark, length, size = _HEAD.unpack_from(data)
    if mark != _MARK or len(data) != _HEAD.size + length + size:
        raise CodecError(f"a parcel of {len(data)} bytes is damaged")
    tree = codec.from_text(data[_HEAD.size : _HEAD.size + length])
    # Numbers in memory begin where their kind has them begin; the text before may have any length.
    block = memoryview(bytearray(data[_HEAD.size + length :])).toreadonly()
    return codec.decode(tree, block)
