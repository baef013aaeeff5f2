"""Cities that ship: zones that exist, coordinates that fit them; users' lists, and what is typed to find a city."""

import math
import re
from datetime import datetime, timedelta
from pathlib import Path
from zoneinfo import TZPATH, ZoneInfo, available_timezones

import numpy as np
import pytest
from mutations import mutate

from lumenray.libraries.cities.catalogue import (
    FILE,
    MOST_PROBLEMS,
    City,
    all_cities,
    find_cities,
    fold,
    read_cities,
    shipped_cities,
)

CITIES = shipped_cities()

HEADER = "name,country,latitude,longitude,elevation_m,zone\n"

ZONE_TABLE = next((p for p in (Path(f) / "zone.tab" for f in TZPATH) if p.exists()), None)
"""The IANA's own table of the places that zones are named by."""


def distance(first, second):
    """Along the ground. [km]"""
    a, b = np.radians(first), np.radians(second)
    cosine = math.sin(a[0]) * math.sin(b[0]) + math.cos(a[0]) * math.cos(b[0]) * math.cos(
        a[1] - b[1]
    )
    return 6371.0 * math.acos(min(1.0, cosine))


def zone_places():
    places = {}
    for line in ZONE_TABLE.read_text(encoding="utf-8").splitlines():
        if line.startswith("#"):
            continue
        where, zone = line.split("\t")[1:3]
        parts = re.fullmatch(r"([+-]\d{4,6})([+-]\d{5,7})", where).groups()
        angles = []
        for part, whole in zip(parts, (2, 3), strict=True):
            digits = part[1:].ljust(whole + 4, "0")
            value = int(digits[:whole]) + int(digits[whole:-2]) / 60.0 + int(digits[-2:]) / 3600.0
            angles.append(math.copysign(value, float(part)))
        places[zone] = tuple(angles)
    return places


def test_the_whole_list_can_be_used():
    cities, problems = read_cities(FILE)
    assert not problems
    assert len(cities) >= 300
    assert len({(fold(city.name), fold(city.country)) for city in cities}) == len(cities)


def test_every_continent_has_its_cities():
    regions = [city.zone.split("/")[0] for city in CITIES]
    for region, least in [
        *[("Africa", 50), ("Asia", 90), ("Europe", 90), ("Australia", 8), ("Pacific", 12)],
        *[("Atlantic", 5), ("Indian", 4), ("Antarctica", 2)],
    ]:
        assert regions.count(region) >= least, region
    america = [city for city in CITIES if city.zone.startswith("America/")]
    assert sum(city.latitude > 13.0 for city in america) >= 60
    assert sum(city.latitude < 0.0 for city in america) >= 30


def test_zones_exist_and_fit_the_longitudes():
    known = available_timezones()
    for city in CITIES:
        assert city.zone in known, city.title
        # Standard time is the lesser of the year's offsets; in Morocco and Ireland it is within the bound either way.
        zone = ZoneInfo(city.zone)
        offset = min(datetime(2025, month, 1, tzinfo=zone).utcoffset() for month in (1, 7))
        apart = (offset / timedelta(hours=1) - city.longitude / 15.0 + 12.0) % 24.0 - 12.0
        assert abs(apart) < 3.5, city.title


@pytest.mark.skipif(ZONE_TABLE is None, reason="no time zone table on this system")
def test_cities_that_zones_are_named_by_lie_where_the_zone_data_have_them():
    places, count = zone_places(), 0
    for city in CITIES:
        last = fold(city.zone.split("/")[-1].replace("_", " "))
        if last in map(fold, (city.name, *city.other_names)) and city.zone in places:
            count += 1
            # The data have minutes of arc, of Longyearbyen degrees alone.
            assert distance((city.latitude, city.longitude), places[city.zone]) < 27.0, city.title
    assert count > 200


# ---- search ----


def names(query, cities=CITIES):
    return [city.name for city in find_cities(query, cities)]


@pytest.mark.parametrize(
    ("query", "first"),
    [
        ("munch", "Munich"),
        ("MÜNCH", "Munich"),
        ("zurich", "Zürich"),
        ("sao p", "São Paulo"),
        ("tromso", "Tromsø"),
        ("lodz", "Łódź"),
        ("ndjam", "N'Djamena"),
        ("nukualofa", "Nuku\u02bbalofa"),
        ("saint-den", "Saint-Denis"),
        ("san jo", "San José"),
        ("york", "New York"),
        ("istanbul", "Istanbul"),
        ("Hyderabad, ind", "Hyderabad"),
    ],
)
def test_cities_are_found_by_the_beginning_of_a_name(query, first):
    assert names(query)[0] == first


