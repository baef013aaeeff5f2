"""Glare of luminance pictures against closed forms, against other mappings of the same scene and against evalglare."""

import numpy as np
import pytest
from glare_pictures import evalglare, picture_of, view_of, write_radiance

from lumenray.engine.analysis.glare import guth_position_index
from lumenray.engine.analysis.glare_sources import link
from lumenray.engine.analysis.picture_glare import position_indices, rate_picture
from lumenray.engine.analysis.picture_view import Mapping, PictureView
from lumenray.engine.errors import SceneError
from lumenray.engine.formats.luminance_picture import read_luminance

FISHEYES = (Mapping.EQUIDISTANT, Mapping.EQUISOLID, Mapping.ORTHOGRAPHIC)


@pytest.mark.parametrize("mapping", FISHEYES)
def test_an_even_hemisphere_gives_pi_times_its_luminance(mapping):
    view = view_of(mapping, 200)
    made = rate_picture(np.full((200, 200), 100.0), view)
    # At the rim of the last one pixels see much, and those whose middles lie outside do not count.
    rim = 0.05 if mapping is Mapping.ORTHOGRAPHIC else 5e-3
    assert made.solid_angle == pytest.approx(2.0 * np.pi, rel=rim)
    assert made.illuminance == pytest.approx(100.0 * np.pi, rel=2e-3)
    assert made.background == made.illuminance / np.pi
    assert made.dgi is None and made.ugr is None and made.veiling == 0.0
    assert made.dgp == pytest.approx(5.87e-5 * made.illuminance + 0.16)


def test_solid_angles_of_a_picture_all_around_are_the_sphere():
    _, solid = PictureView.of_angles(Mapping.EQUIRECTANGULAR, 128, 64, 2 * np.pi, np.pi).pixels()
    assert solid.sum() == pytest.approx(4.0 * np.pi, rel=1e-3)


def test_a_perspective_picture_has_the_solid_angle_of_its_pyramid():
    view = PictureView.of_angles(Mapping.PERSPECTIVE, 40, 40, np.pi / 2, np.pi / 2)
    # A face of a cube is a sixth of all.
    assert view.pixels()[1].sum() == pytest.approx(4.0 * np.pi / 6.0, rel=1e-9)


def test_a_disk_on_the_axis_is_rated_as_by_the_formulas():
    view = view_of(Mapping.EQUIDISTANT, 600)
    directions, _ = view.pixels()
    disk = directions[..., 2] < -np.cos(np.radians(5.0))
    made = rate_picture(np.where(disk, 10_000.0, 50.0), view)
    omega = 2.0 * np.pi * (1.0 - np.cos(np.radians(5.0)))
    assert made.sources.solid_angles == pytest.approx([omega], rel=0.01)
    assert made.indices == pytest.approx([1.0], abs=1e-3)
    background = 50.0 * np.cos(np.radians(5.0)) ** 2
    assert made.background == pytest.approx(background, rel=0.01)
    assert made.ugr == pytest.approx(8.0 * np.log10(0.25 / background * 1e8 * omega), abs=0.05)
    glare = 0.478 * 10_000.0**1.6 * omega**0.8 / (background + 0.07 * np.sqrt(omega) * 10_000.0)
    assert made.dgi == pytest.approx(10.0 * np.log10(glare), abs=0.05)
    lux = made.illuminance
    dgp = 5.87e-5 * lux + 0.0918 * np.log10(1.0 + 1e8 * omega / lux**1.87) + 0.16
    assert made.dgp == pytest.approx(dgp, rel=2e-3)


def test_a_source_aside_veils_by_ten_over_the_square_of_its_angle():
    view = view_of(Mapping.EQUIDISTANT, 600)
    directions, _ = view.pixels()
    towards = np.array([np.sin(np.radians(20.0)), 0.0, -np.cos(np.radians(20.0))])
    made = rate_picture(np.where(directions @ towards > np.cos(np.radians(1.0)), 3e4, 10.0), view)
    assert made.veiling == pytest.approx(10.0 * made.direct_illuminance / 20.0**2, rel=0.01)


