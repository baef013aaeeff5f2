"""Whole years of weather that are odd: gaps, leap days, wrong zones, the south, the poles, the first and the last year."""

import numpy as np
import pytest
from weather_files import epw, epw_record

from lumenray.engine.errors import SceneError
from lumenray.engine.sky.hour import find_daylight_hours, make_hour
from lumenray.engine.sky.place import Place
from lumenray.engine.sky.solar_position import find_sun
from lumenray.engine.sky.weather import find_hours, find_middles
from lumenray.engine.sky.weather_file import read_weather

MANNHEIM = {"latitude": 49.5, "longitude": 8.5, "zone": 1.0}


def cloudless_year(place, year=2005, has_leap_day=False):
    """Records (month, day, hour, dni, dhi) of a year under the sun of a place, whose file says the truth."""
    days = np.arange(f"{year}-01-01", f"{year + 1}-01-01", dtype="datetime64[D]")
    days = [day.astype(object) for day in days]
    if not has_leap_day:
        days = [day for day in days if (day.month, day.day) != (2, 29)]
    start = np.array([np.datetime64(day).astype("datetime64[s]").astype(float) for day in days])
    times = (start[:, None] + 3600.0 * (np.arange(24) + 0.5) - 3600.0 * place["zone"]).ravel()
    where = Place(place["latitude"], place["longitude"], elevation=100.0)
    sine = np.sin(np.radians(find_sun(times, where).elevation))
    dni, dhi = np.where(sine > 0.02, 800, 0), np.round(250 * np.maximum(sine, 0.0), 1)
    dates = [(day.month, day.day, hour) for day in days for hour in range(1, 25)]
    return [(*date, int(a), float(b)) for date, a, b in zip(dates, dni, dhi, strict=True)]


@pytest.fixture
def read(tmp_path):
    def read(rows, year=2005, **place):
        path = tmp_path / "year.epw"
        path.write_text(
            epw([epw_record(year, *row[:3], dni=row[3], dhi=row[4]) for row in rows], **place)
        )
        return read_weather(path)

    return read


def told(weather, hours):
    return [str(remark) for remark in (*weather.remarks, *hours.remarks)]


def test_a_true_year_has_nothing_odd(read):
    weather = read(cloudless_year(MANNHEIM), **MANNHEIM)
    hours = find_hours(weather)
    assert told(weather, hours) == []
    # The sun is up half of the year and some more hours, by the parts of those in which it rises and sets.
    up = np.count_nonzero(hours.sun.elevation > 0.0)
    assert 4380 < up < 4380 + 2 * 365


def test_a_gap_is_told_and_every_other_hour_keeps_its_sun(read):
    rows = cloudless_year(MANNHEIM)
    whole = find_hours(read(rows, **MANNHEIM))
    kept = np.ones(8760, bool)
    kept[2000:2168] = kept[5000] = False
    weather = read([row for row, stays in zip(rows, kept, strict=True) if stays], **MANNHEIM)
    hours = find_hours(weather)
    assert told(weather, hours) == ["has 8591 of a year's 8760 records"]
    np.testing.assert_array_equal(hours.times, whole.times[kept])
    np.testing.assert_array_equal(hours.direct_normal, whole.direct_normal[kept])
    assert weather.interval == 1.0


def test_missing_values_stay_missing_and_dark(read):
    rows = cloudless_year(MANNHEIM)
    noon = next(i for i, row in enumerate(rows) if row[:3] == (6, 21, 12))
    rows[noon] = (*rows[noon][:3], "9999", rows[noon][4])
    rows[noon + 1] = (*rows[noon + 1][:3], rows[noon + 1][3], "9999")
    weather = read(rows, **MANNHEIM)
    hours = find_hours(weather)
    assert told(weather, hours) == [
        f"line {noon + 9}: 1 record has no direct normal irradiance",
        f"line {noon + 10}: 1 record has no diffuse horizontal irradiance",
    ]
    daylight = find_daylight_hours(weather, hours)
    for i in (noon, noon + 1):
        assert np.isnan(daylight.diffuse_horizontal[i])
        assert np.isnan(daylight.direct_normal[i])
        assert make_hour(hours, daylight, i) == (None, None)
    assert None not in make_hour(hours, daylight, noon - 1)


