"""Files of requirements: those that ship, and how others are refused."""

import pytest

from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.judgement.reader import find_requirement, known_requirements, read_requirements
from lumenray.libraries import requirements

OWN = """
standard = "House rules"

[office.writing]
title = "Writing, brighter"
task = { mean = 750, uniformity = 0.7 }

[studio.bench]
title = "Bench"
source = "the client"
task = { mean = 1000 }
light = { ra = 90 }
"""


def written(folder, text):
    path = folder / "own.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_what_ships_can_be_read_and_says_where_it_is_from():
    known = known_requirements()
    standards = {each.standard.split(":")[0] for each in known.values()}
    assert standards == {"EN 12464-1", "EN 1838", "EN 12193", "EN 13201-2"}
    assert all(each.source and each.title for each in known.values())
    assert len(requirements.files()) == 4


def test_offices_are_those_of_the_standard_of_2021():
    office = find_requirement("office.writing")
    assert office.areas["task"] == {"mean": 500.0, "modified": 1000.0, "uniformity": 0.6}
    assert office.areas["cylindrical"]["mean"] == office.areas["walls"]["mean"] == 150.0
    assert office.areas["ceiling"]["mean"] == 100.0
    assert office.light == {"ugr": 19.0, "ra": 80.0}


def test_users_files_stand_beside_and_before_those_that_ship(tmp_path):
    path = written(tmp_path, OWN)
    assert find_requirement("office.writing", [path]).areas["task"]["mean"] == 750.0
    assert find_requirement("studio.bench", [path]).source == "the client"
    assert find_requirement("office.meeting", [path]).standard == "EN 12464-1:2021"


def test_an_unknown_key_names_those_of_its_group():
    with pytest.raises(SceneError, match=r"office\.writting.*office\.writing"):
        find_requirement("office.writting")
    with pytest.raises(SceneError, match="emergency, industry"):
        find_requirement("nothing")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[a", "is no TOML"),
        ("", "holds no activity"),
        ("standard = 3", "expected a text for 'standard'"),
        ("a = 3", "expected a table for 'a'"),
        ('[a.b]\ntitle = "x"', "asks for nothing"),
        ('[a.b]\ntitle = "x"\ntask = 500', "expected values such as"),
        ('[a.b]\ntitle = "x"\ntask = { lux = 500 }', "has 'lux', expected mean"),
        ('[a.b]\ntitle = "x"\ntask = { mean = -1 }', "expected a number above 0"),
        ('[a.b]\ntitle = "x"\ntask = { mean = true }', "expected a number above 0"),
        ('[a.b]\ntitle = "x"\ntask = { mean = inf }', "expected a number above 0"),
        ('[a.b]\ntitle = "x"\ntask = { uniformity = 1.5 }', "above 0 up to 1"),
        ('[a.b]\ntitle = "x"\nfloor = { mean = 1 }', "has 'floor', expected title"),
        ("[a.b]\ntitle = 3\ntask = { mean = 1 }", "needs a text for 'title'"),
    ],
)
def test_files_that_make_no_sense_are_refused(tmp_path, text, words):
    with pytest.raises(FileFormatError, match=words):
        read_requirements(written(tmp_path, text))


def test_a_missing_file_is_refused(tmp_path):
    with pytest.raises(FileFormatError, match="cannot be read"):
        read_requirements(tmp_path / "none.toml")