def test_position_indices_above_the_line_of_sight_are_guths():
    turns, off = np.meshgrid([0.0, 30.0, 60.0, 89.0], [5.0, 20.0, 50.0])
    side, up = np.sin(np.radians(turns)), np.cos(np.radians(turns))
    sine = np.sin(np.radians(off))
    towards = np.stack([sine * side, sine * up, -np.cos(np.radians(off))], axis=-1).reshape(-1, 3)
    wanted = np.minimum(guth_position_index(turns, off).ravel(), 16.0)
    assert np.allclose(position_indices(towards), wanted, rtol=1e-9)


@pytest.mark.parametrize("scene", ["window", "sun", "lamps", "low"])
def test_the_same_scene_is_rated_alike_by_every_mapping(scene):
    views = [view_of(mapping, 500) for mapping in (Mapping.EQUIDISTANT, Mapping.EQUISOLID)]
    views.append(PictureView.of_angles(Mapping.EQUIRECTANGULAR, 1000, 500, 2 * np.pi, np.pi))
    made = [rate_picture(picture_of(scene, view), view) for view in views]
    for name in ("dgp", "dgi", "ugr", "illuminance", "veiling"):
        values = np.array([getattr(each, name) for each in made])
        # Centres of large sources are means over the picture, which what veils tells most of.
        allowed = 0.05 if name == "veiling" else 0.02
        assert np.ptp(values) < allowed * values.mean(), (name, values)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("scene", ["window", "sun", "lamps", "low"])
@pytest.mark.parametrize("mapping", [Mapping.EQUIDISTANT, Mapping.PERSPECTIVE])
def test_what_evalglare_says(scene, mapping, tmp_path):
    pytest.importorskip("pyradiance")
    degrees = 90.0 if mapping is Mapping.PERSPECTIVE else 180.0
    view = view_of(mapping, 400, degrees)
    path = write_radiance(tmp_path / "view.hdr", picture_of(scene, view), view, degrees)
    theirs, made = evalglare(path), rate_picture(*read_luminance(path))
    ours = {"dgp": made.dgp, "dgi": made.dgi, "ugr": made.ugr, "E_v": made.illuminance}
    for name, value in {**ours, "lum_backg": made.background}.items():
        assert value == pytest.approx(theirs[name], rel=0.01), name
    # It takes a source's angle at the corner of a pixel, which is 0.5 degrees here.
    assert made.veiling == pytest.approx(theirs["Lveil_cie"], rel=0.04)


def test_pixels_are_linked_by_chains_of_steps():
    angles = np.array([0.0, 0.09, 0.18, 0.4, 0.49, 1.0])
    towards = np.stack([np.sin(angles), np.zeros(6), -np.cos(angles)], axis=-1)
    labels = link(towards, 0.1)
    assert [labels[k] == labels[0] for k in range(6)] == [True, True, True, False, False, False]
    assert labels[3] == labels[4] != labels[5]


def test_links_are_those_of_all_pairs():
    draw = np.random.default_rng(4)
    towards = draw.normal(size=(300, 3))
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    near = np.arccos(np.clip(towards @ towards.T, -1.0, 1.0)) <= 0.15
    wanted = np.arange(300)
    for _ in range(300):
        wanted = np.where(near, wanted[None, :], 300).min(axis=1)
    labels = link(towards, 0.15)
    assert ((labels[:, None] == labels[None, :]) == (wanted[:, None] == wanted[None, :])).all()


@pytest.mark.parametrize(
    ("picture", "threshold", "words"),
    [
        (np.zeros((20, 20)), 2000.0, "dark"),
        (np.full((20, 20), np.nan), 2000.0, "no luminances"),
        (np.ones((20, 10)), 2000.0, "not of the size"),
        (np.ones((20, 20)), 0.0, "threshold"),
    ],
)
def test_what_cannot_be_rated_is_refused(picture, threshold, words):
    with pytest.raises(SceneError, match=words):
        rate_picture(picture, view_of(Mapping.EQUIDISTANT, 20), threshold)


def test_views_that_no_picture_can_have_are_refused():
    with pytest.raises(SceneError, match="180 degrees"):
        view_of(Mapping.PERSPECTIVE, 20, 180.0)
