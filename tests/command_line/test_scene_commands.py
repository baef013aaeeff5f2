"""Commands on Blender files: what they measure, bake and render, and how they fail."""

import json

import numpy as np
import pytest
from PIL import Image

from lumenray.command_line import main as command_line
from lumenray.engine.analysis.denoiser import find_denoiser
from lumenray.engine.formats import exr
from lumenray.libraries import scenes

pytestmark = pytest.mark.usefixtures("extension")


def test_the_command_line_measures_the_inverse_square_law(tmp_path, capfd):
    (tmp_path / "in.csv").write_text("x,y,z,nx,ny,nz\n0,0,0,0,0,1\n0,0,0.5,0,0,1\n")
    code = command_line.main(
        ["measure", str(scenes.scene_path("inverse_square")), "--sensors", str(tmp_path / "in.csv"),
         "-o", str(tmp_path / "out.csv"), "--samples", "4096", "--method", "paths"]
    )  # fmt: skip
    assert code == 0
    assert "method: full paths are asked for" in "".join(capfd.readouterr())
    rows = np.genfromtxt(tmp_path / "out.csv", delimiter=",", names=True)
    assert rows["illuminance_lx"][0] == pytest.approx(7.9577, rel=2e-3)
    assert rows["illuminance_lx"][1] == pytest.approx(4 * 7.9577, rel=2e-3)
    assert (rows["standard_error_lx"] < 0.01).all()


@pytest.mark.slow
def test_the_command_line_bakes_and_renders(tmp_path, capsys):
    box = str(scenes.scene_path("closed_box"))
    assert (
        command_line.main(
            [
                "bake",
                box,
                "-o",
                str(tmp_path),
                "--objects",
                "Floor",
                "--lumels-per-m",
                "4",
                "--samples",
                "16",
                "--save",
                str(tmp_path / "saved.blend"),
            ]
        )
        == 0
    )
    assert "Floor" in capsys.readouterr().out
    assert (tmp_path / "saved.blend").exists()
    out = tmp_path / "p.exr"
    assert (
        command_line.main(["render", box, "-o", str(out), "--size", "16x12", "--samples", "4"]) == 0
    )
    assert out.exists()
    assert out.with_suffix(".png").exists()
    assert json.loads(out.with_suffix(".json").read_text())["quantities"][0]["unit"] == "cd/m2"


@pytest.mark.skipif(find_denoiser() is None, reason="Open Image Denoise is not installed")
def test_a_denoised_preview_says_so_and_the_numbers_are_as_computed(tmp_path):
    openexr = pytest.importorskip("OpenEXR")
    seen = []
    for name in ("--denoise", "--no-denoise"):
        out = tmp_path / f"{name}.exr"
        code = command_line.main(
            ["render", str(scenes.scene_path("closed_box")), "-o", str(out), "--size", "48x32", "--samples", "4", name]
        )  # fmt: skip
        assert code == 0
        with Image.open(out.with_suffix(".png")) as picture:
            noise = np.abs(np.diff(np.asarray(picture, dtype=float), axis=1)).mean()
            told = picture.text["Description"]
        with openexr.File(str(out), separate_channels=True) as file:
            numbers = {key: each.pixels.copy() for key, each in file.channels().items()}
        assert json.loads(out.with_suffix(".json").read_text())["preview"] == told
        seen.append((noise, told, numbers))
    (calm, words, first), (rough, plain, second) = seen
    assert words.startswith(
        "denoised by Open Image Denoise; all numbers are of the data as computed"
    )
    assert plain == "as computed"
    assert calm < 0.6 * rough
    for key, values in first.items():
        np.testing.assert_array_equal(values, second[key])


def test_without_the_denoiser_it_is_refused_when_asked_for_and_left_out_otherwise(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr("lumenray.engine.analysis.denoiser.find_denoiser", lambda: None)
    box, out = str(scenes.scene_path("closed_box")), str(tmp_path / "a.exr")
    assert command_line.main(["render", box, "-o", out, "--denoise"]) == 1
    assert "Open Image Denoise is not installed" in capsys.readouterr().err
    assert command_line.main(["render", box, "-o", out, "--size", "16x12", "--samples", "2"]) == 0
    assert json.loads((tmp_path / "a.json").read_text())["preview"] == "as computed"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["render", "nowhere.blend", "-o", "a.exr"], "no such file"),
        (["bake", "BOX", "-o", "out", "--objects", "Ghost"], "no object named Ghost"),
        (["measure", "BOX", "--sensors", "none.csv", "-o", "out.csv"], "cannot be opened"),
        (["render", "NOISE", "-o", "a.exr"], "cannot open"),
    ],
)
def test_every_failure_is_one_line_and_a_code(tmp_path, capsys, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "noise.blend").write_bytes(b"this is no Blender file")
    places = {"BOX": str(scenes.scene_path("closed_box")), "NOISE": "noise.blend"}
    assert command_line.main([places.get(a, a) for a in arguments]) == 1
    error = capsys.readouterr().err.strip()
    assert words in error
    assert len(error.splitlines()) == 1


