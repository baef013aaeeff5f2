"""Weather files: what their records mean, when their sun shines, and what is wrong with them."""

import numpy as np
import pytest
from folders import WILD
from weather_files import epw, epw_record, epw_year, wea

from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.sky.place import Place, to_local
from lumenray.engine.sky.solar_position import find_sun
from lumenray.engine.sky.weather import find_hours
from lumenray.engine.sky.weather_file import read_weather

REAL = WILD / "epw"

NOON = {"dni": 700, "dhi": 90, "ghi": 500}


@pytest.fixture
def read(tmp_path):
    def read(text, encoding="utf-8"):
        path = tmp_path / "weather.txt"
        path.write_bytes(text.encode(encoding))
        return read_weather(path)

    return read


def first_of(weather, year=None):
    hours = find_hours(weather, year)
    return to_local(hours.times[0], weather.place.zone)


# ---- EPW ----


def test_epw_hour_ends_at_its_number_so_its_middle_is_half_an_hour_before(read):
    weather = read(epw([epw_record(1999, 7, 3, 12, **NOON)]))
    clock = first_of(weather)
    assert (clock.year, clock.month, clock.day, clock.hour, clock.minute) == (1999, 7, 3, 11, 30)
    assert clock.utcoffset().total_seconds() == 3600.0
    assert weather.interval == 1.0


def test_hour_24_is_the_last_of_its_day_not_the_first_of_the_next(read):
    clock = first_of(read(epw([epw_record(2005, 12, 31, 24, dni=0, dhi=0)])))
    assert (clock.year, clock.day, clock.hour, clock.minute) == (2005, 31, 23, 30)


@pytest.mark.parametrize("minute", [0, 60])
def test_minutes_do_not_count(read, minute):
    assert first_of(read(epw([epw_record(2005, 7, 3, 12, minute, **NOON)]))).minute == 30


def test_records_part_their_hour(read):
    records = [epw_record(2005, 7, 3, h, 15 * k, **NOON) for h in (12, 13) for k in range(1, 5)]
    weather = read(epw(records, per_hour=4))
    assert weather.interval == 0.25
    np.testing.assert_allclose(weather.hour, 11.125 + 0.25 * np.arange(8))


@pytest.mark.parametrize(
    ("place", "zone"),
    [
        ({"latitude": 28.6, "longitude": 77.2, "zone": 5.5}, "UTC+5:30"),
        ({"latitude": -33.9, "longitude": 151.2, "zone": 10}, "UTC+10"),
        ({"latitude": 47.6, "longitude": -52.7, "zone": -3.5}, "UTC-3:30"),
    ],
)
def test_place_and_its_sun(read, place, zone):
    weather = read(epw([epw_record(2005, 12, 21, 12, **NOON)], **place))
    assert weather.place == Place(
        place["latitude"], place["longitude"], zone, 100.0, name="Test, DEU"
    )
    sun = find_hours(weather).sun
    # Half an hour before noon by the clock: the solar time follows from the longitude and the equation of time.
    expected = 11.5 + place["longitude"] / 15.0 - place["zone"] + sun.equation_of_time[0] / 60.0
    assert sun.solar_time[0] == pytest.approx(expected, abs=0.001)
    # Summer in the south.
    assert (sun.elevation[0] > 70.0) == (place["latitude"] < 0.0)


def test_values_and_their_missing_codes(read):
    full = epw_record(
        *(2005, 7, 3, 12),
        temperature=21.5,
        dew=-3.2,
        pressure=98_700,
        water=17,
        albedo=0.2,
        global_lux=60_000,
        direct_lux=70_000,
        diffuse_lux=12_000,
        zenith=5000,
        **NOON,
    )
    weather = read(epw([full, epw_record(2005, 7, 3, 13)]))
    for name, value in {
        "temperature": 21.5,
        "dew_point": -3.2,
        "pressure": 98_700.0,
        "precipitable_water": 17.0,
        "albedo": 0.2,
        "global_illuminance": 60_000.0,
        "direct_normal_illuminance": 70_000.0,
        "diffuse_horizontal_illuminance": 12_000.0,
        "zenith_luminance": 5000.0,
        "direct_normal": 700.0,
        "diffuse_horizontal": 90.0,
        "global_horizontal": 500.0,
    }.items():
        assert weather.values[name][0] == value, name
        assert np.isnan(weather.values[name][1]), name
    assert [str(remark) for remark in weather.remarks] == [
        "line 10: 1 record has no direct normal irradiance",
        "line 10: 1 record has no diffuse horizontal irradiance",
        "has 2 of a year's 8760 records",
    ]


