"""Archives of arrays: bit by bit what was written, and nothing else that a file may claim."""

import io
import struct
import zipfile

import numpy as np
import pytest

from lumenray.engine.errors import FileFormatError, LumenrayError
from lumenray.engine.reading import array_archive
from lumenray.engine.reading.array_archive import (
    FACTS,
    ArrayArchive,
    Schema,
    refuse_damage,
    starts_archive,
    write_archive,
)

SCHEMA = Schema(("|b1", "|u1", "<i4", "<i8", "<f4", "<f8"), 1 << 20, 1000, 16)

UNPACKED = Schema(SCHEMA.kinds, None, 1000)

TABLE = {"name": "Büro 3", "samples": [4, 8], "half": "\ud800"}


def state_of(seed=0):
    """Arrays of every kind and awkward shapes."""
    rng = np.random.default_rng(seed)
    values = rng.normal(size=(7, 3))
    values[2, 1], values[3, 0], values[0, 0] = np.nan, -np.inf, -0.0
    return {
        "sums": values,
        "weights": rng.random(50).astype(np.float32),
        "mask": rng.random(33) < 0.5,
        "ids": rng.integers(-(2**62), 2**62, (2, 3, 4)),
        "none": np.empty((0, 5), dtype=np.float32),
        "single": np.array(2.5),
        "turned": np.arange(12.0).reshape(3, 4).T,
        "big endian": np.arange(5, dtype=">i4"),
    }


def assert_same(read, written):
    assert list(read) == list(written)
    for name, array in written.items():
        assert read[name].shape == array.shape
        assert read[name].dtype == array.dtype.newbyteorder("<")
        assert read[name].tobytes() == array.astype(read[name].dtype).tobytes()


def packed(arrays, facts=TABLE, schema=SCHEMA, level=0):
    content = io.BytesIO()
    write_archive(content, schema, facts, arrays, level)
    return content.getvalue()


def read(data, schema=SCHEMA):
    with refuse_damage("a.zip", "get it anew"):
        archive = ArrayArchive(io.BytesIO(data), schema)
        return archive.facts, archive.arrays()


@pytest.mark.parametrize("level", [0, 9])
def test_facts_and_arrays_come_back_bit_by_bit(level):
    data = packed(state_of(), level=level)
    assert starts_archive(data)
    assert data == packed(state_of(), level=level)
    facts, arrays = read(data)
    assert facts == TABLE
    assert_same(arrays, state_of())
    arrays["sums"][0] = 1.0
    with np.load(io.BytesIO(data), allow_pickle=False) as loaded:
        assert np.array_equal(loaded["turned"], state_of()["turned"])


def test_large_arrays_are_written_and_read_in_pieces(monkeypatch):
    monkeypatch.setattr(array_archive, "PIECE", 1000)
    values = {"lumels": np.random.default_rng(1).random((4321, 3))}
    assert_same(read(packed(values))[1], values)


