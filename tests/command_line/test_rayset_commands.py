"""The commands ``lumenray rayset``: what they print, draw and write, and how they refuse."""

import json
from functools import partial

import numpy as np
import pytest
from commands import run_command
from PIL import Image
from ray_files import lambert_rays, tm25, zemax

from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.luminaires.formats.reader import read_luminaire
from lumenray.engine.raysets.reader import read_rays, read_rayset

run = partial(run_command, "rayset")


@pytest.fixture
def lamp(tmp_path):
    """Zemax file of a Lambertian disk of 2 mm radius, 3 mm above the origin: 4000 rays of 0.5 lm."""
    path = tmp_path / "lamp.ray"
    path.write_bytes(zemax(lambert_rays(4000), total=2000.0))
    return path


def test_info_tells_flux_extents_and_oddities(capsys, lamp):
    code, out, _ = run(capsys, "info", lamp)
    assert code == 0
    assert "Zemax binary" in out
    assert "4 000" in out
    assert "2000 lm" in out
    assert "mm (x, y, z)" in out


def test_info_as_json_has_the_promised_fields(capsys, lamp, tmp_path):
    broken = tmp_path / "broken.ray"
    broken.write_bytes(lamp.read_bytes()[:1000])
    code, out, _ = run(capsys, "info", "--json", lamp, broken)
    assert code == 1
    good, bad = json.loads(out)
    assert set(bad) == {"file", "error"}
    assert bad["file"] == str(broken)
    for key in ("file", "format", "rays", "bounds_m", "centroid_m", "spectrum", "warnings"):
        assert key in good
    assert good["rays"] == 4000
    assert good["luminous_flux_lm"] == pytest.approx(2000.0)
    assert good["bounds_m"][0][2] == pytest.approx(0.003)
    np.testing.assert_allclose(good["centroid_m"], [0.0, 0.0, 0.003], atol=1e-4)


def test_info_of_rays_in_watts_tells_lumens_by_their_wavelengths(capsys, tmp_path):
    rows = np.concatenate([lambert_rays(), np.full((200, 1), 555.0, "<f4")], axis=1)
    path = tmp_path / "green.ray"
    path.write_bytes(tm25(rows, (1, 1, 1, 1, 0, 0, 0, 0), kind=2, watts=100.0))
    row = json.loads(run(capsys, "info", "--json", path)[1])[0]
    assert row["radiant_flux_w"] == pytest.approx(100.0)
    # CIE 1924: V(555 nm) = 1.
    assert row["luminous_flux_lm"] == pytest.approx(68300.2, rel=1e-5)
    assert row["spectrum"]["wavelength_nm"] == [555.0]