def test_values_that_no_record_has_are_left_out(read):
    weather = read(epw([epw_record(2005, 7, 3, 12, dni=0)]))
    assert set(weather.values) == {"direct_normal"}
    assert "no record has diffuse horizontal irradiance" in map(str, weather.remarks)
    with pytest.raises(SceneError, match="no direct and diffuse irradiance"):
        find_hours(weather)


def test_years_of_a_typical_year_are_those_of_its_months(read):
    weather = read(epw([epw_record(1999, 1, 5, 12, **NOON), epw_record(1976, 2, 5, 12, **NOON)]))
    hours = find_hours(weather)
    assert [to_local(t, "UTC").year for t in hours.times] == [1999, 1976]
    assert [to_local(t, "UTC").year for t in find_hours(weather, 2025).times] == [2025, 2025]


def test_leap_day_needs_a_leap_year(read):
    weather = read(epw([epw_record(2004, 2, 29, 12, **NOON), epw_record(2003, 3, 1, 12, **NOON)]))
    with pytest.raises(SceneError, match="29 February, which 2005 has not; expected a leap year"):
        find_hours(weather, 2005)
    assert to_local(find_hours(weather, 2024).times[0], "UTC").day == 29
    with pytest.raises(SceneError, match="which 2100 has not"):
        find_hours(weather, 2100)


@pytest.mark.parametrize(("has_leap_day", "count"), [(False, 8760), (True, 8784)])
def test_whole_years_have_nothing_odd(read, has_leap_day, count):
    year = 2004 if has_leap_day else 2005
    weather = read(epw(epw_year(year, has_leap_day, dni=0, dhi=0)))
    assert len(weather) == count
    assert not weather.remarks
    hours = find_hours(weather)
    np.testing.assert_allclose(np.diff(hours.times[hours.sun.elevation < -10.0]) % 3600.0, 0.0)
    clock = to_local(find_hours(weather, 2024).times[0], weather.place.zone)
    assert (clock.year, clock.month, clock.day, clock.hour, clock.minute) == (2024, 1, 1, 0, 30)


def test_sun_of_an_hour_in_which_it_rises_late_is_that_of_its_lit_part(read):
    """On this morning it rises in the second half, so that the middle would be dark."""
    place = Place(49.5, 8.5, "UTC+1", 100.0)
    weather = read(epw([epw_record(2005, 1, 18, hour, dni=20, dhi=5) for hour in range(8, 13)]))
    hours = find_hours(weather)
    middles = weather.hour
    clock = [to_local(t, "UTC+1") for t in hours.times]
    shown = np.array([c.hour + c.minute / 60.0 + c.second / 3600.0 for c in clock])
    moved = np.flatnonzero(np.abs(shown - middles) > 0.01)
    for i in moved:
        assert hours.sun.elevation[i] > 0.0
        edge = find_sun(hours.times[i] + (middles[i] + 0.5 - shown[i]) * 3600.0, place).elevation
        # Half way between rise and the hour's end.
        assert hours.sun.elevation[i] == pytest.approx(0.5 * edge, abs=0.1)
    assert np.allclose(shown[2:], middles[2:], atol=1e-3)