@pytest.mark.parametrize("level", [0, 9])
def test_damage_is_told_or_makes_no_difference(level):
    whole = packed(state_of(), level=level)
    rng = np.random.default_rng(3)
    refused = 0
    for place in rng.integers(0, len(whole), 1500):
        broken = bytearray(whole)
        broken[place] ^= 1 << int(rng.integers(8))
        try:
            facts, arrays = read(bytes(broken))
        except FileFormatError as error:
            assert str(error).startswith("a.zip: ")
            refused += 1
        else:
            assert facts == TABLE
            # Dates and the like say nothing of what is read.
            assert_same(arrays, state_of())
    assert refused > 900
    for share in range(50):
        with pytest.raises(FileFormatError, match="get it anew"):
            read(whole[: len(whole) * share // 50])


def test_what_the_schema_has_no_place_for_is_neither_written_nor_read():
    many = {f"{i}": np.zeros(1) for i in range(17)}
    for arrays, facts, words in (
        ({"a": np.array([{}])}, {}, "array of object"),
        ({"a": np.zeros(2, np.float16)}, {}, "array of float16"),
        ({"a": np.zeros((1,) * 9)}, {}, "array of"),
        (many, {}, "17 arrays"),
        ({"a": np.zeros(1 << 18)}, {}, "MiB of arrays"),
        ({}, {"a": "x" * 1000}, "facts of"),
    ):
        with pytest.raises(LumenrayError, match=words):
            packed(arrays, facts)
    wide = Schema(("<f2", *SCHEMA.kinds), 1 << 30, 1 << 20, 99)
    for arrays, facts, words in (
        ({"a": np.zeros(2, np.float16)}, {}, "of 1 sides and float16"),
        (many, {}, "17 arrays"),
        ({"a": np.zeros(1 << 18)}, {}, "MiB of arrays"),
        ({}, {"a": "x" * 1000}, "facts of"),
    ):
        with pytest.raises(FileFormatError, match=words):
            read(packed(arrays, facts, wide, level=9))
    # What the file does not have itself is not believed where no limit is set.
    with pytest.raises(FileFormatError, match="more than the"):
        read(packed({"a": np.zeros(1 << 16)}, {}, wide, level=9), UNPACKED)


def forge(head=None, entries=(), packing=zipfile.ZIP_STORED, facts=b"{}"):
    """An archive with any head of its array ``a`` and other entries."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", packing) as archive:
        archive.writestr(FACTS, facts)
        if head is not None:
            text = head.ljust(117) + "\n"
            archive.writestr("a.npy", b"\x93NUMPY\1\0v\0" + text.encode() + bytes(64))
        for name, data in entries:
            archive.writestr(name, data)
    return content.getvalue()


@pytest.mark.parametrize(
    "head",
    [
        "{'descr': '<f8', 'fortran_order': False, 'shape': (1099511627776,)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (0, 140737488355328, 140737488355328)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (-2, -4)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (8.0,)}",
        "{'descr': '<f8', 'fortran_order': True, 'shape': (8,)}",
        "{'descr': '|O', 'fortran_order': False, 'shape': (8,)}",
        "{'descr': [('x', '<f8')], 'fortran_order': False, 'shape': (8,)}",
        "{'descr': '<f8', 'fortran_order': False, 'shape': (8,) + ()}",
        "(" * 100,
    ],
)
def test_heads_are_checked_before_memory_is_taken(head):
    with pytest.raises(FileFormatError, match="damaged"):
        read(forge(head))


def test_heads_of_numpy_are_taken():
    head = "{'descr': '<f8', 'fortran_order': False, 'shape': (8,), }"
    assert np.array_equal(read(forge(head))[1]["a"], np.zeros(8))


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"PK\x03\x04 and nothing else",
        forge(facts=b"[1]"),
        forge(facts=b"[" * 900),
        forge(facts=b"\xff"),
        forge(entries=[("b.npy", b"text")]),
        forge(packing=zipfile.ZIP_BZIP2),
        forge(packing=zipfile.ZIP_LZMA),
    ],
)
def test_other_contents_are_refused(data):
    with pytest.raises(FileFormatError, match="damaged"):
        read(data)


def test_a_bomb_does_not_fill_the_memory():
    bomb = forge(packing=zipfile.ZIP_DEFLATED, facts=b" " * (64 << 20))
    lying = bomb.replace(struct.pack("<I", 64 << 20), struct.pack("<I", 100))
    assert lying != bomb
    with pytest.raises(FileFormatError, match="damaged"):
        read(lying)


def test_entries_that_share_their_bytes_are_refused():
    whole = packed({f"{i}": np.arange(1000.0) for i in range(4)})
    directory = whole.rindex(b"PK\x05\x06")
    place = struct.unpack_from("<I", whole, directory + 16)[0]
    entries = []
    with zipfile.ZipFile(io.BytesIO(whole)) as archive:
        first = archive.getinfo("0.npy").header_offset
        for entry in archive.infolist():
            entries.append(bytearray(whole[place : place + 46 + len(entry.filename)]))
            place += len(entries[-1])
    for entry in entries[2:]:
        struct.pack_into("<I", entry, 42, first)
    kept = whole[: first + 9000]
    end = bytearray(whole[directory:])
    struct.pack_into("<I", end, 16, len(kept))
    with pytest.raises(FileFormatError, match="more than the"):
        read(kept + b"".join(entries) + bytes(end))
