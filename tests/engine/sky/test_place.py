"""Clocks of places: what they show once, twice and never."""

from datetime import datetime

import pytest

from lumenray.engine.errors import SceneError
from lumenray.engine.sky.place import (
    Place,
    check_place,
    find_zone,
    from_local,
    name_offset,
    to_local,
)


def utc(*clock):
    return from_local(datetime(*clock), "UTC").seconds


def test_daylight_saving_counts():
    assert from_local(datetime(2025, 1, 15, 12), "Europe/Berlin").seconds == utc(2025, 1, 15, 11)
    summer = from_local(datetime(2025, 7, 15, 12), "Europe/Berlin")
    assert (summer.seconds, summer.offset, summer.note) == (utc(2025, 7, 15, 10), 2.0, "")


def test_hour_that_clocks_show_twice_is_the_first_or_the_second():
    clock = datetime(2025, 10, 26, 2, 30)
    first = from_local(clock, "Europe/Berlin")
    second = from_local(clock, "Europe/Berlin", is_second=True)
    assert (first.seconds, first.offset) == (utc(2025, 10, 26, 0, 30), 2.0)
    assert (second.seconds, second.offset) == (utc(2025, 10, 26, 1, 30), 1.0)
    assert (
        first.note
        == "clocks of Europe/Berlin show 02:30 on 2025-10-26 twice, and the first was taken"
    )
    assert "the second was taken" in second.note


@pytest.mark.parametrize("is_second", [False, True])
def test_hour_that_clocks_leave_out_goes_on_as_before(is_second):
    time = from_local(datetime(2025, 3, 30, 2, 30), "Europe/Berlin", is_second=is_second)
    assert (time.seconds, time.offset) == (utc(2025, 3, 30, 1, 30), 2.0)
    assert time.note == (
        "clocks of Europe/Berlin leave out 02:30 on 2025-03-30, and 03:30 on 2025-03-30 was taken"
    )


def test_daylight_saving_of_the_south_and_of_half_an_hour():
    assert from_local(datetime(2025, 1, 15, 12), "Australia/Lord_Howe").offset == 11.0
    assert from_local(datetime(2025, 7, 15, 12), "Australia/Lord_Howe").offset == 10.5
    assert from_local(datetime(2025, 7, 15, 12), "Asia/Kathmandu").offset == 5.75


def test_before_zones_clocks_showed_the_mean_time_of_the_place():
    paris = from_local(datetime(1900, 6, 1, 12), "Europe/Paris")
    assert paris.offset == pytest.approx((9 * 60 + 21) / 3600.0)
    assert from_local(datetime(1900, 6, 1, 12), "America/New_York").offset == -5.0


def test_last_year():
    assert from_local(datetime(2100, 7, 1), "Europe/Berlin").offset == 2.0
    with pytest.raises(SceneError, match="the year is 2101, expected 1900 to 2100"):
        from_local(datetime(2101, 1, 1), "UTC")


def test_local_time_and_back():
    for zone in ("Asia/Kathmandu", "America/St_Johns", "UTC-3:30", "Pacific/Kiritimati"):
        clock = datetime(1987, 5, 4, 3, 2, 1)
        assert to_local(from_local(clock, zone).seconds, zone).replace(tzinfo=None) == clock


@pytest.mark.parametrize(
    ("hours", "name"), [(0.0, "UTC"), (5.5, "UTC+5:30"), (-8.0, "UTC-8"), (-3.5, "UTC-3:30")]
)
def test_fixed_offsets_have_names(hours, name):
    assert name_offset(hours) == name
    assert find_zone(name).utcoffset(None).total_seconds() == hours * 3600.0


@pytest.mark.parametrize(
    "zone",
    [
        "",
        "Europe/Atlantis",
        "UTC+16",
        "UTC+5:60",
        "../etc/passwd",
        "a\0b",
        "/etc/localtime",
        "x" * 5000,
    ],
)
def test_zones_that_are_none_are_refused_in_one_sentence(zone):
    with pytest.raises(SceneError) as caught:
        check_place(Place(0.0, 0.0, zone))
    assert "time zone" in str(caught.value)
    assert len(str(caught.value)) < 250
