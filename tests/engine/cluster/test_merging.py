"""Merging results of chunks: means by samples, errors by chance and those that stay, and what is said."""

from dataclasses import replace

import numpy as np
import pytest

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.cluster.merging import CoefficientSum, MeasurementSum, Origins, PictureSum
from lumenray.engine.daylight.coefficients import DaylightCoefficients
from lumenray.engine.measurements import Measurement
from lumenray.engine.scene.provenance import Provenance
from lumenray.engine.views import Picture

ORIGIN = Provenance("1", "llvm_mono", "hash", 1, 1000, 2.0)


def measured(mean, error, samples, floor=None, **origin):
    values = np.full(3, mean), np.full(3, error)
    floors = None if floor is None else np.full(3, floor)
    return Measurement(*values, replace(ORIGIN, samples=samples, **origin), floors=floors)


def merged(*parts):
    sums = MeasurementSum()
    for part in parts:
        sums.add(part)
    return sums.merged(7, 3.0)


def test_chunks_count_by_their_samples():
    made = merged(measured(100.0, 1.0, 3000), measured(104.0, 1.0, 1000))
    assert made.illuminance == pytest.approx(101.0)
    assert made.provenance.samples == 4000
    assert (made.provenance.seed, made.provenance.seconds) == (7, 3.0)


def test_errors_by_chance_fall():
    made = merged(*[measured(100.0, 2.0, 1000)] * 16)
    assert made.standard_error == pytest.approx(0.5)
    assert made.floors is None


def test_what_more_samples_do_not_lower_stays():
    made = merged(*[measured(100.0, np.hypot(2.0, 1.5), 1000, floor=1.5)] * 16)
    assert made.standard_error == pytest.approx(np.hypot(0.5, 1.5))
    assert made.floors == pytest.approx(1.5)


def test_samples_are_asked_beside_what_they_do_not_lower():
    sums = MeasurementSum()
    for _ in range(16):
        sums.add(measured(100.0, np.hypot(2.0, 0.6), 1000, floor=0.6))
    assert sums.estimate().standard_error == pytest.approx(0.5)
    rule = sums.rule_for_samples(StopRule(error=0.01, each=0.01))
    assert (rule.error, rule.each) == pytest.approx((0.008, 0.008), rel=1e-4)
    plain, dark = MeasurementSum(), MeasurementSum()
    plain.add(measured(100.0, 2.0, 1000))
    dark.add(measured(0.0, 2.0, 1000, floor=2.0))
    for other in (plain, dark):
        assert other.rule_for_samples(StopRule(error=0.01)) == StopRule(error=0.01)


def test_errors_hold_what_means_differ_by():
    rng = np.random.default_rng(1)
    hits = 0
    for _ in range(400):
        parts = [
            measured(100.0 + rng.normal(0.0, 3.0 / np.sqrt(n)), 3.0 / np.sqrt(n), n)
            for n in (10, 20, 40)
        ]
        made = merged(*parts)
        hits += abs(made.illuminance[0] - 100.0) < 1.96 * made.standard_error[0]
    assert hits / 400 == pytest.approx(0.95, abs=0.035)


def test_one_chunk_is_itself():
    one = measured(100.0, 2.0, 1000, floor=1.5)
    made = merged(one)
    np.testing.assert_allclose(made.illuminance, one.illuminance)
    np.testing.assert_allclose(made.standard_error, one.standard_error)


def test_a_sentence_is_said_once():
    origins = Origins()
    for number in range(3):
        notes = (f"cells change the mean by {number}.5 %", "the lamp has no size")
        origins.add(replace(ORIGIN, notes=notes + (("odd",) if number == 1 else ())))
    told = origins.tell("notes")
    assert told == (
        "cells change the mean by 0.5 % (said of 3 of 3 chunks, with numbers of the first)",
        "the lamp has no size",
        "odd (said of 1 of 3 chunks)",
    )


def coefficients(rng, samples):
    shape = (10, 4, 6)
    return DaylightCoefficients(
        4, rng.random(shape, dtype=np.float32), rng.random((10, 4, 2), dtype=np.float32),
        rng.random((2, 4, 2), dtype=np.float32), np.full(4, 0.01, np.float32),
        rng.random((4, 3), dtype=np.float32), np.full((4, 3), 0.2, np.float32), np.zeros((3, 3), int),
        np.full((3, 3), 1 / 3), samples, 1, replace(ORIGIN, samples=samples),
    )  # fmt: skip


def test_groups_of_coefficients_stay_apart():
    rng = np.random.default_rng(2)
    parts, sums = [coefficients(rng, 100), coefficients(rng, 300)], CoefficientSum()
    for part in parts:
        sums.add(part)
    made = sums.merged(1, 0.0)
    np.testing.assert_allclose(made.sky, 0.25 * parts[0].sky + 0.75 * parts[1].sky, rtol=1e-6)
    assert made.direct_error == pytest.approx(0.2 * np.sqrt(0.25**2 + 0.75**2), rel=1e-6)
    assert made.reading == pytest.approx(0.01, rel=1e-6)
    assert (made.samples, made.lost) == (400, 2)
    assert sums.error() == pytest.approx(made.error_of_even_world(), rel=1e-5)


def picture(rng, samples, floor=None):
    shape = (4, 5)
    light = rng.random((*shape, 3), dtype=np.float32)
    zeros = np.zeros(shape, np.float32)
    return Picture(
        light, np.full(shape, 0.3, np.float32), 0.1, zeros, light, zeros, zeros,
        replace(ORIGIN, samples=samples), luminance_floor=floor,
    )  # fmt: skip


def test_pictures_are_means():
    rng = np.random.default_rng(3)
    floor = np.full((4, 5), 0.2, np.float32)
    parts, sums = [picture(rng, 10, floor), picture(rng, 30, floor)], PictureSum()
    for part in parts:
        sums.add(part)
    made = sums.merged(1, 0.0)
    expected = 0.25 * parts[0].tristimulus + 0.75 * parts[1].tristimulus
    np.testing.assert_allclose(made.tristimulus, expected, rtol=1e-6)
    by_chance = (0.3**2 - 0.2**2) * (0.25**2 + 0.75**2)
    assert made.luminance_error == pytest.approx(np.sqrt(by_chance + 0.2**2), rel=1e-5)
    assert made.luminance_floor == pytest.approx(0.2)
    # Samples make up for what they do not lower, and are not waited for beyond that.
    share = sums.scatter() / sums.error()
    assert share == pytest.approx(np.sqrt(by_chance / (by_chance + 0.2**2)), rel=1e-5)
    lasting = 0.2 / np.sqrt(by_chance + 0.2**2) * sums.error()
    asked = sums.rule_for_samples(StopRule(error=1.5 * lasting)).error
    assert asked == pytest.approx(np.sqrt(1.5**2 - 1.0) * lasting, rel=1e-5)
    assert made.tristimulus.dtype == np.float32
    assert made.illuminance is None
    np.testing.assert_array_equal(made.normal, parts[0].normal)
