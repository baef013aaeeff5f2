"""The benchmark of denoised pictures: its errors, its demands and its document, from pictures that are known."""

import numpy as np
import pytest

from lumenray.benchmarks.denoising import run
from lumenray.benchmarks.denoising.document import check_bars

SHAPE = 64, 96


def noisy(level: float, share: float, seed: int):
    """Grey picture with noise, and what that is."""
    noise = np.random.default_rng(seed).normal(0.0, share * level, (*SHAPE, 1))
    return level + noise * np.ones(3)


def row(samples: int, error: float, shift: float, theirs: float) -> dict:
    """Numbers of one number of samples."""
    cycles = {
        "samples": 9,
        "seconds": 3.0,
        "raw_error": 0.4,
        "error": theirs,
        "doubt": 0.001,
        "shift": 0.02,
    }
    return {
        "samples": samples,
        "seconds": 3.0,
        "denoising_seconds": 1.0,
        "stated": 0.2,
        "raw_error": 0.2,
        "error": error,
        "doubt": 0.001,
        "network_error": error,
        "shift": shift,
        "network_shift": 0.03,
        "cycles": cycles,
    }


def test_the_noise_of_the_reference_is_no_error_of_the_picture():
    reference = {"colour": noisy(2.0, 0.05, 1), "error": np.full(SHAPE, 0.05 * 2.0)}
    assert run._error(noisy(2.0, 0.08, 2), reference) == pytest.approx(0.08, rel=0.05)
    assert run._error(np.full((*SHAPE, 3), 2.0), reference) < 0.01


def test_a_block_that_loses_light_is_found():
    raw = noisy(1.0, 0.1, 3)
    shown = raw.copy()
    shown[:32, 32:64] *= 0.98
    assert run._shift(shown, raw) == pytest.approx(0.02, rel=1e-6)


def test_the_demands_are_judged():
    good = {"rows": [row(8, 0.05, 1e-6, 0.1), row(32, 0.04, 1e-6, 0.05)]}
    assert [bar.passed for bar in check_bars(good)] == [True, True, True]
    bad = {"rows": [row(8, 0.3, 0.02, 0.1), row(32, 0.04, 1e-6, 0.05)]}
    assert [bar.passed for bar in check_bars(bad)] == [False, False, False]


def test_the_document_holds_every_row_and_its_picture(tmp_path):
    names = ["reference", "Cycles reference", *(f"8 {n}" for n in ("raw", "denoised", "Cycles"))]
    result = {
        "machine": {"cpu": "a processor", "cores": 2},
        "size": [SHAPE[1], SHAPE[0]],
        "reference": {"Lumenray": 256, "Cycles": 256},
        "bounces": 64,
        "rows": [row(8, 0.05, 1e-6, 0.1)],
        "pictures": {name: noisy(0.5, 0.1, 4) for name in names},
    }
    run.write_results(result, tmp_path, tmp_path / "numbers.json")
    text = (tmp_path / "denoising.md").read_text(encoding="utf-8")
    assert "| 8 | 20 % | 5 % | 5 % ± 0.1 % |" in text
    assert "(denoising.png)" in text
    assert (tmp_path / "denoising.png").stat().st_size > 1000
    assert "pictures" not in (tmp_path / "numbers.json").read_text(encoding="utf-8")
