"""The benchmark of cloths: the walk that is timed against, and verdicts."""

import numpy as np
import pytest

pytest.importorskip("mitsuba")

from lumenray.engine.transport import backend

pytestmark = pytest.mark.mitsuba


@pytest.fixture(scope="module", autouse=True)
def variant():
    backend.start(spectral=False)


def test_walk_by_numpy_has_the_mean_way_of_any_body():
    from lumenray.benchmarks.cloth.numpy_walk import walk
    from lumenray.benchmarks.cloth.values import forward
    from lumenray.engine.cloth.thread_walk import ThreadOptics
    from lumenray.engine.paint.fresnel import face_reflectance

    u, v = np.random.default_rng(3).random((2, 4000))
    axial, around = np.sqrt(u) * np.cos(2 * np.pi * v), np.sqrt(u) * np.sin(2 * np.pi * v)
    ways = walk(ThreadOptics(1.557, 5.0, forward(0.5)), axial, around / np.sqrt(1.0 - axial**2))
    ways *= 1.0 - face_reflectance(np.sqrt(u), 1.0, 1.557)
    assert ways.mean() == pytest.approx(2.0 * 1.557**2, abs=4.0 * ways.std() / np.sqrt(4000))


def test_what_is_apart_fails_and_is_named():
    from lumenray.benchmarks.cloth import run as cloth
    from lumenray.benchmarks.cloth.document import describe

    row = {
        "id": "B1.uncollided.tau1.0",
        "ours": [0.3],
        "reference": [0.23],
        "ratio": 7.0,
        "verdict": "FAIL",
    }
    photons = {"seconds": 2.0, "numpy_seconds": 30.0, "ratio": 15.0, "sigmas_apart": 0.5}
    result = {
        "reference_failed": [row["id"]],
        "photons_seconds": 2.0,
        "woven_seconds": None,
        "close_up_percent": None,
        "machine": {"cpu": "a processor", "cores": 2, "system": "Linux", "python": "3.11"},
        "parts": {"photons": photons},
    }
    bars = cloth.check_bars(result)
    assert [bar.passed for bar in bars] == [False, True, True, *[None] * 7]
    text = describe(result, bars)
    assert "Not met: reference values apart: 1." in text
    assert "15.0 times as long" in text
