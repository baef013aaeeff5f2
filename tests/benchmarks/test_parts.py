"""Parts of benchmarks: which are measured, and what is kept of an earlier run."""

import pytest

from lumenray.benchmarks.common.parts import measure_parts
from lumenray.engine.errors import LumenrayError

MEASURES = {name: lambda say, name=name: f"new {name}" for name in ("a", "b", "c")}


def measure(parts=None, earlier=None):
    return measure_parts(MEASURES, parts, earlier, say=None)


def test_all_are_measured_or_those_that_are_asked_for():
    assert measure() == {"a": "new a", "b": "new b", "c": "new c"}
    assert measure(["b"]) == {"b": "new b"}


def test_what_an_earlier_run_has_is_kept_unless_it_is_named():
    earlier = {"parts": {"a": "old a", "b": "old b"}}
    assert measure(None, earlier) == {"a": "old a", "b": "old b", "c": "new c"}
    assert measure(["b"], earlier) == {"a": "old a", "b": "new b"}


def test_a_part_that_is_not_there_is_refused_with_those_that_are():
    with pytest.raises(LumenrayError, match="no part d; choose from a, b, c"):
        measure(["a", "d"])