def test_a_picture_is_written_by_light_group_and_mixed(tmp_path, capsys):
    openexr = pytest.importorskip("OpenEXR")
    office = str(scenes.scene_path("closed_box"))

    def render(name, *options):
        out = tmp_path / f"{name}.exr"
        more = ["-o", str(out), "--size", "16x12", "--samples", "8", "--no-denoise"]
        assert command_line.main(["render", office, *more, *options]) == 0
        with openexr.File(str(out), separate_channels=True) as file:
            return {key: channel.pixels.copy() for key, channel in file.channels().items()}

    kept = render("kept", "--light-groups", "each")
    (name,) = (key[9:-2] for key in kept if key.startswith("Combined_") and key.endswith(".G"))
    np.testing.assert_allclose(kept[f"Combined_{name}.G"], kept["G"], rtol=1e-5)
    np.testing.assert_array_equal(kept[f"Luminance_{name}.Y"], kept["Luminance.Y"])
    rows = json.loads((tmp_path / "kept.json").read_text())["quantities"]
    assert rows[1]["name"] == f"light group {name}"
    assert rows[1]["share"] == pytest.approx(1.0)
    capsys.readouterr()
    half = render("half", "--light-groups", "each", "--mix", f"{name}=50%")
    assert f"light mix: {name} at 50 % of its flux" in capsys.readouterr().out
    np.testing.assert_allclose(half["Luminance.Y"], 0.5 * kept["Luminance.Y"], rtol=1e-5)
    np.testing.assert_allclose(half["Luminance.error"], 0.5 * kept["Luminance.error"], rtol=1e-5)
    np.testing.assert_array_equal(half[f"Luminance_{name}.Y"], kept["Luminance.Y"])


def test_the_report_of_a_picture_says_how_it_was_made_and_what_cells_change(tmp_path):
    box, said = str(scenes.scene_path("closed_box")), {}
    ways = {"cells": ["cells"], "paths": ["paths"], "corrected": ["cells", "--unbiased"]}
    for name, way in ways.items():
        out = tmp_path / f"{name}.exr"
        more = ["-o", str(out), "--size", "32x24", "--samples", "4", "--no-denoise"]
        assert command_line.main(["render", box, *more, "--method", *way]) == 0
        said[name] = json.loads(out.with_suffix(".json").read_text())
    assert any("read from cells, as asked for" in each for each in said["cells"]["decisions"])
    assert any("of the picture's mean (measured at" in each for each in said["cells"]["notes"])
    assert "full paths are asked for" in said["paths"]["decisions"]
    assert not any("cells" in each for each in said["paths"]["notes"])
    assert any("what they change is corrected" in each for each in said["corrected"]["decisions"])
    assert any("corrected by full paths" in each for each in said["corrected"]["notes"])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--mix", "Gone=0.5"], "none are kept apart"),
        (["--light-groups", "each", "--mix", "Gone=0.5"], "no light group is called 'Gone'; those"),
        (["--mix", "Ceiling"], "expected NAME=FACTOR"),
        (["--mix", "Ceiling=-1"], "expected NAME=FACTOR"),
    ],
)
def test_mixes_that_make_no_sense_are_refused(tmp_path, capsys, options, words):
    box = str(scenes.scene_path("closed_box"))
    try:
        code = command_line.main(["render", box, "-o", str(tmp_path / "a.exr"), *options])
    except SystemExit as end:
        code = end.code
    assert code in {1, 2}
    assert words in capsys.readouterr().err


@pytest.fixture
def sensed(tmp_path):
    """A file with a lamp in each of two light groups, a grid and an eye of sensors, and nothing that reflects."""
    import bpy
    from blender_bakes import add_lamp

    add_lamp("A", "Ceiling")
    add_lamp("B", "Desk", 500.0)
    for name, layout, quantity in (("Desk", "GRID", "PLANAR"), ("Eye", "POINT", "VERTICAL")):
        empty = bpy.data.objects.new(name, None)
        own = empty.lumenray.sensor
        own.is_sensor, own.layout, own.quantity = True, layout, quantity
        own.length = own.width = 1.0
        empty.location.x = -1.0 if name == "Eye" else 0.0
        bpy.context.scene.collection.objects.link(empty)
    path = tmp_path / "sensed.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return str(path)


