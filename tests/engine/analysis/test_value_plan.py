"""Plans in false colours: the values that their pixels and their legends tell, and what SVG files hold."""

import base64
import io
import xml.etree.ElementTree as ET

import numpy as np
import pytest
from PIL import Image

from lumenray.engine.analysis.canvas import LIGHT
from lumenray.engine.analysis.colour_maps import EVEN
from lumenray.engine.analysis.colour_scale import BAR, WIDTH, ColourScale
from lumenray.engine.analysis.line_smoothing import (
    choose_passes,
    noise_left,
    relative_noise,
    smooth,
)
from lumenray.engine.analysis.sheet import Line, Text
from lumenray.engine.analysis.value_plan import (
    BOTTOM,
    MARGIN,
    TOP,
    difference_scale,
    draw_grid,
    draw_map,
    even_scale,
)
from lumenray.engine.errors import FileFormatError


def read_legend(pixels, scale):
    """Colours of the legend's bar from the lowest up, and the values that they stand for by their places."""
    height, width = pixels.shape[:2]
    left = round(width - WIDTH - MARGIN + 14)
    rows = pixels[round(TOP + 8) + 1 : round(height - BOTTOM) - 1, left + BAR // 2].astype(float)
    share = 1.0 - (np.arange(len(rows)) + 1.5) / (len(rows) + 2)
    if scale.is_log:
        return rows, scale.low * (scale.high / scale.low) ** share
    return rows, scale.low + share * (scale.high - scale.low)


@pytest.mark.parametrize(
    "scale", [even_scale([500.0], "lx"), even_scale([500.0], "lx", is_log=True)]
)
def test_a_legend_read_back_from_pixels_tells_the_values_of_the_plan(scale):
    x, y = np.arange(6.0), np.arange(4.0)
    values = np.array([[1.3, 4.0, 20.0, 66.0, 130.0, 490.0]]) * np.array(
        [[0.5], [0.7], [0.9], [1.0]]
    )
    sheet = draw_grid("Plan", x, y, values, scale=scale, levels=[])
    pixels = np.asarray(sheet.to_picture())
    bar, at = read_legend(pixels, scale)
    room = np.array([760 - 2 * MARGIN - WIDTH, 560 - TOP - BOTTOM])
    per_metre = (room / [6.0, 4.0]).min()
    corner = np.array([MARGIN, 560 - BOTTOM]) + 0.5 * (room - per_metre * np.array([6.0, 4.0])) * [
        1,
        -1,
    ]
    for row in range(4):
        for column in range(6):
            # Beside the number.
            place = corner + per_metre * np.array([column + 0.1, row + 0.1]) * [1.0, -1.0]
            seen = pixels[int(place[1]), int(place[0])].astype(float)
            told = at[np.abs(bar - seen).sum(axis=1).argmin()]
            value = values[row, column]
            if scale.is_log:
                assert told == pytest.approx(max(value, scale.low), rel=0.05)
            else:
                assert told == pytest.approx(value, abs=0.01 * scale.high)


def test_the_even_map_rises_evenly_in_lightness():
    """CIE 1976 lightness, computed here from the colours that the scale gives."""
    colours = ColourScale(0.0, 1.0, "lx", colour_map="even").colours(np.linspace(0.0, 1.0, 41))
    linear = colours / 255.0
    linear = np.where(linear <= 0.04045, linear / 12.92, ((linear + 0.055) / 1.055) ** 2.4)
    lightness = 116.0 * np.cbrt(linear @ [0.2126, 0.7152, 0.0722]) - 16.0
    steps = np.diff(lightness[2:])
    assert steps.min() > 0.0
    assert steps.max() < 2.0 * steps.mean()
    assert len(EVEN) == 9


def test_differences_are_grey_where_there_are_none_and_alike_on_both_sides():
    scale = difference_scale(np.array([-80.0, 95.0]), "lx")
    assert scale.low == -scale.high
    grey = scale.colours([0.0])[0]
    assert np.ptp(grey) == 0
    assert min(scale.ticks()) < 0.0 < max(scale.ticks())


def test_a_map_keeps_its_rows_and_leaves_what_is_not_shown(tmp_path):
    values = np.tile(np.linspace(1.0, 100.0, 40)[:, None], (1, 60))
    shown = np.ones(values.shape, bool)
    shown[:, :20] = False
    sheet = draw_map("Map", values, shown, levels=[50.0], unit="lx")
    picture = np.asarray(Image.open(sheet.save(tmp_path / "map.png")))
    zoom = 7
    left = round(MARGIN)
    assert tuple(picture[round(TOP) + 100, left + 50]) == (255, 255, 255)
    top, bottom = (
        picture[round(TOP) + zoom * row + 3, left + zoom * 40].astype(int) for row in (1, 38)
    )
    assert np.abs(top - bottom).sum() > 100
    # The line of 50 lx is dark, beside its label.
    dark = np.abs(picture[:, left + zoom * 30].astype(int) - [16, 20, 24]).sum(axis=1)
    line = dark[round(TOP) : round(TOP) + zoom * 40].argmin() / zoom
    exact = 40.0 - (np.interp(50.0, values[:, 0], np.arange(40.0)) + 0.5)
    assert line == pytest.approx(exact, abs=1.0)


def test_svg_files_hold_lines_and_words_and_need_nothing_else(tmp_path):
    x = y = np.arange(5.0)
    values = 100.0 + x[None] * y[:, None] * 20.0
    path = draw_grid("Desk <A> & B", x, y, values, "mean 180 lx").save(tmp_path / "plan.svg")
    root = ET.fromstring(path.read_text())  # noqa: S314
    name = "{http://www.w3.org/2000/svg}"
    texts = [each.text for each in root.iter(f"{name}text")]
    assert {"Desk <A> & B", "mean 180 lx", "lx", "300"} <= set(texts)
    assert len(list(root.iter(f"{name}polyline"))) > 5
    raster = next(root.iter(f"{name}image")).attrib["href"]
    assert raster.startswith("data:image/png;base64,")
    bar = Image.open(io.BytesIO(base64.b64decode(raster.partition(",")[2])))
    assert bar.size[0] == BAR
    with pytest.raises(FileFormatError, match=r"\.png or \.svg"):
        draw_grid("A", x, y, values).save(tmp_path / "plan.jpg")


def test_smoothing_keeps_means_and_what_is_not_known():
    rng = np.random.default_rng(2)
    field = rng.uniform(50.0, 150.0, (40, 50))
    field[:10, :10] = np.nan
    found = smooth(field)
    assert (np.isnan(found) == np.isnan(field)).all()
    assert np.nanmean(found) == pytest.approx(np.nanmean(field), rel=0.01)
    assert np.nanstd(found) < 0.5 * np.nanstd(field)
    np.testing.assert_allclose(smooth(np.full((5, 5), 7.0)), 7.0)
    assert LIGHT.background == "#ffffff"


def test_lines_of_a_noisy_picture_are_where_the_field_has_them_and_say_their_level():
    """Light that falls as cos^4 from a lamp over a plane, with 15 % noise: circles within a pixel, no rings of noise."""
    height, width, over, level = 180, 240, 90.0, 500.0
    x, y = np.arange(width) + 0.5 - 120.0, np.arange(height)[:, None] + 0.5 - 90.0
    exact = 1000.0 / (1.0 + (x**2 + y**2) / over**2) ** 2
    radius = over * np.sqrt(np.sqrt(1000.0 / level) - 1.0)
    noisy = exact * np.random.default_rng(5).normal(1.0, 0.15, exact.shape)
    sheet = draw_map(
        "E", noisy, levels=[level], unit="lx", smoothing=2, error=0.15 * exact, with_values=True
    )
    zoom, middle = 2.0, np.array([MARGIN, TOP]) + 2.0 * np.array([120.0, 90.0])
    paths = [s.path for s in sheet.shapes if isinstance(s, Line) and len(s.path) > 2]
    assert len(paths) == 2  # dark on bright
    distance = np.hypot(*(np.concatenate(paths) - middle).T) / zoom
    # There the light falls by 2 % a pixel, as much as the noise that is left of it.
    assert np.abs(distance - radius).max() < 3.5
    assert np.sqrt(np.mean((distance - radius) ** 2)) < 1.2
    texts = [s for s in sheet.shapes if isinstance(s, Text)]
    label = next(s for s in texts if s.text == "500" and s.size == 11)
    assert np.hypot(*(label.place - middle)) / zoom == pytest.approx(radius, abs=3.5)
    values = [s for s in texts if s.size == 10 and s.halo]
    assert len(values) == 5 * 6
    for each in values:
        column, row = (np.array(each.place) - [0.0, 10.0] - [MARGIN, TOP]) / zoom
        told = float(exact[int(height - row), int(column)])
        assert float(each.text) == pytest.approx(told, rel=0.1)
    assert any("means over about" in s.text and "noise 2 %" in s.text for s in texts)
    exactly = draw_map("E", exact, levels=[level], unit="lx", smoothing=2, error=0.0 * exact)
    path = max((s.path for s in exactly.shapes if isinstance(s, Line)), key=len)
    assert np.abs(np.hypot(*(path - middle).T) / zoom - radius).max() < 0.1


def test_noise_that_is_left_by_means_is_that_of_their_weights():
    noise = np.random.default_rng(3).normal(0.0, 1.0, (300, 300))
    field = noise
    for passes in (1, 2, 3):
        field = smooth(field)
        assert field[8:-8, 8:-8].std() == pytest.approx(noise_left(passes), rel=0.03)
    assert choose_passes(0.0, 2, 500) == 2
    assert choose_passes(0.1, 2, 500) * 2 * np.pi == pytest.approx((0.1 / 0.02) ** 2, rel=0.2)
    assert choose_passes(9.0, 2, 500) == 50 and choose_passes(9.0, 2, 32) == 2
    assert relative_noise([100.0, np.nan], [5.0, 1.0]) == pytest.approx(0.05)
    assert relative_noise([0.0, 0.0], [0.0, 0.0]) == 0.0
