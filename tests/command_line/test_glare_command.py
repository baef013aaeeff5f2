"""The command ``lumenray glare``: what it tells of pictures, and how it refuses."""

import json
from functools import partial

import numpy as np
import pytest
from commands import run_command
from glare_pictures import picture_of, view_of, write_radiance

from lumenray.engine.analysis.picture_glare import rate_picture
from lumenray.engine.analysis.picture_view import Mapping
from lumenray.engine.formats.exr import write_channels
from lumenray.engine.formats.luminance_picture import (
    VIEW,
    describe_view,
    read_luminance,
    view_of_camera,
)
from lumenray.engine.scene.camera import Camera, Projection

run = partial(run_command, "glare")


def test_a_picture_of_ours_says_its_view(tmp_path, capsys):
    camera = Camera(np.eye(4), Projection.EQUIDISTANT, 120, 120, np.pi, np.pi, field=np.pi)
    view = view_of_camera(camera)
    picture = picture_of("lamps", view)
    path = write_channels(
        tmp_path / "lamps.exr", {"Luminance.Y": picture}, {VIEW: describe_view(view)}
    )
    code, text, _ = run(capsys, "--json", path)
    (row,) = json.loads(text)
    assert code == 0
    assert row["view"] == "equidistant fisheye"
    wanted = rate_picture(picture, view)
    assert row["ugr"] == pytest.approx(wanted.ugr, rel=1e-4)
    assert row["dgp"] == pytest.approx(wanted.dgp, rel=1e-4)
    assert len(row["sources"]) == len(wanted.indices)


def test_text_has_the_figures_and_says_what_the_picture_lacks(tmp_path, capsys):
    view = view_of(Mapping.PERSPECTIVE, 100, 90.0)
    path = write_radiance(tmp_path / "part.hdr", picture_of("window", view), view, 90.0)
    code, text, _ = run(capsys, path)
    assert code == 0
    for words in ("DGP", "DGI", "UGR", "veiling luminance", "33 % of what is before the eye"):
        assert words in text


def test_a_picture_without_a_view_needs_one(tmp_path, capsys):
    view = view_of(Mapping.EQUIDISTANT, 60)
    path = write_channels(tmp_path / "plain.exr", {"Y": picture_of("window", view)})
    code, _, complaint = run(capsys, path)
    assert code == 1 and "--view" in complaint
    code, text, _ = run(capsys, path, "--view", "equidistant", "--json")
    assert code == 0
    assert json.loads(text)[0]["vertical_illuminance_lx"] == pytest.approx(
        rate_picture(picture_of("window", view), view).illuminance, rel=1e-5
    )


def test_pictures_without_luminances_are_refused(tmp_path, capsys):
    path = write_channels(tmp_path / "depth.exr", {"Depth.Z": np.ones((4, 4))})
    code, _, complaint = run(capsys, path, "--view", "equidistant")
    assert code == 1 and "Luminance.Y" in complaint
    bad = tmp_path / "bad.exr"
    bad.write_bytes(b"no picture")
    code, _, complaint = run(capsys, bad)
    assert code == 1 and "no OpenEXR picture" in complaint


def test_a_radiance_picture_is_read_at_the_middle_of_its_steps(tmp_path):
    view = view_of(Mapping.EQUIDISTANT, 40)
    luminance = np.random.default_rng(2).uniform(50.0, 5000.0, (40, 40))
    read, found = read_luminance(write_radiance(tmp_path / "a.hdr", luminance, view))
    assert np.abs(read / luminance - 1.0).max() < 1.0 / 250.0
    assert abs((read / luminance).mean() - 1.0) < 5e-4
    assert found.extent == pytest.approx(view.extent)


def test_an_unknown_view_is_refused(tmp_path, capsys):
    view = view_of(Mapping.EQUIDISTANT, 20)
    path = write_radiance(tmp_path / "c.hdr", picture_of("low", view), view)
    path.write_bytes(path.read_bytes().replace(b"-vta", b"-vtl"))
    code, _, complaint = run(capsys, path)
    assert code == 1 and "its view is none that is known" in complaint
