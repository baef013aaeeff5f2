"""The commands ``lumenray brdf``: what they print, draw and write, and how they refuse."""

import json
import subprocess
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from commands import run_command
from folders import WILD
from PIL import Image
from scattering_files import mdl, zemax
from scattering_models import directions, ggx, lambert, schlick
from window_files import KLEMS_FULL, block, window_xml

from lumenray.engine.scattering.data import store
from lumenray.engine.scattering.data.evaluation import evaluate, measure_reciprocity, total
from lumenray.engine.scattering.data.patches import pairs_of
from lumenray.engine.scattering.data.record import ScatteringFile
from lumenray.engine.scattering.data.resampling import resample
from lumenray.engine.scattering.readers.reader import read_scattering
from lumenray.engine.scattering.readers.tensor_file import parse_tensor_file

run = partial(run_command, "brdf")


def write(path, **sides):
    store.write_store(path, ScatteringFile(path, "", sides, "sample"))
    return path


@pytest.fixture
def paint(tmp_path):
    """Table of a satin paint."""
    lobe = ggx(0.3, schlick)
    table = resample(lambda wi, wo: lobe(wi, wo) + 0.4 / np.pi, [550.0], tolerance=0.05)
    return write(tmp_path / "paint.lumbsdf", front_reflection=table)


def test_totals_are_means_over_the_azimuth(capsys, tmp_path):
    """Rotations of 0, 10 and 180 degrees; between them the reflectance goes linearly from 0.2 to 0.2 to 0.8 and back."""
    matt = resample(lambert(1.0), [550.0])
    shares = np.array([0.2, 0.2, 0.8], dtype=np.float32)[:, None, None, None, None]
    turns = np.radians([0.0, 10.0, 180.0])
    table = replace(
        matt,
        rotations=turns,
        azimuths=2.0 * matt.azimuths,
        values=matt.values * shares,
    )
    path = write(tmp_path / "grained.lumbsdf", front_reflection=table)
    _, out, _ = run(capsys, "info", "--json", path)
    mean = (10.0 * 0.2 + 170.0 * 0.5 + 180.0 * 0.5) / 360.0
    assert json.loads(out)[0]["hemispherical_reflectance"][1] == pytest.approx(mean, rel=1e-3)


FIELDS = {
    "file", "format", "symmetry", "wavelengths_nm", "incidence_deg", "hemispherical_reflectance",
    "hemispherical_transmittance", "reciprocity_residual", "warnings",
}  # fmt: skip


def test_info_as_json_has_the_promised_fields(capsys, paint, tmp_path):
    broken = tmp_path / "broken.bsdf"
    broken.write_bytes(b"hello, this is no scattering")
    code, out, _ = run(capsys, "info", "--json", paint, broken, tmp_path / "none.bsdf")
    assert code == 1
    good, bad, missing = json.loads(out)
    assert set(good) >= FIELDS
    assert good["symmetry"] == "isotropic"
    assert good["hemispherical_transmittance"] is None
    table = read_scattering(paint).sides["front_reflection"]
    expected = [total(table, s)[0] for s in table.incidences]
    assert good["hemispherical_reflectance"] == pytest.approx(expected, rel=1e-4)
    assert good["incidence_deg"] == pytest.approx(np.degrees(table.incidences), rel=1e-4)
    assert set(bad) == set(missing) == {"file", "error"}
    assert "known format" in bad["error"]
    assert "cannot be opened" in missing["error"]


def test_info_tells_it_to_people(capsys, paint):
    code, out, _ = run(capsys, "info", paint)
    assert code == 0
    for word in (
        "sample",
        "isotropic",
        "neutral",
        "reflectance",
        "residual",
        "resampled with an error",
    ):
        assert word in out


def test_check_says_what_is_bad(capsys, paint, tmp_path):
    code, out, _ = run(capsys, "check", paint)
    assert code == 0
    assert "BAD" not in out
    # A white tile whose values are luminance factors, not 1/sr.
    factors = write(tmp_path / "tile.lumbsdf", front_reflection=resample(lambert(3.08), [550.0]))
    code, out, _ = run(capsys, "check", "--json", factors)
    assert code == 1
    (row,) = json.loads(out)
    bad = [check for check in row["checks"] if not check["good"]]
    assert [check["what"] for check in bad] == ["energy"]
    assert "luminance factors" in bad[0]["text"]