def test_the_command_line_measures_the_sensors_that_stand_in_a_file(sensed, tmp_path, capsys):
    rows, document, plans = tmp_path / "a.csv", tmp_path / "a.json", tmp_path / "plans"
    options = ["--samples", "256", "--method", "paths"]
    assert command_line.main(["measure", sensed, "-o", str(rows), *options]) == 0
    assert "U0" in capsys.readouterr().out
    table = np.genfromtxt(rows, delimiter=",", names=True, dtype=None, encoding="utf-8")
    assert set(table["object"]) == {"Desk", "Eye"}
    # 1500 lm from 2 m above: cos^3 over the square of the height.
    square = table["x"] ** 2 + table["y"] ** 2 + 4.0
    exact = 1500.0 / (4.0 * np.pi) / square
    exact *= np.where(table["object"] == "Desk", 2.0, 1.0) / np.sqrt(square)
    np.testing.assert_allclose(table["value"], exact, rtol=1e-3)
    more = ["--light-groups", "groups", "--mix", "Desk=off", "--plans", str(plans)]
    assert command_line.main(["measure", sensed, "-o", str(document), *options, *more]) == 0
    content = json.loads(document.read_text())
    assert content["light_mix"] == "Desk off"
    desk = content["sensors"][0]
    assert desk["grid"] == [5, 5]
    np.testing.assert_allclose(desk["values"], exact[:25] / 1.5, rtol=1e-3)
    assert sorted(path.name for path in plans.iterdir()) == ["Desk.png", "Desk.svg"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--kind", "planar"], "those of the file say what they are"),
        (["--objects", "Ghost"], "no sensors named Ghost"),
        (["--mix", "Desk=off"], "none are kept apart"),
        (["-o", "out.txt"], "ends in .csv or .json"),
    ],
)
def test_what_sensors_of_a_file_cannot_be_asked_is_said(sensed, tmp_path, capsys, arguments, words):
    rest = [] if "-o" in arguments else ["-o", str(tmp_path / "out.csv")]
    assert command_line.main(["measure", sensed, *arguments, *rest]) == 1
    error = capsys.readouterr().err.strip()
    assert words in error
    assert len(error.splitlines()) == 1


def test_pictures_are_drawn_in_false_colours_and_compared(tmp_path, capsys):
    box = str(scenes.scene_path("closed_box"))
    paths = []
    for seed in ("0", "1"):
        out = tmp_path / f"{seed}.exr"
        options = [
            "--size",
            "48x32",
            "--samples",
            "16",
            "--no-denoise",
            "--illuminance",
            "--seed",
            seed,
        ]
        more = (
            ["--false-colour", "--scale-to", "500", "--values"]
            if seed == "0"
            else ["--isolux-lines"]
        )
        assert command_line.main(["render", box, "-o", str(out), *options, *more]) == 0
        paths.append(str(out))
    for quantity in ("luminance", "illuminance"):
        words = (tmp_path / f"0_{quantity}.svg").read_text()
        assert ">500<" in words
        assert (tmp_path / f"0_{quantity}.png").is_file()
        assert "lines and values of means over about" in words and "noise" in words
        # Over the picture as it is looked at there is no scale.
        words = (tmp_path / f"1_{quantity}.svg").read_text()
        assert "polyline" in words and "lines of means" in words and words.count("<image") == 1
    capsys.readouterr()
    drawn = tmp_path / "d.png"
    assert command_line.main(["difference", *paths, "-o", str(drawn)]) == 0
    told = capsys.readouterr().out
    assert "luminance" in told
    share = float(told.partition("beyond chance")[2].split("%")[0])
    # Two seeds of one picture.
    assert share == 0.0
    assert Image.open(drawn).size[0] > 300
    assert command_line.main(["difference", paths[0], paths[0], "-o", str(tmp_path / "n.svg")]) == 0
    assert "+0 cd/m2" in capsys.readouterr().out
    brighter = exr.read_channels(paths[0])
    brighter["Luminance.Y"][:16] *= 4.0
    exr.write_channels(tmp_path / "b.exr", brighter)
    assert (
        command_line.main(
            ["difference", str(tmp_path / "b.exr"), paths[1], "-o", str(tmp_path / "b.png")]
        )
        == 0
    )
    share = float(capsys.readouterr().out.partition("beyond chance")[2].split("%")[0])
    assert 40.0 < share <= 50.0
    assert command_line.main(["difference", paths[0], box, "-o", str(tmp_path / "x.png")]) == 1
    assert "is no OpenEXR file" in capsys.readouterr().err


