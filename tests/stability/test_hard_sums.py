"""Sums of very many samples: what single precision may cost where a thousand million are added."""

import math

import numpy as np
import pytest
from small_scenes import session_of

from lumenray.engine.accuracy.estimate import Accumulator
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.accuracy.uneven_sums import UnevenSums
from lumenray.engine.scene.light import AreaLight, Output, PointLight, Quantity

pytestmark = pytest.mark.mitsuba

UP = [[0.0, 0.0, 1.0]]
GROUPS = 16
BLOCKS = 64


def synthetic(name, count):
    """Samples as an estimator may draw them. (count,) float32"""
    rng = np.random.default_rng(3)
    match name:
        case "even":
            return rng.random(count, dtype=np.float32)
        case "long tail":
            return np.exp(3.0 * rng.standard_normal(count)).astype(np.float32)
        case "rare and bright":
            return np.where(rng.random(count) < 1e-3, 1e6, 1e-3).astype(np.float32)
        case "mostly dark":
            return np.where(rng.random(count) < 0.01, 1.0, 0.0).astype(np.float32)
    raise ValueError(name)


@pytest.mark.parametrize("name", ["even", "long tail", "rare and bright", "mostly dark"])
def test_a_thousand_million_samples_are_summed_to_a_millionth(name):
    # Owed: 1e-6 of the mean and 1e-3 of its error. Blocks of so many samples as the engine adds in single precision are
    # added by its own reduction, everything else in double precision; the samples repeat, so the truth is known exactly.
    from lumenray.engine.transport import backend

    backend.start(spectral=False)
    import drjit as dr
    import mitsuba as mi

    from lumenray.engine.transport.paths.illuminance import LARGEST_SUM

    samples = synthetic(name, GROUPS * BLOCKS * LARGEST_SUM)
    sums = dr.block_reduce(dr.ReduceOp.Add, mi.Float(samples), LARGEST_SUM)
    blocks = np.array(sums, dtype=np.float64).reshape(GROUPS, BLOCKS)
    made = Accumulator(GROUPS, 1)
    passes = -(-(10**9) // samples.size)
    for k in range(passes):
        # Another order each time, as later passes find other sums.
        made.add(np.roll(blocks, k, axis=1).sum(axis=1, keepdims=True), BLOCKS * LARGEST_SUM)
    estimate = made.estimate()
    assert estimate.samples >= 10**9
    truth = math.fsum(samples.astype(np.float64)) / samples.size
    assert estimate.mean[0] == pytest.approx(truth, rel=1e-6)
    means = samples.astype(np.float64).reshape(GROUPS, -1).mean(axis=1)
    error = means.std(ddof=1) / np.sqrt(GROUPS)
    assert estimate.standard_error[0] == pytest.approx(error, rel=1e-3)


def test_groups_that_differ_by_little_keep_their_difference():
    # Owed: the error of a value that is known to 1e-9 of itself, to 1 %: means of groups are subtracted in double precision.
    made = Accumulator(2, 1)
    for _ in range(1000):
        made.add(np.array([[1e6 * (1.0 + 1e-9)], [1e6 * (1.0 - 1e-9)]]), 10**6)
    estimate = made.estimate()
    assert estimate.mean[0] == pytest.approx(1.0, rel=1e-12)
    assert estimate.standard_error[0] == pytest.approx(1e-9, rel=0.01)


@pytest.mark.parametrize("candela", [1.0, 12345.6])
def test_an_estimator_without_noise_does_not_drift(candela):
    # Owed: 3e-6 of I / d^2 at any count, which is what adding a thousand equal numbers in single precision costs, and the
    # same mean after 32 passes as after one: beyond a block nothing may be lost.
    lamp = PointLight("l", "l", Output(Quantity.LUMINOUS_INTENSITY, candela), np.array([0, 0, 3.0]))
    session = session_of(lamp)
    found = [
        session.measure([[0, 0, 0]], UP, StopRule(samples=count), transport="mono").illuminance[0]
        for count in (1 << 4, 1 << 19, 1 << 24)
    ]
    np.testing.assert_allclose(found, candela / 9.0, rtol=3e-6)
    np.testing.assert_allclose(found[1:], found[1], rtol=1e-9)


def test_samples_far_along_their_sequence_are_as_good_as_the_first():
    # Owed: the same mean, within 3.5 errors of both, and no greater error, near the thousand millionth sample and before the
    # last that a sequence has.
    from lumenray.engine.transport.paths import illuminance

    frame = np.eye(4)
    frame[2, 3] = 1.0
    lamp = AreaLight("a", "a", Output(Quantity.LUMINANCE, 1000.0), frame, 1.0, 1.0)
    session, batch = session_of(lamp), 1 << 14
    session.measure([[0, 0, 0]], UP, StopRule(samples=16))
    estimates = []
    with session._engine("mono") as compiled:
        receivers = illuminance.Receivers.at_points([[0, 0, 0]], UP)
        job = illuminance._Job(compiled, receivers, GROUPS, 0, None, False)
        for index in (0, 1 << 30, (1 << 32) - batch):
            half, who = np.arange(2), np.zeros(2, dtype=int)
            entries = illuminance._Entries(half, who, np.full(2, index), batch)
            sums = UnevenSums(GROUPS, 1, 1)
            sums.add(half, who, batch, *job.launch(entries))
            estimates.append(sums.estimate())
    means = np.array([e.mean.item() for e in estimates])
    errors = np.array([e.standard_error.item() for e in estimates])
    # A square of 1 m over its middle, 1 m away.
    share = 4.0 / np.hypot(1.0, 0.5) * 0.5 * np.arctan(0.5 / np.hypot(1.0, 0.5))
    assert (np.abs(means - 1000.0 * share) < 3.5 * errors + 1e-6 * means).all(), means
    assert (errors[1:] < 4.0 * errors[0] + 1e-6 * means[0]).all(), errors
