import json
import os
import struct
import subprocess
import sys
import zlib
from dataclasses import dataclass, replace

import numpy as np
import pytest
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.errors import FileFormatError
from lumenray.engine.formats.checkpoint import (
    MAGIC,
    PREFIX,
    digest,
    read_checkpoint,
    write_checkpoint,
)

FACTS = {"scene": "5c", "order": "0d", "samples": [4, 8], "name": "Büro 3"}


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
        assert (
            read[name].tobytes() == np.ascontiguousarray(array).astype(read[name].dtype).tobytes()
        )


def test_state_and_facts_come_back_bit_by_bit(tmp_path):
    path = write_checkpoint(tmp_path / "new" / "bake.checkpoint", state_of(), FACTS)
    state, facts = read_checkpoint(path, scene="5c", order="0d")
    assert_same(state, state_of())
    assert {name: facts[name] for name in FACTS} == FACTS
    state["sums"][0] = 1.0
    assert [entry.name for entry in path.parent.iterdir()] == ["bake.checkpoint"]


def test_large_arrays_are_read_in_pieces(tmp_path, monkeypatch):
    monkeypatch.setattr("lumenray.engine.formats.checkpoint.PIECE", 1000)
    values = {"lumels": np.random.default_rng(1).random((4321, 3))}
    state, _ = read_checkpoint(write_checkpoint(tmp_path / "a", values, {}))
    assert_same(state, values)


