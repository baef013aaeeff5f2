"""The error that a picture states, against how pictures of other seeds scatter."""

import numpy as np
import pytest
from small_pictures import ROOMS, look_in
from small_scenes import session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.transport.pictures.allocation import TILE, Allocation
from lumenray.engine.views import ViewSettings

pytestmark = [pytest.mark.mitsuba, pytest.mark.slow]

SEEDS, SAMPLES, LONG = 24, 64, 8192
VIEW = look_in(32, 24)
METHODS = ("cells", "corrected", "paths")
"""Corrected cells are unbiased ones."""

SHARED = "shared"
"""By cells, and pixels share their light."""


def luminance_of(samples, method, seed):
    """Luminance and its errors. (h, w) each

    Of a session of its own: one that goes on keeps its cells, whose noise is common.
    """
    is_corrected = method == "corrected"
    settings = ViewSettings(
        StopRule(samples=samples),
        seed,
        method=method if method == "paths" else "cells",
        unbiased=is_corrected,
        shares=method == SHARED,
    )
    made = session_of(*ROOMS["matt"]).render(VIEW, settings)
    return made.tristimulus[..., 1].astype(float), made.luminance_error.astype(float)


def ratio_of(values, errors):
    """Stated errors over how pictures (k, h, w) scatter about their mean, as the geometric mean of tiles. [-]

    In some tiles rare bright samples make nearly all noise; so few pictures do not tell what it is there.
    """
    mean = values.mean(axis=0)
    scale = np.maximum(mean, mean.mean())
    true = by_tiles(((values - mean) / scale) ** 2) * len(values) / (len(values) - 1)
    return np.exp(0.5 * np.log(by_tiles((errors / scale) ** 2) / true).mean())


def by_tiles(pictures):
    """Means of tiles over pictures (k, h, w)."""
    count, height, width = pictures.shape
    tiles = pictures.reshape(count, height // TILE, TILE, width // TILE, TILE)
    return tiles.mean(axis=(0, 2, 4))


def pictures_of(method):
    found = [luminance_of(SAMPLES, method, seed) for seed in range(SEEDS)]
    return tuple(np.array(each) for each in zip(*found, strict=True))


@pytest.mark.parametrize("method", METHODS)
def test_the_stated_error_of_samples_that_are_spread_evenly_is_the_true_one(method, monkeypatch):
    def choose(self, *_):
        return {kind: counts.copy() for kind, counts in self.counts.items()}

    monkeypatch.setattr(Allocation, "choose", choose)
    assert 0.85 < ratio_of(*pictures_of(method)) < 1.15


@pytest.mark.parametrize("method", METHODS)
def test_the_stated_error_of_samples_that_go_where_they_are_needed_is_the_true_one(method):
    assert 0.85 < ratio_of(*pictures_of(method)) < 1.15


def test_the_stated_error_holds_what_sharing_smooths_away():
    """The part that is no noise is known of several tiles together, so the bounds are wider."""
    values, errors = pictures_of(SHARED)
    long, _ = luminance_of(LONG, "paths", 1000)
    scale = np.maximum(long, long.mean())
    true = by_tiles(((values - long) / scale) ** 2)
    ratio = np.exp(0.5 * np.log(by_tiles((errors / scale) ** 2) / true).mean())
    assert 0.75 < ratio < 1.35, ratio


@pytest.mark.parametrize("method", [*METHODS, SHARED])
def test_the_mean_of_many_pictures_has_no_bias(method):
    values, _ = pictures_of(method)
    long, long_errors = luminance_of(LONG, "paths", 1000)
    noise = values.mean(axis=(1, 2)).std(ddof=1) / np.sqrt(SEEDS)
    noise = np.hypot(noise, np.sqrt((long_errors**2).sum()) / long.size)
    bias = values.mean() - long.mean()
    # The rest is what cells may change by their size.
    size = 0.002 * long.mean() if method in ("cells", SHARED) else 0.0
    assert abs(bias) < 4.0 * noise + size, f"{bias:.3g} +- {noise:.2g} cd/m2"
