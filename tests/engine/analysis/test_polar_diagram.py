"""Polar and cartesian diagrams: the curves lie where the intensities say, judged by the pixels."""

import numpy as np
import pytest
from drawn_curves import circle_through
from luminaires import rotational
from PIL import ImageColor

from lumenray.engine.analysis.canvas import DARK, LIGHT
from lumenray.engine.analysis.polar_diagram import diagram_pixels, draw_polar_diagram, round_step
from lumenray.engine.luminaires.coordinates import directions
from lumenray.engine.luminaires.formats.record import LuminaireFile
from lumenray.engine.scene.distribution import IntensityDistribution, Opening

SIDE = 1024
"""Size of the pictures that are measured: lines are four pixels wide. [pixel]"""

MIDDLE = SIDE / 2

RED, BLUE, GREY = (np.array(ImageColor.getrgb(colour), float) for colour in LIGHT.curves)
GRID, AXIS = (np.array(ImageColor.getrgb(colour), float) for colour in (LIGHT.grid, LIGHT.axis))


def full(values):
    """Distribution of a function of the direction."""
    azimuth, polar = np.deg2rad(np.arange(0, 361, 5.0)), np.deg2rad(np.arange(0, 181, 1.0))
    towards = directions(azimuth[:, None], polar[None, :])
    return IntensityDistribution(azimuth, polar, np.maximum(values(towards), 0.0))


def picture_of(source, **options):
    """Pixels inside the frame (h, w, 3), and the place (x, y) of its upper left corner."""
    picture = np.asarray(draw_polar_diagram(source, (SIDE, SIDE), **options), dtype=float)
    return picture[134:906, 86:938], np.array([86, 134])


def points_of(picture, colour, offset=(0, 0), near=40.0):
    """Places (n, 2) of pixels of a colour, dots of the peak left out."""
    rows, columns = np.nonzero(np.abs(picture - colour).max(axis=2) < near)
    return np.stack([columns, rows], axis=1) + 0.5 + np.asarray(offset)


# ---- shape ----


def test_a_lambertian_face_is_a_circle_that_hangs_from_the_pole():
    picture, offset = picture_of(rotational(lambda g: 1000.0 * np.cos(g)))
    points = points_of(picture, RED, offset)
    centre, radius = circle_through(points)
    # Apart from the dot at the peak.
    away = np.abs(np.hypot(*(points - centre).T) - radius)
    assert np.percentile(away, 95) < 2.5
    assert centre[0] == pytest.approx(MIDDLE, abs=1.0)
    # The diameter is 1000 cd, and circles of the grid are 200 cd apart: seen on the left of the curve.
    pole = centre - [0.0, radius]
    ray = pole + np.linspace(0.2, 2.0, 4000)[:, None] * radius * [-np.sin(1.2), np.cos(1.2)]
    column, row = (np.floor(ray).astype(int) - offset).T
    inside = (row >= 0) & (row < len(picture)) & (column >= 0) & (column < picture.shape[1])
    value = np.linspace(0.2, 2.0, 4000)[inside] * 500.0
    shade = np.abs(picture[row[inside], column[inside]] - GRID).max(axis=1)
    for circle in (400.0, 600.0, 800.0):
        if value.max() > circle + 20.0:
            assert shade[np.abs(value - circle) < 6.0].min() < 10.0, circle
        assert shade[np.abs(value - circle + 100.0) < 60.0].min() > 10.0, circle


def test_a_globe_is_a_circle_about_the_pole_where_the_axes_cross():
    picture, offset = picture_of(rotational(lambda g: np.full_like(g, 80.0)))
    centre, radius = circle_through(points_of(picture, RED, offset))
    axes = points_of(picture, AXIS, offset, near=8.0)
    outside = axes[np.hypot(*(axes - centre).T) > radius + 8]
    upright = outside[np.abs(outside[:, 0] - centre[0]) < 4]
    level = outside[np.abs(outside[:, 1] - centre[1]) < 4]
    assert len(upright) > 10
    assert len(level) > 10
    assert upright[:, 0].mean() == pytest.approx(centre[0], abs=1.0)
    assert level[:, 1].mean() == pytest.approx(centre[1], abs=1.0)


