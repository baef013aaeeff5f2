"""The commands ``lumenray luminaire``: what they print, draw and write, and how they refuse."""

import json
import subprocess
import sys
from functools import partial

import numpy as np
import pytest
from commands import run_command
from folders import WILD
from PIL import Image

from lumenray.engine.luminaires.formats.reader import read_luminaire

GAMMA = [0, 10, 20, 30, 40, 50, 60, 70, 80, 90]

FACE = [round(1000 * float(np.cos(np.deg2rad(g))), 3) for g in GAMMA]
"""Lambertian face of 1000 cd. [cd]"""

HEAD = """IESNA:LM-63-2002
[TEST] written for this test
[TESTLAB] none
[ISSUEDATE] 2026-01-01
[MANUFAC] Nobody
[LUMCAT] Face
[LAMP] {lamp}
TILT=NONE
"""


def written(folder, name="face.ies", opening="0.5 1.0 0", lamp="LED 25W/840", lumens=4000):
    """Write a Lambertian face as LM-63 with one lamp of 25 W."""
    numbers = f"1 {lumens} 1 {len(GAMMA)} 1 1 2 {opening}\n1 1 25\n"
    rows = [" ".join(map(str, row)) for row in (GAMMA, [0], FACE)]
    path = folder / name
    path.write_text(HEAD.format(lamp=lamp) + numbers + "\n".join(rows) + "\n", newline="\r\n")
    return path


def written_ldt(folder, name="face.ldt"):
    """Write the same face as EULUMDAT, for 4000 lm of the lamp."""
    head = ["Nobody", "1", "1", "1", "0", str(len(GAMMA)), "10", "R1", "Face", "F1", name, "2026"]
    sizes = ["1000", "500", "50", "1000", "500", "0", "0", "0", "0"]
    shares = ["100", "78.5", "1", "0"]
    lamp = ["1", "1", "LED 25W", "4000", "4000K", "1B", "25"]
    ratios = ["0"] * 10
    planes = ["0", *map(str, GAMMA)]
    values = [f"{value / 4.0:.5f}" for value in FACE]
    path = folder / name
    lines = [*head, *sizes, *shares, *lamp, *ratios, *planes, *values]
    path.write_text("\n".join(lines) + "\n", newline="\r\n")
    return path


run = partial(run_command, "luminaire")


def strict(text):
    """Read JSON that may not hold NaN or infinity."""

    def refuse(name):
        raise AssertionError(f"{name} in JSON")

    return json.loads(text, parse_constant=refuse)


# ---- info ----


def test_info_gives_the_numbers_of_a_file_as_json(tmp_path, capsys):
    path = written(tmp_path)
    code, out, _ = run(capsys, "info", "--json", path)
    assert code == 0
    (row,) = strict(out)
    assert row["file"] == str(path)
    assert row["photometric_type"] == "C"
    assert row["symmetry"] == "rotational"
    # Ten degrees between the values: chords hold h^2 / 12 less than the cosine's pi times 1000 cd.
    chords = 1.0 - np.deg2rad(10.0) ** 2 / 12.0
    assert row["luminous_flux_lm"] == pytest.approx(1000 * np.pi * chords, rel=1e-4)
    assert row["stated_flux_lm"] == 4000.0
    assert row["light_output_ratio"] == pytest.approx(row["luminous_flux_lm"] / 4000.0)
    assert row["peak_cd"] == 1000.0
    assert row["peak_direction_deg"] == [0.0, 0.0]
    assert row["opening_m"] == pytest.approx([1.0, 0.5, 0.0])
    assert row["warnings"] == []
    assert row["beam_angle_deg"] == pytest.approx([120.0, 120.0])
    assert row["efficacy_lm_per_w"] == pytest.approx(row["luminous_flux_lm"] / 25.0)
    assert row["luminance_cd_per_m2"]["C0"]["65"] == pytest.approx(2000.0, rel=0.01)
    assert row["metadata"]["LUMCAT"] == "Face"
    assert "LED-B3" in row["spectrum"]


