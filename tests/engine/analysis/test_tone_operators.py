"""Tone operators against closed forms, the CIE's formula of the eye's veil, and Radiance's pcond."""

import os
import subprocess
from pathlib import Path

import numpy as np
import pytest
from glare_pictures import view_of, write_radiance

from lumenray.engine.analysis import tone_operators
from lumenray.engine.analysis.display import show
from lumenray.engine.analysis.picture_view import Mapping, PictureView
from lumenray.engine.analysis.tone import encode_srgb
from lumenray.engine.analysis.tone_operators import (
    apply_operator,
    day_vision,
    legend_range,
    photographic,
    scotopic_luminance,
    threshold,
    visual,
)
from lumenray.engine.analysis.tone_sheet import draw_toned
from lumenray.engine.analysis.veiling import Eye, veil_of_glare
from lumenray.engine.photometry.colour import scene_linear
from lumenray.engine.views import Display, DisplayMode

D65 = np.array([0.95047, 1.0, 1.08883])

NARROW = PictureView.of_angles(Mapping.PERSPECTIVE, 60, 40, np.deg2rad(50.0), np.deg2rad(34.0))


def grey(luminance):
    return np.asarray(luminance, dtype=np.float64)[..., None] * D65


def test_the_key_is_middle_grey_and_the_brightest_is_white():
    rng = np.random.default_rng(3)
    luminance = np.exp(rng.normal(3.0, 2.0, (30, 40)))
    made = photographic(grey(luminance))
    mean = np.exp(np.log(luminance).mean())
    white = 0.18 * luminance.max() / mean
    assert made.curve(np.array([mean]))[0] == pytest.approx(0.18 * (1 + 0.18 / white**2) / 1.18)
    assert made.curve(np.array([luminance.max()]))[0] == pytest.approx(1.0)
    expected = 0.18 * luminance / mean
    expected = expected * (1.0 + expected / white**2) / (1.0 + expected)
    np.testing.assert_allclose(made.colour, np.repeat(expected[..., None], 3, 2), rtol=2e-3)
    # Exposure is no matter of the amount of light.
    np.testing.assert_allclose(photographic(grey(50.0 * luminance)).colour, made.colour, rtol=1e-3)


def test_a_small_source_veils_as_the_cie_says():
    """Illuminance at the eye times the general equation of CIE 146, at ways of 5 to 20 degrees."""
    eye = Eye(NARROW, (40, 60))
    light = np.zeros((eye.rows, eye.columns, 1))
    source = light.copy()
    source[12, 10] = 1e6
    small = PictureView.of_angles(
        Mapping.PERSPECTIVE, eye.columns, eye.rows, np.deg2rad(50.0), np.deg2rad(34.0)
    )
    ways, solid = small.pixels()
    found = eye.veil(source)
    for row, column in ((12, 18), (25, 20), (30, 40)):
        cosine = float(ways[12, 10] @ ways[row, column])
        arrives = 1e6 * solid[12, 10] * cosine
        t = np.rad2deg(np.arccos(cosine))
        old = 1.0 + (30.0 / 62.5) ** 4
        exact = 10.0 / t**3 + (5.0 / t**2 + 0.05 / t) * old + 0.00125
        assert found[row, column, 0] == pytest.approx(arrives * exact, rel=1e-4)
    assert veil_of_glare(np.deg2rad(10.0), 0.0, 0.0) == pytest.approx(0.06)