def test_polar_night_and_polar_day(read):
    place = {"latitude": 78.2, "longitude": 15.6}
    night = find_hours(
        read(epw([epw_record(2005, 12, 21, h, dni=0, dhi=0) for h in range(1, 25)], **place))
    )
    assert (night.sun.elevation < 0.0).all()
    day = find_hours(
        read(epw([epw_record(2005, 6, 21, h, dni=300, dhi=80) for h in range(1, 25)], **place))
    )
    assert (day.sun.elevation > 0.0).all()
    assert not night.remarks
    assert not day.remarks


def test_sun_that_shines_at_night_is_told_and_left_out(read):
    hours = find_hours(read(epw([epw_record(2005, 7, 3, 1, dni=154, dhi=30, ghi=30)])))
    assert hours.direct_normal[0] == 0.0
    assert (
        "line 9: 1 record has direct irradiance while the sun is down, which is taken as 0"
        in str(hours.remarks[0])
    )
    assert "more than 20 W/m2 of diffuse irradiance while the sun is down" in str(hours.remarks[1])


def test_oddities_are_told_with_their_number_and_line(read):
    records = [
        epw_record(2005, 7, 3, 11, dni=1500, dhi=90, ghi=900),
        epw_record(2005, 7, 3, 12, dni=0, dhi=400, ghi=200),
    ]
    remarks = " / ".join(map(str, read(epw(records, longitude=-8.5, zone=9)).remarks))
    assert "line 9: 1 record has more direct normal irradiance than the sun gives" in remarks
    assert "line 10: 1 record has more diffuse than global horizontal irradiance" in remarks
    assert "meridian is 144 degrees from the longitude -8.5" in remarks


def test_texts_of_windows_are_read(read):
    weather = read(epw([epw_record(2005, 7, 3, 12, **NOON)], city="Köln"), "latin-1")
    assert weather.place.name == "Köln, DEU"


FAULTS = {
    "another format": ("a,b\n", "is no weather file: expected EPW"),
    "a heading cut short": (
        "LOCATION,a\nDESIGN CONDITIONS\n",
        "line 3: begins with '', expected TYPICAL",
    ),
    "no location": (
        epw([]).replace(",49.5,8.5,1.0,100", ""),
        "line 1: has 6 fields of the location, expected at least 10",
    ),
    "latitude": (epw([], latitude=95), "line 1: has '95' as latitude, expected -90 to 90"),
    "longitude": (epw([], longitude="nan"), "line 1: has 'nan' as longitude"),
    "zone": (epw([], zone=15), "line 1: has '15' as time zone, expected -12 to 14"),
    "elevation": (epw([], elevation=1e6), "as elevation"),
    "records per hour": (epw([], per_hour=7), "line 8: has '7' as records per hour"),
    "records per hour without end": (epw([], per_hour=999999999), "as records per hour"),
    "no records": (epw([]), "has no records"),
    "columns": (epw(["2005,1,1,1,0,x,1,2,3"]), "line 9: has 9 columns, expected 35"),
    "a date": (
        epw([epw_record(2005, 4, 31, 1)]),
        "line 9: has month 4 and day 31, which no year has",
    ),
    "an hour": (epw([epw_record(2005, 4, 30, 25)]), "line 9: has '25' as hour, expected 1 to 24"),
    "hour 0": (epw([epw_record(2005, 4, 30, 0)]), "has '0' as hour"),
    "a word": (
        epw([epw_record(2005, 4, 30, 1, dni="much")]),
        "line 9: has 'much' as direct normal",
    ),
    "below 0": (
        epw([epw_record(2005, 4, 30, 1, dhi=-3)]),
        "line 9: has -3 W/m2 as diffuse horizontal",
    ),
    "kilojoules": (
        epw([epw_record(2005, 4, 30, 1, dni=2520)]),
        "has 2520 W/m2 as direct normal, expected 0 to 2000",
    ),
    "a record twice": (
        epw([epw_record(2005, 4, 30, h, **NOON) for h in (1, 2, 1)]),
        "line 11: states 30/4 (day/month) 0.5 h a second time, first in line 9",
    ),
    "two records of an hour": (
        epw([epw_record(2005, 4, 30, 1, **NOON)] * 2),
        "line 10: is record 2 of hour 1, which has 1 by DATA PERIODS",
    ),
    "half an hour missing": (
        epw([epw_record(2005, 4, 30, 1, **NOON)], per_hour=2),
        "line 9: is record 1 of hour 1, which has 2",
    ),
    "wea: no latitude": (
        "place A\nlongitude 3\n",
        "line 2: begins with 'longitude', expected latitude",
    ),
    "wea: cut short": ("place A\n", "expected latitude"),
    "wea: unit": (
        wea([], unit=4),
        "line 6: has '4' as weather_data_file_units, expected 1, 2 or 3",
    ),
    "wea: half a unit": (wea([], unit=1.5), "has '1.5' as weather_data_file_units"),
    "wea: meridian": (
        wea([], time_zone=-500),
        "line 4: has '-500' as time_zone, expected -210 to 180",
    ),
    "wea: no records": (wea([]), "has no records"),
    "wea: columns": (wea([(1, 1, 10.5, 3)]), "line 7: has 4 numbers, expected month, day, hour"),
    "wea: hour": (wea([(1, 1, 24.5, 3, 3)]), "line 7: has '24.5' as hour, expected 0 to 24"),
    "wea: word": (wea([(1, 1, 12, 3, "x")]), "line 7: has 'x' where a number was expected"),
    "wea: below 0": (wea([(1, 1, 12, -3, 3)]), "line 7: has -3 W/m2 as direct normal"),
    "wea: date": (wea([(2, 30, 12, 3, 3)]), "line 7: has month 2 and day 30"),
    "wea: twice": (
        wea([(2, 3, 12, 3, 3)] * 2),
        "line 8: states 3/2 (day/month) 12 h a second time",
    ),
}


