"""Reference values of paints, by id: what they are and how they were found stands in docs/benchmarks/paint.md."""

import json
from functools import lru_cache
from pathlib import Path

import numpy as np


@lru_cache
def entries() -> dict[str, dict]:
    """Entries with ``value``, and ``tolerance`` or, of Monte Carlo, ``error``, by id."""
    return json.loads(Path(__file__).with_name("reference.json").read_text(encoding="utf-8"))


def value(name: str) -> np.ndarray:
    """Value or values of an id."""
    return np.array(entries()[name]["value"])
