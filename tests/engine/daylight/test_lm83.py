"""Spatial daylight autonomy, annual sunlight exposure and blinds on rooms that can be counted by hand."""

import numpy as np
import pytest

from lumenray.engine.daylight import lm83, metrics
from lumenray.engine.daylight.occupancy import CountedHours
from lumenray.engine.errors import SceneError

HOURS = np.ones(3650, bool)


def lit_for(hours, illuminance):
    """A sensor with an illuminance in its first hours and nothing later."""
    year = np.zeros(3650)
    year[:hours] = illuminance
    return year


def test_half_of_the_hours_is_1825():
    year = np.stack([lit_for(1824, 301.0), lit_for(1825, 300.0), lit_for(3650, 299.9)])
    autonomy = metrics.daylight_autonomy(year, HOURS)
    assert lm83.spatial_autonomy(autonomy) == pytest.approx(1.0 / 3.0)
    assert lm83.spatial_autonomy(autonomy, [1.0, 3.0, 2.0]) == 0.5


def test_more_than_250_hours_of_more_than_1000_lux():
    direct = np.stack(
        [lit_for(250, 5000.0), lit_for(251, 1000.1), lit_for(3650, 1000.0), lit_for(251, 20_000.0)]
    )
    sunlit = lm83.sunlit_hours(direct, HOURS)
    assert sunlit.tolist() == [250.0, 251.0, 0.0, 251.0]
    assert lm83.sunlight_exposure(sunlit) == 0.5
    assert lm83.sunlight_exposure(sunlit, [1.0, 1.0, 1.0, 5.0]) == 0.75
    # By the quarter of an hour 251 records are 63 hours.
    assert (
        lm83.sunlight_exposure(lm83.sunlit_hours(direct, CountedHours(HOURS, interval=0.25))) == 0.0
    )


def test_blinds_close_above_two_percent_group_by_group():
    """100 sensors, two groups; hours with 0, 2, 3 sunlit sensors and with 3 just at the bound."""
    direct = np.zeros((2, 100, 4))
    direct[0, :2, 1] = direct[0, :3, 2] = 1500.0
    direct[0, :3, 3] = 1000.0
    direct[1, :50, 0] = 4000.0
    areas = lm83.SunlitAreas(2, 4)
    for start in range(0, 100, 30):
        areas.add(direct[:, start : start + 30])
    np.testing.assert_allclose(areas.shares, [[0.0, 0.02, 0.03, 0.0], [0.5, 0.0, 0.0, 0.0]])
    is_closed = lm83.close_blinds(areas.shares)
    assert is_closed.tolist() == [[False, False, True, False], [True, False, False, False]]


def test_two_percent_of_the_area_not_of_the_sensors():
    areas = lm83.SunlitAreas(1, 1)
    direct = np.array([[[2000.0], [0.0], [0.0]]])
    areas.add(direct, [2.0, 49.0, 49.0])
    assert not lm83.close_blinds(areas.shares).any()
    areas = lm83.SunlitAreas(1, 1)
    areas.add(direct, [2.1, 49.0, 49.0])
    assert lm83.close_blinds(areas.shares).all()


def test_groups_are_combined_hour_by_hour():
    rng = np.random.default_rng(3)
    with_open, is_closed = rng.uniform(0.0, 900.0, (3, 5, 40)), rng.uniform(size=(3, 40)) < 0.4
    with_closed = 0.1 * with_open
    combined = lm83.combine_groups(with_open, with_closed, is_closed)
    for hour in range(40):
        for sensor in range(5):
            parts = [
                (with_closed if is_closed[group, hour] else with_open)[group, sensor, hour]
                for group in range(3)
            ]
            assert combined[sensor, hour] == pytest.approx(sum(parts))


def test_a_room_by_hand():
    """Four sensors: the sun reaches the first in 400 hours, in which blinds leave a tenth of all light."""
    sky = np.array([800.0, 500.0, 310.0, 200.0])[:, None] * np.ones(3650)
    sun = np.zeros((4, 3650))
    sun[0, :400] = 20_000.0
    areas = lm83.SunlitAreas(1, 3650)
    areas.add(sun[None])
    is_closed = lm83.close_blinds(areas.shares)
    assert np.count_nonzero(is_closed) == 400
    year = lm83.combine_groups((sky + sun)[None], 0.1 * (sky + sun)[None], is_closed)
    autonomy = metrics.daylight_autonomy(year, HOURS)
    # The first has a tenth of 20 800 lx behind blinds, the others too little.
    share = 3250 / 3650
    np.testing.assert_allclose(autonomy, [1.0, share, share, 0.0])
    assert lm83.spatial_autonomy(autonomy) == 0.75
    assert lm83.sunlight_exposure(lm83.sunlit_hours(sun, HOURS)) == 0.25


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: lm83.SunlitAreas(1, 2).shares, "no area whose sunlight"),
        (lambda: lm83.SunlitAreas(1, 2).add(np.zeros((2, 3, 2))), "does not fit 1 groups"),
        (lambda: lm83.SunlitAreas(1, 2).add(np.full((1, 3, 2), np.nan)), "is missing"),
        (
            lambda: lm83.combine_groups(
                np.zeros((1, 2, 3)), np.zeros((1, 2, 3)), np.zeros((1, 2), bool)
            ),
            "do not fit the states",
        ),
    ],
)
def test_what_cannot_be_is_refused(call, words):
    with pytest.raises(SceneError, match=words):
        call()