@pytest.mark.parametrize("name", FAULTS)
def test_faults_are_refused_in_one_sentence(read, name):
    text, words = FAULTS[name]
    with pytest.raises(FileFormatError) as caught:
        read(text)
    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


# ---- WEA ----


def test_wea_counts_west_positive_and_states_the_middle(read):
    weather = read(wea([(7, 3, 11.5, 700, 90)], longitude=122.2, time_zone=120))
    assert weather.place == Place(49.5, -122.2, "UTC-8", 100.0, name="Test City")
    clock = first_of(weather, 2021)
    assert (clock.year, clock.month, clock.day, clock.hour, clock.minute) == (2021, 7, 3, 11, 30)


def test_wea_has_no_years(read):
    with pytest.raises(SceneError, match="has no years, expected a year to take it in"):
        find_hours(read(wea([(7, 3, 11.5, 700, 90)])))


def test_horizontal_irradiance_by_the_sun_becomes_normal(read):
    normal = find_hours(read(wea([(7, 3, 9.5, 600, 90)])), 2021)
    sine = np.sin(np.radians(normal.sun.elevation[0]))
    horizontal = find_hours(read(wea([(7, 3, 9.5, 600 * sine, 90)], unit=2)), 2021)
    assert horizontal.direct_normal[0] == pytest.approx(600.0, rel=1e-9)


def test_horizontal_irradiance_of_a_sun_at_the_horizon_says_nothing(read):
    hours = find_hours(read(wea([(7, 3, 0.5, 10, 9), (7, 3, 1.5, 0, 0)], unit=2)), 2021)
    assert np.isnan(hours.direct_normal[0])
    assert hours.direct_normal[1] == 0.0
    assert "line 7: 1 record has direct horizontal irradiance while the sun is lower" in str(
        hours.remarks[0]
    )


def test_illuminances_have_names_of_their_own(read):
    weather = read(wea([(7, 3, 9.5, 60_000, 9000)], unit=3))
    assert set(weather.values) == {"direct_normal_illuminance", "diffuse_horizontal_illuminance"}
    assert not weather.has_irradiance


def test_steps_of_minutes_are_found(read):
    records = [(7, 3, 9 + k / 6.0 + 1 / 12.0, 600, 90) for k in range(12)]
    assert read(wea(records)).interval == pytest.approx(1.0 / 6.0)