def side_of(direction, values):
    """One side of a WINDOW XML."""
    return block(direction, values, (KLEMS_FULL, KLEMS_FULL))


def test_scattered_light_beside_a_peak_is_checked_on_its_own(capsys, tmp_path):
    """A fabric: straight light of 5 % that hides a scattered part of 0.018 and 0.006 1/sr for the two ways."""
    sides = {"Transmission Front": 0.018, "Transmission Back": 0.006}
    blocks = [
        side_of(side, np.full((145, 145), low) + 2.0 * np.eye(145)) for side, low in sides.items()
    ]
    path = tmp_path / "fabric.xml"
    path.write_bytes(window_xml("Columns", *blocks))
    file = read_scattering(path)
    found = measure_reciprocity(file.sides["front_transmission"], file.sides["back_transmission"])
    assert found.residual < 0.1
    # The difference over the mean of both.
    assert found.scattered == pytest.approx(0.012 / 0.012, rel=1e-3)
    code, out, _ = run(capsys, "check", path)
    assert code == 1
    assert "BAD   reciprocity     transmission of both sides" in out
    # Next to no light beside a peak is no matter.
    alone = [side_of(side, 1e-5 * low + 2.0 * np.eye(145)) for side, low in sides.items()]
    path.write_bytes(window_xml("Columns", *alone))
    assert "BAD   reciprocity" not in run(capsys, "check", path)[1]


REAL = WILD / "findings" / "2011-SA1.xml"


@pytest.mark.skipif(not REAL.exists(), reason="needs ../shared/data/findings")
def test_reciprocity_of_a_real_fabric_is_bad_where_radiance_finds_it_so(capsys):
    pyradiance = pytest.importorskip("pyradiance")
    program = Path(pyradiance.__file__).parent / "bin" / "checkBSDF"
    told = subprocess.run([program, REAL], capture_output=True, text=True, check=True).stdout
    rows = [line.split("\t") for line in told.split("Reciprocity Error")[1].splitlines()[1:]]
    theirs = {row[0]: float(row[2]) for row in rows}
    _, out, _ = run(capsys, "check", "--json", REAL)
    checks = {
        row["text"].split(":")[0]: row["good"]
        for row in json.loads(out)[0]["checks"]
        if row["what"] == "reciprocity"
    }
    assert theirs["Transmission"] > 25.0
    assert not checks["transmission of both sides"]
    # Radiance's front is indoors; the largest differences of both sides are its own.
    ours = {"Interior Refl": "back_reflection", "Exterior Refl": "front_reflection"}
    largest = {row[0]: float(row[3]) for row in rows}
    for name, side in ours.items():
        there, again, _ = pairs_of(read_scattering(REAL).sides[side])
        apart = np.abs(there - again) / np.maximum(there, again)
        assert 100.0 * apart.max() == pytest.approx(largest[name], abs=0.06)


def test_totals_are_compared_before_values_are_brought_to_them(capsys, tmp_path):
    path = tmp_path / "a.bsdf"
    # The values reflect 0.6; the file states that, or a third more.
    for stated, worst in ((0.6, 0.0), (0.8, 0.2)):
        path.write_bytes(zemax(lambert(0.6), totals=(stated,) * 3))
        code, out, _ = run(capsys, "check", "--json", path)
        row = next(c for c in json.loads(out)[0]["checks"] if c["what"] == "stated totals")
        assert row["good"] == (worst == 0.0)
        assert code == int(worst > 0.0)
        told = float(row["text"].split("at most ")[1].split()[0])
        assert told == pytest.approx(100.0 * worst, abs=0.5)


def noisy_paint(path):
    """A paint with noise from cell to cell, which no coarse grid can follow."""
    rng = np.random.default_rng(3)
    path.write_bytes(mdl(lambda wi, wo: rng.random(len(wi)) ** 4, polars=24, azimuths=36))
    return path