def test_leap_days_are_in_their_place(read):
    weather = read(cloudless_year(MANNHEIM, 2004, has_leap_day=True), 2004, **MANNHEIM)
    hours = find_hours(weather)
    assert len(weather) == 8784
    assert told(weather, hours) == []
    np.testing.assert_allclose(np.diff(find_middles(weather)), 3600.0)
    with pytest.raises(SceneError, match="29 February, which 2023 has not"):
        find_hours(weather, 2023)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ({"zone": 4.0}, "diffuse irradiance is centred at 9.0 h"),
        ({"zone": -1.0}, "diffuse irradiance is centred at 14.0 h"),
        ({"longitude": -8.5}, "diffuse irradiance is centred at 10.9 h"),
        ({"longitude": 98.5}, "meridian is 84 degrees from the longitude 98.5"),
    ],
)
def test_a_wrong_zone_or_longitude_is_told_by_the_sun(read, wrong, words):
    weather = read(cloudless_year(MANNHEIM), **(MANNHEIM | wrong))
    found = told(weather, find_hours(weather))
    assert any(words in text for text in found), found
    assert any("direct irradiance while the sun is down, which is taken as 0" in t for t in found)


def test_a_wrong_hemisphere_is_told_by_the_sun(read):
    """The sun of the other half of the year shines before it rises."""
    weather = read(cloudless_year(MANNHEIM), **(MANNHEIM | {"latitude": -49.5}))
    assert any("while the sun is down" in text for text in told(weather, find_hours(weather)))


def test_the_south_has_its_summer_in_december_and_its_sun_in_the_north(read):
    sydney = {"latitude": -33.87, "longitude": 151.21, "zone": 10.0}
    weather = read(cloudless_year(sydney), **sydney)
    hours = find_hours(weather)
    assert told(weather, hours) == []
    by_month = [np.nansum(hours.diffuse_horizontal[weather.month == m]) for m in range(1, 13)]
    assert int(np.argmax(by_month)) + 1 in {12, 1}
    assert int(np.argmin(by_month)) + 1 == 6
    noon = (np.abs(hours.sun.solar_time - 12.0) < 0.5) & (weather.month == 6)
    azimuth = hours.sun.azimuth[noon]
    assert (np.minimum(azimuth, 360.0 - azimuth) < 15.0).all()


def test_a_polar_year_has_a_night_and_a_day_of_months(read):
    svalbard = {"latitude": 78.2, "longitude": 15.6, "zone": 1.0}
    weather = read(cloudless_year(svalbard), **svalbard)
    hours = find_hours(weather)
    assert told(weather, hours) == []
    winter, summer = (np.isin(weather.month, months) for months in ((11, 12, 1), (5, 6, 7)))
    assert (hours.direct_normal[winter] == 0.0).all()
    assert (hours.direct_normal[summer] == 800.0).all()
    daylight = find_daylight_hours(weather, hours)
    assert (daylight.diffuse_horizontal[winter] == 0.0).all()
    assert (daylight.diffuse_horizontal[summer] > 0.0).all()


@pytest.mark.parametrize("year", [1900, 2100])
def test_first_and_last_year_have_no_leap_day_and_their_sun(read, year):
    weather = read(cloudless_year(MANNHEIM), **MANNHEIM)
    hours = find_hours(weather, year)
    usual = find_hours(weather)
    # The declination drifts by some hours of the calendar within the century; beside sunrise and sunset middles may differ.
    is_far = np.abs(usual.sun.elevation) > 10.0
    assert np.abs(hours.sun.elevation - usual.sun.elevation)[is_far].max() < 0.5
    leap = read(cloudless_year(MANNHEIM, 2004, has_leap_day=True), 2004, **MANNHEIM)
    with pytest.raises(SceneError, match=f"29 February, which {year} has not"):
        find_hours(leap, year)


@pytest.mark.parametrize("year", [1899, 2101])
def test_years_beyond_are_refused_whoever_states_them(read, year):
    rows = cloudless_year(MANNHEIM)[:24]
    with pytest.raises(SceneError, match="beyond 1900 to 2100"):
        find_hours(read(rows, **MANNHEIM), year)
    with pytest.raises(SceneError, match="beyond 1900 to 2100"):
        find_hours(read(rows, year, **MANNHEIM))
