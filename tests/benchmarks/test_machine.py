"""The machine of a benchmark: whether its pace can be foretold."""

import numpy as np
import pytest


def test_steady_work_is_foretold_and_work_that_slows_down_is_not():
    from lumenray.benchmarks.common.machine import foretell

    even = np.arange(400) * 0.1
    assert foretell(even.tolist(), 0.1) == pytest.approx(0.0, abs=1e-9)
    # Twice as slow in every second stretch of 25 pieces: the first tenth of 200 sees but one kind.
    steps = np.where(np.arange(400) // 25 % 2 == 0, 0.1, 0.2)
    assert 0.1 < foretell(np.cumsum(steps).tolist(), 0.1) < 0.4