def test_the_same_light_as_eulumdat_has_the_same_numbers(tmp_path, capsys):
    code, out, _ = run(capsys, "info", "--json", written(tmp_path), written_ldt(tmp_path))
    assert code == 0
    ies, ldt = strict(out)
    for key in ("luminous_flux_lm", "peak_cd", "light_output_ratio", "efficacy_lm_per_w"):
        assert ldt[key] == pytest.approx(ies[key], rel=1e-4), key
    assert ldt["cie_flux_codes"] == pytest.approx(ies["cie_flux_codes"], rel=1e-4)
    assert ldt["stated_light_output_ratio"] == pytest.approx(0.785)
    # The length lies along y in EULUMDAT, along x in LM-63.
    assert ldt["opening_m"] == pytest.approx([0.5, 1.0, 0.0])


def test_a_refused_file_leaves_the_others_and_makes_the_exit_code_1(tmp_path, capsys):
    bad = tmp_path / "bad.ies"
    bad.write_text(
        "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 3 1 1 2 0 0 0\n1 1 10\n0 45 90\n0\n5 x 0\n"
    )
    code, out, _ = run(capsys, "info", "--json", bad, written(tmp_path))
    assert code == 1
    refused, read = strict(out)
    assert set(refused) == {"file", "error"}
    assert "line 7" in refused["error"]
    assert read["peak_cd"] == 1000.0


def test_info_tells_people_numbers_warnings_and_refusals(tmp_path, capsys):
    odd = written(tmp_path, "odd.ies")
    odd.write_text(odd.read_text().replace("1 1 25", "1 0.7 25"))
    code, out, err = run(capsys, "info", odd, tmp_path / "none.ies")
    assert code == 1
    assert "CIE flux code" in out
    assert "44 75 94 100 78" in out
    assert "light output ratio 78.3 %" in out
    warnings = out[out.index("  warnings") :]
    assert "line 10" in warnings
    assert "none.ies" not in out
    assert (
        err == f"lumenray: {tmp_path / 'none.ies'}: cannot be opened (No such file or directory)\n"
    )


def test_what_a_file_does_not_say_is_null(tmp_path, capsys):
    # An opening that faces x is seen edge on in the plane C90.
    path = written(tmp_path, opening="0.5 0 0.2", lumens=-1)
    code, out, _ = run(capsys, "info", "--json", path)
    assert code == 0
    (row,) = strict(out)
    assert row["stated_flux_lm"] is None
    assert row["light_output_ratio"] is None
    assert row["luminance_cd_per_m2"]["C90"] == {"65": None, "75": None, "85": None}
    assert row["luminance_cd_per_m2"]["C0"]["85"] > 0.0
    code, out, _ = run(capsys, "info", path)
    assert code == 0
    assert "edge on" in out
    assert "absolute photometry" in out


def test_folders_and_patterns_are_taken_apart(tmp_path, capsys):
    (tmp_path / "deep").mkdir()
    paths = [written(tmp_path, "b.IES"), written(tmp_path / "deep", "c.ies"), written_ldt(tmp_path)]
    (tmp_path / "notes.txt").write_text("no luminaire")
    code, out, _ = run(capsys, "info", "--json", tmp_path)
    assert code == 0
    assert {row["file"] for row in strict(out)} == set(map(str, paths))
    code, out, _ = run(capsys, "info", "--json", tmp_path / "**" / "*.ies")
    assert [row["file"] for row in strict(out)] == [str(paths[1])]
    code, out, _ = run(capsys, "info", "--json", tmp_path / "*.none")
    assert code == 1
    assert "cannot be opened" in strict(out)[0]["error"]


def test_an_empty_folder_is_an_error(tmp_path, capsys):
    code, out, err = run(capsys, "info", tmp_path)
    assert code == 1
    assert out == ""
    assert "no such file in it, expected names ending .ies, .ldt, .xml" in err


def test_names_and_texts_of_any_alphabet_come_through(tmp_path, capsys):
    path = written(tmp_path, "Stehleuchte_äöü_灯.ies", lamp="LED 灯 840")
    code, out, _ = run(capsys, "info", "--json", path)
    assert code == 0
    assert strict(out)[0]["file"] == str(path)
    assert out.isascii()


def test_a_terminal_without_the_letters_gets_question_marks(tmp_path):
    path = written(tmp_path, lamp="LED 灯 840")
    program = "import sys; from lumenray.command_line.main import main; sys.exit(main())"
    done = subprocess.run(
        [sys.executable, "-c", program, "luminaire", "info", str(path)],
        capture_output=True,
        env={"PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"},
        check=False,
    )
    assert done.returncode == 0, done.stderr.decode()
    assert b"LED ? 840" in done.stdout


