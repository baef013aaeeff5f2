"""Daylight provision and exposure to sunlight by EN 17037 on planes and days that can be counted by hand."""

from datetime import date

import numpy as np
import pytest

from lumenray.engine.daylight import en17037
from lumenray.engine.daylight.replicated import perturb
from lumenray.engine.daylight.sunlight import day_hours, make_day, year_hours
from lumenray.engine.errors import SceneError
from lumenray.engine.sky.place import Place
from lumenray.engine.sky.solar_position import find_day


def still(values):
    """Versions of what has no noise."""
    return np.repeat(np.asarray(values, float)[None], 5, axis=0)


def test_median_sky_is_that_of_the_brighter_half():
    rng = np.random.default_rng(2)
    diffuse = np.concatenate([np.zeros(4380), np.arange(1.0, 4381.0)])
    rng.shuffle(diffuse)
    assert np.count_nonzero(en17037.daylight_hours(diffuse)) == 4380
    assert en17037.median_illuminance(diffuse) == 2190.5
    # Dusk beyond the half does not count.
    diffuse[np.flatnonzero(diffuse == 0.0)[:500]] = 0.5
    assert en17037.median_illuminance(diffuse) == 2190.5


def test_factors_of_a_place():
    """300 and 100 lx under 15 000 lx are 2 and 0.67 %."""
    np.testing.assert_allclose(
        en17037.target_factors(15_000.0),
        [[0.02, 0.1 / 15], [0.5 / 15, 0.02], [0.05, 0.5 / 15]],
    )


@pytest.mark.parametrize(
    ("factors", "level"),
    [
        # Percent of 20 sensors under 10 000 lx: half needs 3, 5, 7.5 %, and 95 % need 1, 3, 5 %.
        ([3.0] * 10 + [1.0] * 9 + [0.0], "minimum"),
        ([3.0] * 10 + [1.0] * 8 + [0.0] * 2, "none"),
        ([3.0] * 9 + [2.9] * 11, "none"),
        ([5.0] * 10 + [3.0] * 9 + [0.5], "medium"),
        ([7.5] * 10 + [5.0] * 10, "high"),
        ([9.0] * 10 + [4.9] * 10, "medium"),
    ],
)
def test_levels_by_daylight_factors(factors, level):
    made = en17037.judge_factors(still(np.array(factors) / 100.0), 10_000.0, 4)
    assert made.level == made.lowest == made.highest == level
    values = np.array(factors)
    np.testing.assert_allclose(
        made.target_areas.value, [(values >= bound).mean() for bound in (3.0, 5.0, 7.5)]
    )
    np.testing.assert_allclose(
        made.least_areas.value, [(values >= bound).mean() for bound in (1.0, 3.0, 5.0)]
    )


def test_openings_above_need_the_target_nearly_everywhere():
    even, half = np.full(20, 0.051), np.array([0.09] * 10 + [0.04] * 10)
    for factors, level in ((even, "medium"), (half, "minimum")):
        made = en17037.judge_factors(still(factors), 10_000.0, 4, is_from_above=True)
        assert made.level == level


def test_levels_by_illuminances():
    """Two sensors: 800 lx in half of the daylight hours, and 350 lx in one hour more than half."""
    year = np.zeros((2, 1000))
    year[0, :500], year[1, :501] = 800.0, 350.0
    hours = np.ones(1000, bool)
    shares = en17037.autonomy_by_level(year, hours)
    np.testing.assert_allclose(shares, [[0.5] * 6, [0.501, 0.501, 0.0, 0.501, 0.0, 0.0]])
    made = en17037.judge_illuminances(still(shares), 4)
    np.testing.assert_allclose(made.target_areas.value, [1.0, 0.5, 0.5])
    np.testing.assert_allclose(made.least_areas.value, [1.0, 1.0, 0.5])
    assert made.level == "medium"
    made = en17037.judge_illuminances(still(shares), 4, [1.0, 3.0])
    assert made.level == "minimum"


def test_noise_leaves_a_level_open():
    """Half of the plane lies about the target of the lowest level within its noise."""
    rng = np.random.default_rng(5)
    factors = np.concatenate([np.full(100, 0.03), np.full(100, 0.02)])
    versions = perturb(factors * rng.normal(1.0, 0.05, (16, 1)))
    made = en17037.judge_factors(versions, 10_000.0, 15)
    assert (made.lowest, made.highest) == ("none", "minimum")
    low, high = made.target_areas.interval()
    assert low[0] < 0.5 - 0.1
    assert high[0] > 0.5 - 0.1
    # The least illuminance is far from it and known to a sensor.
    assert made.least_areas.standard_error[0] <= 1.0 / 200