def reach(points, pole, degrees, width):
    """Median distance from the pole of the outer points near a ray; the angle counts from below, to the right."""
    away = points - pole
    angle = np.rad2deg(np.arctan2(away[:, 0], away[:, 1]))
    distance = np.hypot(*away.T)[np.abs(angle - degrees) < width]
    return np.median(distance[distance > distance.max() - 8.0])


def test_curves_reach_as_far_as_the_intensities_say():
    """Two planes unlike each other, and unlike on their two sides."""

    def light(d):
        down, x, y = -d[..., 2], d[..., 0], d[..., 1]
        return np.where(down > 0, 1000 * down + 600 * x * down + 1500 * np.abs(y) * down, 0.0)

    picture, offset = picture_of(full(light))
    red, blue = points_of(picture, RED, offset), points_of(picture, BLUE, offset)
    # The curves leave the pole sideways, and their lines are four pixels wide.
    pole = np.array([MIDDLE, red[:, 1].min() + 2.0])
    scale = reach(red, pole, 20.0, 0.5) / light(directions(0.0, np.deg2rad(20.0)))
    for degrees in (-60, -45, -30, 30, 45, 60):
        wanted = light(directions(0.0, np.deg2rad(degrees))) * scale
        assert reach(red, pole, degrees, 0.5) == pytest.approx(wanted, abs=3.0), degrees
    # The other is dashed, so all of its points are looked at, each at its own angle.
    away = blue - pole
    angle = np.arctan2(away[:, 0], away[:, 1])
    wanted = light(directions(0.5 * np.pi, angle)) * scale
    off = np.abs(np.hypot(*away.T) - wanted)[np.abs(angle) < np.deg2rad(65.0)]
    assert len(off) > 1000
    assert np.percentile(off, 95) < 5.0


@pytest.mark.parametrize(("x", "is_right"), [(0.6, True), (-0.6, False)])
def test_light_to_c0_lies_on_the_right(x, is_right):
    aside = full(lambda d: np.maximum(d @ np.array([x, 0.0, -0.8]), 0.0) ** 20)
    picture, offset = picture_of(aside, kind="polar")
    lowest = points_of(picture, RED, offset)[:, 1].max()
    points = points_of(picture, RED, offset)
    foot = points[points[:, 1] > lowest - 20, 0]
    assert np.all(foot > MIDDLE if is_right else foot < MIDDLE)


def test_light_upwards_lies_above_the_pole():
    picture, offset = picture_of(rotational(lambda g: -np.cos(g)))
    axes = points_of(picture, AXIS, offset, near=8.0)
    level = np.bincount(axes[:, 1].astype(int)).argmax()
    points = points_of(picture, RED, offset)
    assert points[:, 1].max() < level + 8
    assert points[:, 1].min() < level - 300


def test_the_plane_of_the_peak_is_drawn_where_neither_plane_has_it():
    def light(d):
        return 50.0 + 5000.0 * np.maximum(d @ np.array([0.5, 0.5, -np.sqrt(0.5)]), 0.0) ** 30

    picture, _ = picture_of(full(light))
    assert len(points_of(picture, GREY, near=12.0)) > 1000
    picture, _ = picture_of(full(lambda d: 50.0 + 100.0 * d[..., 0] ** 2))
    assert len(points_of(picture, GREY, near=12.0)) < 300


# ---- cartesian ----