def test_an_even_field_stays_as_bright_as_it_is():
    view = view_of(Mapping.EQUIDISTANT, 90)
    eye = Eye(view, (90, 90))
    field = eye.means((view.pixels()[1] > 0.0)[..., None].astype(float))
    seen = field * eye.kept + eye.veil(field)
    assert seen[eye.rows // 2, eye.columns // 2, 0] == pytest.approx(1.0, abs=0.01)


def test_night_takes_the_colour_by_the_adaptation():
    np.testing.assert_allclose(day_vision([1e-4, 5.62e-3, 5.62, 100.0]), [0.0, 0.0, 1.0, 1.0])
    assert day_vision(0.5 * (5.62e-3 + 5.62)) == pytest.approx(0.5)
    assert scotopic_luminance(D65) == pytest.approx(1.0)
    x, y, z = 1.0985, 1.0, 0.3558  # Illuminant A has less for rods.
    exact = (1.33 * (1.0 + (y + z) / x) - 1.68) / (1.33 * (1.0 + 2.08883 / 0.95047) - 1.68)
    assert scotopic_luminance([x, y, z]) == pytest.approx(exact, rel=1e-4)
    cyan = np.array([0.5380, 0.7873, 1.0694]) / 0.7873
    stripes = np.geomspace(0.2, 5.0, 60)[None, :, None] * np.ones((40, 1, 1)) * cyan
    night, day = visual(1e-3 * stripes, NARROW), visual(100.0 * stripes, NARROW)
    tint = tone_operators.NIGHT / tone_operators.NIGHT.max()
    share = night.colour[20, 50] / night.colour[20, 50].max()
    np.testing.assert_allclose(share, tint, atol=0.01)
    assert "rods" in night.words
    assert day.colour[20, 30, 0] < 0.02 * day.colour[20, 30, 1]


def test_what_fits_on_the_display_keeps_its_contrast():
    luminance = np.tile(np.geomspace(50.0, 100.0, 60), (40, 1))
    made = visual(grey(luminance))
    factor = threshold(50.0) / threshold(np.sqrt(50.0 * 100.0))
    shown = factor * np.array([60.0, 90.0])
    np.testing.assert_allclose(made.curve([60.0, 90.0]), (shown - 1.0) / 99.0, rtol=0.02)
    assert "no veil" in made.words


def test_contrasts_are_those_of_radiances_pcond(tmp_path):
    """Its human contrast on a picture of two rooms' luminances; it samples the fovea otherwise."""
    pyradiance = pytest.importorskip("pyradiance")
    rng = np.random.default_rng(1)
    view = PictureView.of_angles(Mapping.PERSPECTIVE, 240, 160, np.deg2rad(70.0), np.deg2rad(50.0))
    smooth = np.add.outer(np.linspace(0.0, 2.0, 160), np.linspace(-1.0, 1.5, 240))
    luminance = 3.0 * np.exp(smooth + 0.1 * rng.standard_normal((160, 240)))
    luminance[90:130, 30:90] *= 150.0
    path = tmp_path / "picture.hdr"
    write_radiance(path, luminance, view, 70.0)
    folder = Path(pyradiance.__file__).parent
    mapping = tmp_path / "mapping.txt"
    run = [folder / "bin" / "pcond", "-s", "-x", mapping, path]
    environment = os.environ | {"RAYPATH": str(folder / "lib")}
    subprocess.run(run, check=True, capture_output=True, env=environment)
    world, shown = np.loadtxt(mapping).T
    ours = 1.0 + 99.0 * apply_operator("visual", grey(luminance), None).curve(world)
    inner = (shown > 1.5) & (shown < 95.0)
    assert inner.sum() > 40
    assert np.abs(np.log(ours / shown))[inner].max() < 0.35
    assert np.abs(np.log(ours / shown))[inner].mean() < 0.12


def test_pictures_for_looking_say_so_and_have_a_legend():
    luminance = np.tile(np.geomspace(1.0, 1e4, 60), (40, 1))
    for name in tone_operators.OPERATORS:
        made = apply_operator(name, grey(luminance), NARROW)
        sheet = draw_toned(made, "as computed")
        text = sheet.to_svg()
        assert "not for measuring" in text
        assert "cd/m²" in text
        low, high = legend_range(made.curve)
        # The legend's greys are the picture's.
        place = 30
        seen = encode_srgb(made.colour)[20, place, 0]
        if name == "photographic":
            assert seen == pytest.approx(encode_srgb(made.curve(luminance[20, [place]]))[0], abs=1)
        assert 0.1 < low < high
        mode = DisplayMode[name.upper()]
        fields = show(grey(luminance).astype(np.float32), Display(mode=mode), view=NARROW)
        assert fields["is_display_referred"]
        assert fields["is_logarithmic"]
        assert "not for measuring" in fields["statement"]
        assert (np.diff(fields["greys"]) >= 0.0).all()
        np.testing.assert_allclose(
            fields["pixels"][..., :3], encode_srgb(made.colour) / 255.0, atol=1e-6
        )


def test_a_copy_without_noise_is_shown_in_the_images_place():
    rng = np.random.default_rng(2)
    image = grey(np.exp(rng.normal(2.0, 1.0, (20, 30)))).astype(np.float32)
    display = Display(mode=DisplayMode.PHOTOGRAPHIC)
    noisy = show(3.0 * image, display, scene_linear(image, 1.0))
    np.testing.assert_allclose(noisy["pixels"], show(image, display)["pixels"], atol=0.01)


def test_nothing_and_what_is_no_number_are_shown_black():
    for name in tone_operators.OPERATORS:
        assert not apply_operator(name, np.zeros((6, 8, 3)), NARROW).colour.any()
        broken = grey(np.full((6, 8), 10.0))
        broken[2, 3] = np.nan
        made = apply_operator(name, broken, NARROW)
        assert np.isfinite(made.colour).all()
