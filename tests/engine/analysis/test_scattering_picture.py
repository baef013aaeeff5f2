"""Pictures of scattering: curves lie where the values say, judged by the pixels."""

from pathlib import Path

import numpy as np
import pytest
from drawn_curves import circle_through
from instruments import measure, paint
from PIL import ImageColor

from lumenray.engine.analysis.canvas import DARK, LIGHT
from lumenray.engine.analysis.scattering_picture import (
    CURVES,
    albedo_chart,
    draw_albedo_chart,
    draw_before_after,
    draw_polar_cuts,
    luminous_mean,
    polar_cuts,
)
from lumenray.engine.scattering.data.record import ScatteringFile
from lumenray.engine.scattering.measuring.processing import process_measurement
from lumenray.engine.scene.scattering import ScatterTable

SIZE = (960, 720)
"""Pictures that are measured."""

COLOURS = [np.array(ImageColor.getrgb(colour), float) for colour in CURVES[False]]

CENTRE = SIZE[0] / 2


def table(values, direct=None, wavelengths=(450.0, 650.0)):
    """A table of a function of the radial angle and the azimuth, for all angles of incidence."""
    radials = np.radians(np.arange(0.0, 181.0, 2.0))
    azimuths = np.radians(np.arange(0.0, 181.0, 15.0))
    incidences = np.radians([0.0, 45.0, 89.0])
    grid = values(radials[:, None], azimuths[None, :])
    shape = 1, 3, len(radials), len(azimuths), len(wavelengths)
    made = np.broadcast_to(np.broadcast_to(grid, shape[2:4])[..., None], shape).astype(np.float32)
    if direct is not None:
        direct = np.full((1, 3, len(wavelengths)), direct, np.float32)
    return ScatterTable(
        np.zeros(1), incidences, radials, azimuths, np.array(wavelengths), made, direct
    )


def matt(value):
    return table(lambda t, a: np.full(np.broadcast(t, a).shape, value))


def points_of(picture, colour, near=30.0):
    """Places (n, 2) of pixels of a colour inside the plot: x, y."""
    pixels = np.asarray(picture, dtype=float)[100:-100]
    rows, columns = np.nonzero(np.abs(pixels - colour).max(axis=2) < near)
    return np.stack([columns, rows + 100], axis=1) + 0.5


def on_the_curve(points):
    """Without the arrow of the light and the legend."""
    middle, radius = circle_through(points)
    away = np.abs(np.hypot(*(points - middle).T) - radius)
    return points[away < 12.0]


# ---- polar cuts ----


def test_a_matt_surface_is_half_a_circle_of_its_value():
    """0.2 / sr reaches twice as far as 0.1 / sr on the same scale, whose rim is at 0.2."""
    for value in (0.2, 0.1):
        both = {"front_reflection": matt(value), "front_transmission": matt(0.2)}
        points = points_of(draw_polar_cuts(both, (30,), size=SIZE), COLOURS[0])
        ground = np.median(points[:, 1][np.abs(points[:, 0] - points[:, 0].max()) < 3])
        upper = on_the_curve(points[points[:, 1] < ground - 20])
        lower = on_the_curve(points[points[:, 1] > ground + 20])
        (middle, radius), (_, other) = circle_through(upper), circle_through(lower)
        assert middle[0] == pytest.approx(CENTRE, abs=1.5)
        assert radius / other == pytest.approx(value / 0.2, abs=0.02)


def test_light_comes_from_the_left_and_is_mirrored_to_the_right():
    lobe = table(lambda t, a: 0.1 + 0.5 * np.exp(-((t / 0.2) ** 2)) + 0.0 * a)
    points = points_of(draw_polar_cuts(lobe, (45,), size=SIZE), COLOURS[0])
    curve = points[points[:, 0] > CENTRE]
    ground = points[:, 1].max()
    # The farthest point lies at 45 degrees on the right.
    far = curve[np.hypot(curve[:, 0] - CENTRE, ground - curve[:, 1]).argmax()]
    assert np.degrees(np.arctan2(far[0] - CENTRE, ground - far[1])) == pytest.approx(45.0, abs=4.0)
    # The arrow, beyond the curve on the left, at 45 degrees too.
    away = np.hypot(points[:, 0] - CENTRE, ground - points[:, 1])
    arrow = points[(points[:, 0] < CENTRE) & (away > 0.8 * away.max())].mean(axis=0)
    assert np.degrees(np.arctan2(arrow[0] - CENTRE, ground - arrow[1])) == pytest.approx(
        -45.0, abs=2.0
    )


def test_a_peak_makes_the_scale_logarithmic():
    """0.1 / sr under a peak of 10 / sr: on a linear scale it would be a hundredth of the radius."""
    peak = table(lambda t, a: 0.1 + 9.9 * np.exp(-((t / 0.1) ** 2)) + 0.0 * a)
    points = points_of(draw_polar_cuts(peak, (0,), size=SIZE), COLOURS[0])
    ground = points[:, 1].max()
    side = points[(points[:, 1] > ground - 30) & (points[:, 0] > CENTRE)]
    top = ground - points[:, 1].min()
    reach = side[:, 0].max() - CENTRE
    # From 0.05 to 10 / sr: 0.1 lies at log 2 / log 200 = 0.131.
    assert reach / top == pytest.approx(0.131, abs=0.02)


