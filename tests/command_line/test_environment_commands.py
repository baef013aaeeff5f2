"""The commands ``lumenray environment``: what they tell, write and refuse."""

import json
from functools import partial

import numpy as np
import pytest
from commands import run_command
from PIL import Image

from lumenray.benchmarks.environment.drawn_maps import Spot, make_map
from lumenray.engine.environment.map_file import read_map, write_map
from lumenray.engine.scene.light import CieSky
from lumenray.engine.sky.availability import usual_illuminance
from lumenray.engine.sky.picture import find_illuminance
from lumenray.engine.sky.skies import find_luminances
from lumenray.engine.sky.sunlight import direct_illuminance

pytestmark = pytest.mark.mitsuba

run = partial(run_command, "environment")

SUN = Spot(40.0, 120.0, 2.0, 3.0)


def written(capsys, *arguments):
    code, out, err = run(capsys, *arguments)
    assert (code, err) == (0, "")
    return out


def refusal(capsys, *arguments):
    code, _, err = run(capsys, *arguments)
    assert code == 1
    assert err.count("\n") == 1
    return err


def horizontal(path):
    return find_illuminance(read_map(path)[0], np.eye(3), np.array([0.0, 0.0, 1.0]))


@pytest.fixture
def street(tmp_path):
    """A picture of an even sky of 1 over a ground of 0.2, with a sun."""
    return write_map(tmp_path / "street.exr", make_map(256, [SUN]))


def test_analyse_tells_people_and_programs(street, tmp_path, capsys):
    row = json.loads(written(capsys, "analyse", street, "--json", "-o", tmp_path / "a.png"))
    assert row["luminance_per_unit_cd_m2"] == 179.0
    (source,) = row["sources"]
    assert (source["elevation_deg"], source["azimuth_deg"]) == pytest.approx((40, 120), abs=0.1)
    assert source["illuminance_lx"] == pytest.approx(3.0 * 179.0, rel=0.03)
    assert row["sun_over_all_else"] == pytest.approx(3.0 * np.sin(np.radians(40)) / np.pi, rel=0.03)
    assert Image.open(tmp_path / "a.png").size == (900, 680)
    text = written(capsys, "analyse", street, "--lux", "5000")
    assert "clipped at 1 : 1.6" in text
    assert "5000 lx" in text
    assert "lx horizontal" in text and "{" not in text
    row = json.loads(written(capsys, "analyse", street, "--json", "--white", 10, "--factor", 2))
    assert row["luminance_per_unit_cd_m2"] == 20.0
    row = json.loads(written(capsys, "analyse", street, "--json", "--source", 10000))
    assert row["sources"] == []


def test_extract_writes_a_clipped_picture_and_its_lights(street, tmp_path, capsys):
    out, lights = tmp_path / "clipped.exr", tmp_path / "lights.json"
    written(capsys, "extract", street, "-o", out, "--lights", lights)
    made = json.loads(lights.read_text())
    (light,) = made["lights"]
    together = 179.0 * horizontal(out) + light["horizontal_lx"]
    assert together == pytest.approx(179.0 * horizontal(street), rel=1e-5)
    assert np.asarray(light["towards"]) == pytest.approx(SUN.towards, abs=2e-3)
    assert "is there already" in refusal(capsys, "extract", street, "-o", out)
    even = write_map(tmp_path / "even.exr", make_map(16, []))
    assert "no bright source" in refusal(capsys, "extract", even, "-o", tmp_path / "b.exr")


def test_repair_brings_the_sun_to_a_multiple_of_the_sky(street, tmp_path, capsys):
    out = tmp_path / "mended.exr"
    written(capsys, "repair", street, "-o", out, "--ratio", 2.5)
    row = json.loads(written(capsys, "analyse", out, "--json"))
    assert row["sun_over_all_else"] == pytest.approx(2.5, rel=0.02)


def test_repair_finds_the_time_and_the_model_s_sun(tmp_path, capsys):
    """In Berlin on 20 May the sun is 39.3 degrees high at 09:40 by the clock (NREL) and rises by 9 an hour."""
    sun = Spot(37.26, 10.0, illuminance=1e-3 * direct_illuminance(37.26, 3.0))
    sky = CieSky(12, sun.towards, usual_illuminance("clear", 37.26))
    drawn = make_map(512, [sun], lambda d: 1e-3 * find_luminances(sky, d), 0.5, clip=500.0)
    yard, out = write_map(tmp_path / "yard.exr", drawn), tmp_path / "mended.exr"
    where = ("--place", "Berlin", "--date", "2026-05-20", "--sky", "100,200")
    text = written(capsys, "repair", yard, "-o", out, *where)
    assert "2026-05-20 09:2" in text
    assert "its height is sure to 0.18°, half a pixel, the time to" in text
    assert "half a pixel of its height changes its light by" in text
    row = json.loads(written(capsys, "analyse", out, "--json"))
    lit = row["sources"][0]["illuminance_lx"] / 179.0
    # The sun is farther away in May than the mean, by 1.2 %, and Berlin lies 34 m above the sea.
    assert lit == pytest.approx(sun.illuminance / 1.024, rel=0.01)
    words = refusal(
        capsys,
        "repair",
        yard,
        "-o",
        tmp_path / "b.exr",
        *where[:2],
        "--date",
        "2026-12-21",
        *where[4:],
    )
    assert "stands 37" in words
    assert "needs --sky" in refusal(capsys, "repair", yard, "-o", tmp_path / "b.exr", *where[:2])
    assert "one of" in refusal(
        capsys, "repair", yard, "-o", tmp_path / "b.exr", *where, "--ratio", 4
    )


def test_damaged_files_are_refused_with_a_sentence(street, tmp_path, capsys):
    half = tmp_path / "half.exr"
    half.write_bytes(street.read_bytes()[:3000])
    for task in (
        ("analyse",),
        ("extract", "-o", tmp_path / "b.exr"),
        ("repair", "-o", tmp_path / "b.exr"),
    ):
        assert "ends early" in refusal(capsys, task[0], half, *task[1:])
    text = tmp_path / "notes.hdr"
    text.write_text("hello")
    assert "expected a Radiance picture" in refusal(capsys, "analyse", text)
