"""The sun's place against the report's own example, a shorter theory of the sun, and what is known of days."""

from datetime import datetime

import numpy as np
import pytest

from lumenray.benchmarks.daylight.sun import meeus_direction
from lumenray.engine.errors import SceneError
from lumenray.engine.sky import solar_position
from lumenray.engine.sky.place import Place, from_local, to_local
from lumenray.engine.sky.solar_position import Air, delta_t, find_day, find_sun, refraction

GOLDEN = Place(39.742476, -105.1786, "UTC-7", 1830.14)
"""Place of the example in NREL/TP-560-34302, table A5.1."""

TROMSO = Place(69.65, 18.96, "Europe/Oslo")


def at(place, *clock):
    return from_local(datetime(*clock), place.zone).seconds


# ---- published values ----


def test_example_of_the_report(monkeypatch):
    monkeypatch.setattr(solar_position, "delta_t", lambda years: np.full_like(years, 67.0))
    sun = find_sun(at(GOLDEN, 2003, 10, 17, 12, 30, 30), GOLDEN, Air(82_000.0, 11.0))
    np.testing.assert_allclose(90.0 - sun.elevation, 50.11162, atol=1e-5)
    np.testing.assert_allclose(sun.azimuth, 194.34024, atol=1e-5)
    np.testing.assert_allclose(sun.distance, 0.9965422974, atol=1e-9)
    np.testing.assert_allclose(sun.declination, -9.31434, atol=1e-5)
    np.testing.assert_allclose(sun.equation_of_time, 14.641503, atol=2e-5)


def test_rise_noon_and_set_of_the_example():
    """Its set is that of the day in universal time, the 16th by local clocks."""
    day, before = find_day(2003, 10, 17, GOLDEN), find_day(2003, 10, 16, GOLDEN)
    assert abs(day.rise - at(GOLDEN, 2003, 10, 17, 6, 12, 43)) < 2.0
    assert abs(day.noon - at(GOLDEN, 2003, 10, 17, 11, 46, 5)) < 1.0
    assert abs(before.set - at(GOLDEN, 2003, 10, 16, 17, 20, 19)) < 2.0


@pytest.mark.parametrize(
    ("year", "seconds", "error"),
    [
        # Astronomical almanac; the last is beyond what the polynomials were fitted to.
        (1900.0, -2.72, 0.5),
        (1920.0, 21.16, 0.5),
        (1940.0, 24.33, 0.5),
        (1960.0, 33.15, 0.5),
        (1980.0, 50.54, 0.5),
        (2000.0, 63.83, 0.5),
        (2010.0, 66.07, 1.0),
        (2020.0, 69.36, 2.5),
    ],
)
def test_time_of_dynamics_against_observations(year, seconds, error):
    assert abs(delta_t(year) - seconds) < error


def test_time_of_dynamics_has_no_step():
    for year in (1920.0, 1941.0, 1961.0, 1986.0, 2005.0, 2050.0):
        assert abs(delta_t(year) - delta_t(year - 1e-9)) < 0.5


# ---- a shorter theory ----


def test_thousand_places_and_times_agree_with_a_shorter_theory():
    rng = np.random.default_rng(28)
    first, last = (datetime(year, 1, 1).timestamp() for year in (1950, 2050))
    worst = 0.0
    for _ in range(1000):
        seconds = rng.uniform(first, last)
        place = Place(np.degrees(np.arcsin(rng.uniform(-1.0, 1.0))), rng.uniform(-180.0, 180.0))
        ours = find_sun(seconds, place).directions()
        chord = np.linalg.norm(ours - meeus_direction(seconds, place.latitude, place.longitude))
        worst = max(worst, np.degrees(chord))
    # 0.01 of the theory (J. Meeus, Astronomical algorithms, chapter 25), 0.0024 of the parallax that it leaves out.
    assert worst < 0.0125


def test_many_times_are_those_of_one_at_a_time():
    times = at(GOLDEN, 2024, 1, 1, 0) + 3600.0 * np.arange(3000).reshape(2, 1500)
    sun = find_sun(times, GOLDEN)
    assert sun.elevation.shape == (2, 1500)
    for index in ((0, 0), (1, 20), (1, 1499)):
        one = find_sun(times[index], GOLDEN)
        assert one.elevation == pytest.approx(sun.elevation[index], abs=1e-11)
        assert one.azimuth == pytest.approx(sun.azimuth[index], abs=1e-11)


# ---- days ----


def test_length_of_days_by_the_closed_form():
    for latitude, month in [(0.0, 3), (48.0, 6), (-33.9, 6), (60.0, 12), (-54.8, 12)]:
        place = Place(latitude, 0.0)
        day = find_day(2025, month, 21, place)
        declination = np.radians(find_sun(day.noon, place).declination)
        phi = np.radians(latitude)
        cosine = (np.sin(np.radians(-0.8333)) - np.sin(phi) * np.sin(declination)) / (
            np.cos(phi) * np.cos(declination)
        )
        # The declination is not quite that of noon at rise and set; both move the same way.
        assert abs((day.set - day.rise) - np.degrees(np.arccos(cosine)) * 480.0) < 20.0