def test_a_cut_file_is_told_from_a_foreign_one(tmp_path):
    path = write_checkpoint(tmp_path / "a", state_of(), FACTS)
    whole = path.read_bytes()
    for share in range(1, 50):
        path.write_bytes(whole[: len(whole) * share // 50])
        with pytest.raises(FileFormatError, match="ends too early"):
            read_checkpoint(path)
    for foreign in (b"", b"PK\x03\x04 an archive", b"\x93NUMPY\x01\x00v\x00{'descr': '|O'"):
        path.write_bytes(foreign)
        with pytest.raises(FileFormatError, match="no checkpoint"):
            read_checkpoint(path)
    path.write_bytes(whole + b"\0")
    with pytest.raises(FileFormatError, match="damaged"):
        read_checkpoint(path)
    with pytest.raises(FileFormatError, match="cannot be opened"):
        read_checkpoint(tmp_path / "nowhere")
    with pytest.raises(FileFormatError, match="is a folder"):
        read_checkpoint(tmp_path)


def test_no_flipped_bit_goes_unseen(tmp_path):
    path = write_checkpoint(tmp_path / "a", state_of(), FACTS)
    whole = path.read_bytes()
    rng = np.random.default_rng(3)
    places = {*range(len(MAGIC) + PREFIX.size + 40), *rng.integers(0, len(whole), 600).tolist()}
    for place in places:
        broken = bytearray(whole)
        broken[place] ^= 1 << int(rng.integers(8))
        path.write_bytes(broken)
        with pytest.raises(FileFormatError):
            read_checkpoint(path)


def forge(path, table, data=b"", facts=None):
    """Write a file whose checksums are right and whose claims are not."""
    from lumenray.engine import VERSION

    header = json.dumps({"facts": facts or {"engine": VERSION}, "arrays": table}).encode()
    path.write_bytes(MAGIC + PREFIX.pack(len(header), zlib.crc32(header), 0) + header + data)
    return path


@pytest.mark.parametrize(
    "table",
    [
        [["a", "<f8", [1 << 40], 0, 0]],
        [["a", "<f8", [1 << 47, 1 << 47, 1 << 47], 0, 0]],
        [["a", "<f8", [0, 1 << 47, 1 << 47], 0, 0]],
        [["a", "<f8", [-1], 0, 0]],
        [["a", "<f8", [1.0], 0, 0]],
        [["a", "<f8", [True], 0, 0]],
        [["a", "|O", [1], 0, 0]],
        [["a", ["<f8"], [1], 0, 0]],
        [["a", "<f8", [1], 8, 0]],
        [["a", "<f8", [1] * 40, 0, 0]],
        [["a", "<f8", [0], 0, 0], ["a", "<f8", [0], 0, 0]],
        [["a", "<f8", [1], 0]],
        ["a"],
        [[f"{i}", "<f8", [0], 0, 0] for i in range(5000)],
        {"a": 1},
    ],
)
def test_claims_are_checked_before_memory_is_taken(tmp_path, table):
    with pytest.raises(FileFormatError, match=r"damaged|too early"):
        read_checkpoint(forge(tmp_path / "a", table))


def test_a_header_that_claims_to_be_huge_is_refused(tmp_path):
    path = tmp_path / "a"
    path.write_bytes(MAGIC + struct.pack("<QII", 1 << 62, 0, 0) + b"{}")
    with pytest.raises(FileFormatError, match="damaged"):
        read_checkpoint(path)
    deep = b"[" * 100_000
    path.write_bytes(MAGIC + PREFIX.pack(len(deep), zlib.crc32(deep), 0) + deep)
    with pytest.raises(FileFormatError, match="damaged"):
        read_checkpoint(path)


def test_another_scene_order_or_version_is_named(tmp_path):
    path = write_checkpoint(tmp_path / "a", state_of(), FACTS)
    with pytest.raises(FileFormatError, match="another state of the scene"):
        read_checkpoint(path, scene="99")
    with pytest.raises(FileFormatError, match="other settings"):
        read_checkpoint(path, scene="5c", order="99")
    path.write_bytes(path.read_bytes().replace(b"checkpoint 3", b"checkpoint 2"))
    with pytest.raises(FileFormatError, match="another version"):
        read_checkpoint(path)
    with pytest.raises(FileFormatError, match=r"another version of Lumenray \(0\.0\.1"):
        read_checkpoint(forge(tmp_path / "b", [], facts={"engine": "0.0.1"}))


def test_a_failed_write_leaves_the_old_file(tmp_path):
    path = write_checkpoint(tmp_path / "a", state_of(), FACTS)
    before = path.read_bytes()
    with pytest.raises(FileFormatError, match="array of object"):
        write_checkpoint(path, {"a": np.array([{}])}, {})
    # Writing the part fails where its name is taken by a folder.
    (tmp_path / "a.part").mkdir()
    with pytest.raises(FileFormatError, match="cannot be written"):
        write_checkpoint(path, {"a": np.zeros(3)}, {})
    assert path.read_bytes() == before


@dataclass(frozen=True)
class Place:
    frame: np.ndarray


def test_digests_tell_orders_apart_and_ignore_what_makes_no_difference():
    order = BakeOrder(("a", "b"), StopRule(error=0.01), densities={"a": 4.0, "b": 2.0})
    other = replace(order, densities={"b": 2.0, "a": 4.0}, folder="elsewhere", density=8)
    assert digest(order, without=("folder",)) == digest(other, without=("folder",))
    changes = (
        {"objects": ("ab",)},
        {"objects": ("b", "a")},
        {"seed": 1},
        {"density": 8.5},
        {"rule": StopRule(error=0.02)},
        {"densities": {"a": 4.0}},
        {"two_sided": ("a",)},
    )
    digests = {digest(order), *(digest(replace(order, **change)) for change in changes)}
    assert len(digests) == len(changes) + 1
    assert digest(Place(np.eye(3))) != digest(Place(np.eye(3).reshape(9)))
    with pytest.raises(TypeError):
        digest({"a": object()})


def test_digests_are_the_same_in_another_process():
    code = (
        "from lumenray.engine.formats.checkpoint import digest;"
        "print(digest({'b': {1.5, }.pop(), 'a': ('x', None, True)}))"
    )
    seeds = [{**os.environ, "PYTHONHASHSEED": str(seed)} for seed in (1, 2)]
    made = {
        subprocess.run(
            [sys.executable, "-c", code], env=env, capture_output=True, check=True
        ).stdout
        for env in seeds
    }
    assert made == {f"{digest({'a': ('x', None, True), 'b': 1.5})}\n".encode()}
