"""Polar solids, curves and outlines of openings, against closed forms."""

import numpy as np
import pytest
from blender_luminaires import farthest

from lumenray.blender_addon.luminaires.solid import make_curve, make_outline, make_solid
from lumenray.engine.luminaires.coordinates import FRAMES
from lumenray.engine.luminaires.distribution import intensity
from lumenray.engine.scene.distribution import IntensityDistribution, Opening

DEGREES = np.arange(181.0)

POLAR = np.radians(DEGREES)


def rotational(values, polar=POLAR):
    """Return a distribution that is the same all around. ``values`` (p,) [cd]"""
    return IntensityDistribution(np.zeros(1), polar, np.asarray(values, float)[None])


def pointed(azimuth, polar, kind="C"):
    """Return a distribution with light about one pair of angles of the grid alone. [degree]"""
    azimuths = np.radians(np.arange(0.0, 361.0, 10.0))
    values = np.zeros((len(azimuths), len(POLAR)))
    values[round(azimuth / 10.0), round(polar)] = 700.0
    return IntensityDistribution(azimuths, POLAR, values, FRAMES[kind])


def volume(solid):
    """Volume that the triangles enclose, positive if they are counter-clockwise from outside."""
    a, b, c = (solid.vertices[solid.triangles[:, corner]].astype(float) for corner in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


def test_solid_of_a_lambertian_source_is_a_sphere_that_touches_it():
    solid = make_solid(rotational(50.0 * np.clip(np.cos(POLAR), 0.0, None)), 72, 60)
    used = solid.vertices[np.unique(solid.triangles)]
    assert np.linalg.norm(used - np.array([0.0, 0.0, -0.5]), axis=1) == pytest.approx(0.5, abs=1e-4)
    assert volume(solid) == pytest.approx(np.pi / 6.0, rel=5e-3)
    assert solid.brightness.min() > 0.0
    assert solid.brightness.max() <= 1.0


@pytest.mark.parametrize("kind", ["A", "B", "C"])
def test_vertices_lie_as_far_out_as_the_intensity_in_their_direction(kind):
    rng = np.random.default_rng(3)
    azimuth, polar = np.radians(np.arange(0.0, 361.0, 15.0)), np.radians(np.arange(0.0, 181.0, 5.0))
    values = rng.uniform(1.0, 9.0, (len(azimuth), len(polar)))
    values[-1] = values[0]
    # At the poles all azimuths are one direction.
    values[:, 0], values[:, -1] = 2.0, 5.0
    distribution = IntensityDistribution(azimuth, polar, values, FRAMES[kind])
    solid = make_solid(distribution, 48, 36)
    reach = np.linalg.norm(solid.vertices, axis=1)
    assert reach == pytest.approx(intensity(distribution, solid.vertices) / values.max(), rel=1e-4)
    assert reach.max() == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(
    ("distribution", "direction"),
    [
        (pointed(0, 60), (np.sin(np.radians(60)), 0.0, -0.5)),
        (pointed(90, 60), (0.0, np.sin(np.radians(60)), -0.5)),
        (pointed(0, 150), (0.5, 0.0, np.sin(np.radians(60)))),
        # LM-75: H of type A turns to the right, V of type B to above.
        (pointed(20, 90, "A"), (np.sin(np.radians(20)), 0.0, -np.cos(np.radians(20)))),
        (pointed(30, 90, "B"), (0.0, 0.5, -np.cos(np.radians(30)))),
    ],
)
def test_solid_points_where_the_light_goes(distribution, direction):
    assert farthest(make_solid(distribution, 48, 36)) == pytest.approx(direction, abs=1e-5)


def test_beam_of_two_degrees_keeps_its_length_and_volume():
    spread = np.radians(1.2)
    polar = np.radians(np.linspace(0.0, 180.0, 1801))
    solid = make_solid(rotational(1e6 * np.exp(-((polar / spread) ** 2)), polar), 48, 36)
    assert farthest(solid) == pytest.approx((0.0, 0.0, -1.0), abs=1e-6)
    # A third of the integral of (I / peak)^3 over the sphere, for small angles.
    assert volume(solid) == pytest.approx(np.pi * spread**2 / 9.0, rel=0.1)


def test_light_that_ends_at_the_edge_of_the_grid_is_closed_there():
    half = rotational(np.ones(3), np.radians([0.0, 45.0, 90.0]))
    assert volume(make_solid(half, 72, 60)) == pytest.approx(2.0 * np.pi / 3.0, rel=5e-3)
    quarter = IntensityDistribution(np.radians([0.0, 45.0, 90.0]), POLAR, np.ones((3, 181)))
    assert volume(make_solid(quarter, 72, 60)) == pytest.approx(np.pi / 3.0, rel=5e-3)


def test_mirrored_grid_is_not_inside_out():
    distribution = IntensityDistribution(
        np.radians([0.0, 90.0, 180.0, 270.0, 360.0]),
        POLAR,
        np.ones((5, 181)),
        np.diag([1.0, -1.0, 1.0]),
    )
    assert volume(make_solid(distribution, 72, 60)) == pytest.approx(4.0 * np.pi / 3.0, rel=5e-3)


def test_dark_distribution_has_neither_solid_nor_curve():
    dark = rotational(np.zeros(181))
    assert len(make_solid(dark, 48, 36).triangles) == 0
    assert len(make_curve(dark, 0.0, 100)) == 0


def test_curves_lie_in_their_planes_and_show_c180_on_the_other_side():
    azimuth = np.radians([0.0, 90.0, 180.0, 270.0, 360.0])
    downwards = np.clip(np.cos(POLAR), 0.0, None)
    values = np.array([1.0, 2.0, 3.0, 4.0, 1.0])[:, None] * downwards
    distribution = IntensityDistribution(azimuth, POLAR, values)
    first = make_curve(distribution, 0.0, 400)
    assert np.abs(first[:, 1]).max() < 1e-12
    # The largest sideways reach of k cos gamma is k / 2.
    assert first[:, 0].max() == pytest.approx(0.5 * 1.0 / 4.0, rel=1e-3)
    assert first[:, 0].min() == pytest.approx(-0.5 * 3.0 / 4.0, rel=1e-3)
    second = make_curve(distribution, np.pi / 2.0, 400)
    assert np.abs(second[:, 0]).max() < 1e-12
    assert second[:, 1].max() == pytest.approx(0.5 * 2.0 / 4.0, rel=1e-3)
    assert second[:, 1].min() == pytest.approx(-0.5, rel=1e-3)
    assert first[0] == pytest.approx(first[-1])


@pytest.mark.parametrize(
    ("opening", "lines"),
    [
        (Opening("rectangle", (1.2, 0.3, 0.0)), 4),
        (Opening("rectangle", (1.2, 0.0, 0.3), "y"), 4),
        (Opening("ellipse", (0.4, 0.2, 0.0)), 32),
        (Opening("box", (1.0, 0.5, 0.1)), 12),
        (Opening("cylinder", (1.5, 0.04, 0.04), "x"), 68),
        (Opening("ellipsoid", (0.3, 0.3, 0.2)), 96),
    ],
)
def test_outline_has_the_size_of_the_opening(opening, lines):
    outline = make_outline(opening)
    assert outline.shape == (lines, 2, 3)
    points = outline.reshape(-1, 3)
    assert points.max(axis=0) == pytest.approx(0.5 * np.array(opening.size), rel=1e-9)
    assert points.min(axis=0) == pytest.approx(-0.5 * np.array(opening.size), rel=1e-9)


def test_point_has_no_outline():
    assert make_outline(Opening()).shape == (0, 2, 3)
