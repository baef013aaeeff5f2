"""What is kept beside ray files: read back as it was, refused where it is out of date or damaged."""

import dataclasses
import os

import numpy as np
import pytest
from ray_files import zemax

from lumenray.benchmarks.common.ray_sources import disk, even_numbers
from lumenray.engine.errors import FileFormatError
from lumenray.engine.raysets import cloud, emission
from lumenray.engine.raysets.cloud import Fluctuation
from lumenray.engine.raysets.emission import Wish
from lumenray.engine.raysets.index import index_path, load_light, obtain_light, save_light

PLAIN = Wish()


@pytest.fixture(autouse=True, scope="module")
def _sooner():
    """Fewer rays tell intensities and moments, which do not matter here."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(emission, "GENERATED", 1 << 17)
        patch.setattr(emission, "PIECE", 1 << 17)
        patch.setattr(cloud, "MADE", 1 << 14)
        yield


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    path = tmp_path_factory.mktemp("rays") / "led.dat"
    position, direction = disk(even_numbers(1500, 1))
    path.write_bytes(zemax(np.column_stack([1e3 * position, direction, np.full(1500, 0.01)])))
    return path, obtain_light(path, is_kept=True)


def assert_same(one, other):
    for entry in dataclasses.fields(one):
        a, b = getattr(one, entry.name), getattr(other, entry.name)
        if dataclasses.is_dataclass(a):
            assert_same(a, b)
        elif isinstance(a, np.ndarray):
            assert a.dtype == b.dtype
            np.testing.assert_array_equal(a, b)
        else:
            assert a == b


def test_what_is_kept_comes_back_and_is_used(prepared):
    path, light = prepared
    assert_same(light, load_light(path, PLAIN))
    shares = []
    assert_same(light, obtain_light(path, progress=shares.append))
    assert not shares


def test_another_file_another_wish_or_another_seed_is_prepared_anew(prepared, tmp_path):
    path, light = prepared
    assert load_light(path, Wish(Fluctuation(0.1))) is None
    assert load_light(path, Wish(seed=1)) is None
    copy = tmp_path / "led.dat"
    copy.write_bytes(path.read_bytes())
    save_light(copy, light, PLAIN)
    assert load_light(copy, PLAIN) is not None
    os.utime(copy, ns=(1, 1))
    assert load_light(copy, PLAIN) is None


def test_a_damaged_index_is_told_and_replaced(prepared, tmp_path):
    path, _ = prepared
    copy = tmp_path / "led.dat"
    copy.write_bytes(path.read_bytes())
    index_path(copy).write_bytes(b"PK\x03\x04 and nothing else")
    with pytest.raises(FileFormatError, match="damaged"):
        load_light(copy, PLAIN)
    again = obtain_light(copy, is_kept=True)
    assert "prepared anew" in str(again.remarks[-1])
    assert load_light(copy, PLAIN) is not None


def test_mutated_indexes_are_refused_in_words_or_read(prepared, tmp_path):
    path, _ = prepared
    copy = tmp_path / "led.dat"
    copy.write_bytes(path.read_bytes())
    os.utime(copy, ns=(1, path.stat().st_mtime_ns))
    whole = index_path(path).read_bytes()
    rng = np.random.default_rng(1)
    outcomes = set()
    for _ in range(1000):
        data = bytearray(whole)
        for place in rng.integers(0, len(data) if rng.random() < 0.5 else 3000, rng.integers(1, 6)):
            data[place] = rng.integers(0, 256)
        if rng.random() < 0.2:
            data = data[: rng.integers(0, len(data))]
        index_path(copy).write_bytes(data)
        try:
            outcomes.add(load_light(copy, PLAIN) is not None)
        except FileFormatError:
            outcomes.add("refused")
    assert outcomes >= {True, "refused"}
