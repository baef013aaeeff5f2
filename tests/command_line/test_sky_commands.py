"""The commands ``lumenray sky``: what they tell and draw."""

import json
from functools import partial

import numpy as np
import pytest
from commands import run_command
from PIL import Image
from weather_files import epw, epw_record, epw_year, wea

from lumenray.command_line.main import main

run = partial(run_command, "sky")

BERLIN = ("--place", "Berlin")

NOON = ("--time", "2026-06-21T12:00")


def told(capsys, *arguments):
    code, out, err = run(capsys, "info", "--json", *arguments)
    assert (code, err) == (0, "")
    return json.loads(out)


def refusal(capsys, *arguments):
    code, _, err = run(capsys, *arguments)
    assert code == 1
    assert err.count("\n") == 1
    return err


@pytest.fixture
def summer(tmp_path):
    """A weather file of one day in July."""
    path = tmp_path / "summer.epw"
    given = {12: (700, 90), 13: (0, 300), 14: (9999, 9999)}
    path.write_text(
        epw(
            [
                epw_record(2005, 7, 3, h, dni=given.get(h, (0, 0))[0], dhi=given.get(h, (0, 0))[1])
                for h in range(1, 25)
            ]
        )
    )
    return path


# ---- info ----


def test_info_tells_people_and_programs_of_the_sun(capsys):
    row = told(capsys, *BERLIN, *NOON)
    # Noon of 21 June at 13:08 by the clock; the sun is then at 90 - 52.52 + 23.43 degrees.
    assert row["day"]["noon"].startswith("2026-06-21T13:08")
    assert row["sun"]["declination_deg"] == pytest.approx(23.43, abs=0.01)
    assert row["sun"]["azimuth_deg"] < 180.0
    assert row["time"]["utc"] == "2026-06-21T10:00:00+00:00"
    assert row["sun"]["elevation_with_refraction_deg"] > row["sun"]["elevation_deg"]
    horizontal = row["cloudless"]["direct_normal_lx"] * np.sin(
        np.radians(row["sun"]["elevation_deg"])
    )
    assert row["cloudless"]["direct_horizontal_lx"] == pytest.approx(horizontal, rel=1e-5)
    code, out, _ = run(capsys, "info", *BERLIN, *NOON)
    assert code == 0
    assert "Berlin, Germany" in out
    assert "2026-06-21 12:00 (UTC+02:00)" in out
    assert "noon 13:08:" in out


def test_coordinates_without_a_zone_are_in_universal_time(capsys):
    row = told(capsys, "--latitude", "52.52", "--longitude", "13.4", "--time", "2026-06-21T10:00")
    city = told(capsys, *BERLIN, *NOON)
    assert row["sun"]["azimuth_deg"] == pytest.approx(city["sun"]["azimuth_deg"], abs=1e-3)


def test_southern_summer(capsys):
    row = told(
        capsys, "--latitude", "-33.87", "--longitude", "151.21", "--zone", "Australia/Sydney",
        "--time", "2026-12-21T12:53",
    )  # fmt: skip
    azimuth = row["sun"]["azimuth_deg"]
    assert min(azimuth, 360.0 - azimuth) < 1.0
    assert row["sun"]["elevation_deg"] == pytest.approx(90.0 - 33.87 + 23.44, abs=0.05)


def test_polar_day_and_night_are_said(capsys):
    place = ("--latitude", "78.2", "--longitude", "15.6", "--zone", "UTC+1")
    _, out, _ = run(capsys, "info", *place, "--time", "2026-06-21T00:00")
    assert "the sun does not set" in out
    _, out, _ = run(capsys, "info", *place, "--time", "2026-12-21T12:00")
    assert "the sun does not rise" in out
    row = told(capsys, *place, "--time", "2026-12-21T12:00")
    assert row["day"]["sunrise"] is None
    assert row["cloudless"]["direct_normal_lx"] == 0.0


def test_hours_that_clocks_leave_out_are_said(capsys):
    row = told(capsys, *BERLIN, "--time", "2026-03-29T02:30")
    assert "leave out 02:30" in row["time"]["note"]


@pytest.mark.parametrize("year", [1900, 2100])
def test_first_and_last_year(capsys, year):
    row = told(capsys, "--latitude", "51.5", "--longitude", "0", "--time", f"{year}-06-21T12:00")
    assert row["sun"]["elevation_deg"] == pytest.approx(61.9, abs=0.1)
    for beyond in (year - 1, year + 1):
        if not 1900 <= beyond <= 2100:
            err = refusal(capsys, "info", *BERLIN, "--time", f"{beyond}-06-21T12:00")
            assert "expected 1900 to 2100" in err