def test_a_tolerance_that_is_asked_for_is_met_or_refused_with_the_figure(
    capsys, tmp_path, monkeypatch
):
    monkeypatch.setattr("lumenray.engine.scattering.readers.slices.MOST_VALUES", 1 << 14)
    path = noisy_paint(tmp_path / "paint.mbsdf")
    code, _, err = run(capsys, "info", "--tolerance", "1%", path)
    assert code == 1
    assert "cannot be resampled with an error of 1 %" in err
    figure = float(err.split(": ")[-1].split()[0].rstrip(","))
    assert figure > 5.0
    code, _, err = run(capsys, "convert", "--tolerance", "1%", path, tmp_path / "x.lumbsdf")
    assert code == 1
    assert "was reached" in err
    assert not (tmp_path / "x.lumbsdf").exists()
    # Who asks for nothing is told.
    code, out, _ = run(capsys, "info", path)
    assert code == 0
    assert "more than the 2 % that are allowed" in out
    smooth = tmp_path / "smooth.mbsdf"
    smooth.write_bytes(mdl())
    assert run(capsys, "info", "--tolerance", "0.05", smooth)[0] == 0


def test_a_table_that_states_a_larger_error_than_is_asked_for_is_refused(capsys, paint, tmp_path):
    table = read_scattering(paint).sides["front_reflection"]
    coarse = write(tmp_path / "coarse.lumbsdf", front_reflection=replace(table, error=0.12))
    code, _, err = run(capsys, "info", "--tolerance", "1%", coarse)
    assert code == 1
    assert "states an error of 12 %" in err
    assert "more than the 1 % that are allowed" in err
    target = tmp_path / "again.lumbsdf"
    code, _, err = run(capsys, "convert", "--tolerance", "1%", coarse, target)
    assert code == 1
    assert "make it anew from its source" in err
    assert not target.exists()
    assert run(capsys, "convert", "--tolerance", "0.15", coarse, target)[0] == 0
    # Who asks for nothing gets what there is.
    assert run(capsys, "info", coarse)[0] == 0


@pytest.mark.parametrize("tolerance", [None, 0.05, 0.01])
def test_an_rgl_file_has_the_error_that_it_tells_and_that_was_asked_for(
    capsys, tmp_path, tolerance
):
    """Grazing light, where such files err most, counts by its cosine."""
    lobe = ggx(0.3, schlick)
    table = resample(lambda wi, wo: lobe(wi, wo) + 0.1 / np.pi, [550.0], tolerance=0.01)
    source = write(tmp_path / "paint.lumbsdf", front_reflection=table)
    target, more = tmp_path / "paint.bsdf", () if tolerance is None else ("--tolerance", tolerance)
    code, out, _ = run(capsys, "convert", *more, source, target)
    assert code == 0
    told = float(out.split(f"{target}: its error against {source} is ")[1].split()[0]) / 100.0
    assert told <= (tolerance or 0.02)
    rng = np.random.default_rng(5)
    wi, wo = (towards_by_cosine(rng, 20_000) for _ in range(2))
    true = evaluate(read_scattering(source).sides["front_reflection"], wi, wo)
    made = parse_tensor_file(target.read_bytes(), target).evaluate(wi, wo)
    floor = 0.05 * max(total(table, s)[0] for s in table.incidences) / np.pi
    error = np.sqrt((((made - true) / (true + floor)) ** 2).mean())
    assert 0.2 * told < error < 1.2 * told


def towards_by_cosine(rng, count):
    """Directions of light from everywhere, within 89 degrees of the normal. (n, 3)"""
    square, turn = rng.uniform(0.0, np.sin(np.radians(89.0)) ** 2, count), rng.uniform(0, 7, count)
    sine = np.sqrt(square)
    return np.stack([sine * np.cos(turn), sine * np.sin(turn), np.sqrt(1.0 - square)], axis=1)


def test_an_rgl_file_that_misses_the_tolerance_is_not_written(capsys, tmp_path):
    metal = replace(resample(ggx(0.05, schlick), [550.0], tolerance=0.05), error=0.0)
    source, target = tmp_path / "metal.lumbsdf", tmp_path / "metal.bsdf"
    write(source, front_reflection=metal)
    code, _, err = run(capsys, "convert", "--tolerance", "0.002", source, target)
    assert code == 1
    assert "more than the 0.2 % that are allowed" in err
    assert not target.exists()