@pytest.mark.slow
def test_lux_maps_are_drawn_with_isolux_lines(tmp_path):
    box = str(scenes.scene_path("closed_box"))
    code = command_line.main(
        ["bake", box, "-o", str(tmp_path), "--objects", "Floor", "--lumels-per-m", "4", "--samples", "16", "--isolux-lines"]
    )  # fmt: skip
    assert code == 0
    assert (tmp_path / "illuminance.1001.isolux.png").is_file()
    assert "polyline" in (tmp_path / "illuminance.1001.isolux.svg").read_text()


def test_a_goniometer_makes_a_photometric_file_of_a_modelled_luminaire(tmp_path, capsys):
    """A disk of an even luminance, which shines down by the cosine law, beside a sun that is none of it."""
    import bpy

    from lumenray.engine.luminaires.formats.reader import read_luminaire

    lamp = bpy.data.lights.new("Disk", "AREA")
    lamp.shape, lamp.size = "DISK", 0.2
    lamp.lumenray.use_physical, lamp.lumenray.value = True, 3000.0
    item = bpy.data.objects.new("Disk", lamp)
    item.location = (1.0, 2.0, 3.0)
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    for each in (item, sun):
        bpy.context.scene.collection.objects.link(each)
    path, out = tmp_path / "disk.blend", tmp_path / "disk.ldt"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    assert (
        command_line.main(["goniometer", str(path), "-o", str(out), "--step", "5", "--watts", "25"])
        == 0
    )
    told = capsys.readouterr()
    assert "Sun lights are no part of the luminaire" in told.err
    found = read_luminaire(out)
    assert found.watts == pytest.approx(25.0)
    polar = found.distribution.polar
    exact = 3000.0 / np.pi * np.maximum(np.cos(polar), 0.0)
    np.testing.assert_allclose(found.distribution.intensity[0], exact, atol=0.005 * exact.max())
    assert (
        command_line.main(["goniometer", str(path), "-o", str(out), "--step", "7", "--force"]) == 1
    )
    assert "no whole number" in capsys.readouterr().err


@pytest.mark.slow
def test_a_goniometer_sees_what_a_reflector_adds(tmp_path):
    """A point lamp above a large white plate: below it shines like a lamp, and the plate sends light up."""
    import bpy
    from blender_bakes import add_lamp
    from blender_objects import new_material

    from lumenray.engine.luminaires.formats.reader import read_luminaire

    add_lamp("Lamp", value=1000.0).location = (0.0, 0.0, 0.1)
    mesh = bpy.data.meshes.new("Plate")
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    paint = new_material("White", "ShaderNodeBsdfDiffuse")
    paint.node_tree.nodes["Diffuse BSDF"].inputs["Color"].default_value = (0.8, 0.8, 0.8, 1.0)
    mesh.materials.append(paint)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Plate", mesh))
    path, out = tmp_path / "plate.blend", tmp_path / "plate.ies"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    options = ["--step", "30", "--plane-step", "90"]
    assert command_line.main(["goniometer", str(path), "-o", str(out), *options]) == 0
    distribution = read_luminaire(out).distribution
    lamp = 1000.0 / (4.0 * np.pi)
    # So much of its flux meets the plate, and 80 % of that leaves by the cosine law.
    met = 1000.0 / np.pi * np.arcsin(1.0 / (1.0 + 0.1**2))
    up = np.maximum(-np.cos(distribution.polar), 0.0)
    above = up > 1e-9
    exact = lamp + 0.8 * met / np.pi * up
    found = distribution.intensity.mean(axis=0)
    np.testing.assert_allclose(found[above], exact[above], rtol=0.01)
    # The plate hides the lamp from below.
    assert distribution.intensity[:, :3].max() < 0.01 * lamp


def test_the_command_line_rates_what_observers_see(tmp_path, capfd):
    (tmp_path / "eyes.csv").write_text("x,y,z,nx,ny,nz\n0,0,0.5,0,1,0\n")
    out = tmp_path / "out.csv"
    tell = ["observe", str(scenes.scene_path("closed_box")), "--observers", str(tmp_path / "eyes.csv"),
            "-o", str(out), "--size", "64", "--samples", "4"]  # fmt: skip
    assert command_line.main([*tell, "--require", "office.writing"]) == 0
    assert "UGR at most 19 is" in "".join(capfd.readouterr())
    lines = [line for line in out.read_text().splitlines() if not line.startswith("#")]
    rows = np.genfromtxt(lines, delimiter=",", names=True)
    assert rows["ugr_error"] > 0.0
    assert rows["vertical_illuminance_lx"] > 0.0
    assert command_line.main([*tell, "--require", "office.writing"]) != 0
    assert "out.csv" in "".join(capfd.readouterr())