def test_country_after_a_comma_chooses():
    assert names("santiago") == ["Santiago"]
    assert names("s, norway") == []
    assert set(names(", norway")) == {"Bergen", "Longyearbyen", "Oslo", "Tromsø", "Trondheim"}


def test_names_that_begin_so_come_before_words_within():
    found = names("den")
    assert found[:2] == ["Denpasar", "Denver"]
    assert found[2:] == ["The Hague", "Saint-Denis"]


def test_no_more_are_returned_than_asked_for():
    assert len(find_cities("", CITIES, 7)) == 7


# ---- users' lists ----


def test_users_city_takes_the_place_of_one_that_ships(tmp_path):
    path = tmp_path / "cities.csv"
    path.write_text(
        "\ufeffzone,Name,country,longitude,latitude,note\r\n"
        'Europe/Berlin,BERLIN,Germany,13.5,52.5,"office, our"\r\n'
        "Asia/Tokyo,Hamlet,,139,35,\r\n\r\n",
        encoding="utf-8",
    )
    cities, problems = all_cities([path])
    assert not problems
    assert len(cities) == len(CITIES) + 1
    assert find_cities("berlin", cities) == [
        City("BERLIN", (), "Germany", 52.5, 13.5, 0.0, "Europe/Berlin")
    ]
    assert find_cities("hamlet", cities)[0].title == "Hamlet"


def test_first_of_several_lists_counts(tmp_path):
    for k in range(2):
        (tmp_path / f"{k}.csv").write_text(f"{HEADER}Here,X,{k},0,,UTC\n")
    cities, _ = all_cities([tmp_path / "0.csv", tmp_path / "1.csv"])
    assert find_cities("here", cities)[0].latitude == 0.0


@pytest.mark.parametrize(
    ("row", "words"),
    [
        ("A,X,91,0,0,UTC", "line 2 has '91' as latitude, expected -90 to 90"),
        ("A,X,0,-180.1,0,UTC", "has '-180.1' as longitude"),
        ("A,X,nan,0,0,UTC", "has 'nan' as latitude"),
        ("A,X,1_0,0,0,UTC", "has '1_0' as latitude"),
        ("A,X,0,0,1e9,UTC", "has '1e9' as elevation_m"),
        ("A,X,0,0,0,Europe/Atlantis", "has the zone 'Europe/Atlantis', expected a name"),
        ("A,X,0,0,0,../../etc/passwd", "has the zone"),
        ("A,X,0,0,0", "has no zone"),
        (",X,0,0,0,UTC", "has no name"),
        ("A//B,X,0,0,0,UTC", "name that is empty or too long"),
        (f"{'A' * 200},X,0,0,0,UTC", "name that is empty or too long"),
        ('"A,X', "is no CSV"),
    ],
)
def test_what_cannot_be_used_is_told_with_its_line(tmp_path, row, words):
    path = tmp_path / "cities.csv"
    path.write_text(f"{HEADER}{row}\n" + ("" if "CSV" in words else "Fine,X,0,0,0,UTC\n"))
    cities, problems = read_cities(path)
    assert [city.name for city in cities] == ([] if "CSV" in words else ["Fine"])
    assert words in str(problems[0])
    assert len(problems) == 1


def test_files_that_are_no_lists_are_told(tmp_path):
    assert "cannot be opened" in str(read_cities(tmp_path / "none.csv")[1][0])
    (tmp_path / "a.csv").write_bytes(b"name,\xff\n")
    assert "is not UTF-8 at byte 5" in str(read_cities(tmp_path / "a.csv")[1][0])
    (tmp_path / "a.csv").write_text("name;country\n")
    assert "line 1 has no column 'name'" in str(read_cities(tmp_path / "a.csv")[1][0])
    (tmp_path / "a.csv").write_text("")
    assert "line 1 has no column 'name'" in str(read_cities(tmp_path / "a.csv")[1][0])
    (tmp_path / "a.csv").write_text(HEADER + "A,X,99,0,0,UTC\n" * 1000)
    assert len(read_cities(tmp_path / "a.csv")[1]) == MOST_PROBLEMS


def test_damaged_lists_are_read_or_told(tmp_path):
    rng, path = np.random.default_rng(28), tmp_path / "cities.csv"
    data = b"".join(FILE.read_bytes().splitlines(keepends=True)[:40])
    count = 0
    for _ in range(200):
        path.write_bytes(mutate(data, rng))
        cities, problems = read_cities(path)
        count += bool(problems)
        assert all("\n" not in str(problem) for problem in problems)
        assert all(abs(city.latitude) <= 90.0 and abs(city.longitude) <= 180.0 for city in cities)
    assert 0 < count < 200