@pytest.mark.parametrize("more", [(), ("--totals",), ("--dark", "--incidences", "10,70")])
def test_plot_draws_a_picture(capsys, paint, tmp_path, more):
    target = tmp_path / "paint.png"
    code, _, _ = run(capsys, "plot", paint, "-o", target, "--size", 320, *more)
    assert code == 0
    picture = np.asarray(Image.open(target).convert("RGB"))
    assert picture.shape[1] == 320
    assert len(np.unique(picture.reshape(-1, 3), axis=0)) > 10
    assert (picture.mean() < 100) == ("--dark" in more)


def test_plot_refuses_a_side_without_data(capsys, paint, tmp_path):
    code, _, err = run(capsys, "plot", paint, "-o", tmp_path / "x.png", "--side", "back")
    assert code == 1
    assert "no data for light that comes to the back" in err


def test_convert_writes_what_others_read(capsys, paint, tmp_path):
    target = tmp_path / "paint.bsdf"
    assert run(capsys, "convert", paint, target)[0] == 0
    again = read_scattering(target)
    assert again.format == "tensor file"
    wi, wo = directions(3000, 1, 0.2), directions(3000, 2, 0.1)
    old = evaluate(read_scattering(paint).sides["front_reflection"], wi, wo)[:, 0]
    made = again.sides["front_reflection"]
    new = evaluate(made, wi, wo).mean(axis=1)
    assert np.sqrt((((new - old) / (old + 0.02)) ** 2).mean()) < 0.04
    code, _, err = run(capsys, "convert", paint, target)
    assert code == 1
    assert "--force" in err
    assert run(capsys, "convert", "--force", paint, target)[0] == 0


def test_convert_makes_reciprocal_and_takes_away_light_from_nothing(capsys, tmp_path):
    unfair = resample(lambda wi, wo: 0.5 * (1 + wi[:, 2:]) / np.pi * 1.2, [550.0], tolerance=0.01)
    source = write(tmp_path / "a.lumbsdf", front_reflection=unfair)
    target = tmp_path / "b.lumbsdf"
    assert run(capsys, "convert", "--reciprocal", "--limit", source, target)[0] == 0
    made = read_scattering(target).sides["front_reflection"]
    before, after = (measure_reciprocity(t).residual for t in (unfair, made))
    # What is left comes of scaling at steep incidence, where it was more than all light.
    assert after < 0.5 * before
    assert max(total(made, s)[0] for s in made.incidences) < 1.001
    assert max(total(unfair, s)[0] for s in unfair.incidences) > 1.15


def test_convert_refuses_what_a_format_cannot_hold(capsys, tmp_path):
    sheet = resample(lambert(0.4), [550.0])
    source = write(tmp_path / "sheet.lumbsdf", front_transmission=sheet)
    code, _, err = run(capsys, "convert", source, tmp_path / "sheet.bsdf")
    assert code == 1
    assert "isotropic reflection" in err
    code, _, err = run(capsys, "convert", source, tmp_path / "sheet.xyz")
    assert code == 1
    assert ".lumbsdf or .bsdf" in err


@pytest.mark.slow
def test_process_makes_a_table_of_counts(capsys, tmp_path):
    from instruments import measure, paint, text_of

    source, target, report = (tmp_path / n for n in ("raw.csv", "out.lumbsdf", "report.png"))
    source.write_bytes(text_of(measure(paint([550.0]), [550.0])))
    code, out, _ = run(capsys, "process", source, target, "--report", report)
    assert code == 0
    assert "residual" in out
    assert read_scattering(target).sides["front_reflection"].values.min() >= 0.0
    assert Image.open(report).width > 300


def test_a_tolerance_out_of_range_is_refused(capsys, paint):
    with pytest.raises(SystemExit, match="2"):
        run(capsys, "info", "--tolerance", "0", paint)
    assert "0.1 to 50 %" in capsys.readouterr().err
