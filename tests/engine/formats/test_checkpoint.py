import os
import subprocess
import sys
from dataclasses import dataclass, replace

import numpy as np
import pytest

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.baking.order import BakeOrder
from lumenray.engine.errors import FileFormatError
from lumenray.engine.formats import checkpoint
from lumenray.engine.formats.checkpoint import digest, read_checkpoint, write_checkpoint

FACTS = {"scene": "5c", "order": "0d", "samples": [4, 8], "name": "Büro 3"}

STATE = {"0.sums": np.array([[np.nan, -0.0], [1.0, np.inf]]), "0.state": np.array([3, 1])}


def test_state_and_facts_come_back_bit_by_bit(tmp_path):
    path = write_checkpoint(tmp_path / "new" / "bake.checkpoint", STATE, FACTS)
    state, facts = read_checkpoint(path, scene="5c", order="0d")
    assert {name: array.tobytes() for name, array in state.items()} == {
        name: array.tobytes() for name, array in STATE.items()
    }
    assert {name: facts[name] for name in FACTS} == FACTS
    assert [entry.name for entry in path.parent.iterdir()] == ["bake.checkpoint"]


def test_a_damaged_file_is_told_from_a_foreign_one(tmp_path):
    path = write_checkpoint(tmp_path / "a", STATE, FACTS)
    whole = path.read_bytes()
    for broken in (
        whole[:-100],
        whole[:200],
        whole + b"\0",
        whole.replace(b"0.sums", b"0.sumz", 1),
    ):
        path.write_bytes(broken)
        with pytest.raises(FileFormatError, match=r"damaged .* delete it and start anew"):
            read_checkpoint(path)
    with (tmp_path / "b").open("wb") as file:
        checkpoint.write_archive(file, checkpoint.SCHEMA, {"version": 1}, {})
    foreign = (b"", b"PK\x03\x04 an archive", b"\x93NUMPY\x01\x00v\x00{'descr': '|O'")
    for content in (*foreign, (tmp_path / "b").read_bytes()):
        path.write_bytes(content)
        with pytest.raises(FileFormatError, match="no checkpoint"):
            read_checkpoint(path)
    with pytest.raises(FileFormatError, match="cannot be opened"):
        read_checkpoint(tmp_path / "nowhere")
    with pytest.raises(FileFormatError, match="is a folder"):
        read_checkpoint(tmp_path)


def test_another_scene_order_or_version_is_named(tmp_path, monkeypatch):
    path = write_checkpoint(tmp_path / "a", STATE, FACTS)
    with pytest.raises(FileFormatError, match="another state of the scene"):
        read_checkpoint(path, scene="99")
    with pytest.raises(FileFormatError, match="other settings"):
        read_checkpoint(path, scene="5c", order="99")
    monkeypatch.setattr(checkpoint, "VERSION", "0.0.1")
    old = write_checkpoint(tmp_path / "b", STATE, FACTS)
    monkeypatch.undo()
    with pytest.raises(FileFormatError, match=r"another version of Lumenray \(0\.0\.1"):
        read_checkpoint(old)
    old.write_bytes(b"Lumenray checkpoint 3\n" + bytes(100))
    with pytest.raises(FileFormatError, match="another version of Lumenray: delete it"):
        read_checkpoint(old)


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