def test_levels_that_replicates_reach_hold_the_true_one():
    """80 rooms of 40 sensors at any level, with noise of 15 % in each coefficient of the mean."""
    names, held, was_open = ["none", "minimum", "medium", "high"], 0, 0
    hours = np.ones(400, bool)
    for seed in range(80):
        rng = np.random.default_rng([17037, seed])
        depth = np.linspace(0.0, 1.0, 40)[:, None]
        truth = 0.03 * np.exp(-rng.uniform(0.5, 2.5) * depth) * rng.uniform(0.3, 1.7, (40, 20))
        skies = rng.gamma(2.0, 900.0, 400) * rng.uniform(0.2, 1.8, (20, 400))
        versions = perturb(truth * rng.gamma(1.0 / 0.36, 0.36, (16, 40, 20)))
        shares = [en17037.autonomy_by_level(each @ skies, hours) for each in versions]
        made = en17037.judge_illuminances(shares, 15)
        level = en17037.judge_illuminances(
            still(en17037.autonomy_by_level(truth @ skies, hours)), 15
        ).level
        lowest, true, highest = map(names.index, (made.lowest, level, made.highest))
        held += lowest <= true <= highest
        was_open += lowest != highest
    assert held >= 76
    # They are not held by telling nothing.
    assert 2 <= was_open <= 40


# ---- sunlight ----

PRAGUE = Place(50.09, 14.42, "Europe/Prague")


def test_an_open_field_has_sun_from_rise_to_set():
    day = make_day(date(2025, 3, 21), PRAGUE)
    made = day_hours(np.ones((1, len(day.times))), day)[0]
    sun = find_day(2025, 3, 21, PRAGUE)
    # Without refraction and the radius of the disk about 11 minutes less than from rise to set of almanacs.
    assert made == pytest.approx((sun.set - sun.rise) / 3600.0 - 0.18, abs=0.05)


def test_low_sun_does_not_count():
    """At the equinox the sun rises by 15 degrees an hour along a circle that is tilted by the latitude."""
    place = Place(50.0, 0.0)
    day = make_day(date(2025, 3, 20), place, 13.0)
    made = day_hours(np.ones((1, len(day.times))), day)[0]
    declination = np.radians(day.sun.declination.mean())
    phi = np.radians(50.0)
    cosine = (np.sin(np.radians(13.0)) - np.sin(phi) * np.sin(declination)) / (
        np.cos(phi) * np.cos(declination)
    )
    assert made == pytest.approx(2.0 * np.degrees(np.arccos(cosine)) / 15.0, abs=0.04)
    half = day_hours([day.sun.azimuth < 180.0], day)[0]
    assert half == pytest.approx(0.5 * made, abs=0.05)


def test_polar_night_has_no_moment():
    day = make_day(date(2025, 2, 1), Place(89.0, 0.0))
    assert len(day.times) == 0
    assert day_hours(np.zeros((3, 0)), day).tolist() == [0.0, 0.0, 0.0]


def test_polar_day_has_all():
    day = make_day(date(2025, 6, 21), Place(80.0, 0.0))
    assert day_hours(np.ones((1, len(day.times))), day)[0] == pytest.approx(24.0)


@pytest.mark.parametrize(
    ("hours", "level"),
    [(1.49, "none"), (1.5, "minimum"), (2.99, "minimum"), (3.0, "medium"), (4.0, "high")],
)
def test_levels_of_exposure(hours, level):
    assert en17037.exposure_level(hours) == level


def test_sunshine_of_a_year_by_the_weather():
    is_sunlit = np.array([[1.0, 1.0, 0.5, 1.0], [0.0, 1.0, 1.0, 1.0]])
    assert year_hours(is_sunlit).tolist() == [3.5, 3.0]
    assert year_hours(is_sunlit, [800.0, 120.0, 121.0, 0.0], 0.5).tolist() == [0.75, 0.5]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: en17037.daylight_hours([1.0, np.nan]), "no diffuse illuminance in 1 of 2 hours"),
        (lambda: en17037.daylight_hours([0.0, 0.0]), "gives no light in any hour"),
        (lambda: en17037.target_factors(0.0), "median illuminance by the sky is 0.0 lx"),
        (lambda: en17037.check_date(date(2025, 3, 22)), "found 2025-03-22"),
        (lambda: en17037.check_date(date(2025, 1, 31)), "found 2025-01-31"),
        (lambda: make_day(date(2025, 3, 1), PRAGUE, -1.0), "from -1 degrees on"),
        (lambda: make_day(date(2025, 3, 1), PRAGUE, 0.0, 0.0), "steps of 0 s"),
        (lambda: year_hours(np.ones((1, 2)), [1.0, np.nan]), "sunshine is unknown"),
        (lambda: year_hours(np.ones((1, 2)), [1.0]), "does not fit the 1 hours"),
    ],
)
def test_what_cannot_be_is_refused(call, words):
    with pytest.raises(SceneError, match=words):
        call()


@pytest.mark.parametrize("day", [date(2025, 2, 1), date(2024, 2, 29), date(2025, 3, 21)])
def test_days_of_exposure(day):
    en17037.check_date(day)