# ---- real files ----


@pytest.mark.parametrize(
    ("name", "count", "zone"),
    [
        ("USA_CA_Oakland.Intl.AP.724930_TMY3.epw", 8760, "UTC-8"),
        ("los_angeles_no_leap_field.epw", 8784, "UTC-8"),
        ("mannheim.epw", 8760, "UTC+1"),
        ("oak.wea", 8760, "UTC-8"),
        ("chicago_filtered.wea", 4427, "UTC-6"),
    ],
)
def test_real_files_are_read(name, count, zone):
    if not (REAL / name).exists():
        pytest.skip("no weather files on this machine")
    weather = read_weather(REAL / name)
    assert len(weather) == count
    assert weather.place.zone == zone
    hours = find_hours(weather, None if weather.year.any() else 2001)
    # Sun and clock agree: the sky is brightest about noon, true solar time; Mannheim's file is half an hour early, and told.
    noon = np.average(hours.sun.solar_time, weights=hours.diffuse_horizontal)
    told = [str(remark) for remark in hours.remarks if "centred" in str(remark)]
    assert bool(told) == (abs(noon - 12.0) > 0.4) == (name == "mannheim.epw")


@pytest.mark.parametrize("name", ["los_angeles_no_leap_field.epw", "mannheim.epw"])
def test_sun_is_where_the_files_own_column_has_it(name):
    """Column 10 is the irradiance of a horizontal plane outside the atmosphere."""
    if not (REAL / name).exists():
        pytest.skip("no weather files on this machine")
    rows = [line.split(",") for line in (REAL / name).read_text("latin-1").splitlines()[8:]]
    stated = np.array([float(row[10]) for row in rows])
    weather = read_weather(REAL / name)
    hours = find_hours(weather)
    times = hours.times[:, None] + (np.arange(6) - 2.5) * 600.0
    sun = find_sun(times, weather.place)
    found = 1361.0 / sun.distance**2 * np.maximum(np.sin(np.radians(sun.elevation)), 0.0)
    is_middle = np.isclose(hours.times % 3600.0, 1800.0, atol=1.0)
    error = (found.mean(axis=1) - stated)[is_middle]
    # Solar constants differ by a percent, and files round.
    assert np.sqrt(np.mean(error**2)) < 0.02 * stated.max()


def test_a_real_file_with_sun_at_night_is_told():
    """Its own column of the sun outside the atmosphere is 0 at night, by a clock that is half an hour early.

    A sun that is lifted by refraction and seen with its upper edge is up to 0.8333 degrees apart.
    """
    path = REAL / "mannheim.epw"
    if not path.exists():
        pytest.skip("no weather files on this machine")
    rows = [line.split(",") for line in path.read_text("latin-1").splitlines()[8:]]
    outside, direct = (np.array([float(row[column]) for row in rows]) for column in (11, 14))
    weather = read_weather(path)
    hours = find_hours(weather)
    middles = 3600.0 * (np.round(hours.times / 3600.0 - 0.5) + 0.5)
    moments = middles[:, None] + np.linspace(-1800.0, 1800.0, 13)
    own = find_sun(moments, weather.place).elevation.max(axis=1)
    early = find_sun(moments - 1800.0, weather.place).elevation.max(axis=1)
    assert not outside[early < -0.8333].any()
    assert (outside[early > 0.8333] > 0.0).all()
    remark = next(r.text for r in hours.remarks if "direct" in r.text)
    assert int(remark.split()[0]) == np.count_nonzero((own <= 0.0) & (direct > 0.0)) > 1000


def test_the_same_place_in_both_formats_is_the_same():
    if not REAL.exists():
        pytest.skip("no weather files on this machine")
    ours = read_weather(REAL / "USA_CA_Oakland.Intl.AP.724930_TMY3.epw")
    other = read_weather(REAL / "test.wea")
    assert (ours.place.latitude, ours.place.longitude, ours.place.zone) == (
        other.place.latitude,
        other.place.longitude,
        other.place.zone,
    )
