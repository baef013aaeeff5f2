"""The benchmark of isolux lines and sliders: its figures are what they are called."""

import numpy as np
import pytest

from lumenray.benchmarks.judgement import isolux


def test_lines_are_compared_with_the_exact_circles(monkeypatch):
    assert isolux.measure_lines() < 0.1

    def shifted(x, y, field, levels):
        return [
            (level, [path + np.array([0.0, isolux.LUMEL]) for path in paths])
            for level, paths in find(x, y, field, levels)
        ]

    find = isolux.find_contours
    monkeypatch.setattr(isolux, "find_contours", shifted)
    assert isolux.measure_lines() == pytest.approx(1.0, abs=0.1)


def test_a_slider_takes_time():
    assert 0.0 < isolux.measure_slider(groups=3, lumels=10_000, moves=4) < 1.0