def test_info_tells_of_a_weather_file_and_its_hour(capsys, summer):
    row = told(capsys, "--weather", summer, "--time", "2026-07-03T11:30")
    hour = row["hour"]
    assert hour["line"] == 20
    assert (hour["direct_normal_w_m2"], hour["diffuse_horizontal_w_m2"]) == (700.0, 90.0)
    assert hour["sky_class"] == 8
    # Sunlight has about 100, a clear sky about 130 lm/W.
    assert 60_000 < hour["direct_normal_lx"] < 80_000
    assert 9_000 < hour["diffuse_horizontal_lx"] < 14_000
    assert row["weather"]["sums"]["direct_normal_kwh_m2"] == pytest.approx(0.7)
    assert row["weather"]["sums"]["diffuse_horizontal_kwh_m2"] == pytest.approx(0.39)
    assert row["weather"]["sunshine_h"] == 1.0
    assert row["weather"]["missing_records"] == 1
    assert row["weather"]["en17037"] is None
    assert "has 24 of a year's 8760 records" in row["weather"]["remarks"]
    _, out, _ = run(capsys, "info", "--weather", summer, "--time", "2026-07-03T12:30")
    assert "overcast, class 1 of 8" in out
    assert "1 without values" in out


@pytest.mark.parametrize(
    ("time", "line"), [("11:00", 20), ("11:59", 20), ("12:00", 21), ("00:00", 9), ("23:59", 32)]
)
def test_hours_begin_with_their_first_minute(capsys, summer, time, line):
    assert told(capsys, "--weather", summer, "--time", f"2005-07-03T{time}")["hour"]["line"] == line


def test_clocks_of_a_zone_read_the_file_an_hour_earlier(capsys, summer):
    row = told(capsys, "--weather", summer, "--zone", "Europe/Berlin", "--time", "2026-07-03T12:30")
    assert row["hour"]["line"] == 20


def test_hours_without_values_are_unknown(capsys, summer):
    code, out, _ = run(capsys, "info", "--weather", summer, "--time", "2026-07-03T13:30")
    assert code == 0
    assert "sun unknown W/m² normal, sky unknown W/m²" in out
    assert "its illuminances are not known" in out
    assert (
        told(capsys, "--weather", summer, "--time", "2026-07-03T13:30")["hour"]["sky_class"] is None
    )


def test_whole_years_have_the_median_sky_of_the_standard(capsys, tmp_path):
    path = tmp_path / "year.epw"
    path.write_text(epw(epw_year(2005, dni=0, dhi=100, dew=10)))
    row = told(capsys, "--weather", path)
    standard = row["weather"]["en17037"]
    assert standard["target_factors"]["minimum"]["target"] == pytest.approx(
        300.0 / standard["median_diffuse_lx"], rel=1e-5
    )
    _, out, _ = run(capsys, "info", "--weather", path)
    assert "EN 17037" in out


def test_files_without_years_are_taken_in_one(capsys, tmp_path):
    path = tmp_path / "day.wea"
    path.write_text(wea([(2, 28, 11.5, 600, 90)]))
    assert told(capsys, "--weather", path)["weather"]["taken_as_year"] == 2001
    path.write_text(wea([(2, 29, 11.5, 600, 90)]))
    assert told(capsys, "--weather", path)["weather"]["taken_as_year"] == 2000
    err = refusal(capsys, "info", "--weather", path, "--year", "2025")
    assert "29 February, which 2025 has not" in err


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((), "expected a place: --place"),
        (BERLIN, "expected --time, such as"),
        (("--latitude", "5", *NOON), "needs both --latitude and --longitude"),
        ((*BERLIN, "--latitude", "5", "--longitude", "5", *NOON), "the place is told twice"),
        (("--place", "Nowhere", *NOON), "no city of the library is called 'Nowhere'"),
        (("--place", "San", *NOON), "write the whole name"),
        ((*BERLIN, "--zone", "Berlin", *NOON), "time zone 'Berlin' is not known"),
        (("--weather", "none.epw"), "none.epw: cannot be opened"),
    ],
)
def test_what_is_missing_or_wrong_is_one_sentence(capsys, arguments, words):
    assert words in refusal(capsys, "info", *arguments)


@pytest.mark.parametrize(
    "arguments",
    [
        (*BERLIN, "--time", "12:00"),
        (*BERLIN, "--time", "2026-06-21T12:00Z"),
        (*BERLIN, "--time", "2026-06-31T12:00"),
        ("--latitude", "91", "--longitude", "0", *NOON),
    ],
)
def test_options_that_cannot_be_read_have_the_code_of_options(capsys, arguments):
    with pytest.raises(SystemExit) as ended:
        main(["sky", "info", *arguments])
    assert ended.value.code == 2
    assert capsys.readouterr().err.count("\n") == 1


def test_cities_are_found_by_their_own_names_and_countries(capsys):
    assert told(capsys, "--place", "münchen", *NOON)["place"]["name"] == "Munich, Germany"
    assert (
        told(capsys, "--place", "san jose, costa", *NOON)["place"]["zone"] == "America/Costa_Rica"
    )


