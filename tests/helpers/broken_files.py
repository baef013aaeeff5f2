"""Scenes that are damaged or made to do harm: .blend files block by block, binary glTF files by document and bytes."""

import json
import struct
import zlib
from dataclasses import dataclass, replace

import numpy as np
import zstandard
from mutations import damage, mutate

LIMITS = (0, 1, 7, 1 << 10, 1 << 20, 0x7FFFFFFF, 0xFFFFFFFF)
"""What lengths and counts of blocks become."""

CODES = (b"DATA", b"OB\0\0", b"ME\0\0", b"GLOB", b"LI\0\0", b"ENDB", b"\xff\xff\xff\xff")
"""What blocks are called instead."""

PIECE = bytes(1 << 20)


@dataclass(frozen=True)
class Block:
    """A block of a .blend file, as Blender 5 (files of version 1) writes it.

    Parameters
    ----------
    code : bytes    What it is.
    kind : int    Number of its structure.
    address : int    Where it was in memory.
    count : int    Of structures.
    content : bytes
    length : int or None    As stated; None: the true one.
    """

    code: bytes
    kind: int
    address: int
    count: int
    content: bytes
    length: int | None = None

    def head(self, length=None):
        """Its first bytes."""
        told = self.length if length is None else length
        told = len(self.content) if told is None else told
        return struct.pack("<4siQqq", self.code, self.kind, self.address, told, self.count)


def read_blend(data):
    """The head and the blocks of a compressed .blend file."""
    data = zstandard.ZstdDecompressor().stream_reader(data, read_across_frames=True).read()
    size = int(data[7:9])
    blocks, at = [], size
    while at < len(data):
        code, kind, address, length, count = struct.unpack_from("<4siQqq", data, at)
        at += 32
        blocks.append(Block(code, kind, address, count, data[at : at + length]))
        at += length
    return data[:size], blocks


def write_blend(head, blocks):
    """The file of them, not compressed."""
    return head + b"".join(block.head() + block.content for block in blocks)


def break_blend(data, rng):
    """A .blend file with one to three blocks damaged, sometimes cut short."""
    head, blocks = read_blend(data)
    for _ in range(rng.integers(1, 4)):
        at = int(rng.integers(len(blocks)))
        blocks[at : at + 1] = _DAMAGES[rng.integers(len(_DAMAGES))](blocks[at], rng)
    made = write_blend(head, blocks)
    return made[: int(rng.integers(len(made)))] if rng.integers(8) == 0 else made


def _flip_bytes(block, rng):
    if not block.content:
        return [block]
    content = np.frombuffer(block.content, np.uint8).copy()
    at = rng.integers(len(content), size=min(len(content), int(rng.integers(1, 40))))
    content[at] = rng.integers(256, size=len(at))
    return [replace(block, content=content.tobytes())]


def _lie_about_length(block, rng):
    return [replace(block, length=int(rng.choice(LIMITS)))]


def _lie_about_count(block, rng):
    return [replace(block, count=int(rng.choice(LIMITS)))]


def _lie_about_kind(block, rng):
    return [replace(block, kind=int(rng.choice([-1, 0, 5, 400, 0x7FFFFFFF])))]


def _lie_about_code(block, rng):
    return [replace(block, code=CODES[rng.integers(len(CODES))])]


def _lie_about_address(block, rng):
    return [replace(block, address=int(rng.choice([0, 1, block.address + 8])))]


def _shorten(block, rng):
    return [replace(block, content=block.content[: int(rng.integers(len(block.content) + 1))])]


def _leave_out(*_):
    return []


def _double(block, _):
    return [block, block]


_DAMAGES = [
    *[_flip_bytes] * 4,
    *(_lie_about_length, _lie_about_count, _lie_about_kind, _lie_about_code, _lie_about_address),
    *(_shorten, _leave_out, _double),
]


def glb(document, binary=b""):
    """A binary glTF file of a document, which may be bytes that are no JSON."""
    text = document if isinstance(document, bytes) else json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text
    chunks += struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks


def break_glb(data, rng):
    """A binary glTF file with its document damaged, its bytes, or what holds both."""
    length = struct.unpack_from("<I", data, 12)[0]
    document, binary = data[20 : 20 + length], data[28 + length :]
    kind = rng.integers(6)
    if kind < 4:
        # Numbers mostly: indices, counts, offsets.
        lines = json.dumps(json.loads(document), indent=0).encode()
        return glb(damage(lines, rng), binary)
    return glb(document, mutate(binary, rng)) if kind == 4 else mutate(data, rng)


def blend_bomb(data, blocks, pieces, compress):
    """A .blend file of few bytes that holds, behind its first scene, so many blocks of so many pieces of 1 MiB of zeros."""
    head, found = read_blend(data)
    at = next(i for i, block in enumerate(found) if block.code == b"SC\0\0") + 1
    yield from compress(_bomb(head, found, at, blocks, pieces))


def _bomb(head, found, at, blocks, pieces):
    yield write_blend(head, found[:at])
    for number in range(blocks):
        yield Block(b"DATA", 0, 0x7000_0000_0000 + number, 1, b"").head(pieces * len(PIECE))
        for _ in range(pieces):
            yield PIECE
    yield write_blend(b"", found[at:])


def by_zstandard(parts):
    """Compressed as Blender does since 3.0."""
    packer = zstandard.ZstdCompressor(level=1).compressobj()
    for part in parts:
        yield packer.compress(part)
    yield packer.flush()


def by_gzip(parts):
    """Compressed as Blender did before."""
    packer = zlib.compressobj(level=1, wbits=31)
    for part in parts:
        yield packer.compress(part)
    yield packer.flush()


def png_bomb(side):
    """A picture of few bytes that has so many pixels on each side, all black."""

    def chunk(kind, content):
        return (
            struct.pack(">I", len(content))
            + kind
            + content
            + struct.pack(">I", zlib.crc32(kind + content))
        )

    packer = zlib.compressobj(level=9)
    row = bytes(1 + (side + 7) // 8)
    rows = b"".join(packer.compress(row) for _ in range(side)) + packer.flush()
    head = struct.pack(">IIBBBBB", side, side, 1, 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", rows) + chunk(b"IEND", b"")