def test_incidences_have_colours_of_their_own_and_a_legend():
    lobe = table(lambda t, a: 0.1 + 0.5 * np.exp(-((t / 0.2) ** 2)) + 0.0 * a)
    picture = draw_polar_cuts(lobe, size=SIZE)
    for colour in COLOURS:
        assert len(points_of(picture, colour)) > 200
        legend = np.asarray(picture, dtype=float)[-80:]
        assert (np.abs(legend - colour).max(axis=2) < 30).sum() > 50


def test_a_mirrors_share_is_a_dashed_ray():
    plain, coated = matt(0.1), table(lambda t, a: 0.1 + 0.0 * t * a, direct=0.04)
    with_ray, without = (
        points_of(draw_polar_cuts(each, (60,), size=SIZE), COLOURS[0]) for each in (coated, plain)
    )
    ground = without[:, 1].max()
    new = {tuple(p) for p in with_ray} - {tuple(p) for p in without}
    new = np.array([p for p in new if p[1] < ground - 20])
    angle = np.degrees(np.arctan2(new[:, 0] - CENTRE, ground - new[:, 1]))
    assert len(new) > 100
    assert np.median(angle) == pytest.approx(60.0, abs=1.5)


def test_spectra_count_by_the_eye():
    """V(450 nm) = 0.038, V(550 nm) = 0.995 (CIE 018): green counts, and even spectra keep their value."""
    bands = np.arange(400.0, 701.0, 10.0)
    np.testing.assert_allclose(luminous_mean(bands, np.full((3, 31), 0.4)), 0.4, rtol=1e-9)
    blue, green = np.exp(-(((bands - 450) / 20) ** 2)), np.exp(-(((bands - 550) / 20) ** 2))
    assert (
        luminous_mean(bands, np.stack([blue, green]))[1] > 15 * luminous_mean(bands, blue[None])[0]
    )


def test_pixels_for_blender_come_from_the_bottom_row_up():
    picture = np.asarray(draw_polar_cuts(matt(0.1), size=(320, 240), dark=True))
    pixels = polar_cuts(matt(0.1), size=(320, 240), dark=True)
    assert pixels.shape == (240, 320, 4)
    assert pixels.dtype == np.float32
    assert np.all(pixels[..., 3] == 1.0)
    np.testing.assert_array_equal(np.rint(pixels[::-1, :, :3] * 255).astype(np.uint8), picture)
    assert tuple(picture[0, 0]) == ImageColor.getrgb(DARK.background)


@pytest.mark.parametrize("side", ["front", "back", "front_transmission", "back_reflection"])
@pytest.mark.parametrize("value", [0.0, 1e-7, 0.3, 1e5])
def test_any_side_and_any_value_can_be_drawn(side, value):
    file = ScatteringFile(
        Path("glass"),
        "made here",
        {"front_transmission": matt(value), "back_reflection": matt(value)},
    )
    for picture in (
        draw_polar_cuts(file, side=side, size=(200, 160)),
        draw_albedo_chart(file, side, (200, 160)),
    ):
        assert picture.size == (200, 160)


def test_unknown_sides_are_refused():
    with pytest.raises(ValueError, match="no side"):
        draw_polar_cuts(matt(0.1), side="left")


# ---- totals ----


def level_of(picture, colour):
    """Height of a level line over the frame's bottom, as a share of the frame."""
    pixels = np.asarray(picture, dtype=float)
    frame = np.array(ImageColor.getrgb(LIGHT.axis), float)
    # The frame's left side, and its rows.
    rows = np.flatnonzero((np.abs(pixels - frame).max(axis=2) < 12).sum(axis=1) > 0.8 * SIZE[0])
    top, bottom = rows.min(), rows.max()
    line = np.flatnonzero((np.abs(pixels - colour).max(axis=2) < 30).sum(axis=1) > 0.5 * SIZE[0])
    return (bottom - line.mean()) / (bottom - top)


def test_totals_are_levels_of_their_share():
    """A matt surface reflects pi times its BRDF at every angle."""
    both = {"front_reflection": matt(0.5 / np.pi), "front_transmission": matt(0.2 / np.pi)}
    picture = draw_albedo_chart(both, size=SIZE)
    assert level_of(picture, COLOURS[0]) == pytest.approx(0.5, abs=0.01)
    assert level_of(picture, COLOURS[4]) == pytest.approx(0.2, abs=0.01)
    assert albedo_chart(both, size=(200, 160)).shape == (160, 200, 4)


def test_the_direct_part_counts_in_totals():
    coated = table(lambda t, a: 0.5 / np.pi + 0.0 * t * a, direct=0.25)
    assert level_of(draw_albedo_chart(coated, size=SIZE), COLOURS[0]) == pytest.approx(
        0.75, abs=0.01
    )


# ---- before and after ----


@pytest.mark.slow
def test_dots_of_the_measurement_lie_about_the_lines_of_the_table():
    bands = np.array([450.0, 550.0, 650.0])
    made = process_measurement(measure(paint(bands), bands, noise=0.01, holes=0.0))
    picture = draw_before_after(made, size=SIZE)
    for colour in COLOURS[:5]:
        assert len(points_of(picture, colour)) > 500
    # The lobe at 45 degrees of incidence is highest at 45 of the angles from -90 to 90 across the frame.
    points = points_of(picture, COLOURS[3])
    left, right = 58 * 1.5, SIZE[0] - 20 * 1.5
    degrees = -90.0 + 180.0 * (points[:, 0] - left) / (right - left)
    top = points[:, 1] < points[:, 1].min() + 6
    assert degrees[top].mean() == pytest.approx(45.0, abs=2.0)
    assert draw_before_after(made, size=(200, 160), dark=True).size == (200, 160)