def test_own_cities_are_found_beside_those_of_the_library(capsys, tmp_path):
    path = tmp_path / "own.csv"
    heading = "name,country,latitude,longitude,zone"
    path.write_text(f"{heading}\nSmallville,Kansas,38.9,-97.6,America/Chicago\nBad,X,99,0,UTC\n")
    code, out, err = run(capsys, "info", "--json", "--cities", path, "--place", "Smallville", *NOON)
    assert code == 0
    assert json.loads(out)["place"]["latitude_deg"] == 38.9
    assert err.count("\n") == 1
    assert "line 3 has '99' as latitude" in err
    _, out, _ = run(capsys, "info", "--cities", path, *BERLIN, *NOON)
    assert "Berlin, Germany" in out
    path.write_text("no list\n")
    err = refusal(capsys, "info", "--cities", path, *BERLIN, *NOON)
    assert "line 1 has no column 'name'" in err


# ---- plot ----


@pytest.mark.parametrize(
    "arguments",
    [
        (*BERLIN, *NOON, "--cie", "12"),
        (*BERLIN, *NOON, "--cloudiness", "0.5", "--illuminance", "20000", "--dark"),
        ("--latitude", "78", "--longitude", "15", "--time", "2026-06-21T00:00", "--cie", "5"),
        (*BERLIN, "--time", "2026-06-21T00:00", "--cie", "16", "--illuminance", "1"),
    ],
)
def test_plot_draws_skies_by_formula(capsys, tmp_path, arguments):
    target = tmp_path / "out" / "sky.png"
    code, out, err = run(capsys, "plot", *arguments, "-o", target, "--size", "320x300")
    assert (code, err) == (0, "")
    assert "written to" in out
    picture = np.asarray(Image.open(target).convert("RGB"))
    assert picture.shape == (300, 320, 3)
    assert (picture.mean() < 128) == ("--dark" in arguments) or "16" in arguments


def test_plot_draws_the_hour_of_a_weather_file(capsys, tmp_path, summer):
    target = tmp_path / "hour.png"
    code, _, _ = run(
        capsys, "plot", "--weather", summer, "--time", "2026-07-03T11:30", "-o", target
    )
    assert code == 0
    # The sun is a white dot in the south, half an hour before noon a little to the east.
    picture = np.asarray(Image.open(target).convert("RGB")).astype(int)
    hit = np.argwhere((picture > 250).all(axis=-1))
    inside = hit[np.hypot(hit[:, 0] - 341, hit[:, 1] - 273) < 150]
    assert 341 < inside[:, 0].mean() < 460
    assert inside[:, 1].mean() > 273


def test_plot_draws_the_mean_of_hours(capsys, tmp_path, summer):
    target = tmp_path / "mean.png"
    code, _, err = run(
        capsys, "plot", "--weather", summer, "--mean", "months=7,hours=11-13", "-o", target
    )
    assert (code, err) == (0, "")
    with Image.open(target) as picture:
        assert picture.size == (640, 640)
    refused = refusal(
        capsys, "plot", "--weather", summer, "--mean", "months=1", "-o", tmp_path / "b.png"
    )
    assert "no record of month 1" in refused
    assert "expected --weather" in refusal(
        capsys, "plot", *BERLIN, "--mean", "months=1", "-o", tmp_path / "b.png"
    )


def test_plot_draws_measured_skies_with_and_without_a_place(capsys, tmp_path):
    table = tmp_path / "scan.sky"
    table.write_text("\n".join(["4000"] * 145))
    for more in ((), BERLIN, (*BERLIN, *NOON)):
        code, _, err = run(
            capsys, "plot", "--measured", table, *more, "-o", tmp_path / "a.png", "--force"
        )
        assert (code, err) == (0, "")


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ((*BERLIN, *NOON), "expected a sky: --cie"),
        ((*BERLIN, "--cie", "3"), "expected --time"),
        ((*NOON, "--cie", "3"), "expected a place"),
        ((*BERLIN, "--time", "2026-06-21T00:00", "--cie", "3"), "degrees below the horizon"),
        (("--measured", "none.sky"), "none.sky: cannot be opened"),
    ],
)
def test_plot_says_what_is_missing(capsys, tmp_path, arguments, words):
    assert words in refusal(capsys, "plot", *arguments, "-o", tmp_path / "a.png")
    assert not (tmp_path / "a.png").exists()


@pytest.mark.parametrize(
    ("time", "words"),
    [
        ("2026-07-03T13:30", "line 22 of the weather file is not known"),
        ("2026-07-03T01:30", "line 10 of the weather file is 0"),
        ("2026-07-04T12:00", "no record of 12:00 on 2026-07-04"),
    ],
)
def test_plot_says_which_hour_has_no_sky(capsys, tmp_path, summer, time, words):
    err = refusal(capsys, "plot", "--weather", summer, "--time", time, "-o", tmp_path / "a.png")
    assert words in err