def test_a_narrow_beam_is_cartesian_and_has_half_its_peak_at_its_half_angle():
    spot = rotational(lambda g: 20000.0 * (1.0 - np.rad2deg(g) / 8.0), 0.5)
    picture, offset = picture_of(spot)
    points = points_of(picture, RED, offset)
    body = points[(points[:, 1] > points[:, 1].min() + 40) & (points[:, 1] < 880)]
    # A triangle, not the drop of the polar diagram: straight flanks that meet the ground twice as wide as the middle.
    flanks = [body[body[:, 0] < MIDDLE - 15], body[body[:, 0] > MIDDLE + 15]]
    lines = [np.polyfit(flank[:, 1], flank[:, 0], 1) for flank in flanks]
    for flank, line in zip(flanks, lines, strict=True):
        assert np.abs(flank[:, 0] - np.polyval(line, flank[:, 1])).max() < 6.0
    apex = (lines[1][1] - lines[0][1]) / (lines[0][0] - lines[1][0])
    assert np.polyval(lines[0], apex) == pytest.approx(MIDDLE, abs=1.0)
    ground = 2 * (512 - 56)
    width = [
        np.polyval(lines[1], y) - np.polyval(lines[0], y)
        for y in (apex, 0.5 * (apex + ground), ground)
    ]
    assert width[1] == pytest.approx(0.5 * width[2], rel=0.01)
    assert np.any(
        np.asarray(draw_polar_diagram(spot)) != np.asarray(draw_polar_diagram(spot, kind="polar"))
    )


def test_a_narrow_uplight_stands_in_the_middle():
    picture, offset = picture_of(rotational(lambda g: np.maximum(-np.cos(g), 0.0) ** 400, 0.5))
    points = points_of(picture, RED, offset)
    assert points[:, 0].mean() == pytest.approx(MIDDLE, abs=3.0)
    top = points[points[:, 1] < points[:, 1].min() + 8, 0]
    assert top.mean() == pytest.approx(MIDDLE, abs=3.0)


# ---- picture ----


def test_intensities_for_1000_lumens_leave_the_shape():
    # 500 cd on the axis of 500 pi lm: 318 cd/klm. Both need circles of other values, but the curve is the same circle.
    light = rotational(lambda g: 500.0 * np.cos(g))
    circles = []
    for per_klm in (False, True):
        picture, offset = picture_of(light, per_klm=per_klm)
        circles.append(circle_through(points_of(picture, RED, offset)))
    assert circles[0][0] == pytest.approx(circles[1][0], abs=1.5)
    assert circles[0][1] == pytest.approx(circles[1][1], abs=1.5)


def test_pixels_for_blender_come_from_the_bottom_row_up():
    light = rotational(np.cos)
    pixels = diagram_pixels(light, size=(320, 256), dark=True)
    assert pixels.shape == (256, 320, 4)
    assert pixels.dtype == np.float32
    assert pixels.min() >= 0.0
    assert pixels.max() <= 1.0
    assert np.all(pixels[..., 3] == 1.0)
    picture = np.asarray(draw_polar_diagram(light, (320, 256), dark=True))
    assert np.array_equal(np.rint(pixels[::-1, :, :3] * 255).astype(np.uint8), picture)
    assert tuple(picture[0, 0]) == ImageColor.getrgb(DARK.background)


@pytest.mark.parametrize("size", [(128, 128), (300, 640), (1024, 512)])
def test_sizes_are_kept(size):
    assert draw_polar_diagram(rotational(np.cos), size).size == size


@pytest.mark.parametrize("kind", ["auto", "polar", "cartesian"])
def test_a_dark_luminaire_and_a_file_can_be_drawn(kind):
    dark = rotational(lambda g: 0.0 * g)
    file = LuminaireFile(
        "made here", "C", "rotational", dark, Opening(), np.zeros(1), np.zeros(2), False, 0.0
    )
    picture = np.asarray(draw_polar_diagram(file, kind=kind, per_klm=True), dtype=float)
    assert len(points_of(picture[64:454], RED)) == 0


def test_lines_of_the_grid_are_at_round_values():
    assert [round_step(x, 5) for x in (1000, 999, 1245, 0.37, 7.0)] == [200, 200, 250, 0.1, 2]