def test_the_commands_start_without_blender_and_mitsuba(tmp_path):
    path, out = written(tmp_path), tmp_path / "out.png"
    program = f"""
import sys
from lumenray.command_line.main import main
assert main(["luminaire", "info", {str(path)!r}]) == 0
assert main(["luminaire", "plot", {str(path)!r}, "-o", {str(out)!r}]) == 0
assert main(["luminaire", "convert", {str(path)!r}, {str(tmp_path / "out.ldt")!r}]) == 0
sys.exit(", ".join({{"bpy", "mitsuba", "drjit", "xatlas"}} & set(sys.modules)) or None)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()


# ---- plot ----


def test_plot_draws_a_picture(tmp_path, capsys):
    path, picture = written(tmp_path), tmp_path / "new" / "face.png"
    code, out, _ = run(capsys, "plot", path, "-o", picture)
    assert code == 0
    assert str(picture) in out
    with Image.open(picture) as image:
        assert image.size == (512, 512)
        light = np.asarray(image)
    code, _, _ = run(capsys, "plot", path, "-o", picture, "--dark", "--size", "300x200", "--force")
    assert code == 0
    with Image.open(picture) as image:
        assert image.size == (300, 200)
        assert np.asarray(image).mean() < 0.5 * light.mean()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["-o", "face.nonsense"], "ends in .png"),
        (["-o", "."], "is a folder"),
    ],
)
def test_plot_refuses_with_one_sentence(tmp_path, capsys, monkeypatch, arguments, words):
    monkeypatch.chdir(tmp_path)
    code, _, err = run(capsys, "plot", written(tmp_path), *arguments)
    assert code == 1
    assert words in err
    assert err.count("\n") == 1


# ---- convert ----


def test_convert_keeps_the_light(tmp_path, capsys):
    path, out = written_ldt(tmp_path), tmp_path / "out.ies"
    code, text, _ = run(capsys, "convert", path, out)
    assert code == 0
    assert f"written to {out}" in text
    before, after = read_luminaire(path), read_luminaire(out)
    assert after.format.startswith("LM-63")
    assert after.distribution.intensity.max() == pytest.approx(1000.0, rel=1e-6)
    assert before.stated_flux == after.stated_flux


def test_convert_replaces_a_file_only_by_force(tmp_path, capsys):
    path, out = written_ldt(tmp_path), tmp_path / "out.ies"
    out.write_text("precious")
    code, _, err = run(capsys, "convert", path, out)
    assert code == 1
    assert "--force" in err
    assert out.read_text() == "precious"
    code, _, _ = run(capsys, "convert", path, out, "--force")
    assert code == 0
    assert out.read_text().startswith("IESNA")


def test_convert_refuses_unknown_formats(tmp_path, capsys):
    code, _, err = run(capsys, "convert", written(tmp_path), tmp_path / "out.txt")
    assert code == 1
    assert "expected .ies or .ldt" in err


# ---- files of makers ----


def test_all_real_files_are_told_or_refused(capsys):
    folders = [WILD / "ies", WILD / "ldt"]
    if not all(folder.is_dir() for folder in folders):
        pytest.skip("the folder of real files is not beside the repository")
    code, out, _ = run(capsys, "info", "--json", *folders)
    rows = strict(out)
    assert len(rows) > 50
    assert code == int(any("error" in row for row in rows))
    for row in rows:
        if "error" in row:
            assert set(row) == {"file", "error"}
            assert len(row["error"]) > len(row["file"]) + 10
            continue
        unit = "lm" if row["quantity"] == "luminous" else "w"
        total = row[f"{row['quantity']}_flux_{unit}"]
        assert total > 0.0, row["file"]
        zones = sum(row[f"zonal_flux_{unit}"].values())
        assert zones == pytest.approx(total, rel=1e-5), row["file"]
        assert all(0.0 <= code <= 100.0 for code in row["cie_flux_codes"][:4]), row["file"]
        assert 0.0 <= row["peak_direction_deg"][0] < 360.0, row["file"]
