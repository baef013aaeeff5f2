"""The command ``lumenray daylight`` on a floor in the open, whose year the weather tells."""

import json

import bpy
import numpy as np
import pytest
from blender_objects import add_quad, new_paint
from commands import run_command
from PIL import Image
from weather_files import epw, epw_year, sunny_year

pytestmark = pytest.mark.usefixtures("extension")


@pytest.fixture
def open_floor(tmp_path):
    """A .blend file with a floor, a plate high above it in the collection Blinds, and a weather file."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    paint = new_paint()
    floor = add_quad("Floor", material=paint)
    floor.scale = (4.0, 4.0, 1.0)
    plate = add_quad("Plate", material=paint)
    plate.scale, plate.location = (400.0, 400.0, 1.0), (-198.0, -198.0, 3.0)
    blinds = bpy.data.collections.new("Blinds")
    bpy.context.scene.collection.children.link(blinds)
    blinds.objects.link(plate)
    bpy.context.scene.collection.objects.unlink(plate)
    path, weather = tmp_path / "floor.blend", tmp_path / "year.epw"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    weather.write_text(sunny_year(), encoding="latin-1")
    return path, weather


def ask(capsys, path, weather, out, *more):
    return run_command(
        "daylight", capsys, path, "--weather", weather, "-o", out, "--samples", "600", *more
    )


def read_table(path):
    lines = [line for line in path.read_text().splitlines() if not line.startswith("#")]
    return np.genfromtxt(lines, delimiter=",", names=True, dtype=None, encoding="utf-8")


def read_channels(path):
    """Channels of an OpenEXR file by name, row 0 at the top."""
    import mitsuba as mi

    bitmap = mi.Bitmap(str(path))
    names = [entry.name for entry in bitmap.struct_()]
    return dict(zip(names, np.moveaxis(np.array(bitmap), -1, 0), strict=True))


@pytest.mark.mitsuba
def test_a_year_over_a_floor_with_blinds(open_floor, tmp_path, capsys):
    path, weather = open_floor
    out = tmp_path / "out"
    code, said, errors = ask(
        capsys, path, weather, out, "--floor", "Floor", "--spacing", "2", "--blinds", "Blinds",
        "--least-sun", "10", "--hourly",
    )  # fmt: skip
    assert code == 0, errors
    assert "no light" not in errors
    assert "4 sensors" in said
    found = json.loads((out / "summary.json").read_text())
    figures = found["figures"]
    factor = figures["daylight_factor_median"]
    # Half of the hours with much sun have the plate above, but not the daylight factor.
    assert factor["low"] - 1e-3 <= 1.0 <= factor["high"] + 1e-3
    assert figures["en17037_factors"]["level"] == "high"
    assert 0.0 < figures["ase"]["value"] <= 1.0
    sensors, hours, matrix = (
        read_table(out / name) for name in ("sensors.csv", "hours.csv", "illuminance.csv")
    )
    np.testing.assert_allclose(sensors["z"], 0.8)
    np.testing.assert_allclose(sensors["area_m2"], 4.0)
    is_open = hours["blinds_1"] == "open"
    assert 0.2 < is_open.mean() < 0.95
    # Hours without a sun that could close the blinds have what the sky gives.
    overcast = hours["direct_normal_lx"] == 0.0
    assert is_open[overcast].all()
    sky = hours["diffuse_horizontal_lx"][overcast]
    # Light from the ground below falls on the floor's back alone.
    np.testing.assert_allclose(hours["mean_lx"][overcast], sky, rtol=0.02, atol=1.0)
    mean = np.mean([matrix[f"s{k}_lx"] for k in range(1, 5)], axis=0)
    np.testing.assert_allclose(mean, hours["mean_lx"], rtol=1e-3, atol=0.1)
    for name in ("hours.png", "autonomy.png", "factor.png", "sunlight.png"):
        with Image.open(out / name) as picture:
            assert picture.size[0] > 400

    # Again without tracing: the same answer.
    before = (out / "sensors.csv").read_text()
    kept = {name.name: name.stat().st_mtime_ns for name in out.glob("traced_*")}
    assert len(kept) == 2
    code, _, errors = ask(
        capsys, path, weather, out, "--floor", "Floor", "--spacing", "2", "--blinds", "Blinds",
        "--least-sun", "10", "--resume",
    )  # fmt: skip
    assert code == 0, errors
    assert (out / "sensors.csv").read_text() == before
    assert {name.name: name.stat().st_mtime_ns for name in out.glob("traced_*")} == kept


@pytest.mark.mitsuba
@pytest.mark.slow
def test_maps_of_a_year(open_floor, tmp_path, capsys):
    path, weather = open_floor
    out = tmp_path / "out"
    code, said, errors = ask(
        capsys, path, weather, out, "--floor", "Floor", "--spacing", "2", "--blinds", "Blinds",
        "--blinds-when", "closed", "--maps", "Floor,Plate,Floor", "--lumels-per-m", "1",
    )  # fmt: skip
    assert code == 0, errors
    assert "Plate: the object has no surface that is rendered; it has no map" in errors
    assert "100 % of the hours with light" in said
    assert "maps of 1 objects with 16 lumels" in said
    found = json.loads((out / "summary.json").read_text())
    (row,) = found["maps"]
    assert (row["object"], row["lumels"], row["filled"]) == ("Floor", 16, 0)
    # Under the plate, as the sensors are that stand a little higher; daylight factors are those of open blinds.
    means = [each["mean_lx"]["value"] for each in (row["figures"], found["figures"])]
    assert means[0] == pytest.approx(means[1], rel=0.1)
    assert row["figures"]["daylight_factor_median"]["value"] == pytest.approx(1.0, rel=0.1)
    channels = read_channels(out / "maps" / "daylight_factor.1001.exr")
    covered = channels["covered.Y"] > 0.0
    assert covered.sum() == 16
    factor, error = channels["Y"][covered], channels["standard_error.Y"][covered]
    assert (np.abs(factor - 1.0) < 5.0 * error + 0.01).all()
    assert len(list((out / "maps").glob("*.exr"))) == len(list((out / "maps").glob("*.png"))) == 13
    code, _, errors = ask(
        capsys, path, weather, tmp_path / "other", "--floor", "Floor", "--maps", "Attic"
    )
    assert code == 1
    assert "no object named Attic" in errors


@pytest.mark.mitsuba
@pytest.mark.slow
def test_blinds_by_rules_of_ones_own(open_floor, tmp_path, capsys):
    path, weather = open_floor
    out = tmp_path / "out"
    code, _, errors = ask(
        capsys, path, weather, out, "--floor", "Floor", "--spacing", "4", "--blinds", "Blinds",
        "--blinds-when", "months=6-8,hours=0-24",
    )  # fmt: skip
    assert code == 0, errors
    assert "sDA, whose blinds are those of LM-83" in errors
    hours = read_table(out / "hours.csv")
    in_summer = np.array([clock[5:7] in {"06", "07", "08"} for clock in hours["clock"]])
    np.testing.assert_array_equal(hours["blinds_1"] == "closed", in_summer)
    # Under the plate there is little light, of what the ground below sends up.
    assert hours["mean_lx"][in_summer].mean() < 0.1 * hours["mean_lx"][~in_summer].mean()

    # The same states from a table, without tracing anew.
    table = tmp_path / "states.csv"
    months = [day // (24 * 30.4) for day in range(8760)]
    table.write_text("".join(f"{int(5 <= month < 8)}\n" for month in months))
    code, _, errors = ask(
        capsys, path, weather, out, "--floor", "Floor", "--spacing", "4", "--blinds", "Blinds",
        "--blinds-when", f"table={table}", "--resume",
    )  # fmt: skip
    assert code == 0, errors
    again = read_table(out / "hours.csv")
    assert 0.95 < ((again["blinds_1"] == "closed") == in_summer).mean() <= 1.0


@pytest.mark.parametrize(
    "rule", ["hours=25-3", "noon", "facade=200", "sun=180:200", "sun=-5", "workdays=1"]
)
def test_rules_for_blinds_that_are_none_are_refused(open_floor, tmp_path, capsys, rule):
    path, weather = open_floor
    with pytest.raises(SystemExit):
        ask(capsys, path, weather, tmp_path / "out", "--floor", "Floor", "--blinds-when", rule)
    assert "blinds-when" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (("--floor", "Attic"), "no object named Attic"),
        (("--floor", "Floor", "--blinds", "Curtains"), "no collection named 'Curtains'"),
        (("--floor", "Floor", "--blinds-when", "closed"), "there are none"),
        (("--floor", "Floor", "--sun-day", "6-21"), "between 1 February and 21 March"),
        (("--floor", "Floor", "--sun-day", "2-31"), "no day 02-31"),
        (("--floor", "Floor", "--hours", "18-8"), "18 to 8 h"),
        (("--floor", "Floor", "--zone", "Europe/Atlantis"), "Europe/Atlantis"),
        (("--floor", "Floor", "--spacing", "9"), "smaller"),
    ],
)
def test_what_makes_no_sense_is_refused_in_one_line(open_floor, tmp_path, capsys, more, words):
    path, weather = open_floor
    code, _, errors = ask(capsys, path, weather, tmp_path / "out", *more)
    assert code == 1
    assert words in errors
    assert len(errors.strip().splitlines()) == 1
    assert not (tmp_path / "out" / "summary.json").exists()


def test_a_year_without_light_is_refused(open_floor, tmp_path, capsys):
    path, _ = open_floor
    dark = tmp_path / "dark.epw"
    dark.write_text(epw(epw_year(2005, dni=0, dhi=0)), encoding="latin-1")
    code, _, errors = ask(capsys, path, dark, tmp_path / "out", "--floor", "Floor")
    assert code == 1
    assert "no hour has any daylight" in errors
