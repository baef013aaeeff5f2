"""The error that a picture states, against how pictures of other seeds scatter."""

import numpy as np
import pytest
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.transport.pictures.allocation import Allocation
from lumenray.engine.views import ViewSettings
from small_pictures import ROOMS, look_in
from small_scenes import session_of

pytestmark = [pytest.mark.mitsuba, pytest.mark.slow]

SEEDS, SAMPLES, LONG = 24, 64, 8192
VIEW = look_in(32, 24)
METHODS = ("cells", "corrected", "paths")
"""Corrected cells are unbiased ones."""


@pytest.fixture(scope="module")
def session():
    return session_of(*ROOMS["matt"])


def luminance_of(session, samples, method, seed):
    """Luminance and its errors. (h, w) each"""
    is_corrected = method == "corrected"
    settings = ViewSettings(
        StopRule(samples=samples),
        seed,
        method="cells" if is_corrected else method,
        unbiased=is_corrected,
    )
    made = session.render(VIEW, settings)
    return made.tristimulus[..., 1].astype(float), made.luminance_error.astype(float)


def ratio_of(values, errors):
    """Stated errors over how pictures (k, h, w) scatter about their mean. [-]"""
    mean = values.mean(axis=0)
    scale = np.maximum(mean, mean.mean())
    true = (((values - mean) / scale) ** 2).mean() * len(values) / (len(values) - 1)
    return np.sqrt(((errors / scale) ** 2).mean() / true)


def pictures_of(session, method):
    found = [luminance_of(session, SAMPLES, method, seed) for seed in range(SEEDS)]
    return tuple(np.array(each) for each in zip(*found, strict=True))


@pytest.mark.parametrize("method", METHODS)
def test_the_stated_error_of_samples_that_are_spread_evenly_is_the_true_one(
    session, method, monkeypatch
):
    def choose(self, *_):
        return {kind: counts.copy() for kind, counts in self.counts.items()}

    monkeypatch.setattr(Allocation, "choose", choose)
    assert 0.85 < ratio_of(*pictures_of(session, method)) < 1.15


@pytest.mark.parametrize("method", METHODS)
def test_the_stated_error_of_samples_that_go_where_they_are_needed_is_the_true_one(session, method):
    assert 0.85 < ratio_of(*pictures_of(session, method)) < 1.15


@pytest.mark.parametrize("method", METHODS)
def test_the_mean_of_many_pictures_has_no_bias(session, method):
    values, _ = pictures_of(session, method)
    long, long_errors = luminance_of(session, LONG, "paths", 1000)
    noise = values.mean(axis=(1, 2)).std(ddof=1) / np.sqrt(SEEDS)
    noise = np.hypot(noise, np.sqrt((long_errors**2).sum()) / long.size)
    bias = values.mean() - long.mean()
    # The rest is what cells may change by their size.
    size = 0.002 * long.mean() if method == "cells" else 0.0
    assert abs(bias) < 4.0 * noise + size, f"{bias:.3g} +- {noise:.2g} cd/m2"