def test_sun_stays_up_and_stays_down_beyond_the_circle():
    summer, winter = find_day(2025, 6, 21, TROMSO), find_day(2025, 12, 21, TROMSO)
    assert summer.is_polar_day
    assert not summer.is_polar_night
    assert summer.rise is summer.set is None
    assert winter.is_polar_night
    assert not winter.is_polar_day
    assert winter.rise is winter.set is None
    # Local clocks pass noon all the same.
    assert to_local(summer.noon, "Europe/Oslo").hour == 12
    assert to_local(winter.noon, "Europe/Oslo").hour == 11


def test_year_beyond_the_circle_has_each_kind_of_day():
    """Tromsø's sun stays up from about 18 May to 26 July, and down from 27 November to 15 January."""
    states = {
        (month, day): find_day(2025, month, day, TROMSO)
        for month, day in [(5, 14), (5, 22), (7, 22), (7, 30), (11, 22), (12, 2), (1, 10), (1, 20)]
    }
    assert [key for key, day in states.items() if day.is_polar_day] == [(5, 22), (7, 22)]
    assert [key for key, day in states.items() if day.is_polar_night] == [(12, 2), (1, 10)]
    for key in [(5, 14), (7, 30), (11, 22), (1, 20)]:
        assert states[key].rise is not None


def test_sun_stands_in_the_north_at_noon_in_the_south():
    sydney = Place(-33.87, 151.21, "Australia/Sydney")
    noon = find_day(2025, 6, 21, sydney).noon
    sun = find_sun(noon, sydney)
    assert min(sun.azimuth, 360.0 - sun.azimuth) < 0.01
    assert sun.elevation == pytest.approx(90.0 - 33.87 - 23.44, abs=0.02)
    assert sun.solar_time == pytest.approx(12.0, abs=1e-5)


def test_days_of_23_and_25_hours_have_their_sun():
    berlin = Place(52.52, 13.4, "Europe/Berlin")
    for month, day, hour in [(3, 30, 6), (10, 26, 6)]:
        rise = to_local(find_day(2025, month, day, berlin).rise, berlin.zone)
        assert (rise.month, rise.day, rise.hour) == (month, day, hour)


def test_first_and_last_years():
    place = Place(51.5, 0.0)
    for year in (1900, 2100):
        for month in (1, 12):
            assert 11 <= to_local(find_day(year, month, 31, place).noon, "UTC").hour <= 12


# ---- axes and air ----


def test_north_turns_the_scene():
    place = Place(50.0, 10.0, "Europe/Berlin", north=30.0)
    sun = find_sun(at(place, 2025, 6, 21, 9), place)
    true, turned = sun.directions(), sun.directions(place.north)
    azimuth = np.radians(sun.azimuth)
    np.testing.assert_allclose(
        true[:2] / np.cos(np.radians(sun.elevation)), [np.sin(azimuth), np.cos(azimuth)]
    )
    # What lies at 30 degrees on a compass lies along +y.
    np.testing.assert_allclose(
        np.degrees(np.arctan2(turned[0], turned[1])), sun.azimuth - 30.0, atol=1e-9
    )
    assert turned[2] == true[2]


def test_air_lifts_the_sun_by_what_almanacs_say():
    standard = Air(101_000.0, 10.0)
    # Saemundsson: 29 minutes of arc at the horizon, 1 at 45 degrees, nothing at the zenith.
    assert refraction(0.0, standard) * 60.0 == pytest.approx(29.0, abs=0.5)
    assert refraction(45.0, standard) * 60.0 == pytest.approx(1.0, abs=0.03)
    assert refraction(90.0, standard) == pytest.approx(0.0, abs=1e-4)
    assert refraction(-5.0, standard) == 0.0
    assert refraction(20.0, Air(0.0, 10.0)) == 0.0


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: find_sun(0.0, Place(91.0, 0.0)), "latitude is 91.0 degrees, expected -90 to 90"),
        (lambda: find_sun(0.0, Place(0.0, 181.0)), "longitude is 181.0 degrees"),
        (lambda: find_sun(0.0, Place(np.nan, 0.0)), "latitude is nan"),
        (lambda: find_sun(1e12, Place(0.0, 0.0)), "beyond the years 1900 to 2100"),
        (lambda: find_sun(np.nan, Place(0.0, 0.0)), "beyond the years"),
        (lambda: find_sun(0.0, Place(0.0, 0.0), Air(-1.0)), "the air has -1.0 Pa"),
        (lambda: find_day(2025, 2, 29, Place(0.0, 0.0)), "no day 2025-2-29"),
        (lambda: find_day(1899, 1, 1, Place(0.0, 0.0)), "the year is 1899"),
        (lambda: find_day(2101, 1, 1, Place(0.0, 0.0)), "the year is 2101"),
    ],
)
def test_what_cannot_be_is_refused(call, words):
    with pytest.raises(SceneError, match=words):
        call()