@pytest.mark.slow
def test_a_plot_shows_four_panels(capsys, lamp, tmp_path):
    picture = tmp_path / "lamp.png"
    assert run(capsys, "plot", lamp, "-o", picture, "--size", 256)[0] == 0
    pixels = np.asarray(Image.open(picture).convert("RGB"))
    assert pixels.shape == (2 * 256 + 256 // 14, 512, 3)
    for rows in (slice(18, 274), slice(274, None)):
        for columns in (slice(0, 256), slice(256, None)):
            assert pixels[rows, columns].std() > 5.0
    with pytest.raises(SystemExit, match="2"):
        run(capsys, "plot", lamp, "-o", picture, "--size", 5)


@pytest.mark.slow
def test_the_reduced_file_is_a_lambertian_luminaire_of_the_same_flux(capsys, lamp, tmp_path):
    target = tmp_path / "lamp.ies"
    code, out, _ = run(capsys, "reduce", lamp, target)
    assert code == 0
    assert "own error" in out
    luminaire = read_luminaire(target)
    assert flux(luminaire.distribution) == pytest.approx(2000.0, rel=1e-5)
    # It shines along -z, as luminaires do.
    down = intensity(luminaire.distribution, np.array([0.0, 0.0, -1.0]))
    assert down == pytest.approx(2000.0 / np.pi, rel=0.06)
    assert intensity(luminaire.distribution, np.array([0.0, 0.0, 1.0])) == 0.0
    assert luminaire.opening.size[0] == pytest.approx(0.004, rel=0.02)
    code, _, error = run(capsys, "reduce", lamp, target)
    assert code == 1
    assert "--force" in error


def test_a_converted_file_holds_the_same_rays(capsys, lamp, tmp_path):
    for name in ("lamp.tm25ray", "lamp.dat"):
        target = tmp_path / name
        assert run(capsys, "convert", lamp, target)[0] == 0
        first, second = (next(read_rays(read_rayset(path))) for path in (lamp, target))
        np.testing.assert_allclose(first.position, second.position, rtol=1e-6)
        np.testing.assert_allclose(first.direction, second.direction, atol=1e-7)
        np.testing.assert_allclose(first.weight, second.weight)
    code, _, error = run(capsys, "convert", lamp, tmp_path / "lamp.xyz")
    assert code == 1
    assert ".tm25ray" in error
    assert not (tmp_path / "lamp.xyz").exists()


def test_generated_rays_are_as_many_as_wanted_and_carry_the_flux(capsys, lamp, tmp_path):
    target = tmp_path / "many.tm25ray"
    assert run(capsys, "convert", lamp, target, "--generate", 30_000)[0] == 0
    row = json.loads(run(capsys, "info", "--json", target)[1])[0]
    assert row["rays"] == 30_000
    assert row["luminous_flux_lm"] == pytest.approx(2000.0, rel=1e-4)
    np.testing.assert_allclose(row["bounds_m"][0], [-0.002, -0.002, 0.003], atol=5e-5)
    assert row["mean_direction"][2] == pytest.approx(2.0 / 3.0, abs=0.02)


def test_a_file_that_fails_half_way_leaves_nothing(capsys, lamp, tmp_path):
    data = bytearray(lamp.read_bytes())
    # The flux of the last ray.
    data[-4:] = np.float32(-1.0).tobytes()
    lamp.write_bytes(bytes(data))
    target = tmp_path / "out.dat"
    code, _, error = run(capsys, "convert", lamp, target)
    assert code == 1
    assert "ray 4000" in error
    assert not list(tmp_path.glob("*out*"))


def test_light_that_nobody_sees_is_not_reduced(capsys, tmp_path):
    rows = np.concatenate([lambert_rays(), np.full((200, 1), 940.0, "<f4")], axis=1)
    path = tmp_path / "infrared.ray"
    path.write_bytes(tm25(rows, (1, 1, 1, 1, 0, 0, 0, 0), kind=2, watts=1.0))
    code, _, error = run(capsys, "reduce", path, tmp_path / "out.ies")
    assert code == 1
    assert "no visible light" in error
    assert not (tmp_path / "out.ies").exists()


def test_texts_take_the_unit_that_is_given(capsys, tmp_path):
    path = tmp_path / "rays.txt"
    np.savetxt(path, lambert_rays())
    row = json.loads(run(capsys, "info", "--json", path, "--unit", "m", "--lumens")[1])[0]
    assert row["bounds_m"][0][2] == pytest.approx(3.0)
    assert row["luminous_flux_lm"] == pytest.approx(100.0)


@pytest.mark.slow
def test_prepared_files_tell_how_exact_they_are_and_are_kept(capsys, lamp, tmp_path):
    code, out, _ = run(capsys, "prepare", "--json", lamp)
    assert code == 0
    row = json.loads(out)[0]
    assert row["rays"] == 4000
    assert row["is_rotational"]
    assert row["size_m"] == pytest.approx(0.004, rel=0.05)
    assert 0.0 < row["information_error"] < 0.1
    errors = {round(e["distance_m"] / row["size_m"]): e["error"] for e in row["far_field"]}
    assert errors[1] > errors[2] > errors[5]
    assert row["near_m"] == pytest.approx(5.0 * row["size_m"], rel=1e-6)
    assert (tmp_path / "lamp.ray.prepared").is_file()
    code, out, err = run(capsys, "prepare", lamp, tmp_path / "gone.ray")
    assert code == 1
    assert "even about its axis" in out
    assert "as rays" in out
    assert "gone.ray: cannot be opened" in err
