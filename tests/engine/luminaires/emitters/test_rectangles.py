"""Rectangles that glow or let light in: points on them are drawn evenly over the solid angle, and densities say so."""

import numpy as np
import pytest
from scipy import integrate, stats
from small_scenes import quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.light import AreaLight, Output, Quantity
from lumenray.engine.scene.material import Black, Emission, Material

pytestmark = [pytest.mark.mitsuba, pytest.mark.usefixtures("mono")]

DRAWN = 1 << 18
SIGNIFICANCE = 1e-4
"""Of each of the few chi-square tests of this file."""

RECEIVERS = {
    "square": ((1.0, 1.0), (0.0, 0.0, 0.5)),
    "along a strip": ((5.8, 0.15), (0.3, 0.1, 0.3)),
    "below its plane": ((5.8, 0.15), (3.0, 0.4, -1.0)),
    "before its end": ((5.8, 0.15), (7.0, 0.0, 0.2)),
    "close to a corner": ((1.0, 1.0), (0.99, 0.99, 0.01)),
    "far away": ((0.6, 0.6), (0.0, 3.0, 4.0)),
}
"""Half sizes and place of the receiver in the rectangle's axes. [m]"""

FIELDS = 8


def solid_angles(half, q):
    """Solid angles of equal fields of a rectangle, by adaptive quadrature. (FIELDS, FIELDS) [sr]"""

    def element(y, x):
        squared = (x - q[0]) ** 2 + (y - q[1]) ** 2 + q[2] ** 2
        return abs(q[2]) / squared**1.5

    edges = [np.linspace(-size, size, FIELDS + 1) for size in half]
    return np.array(
        [
            [
                integrate.dblquad(element, *edges[0][i : i + 2], *edges[1][j : j + 2])[0]
                for j in range(FIELDS)
            ]
            for i in range(FIELDS)
        ]
    )


def draw(half, q):
    """Points on a rectangle, -1 to 1, and its solid angle as found. (DRAWN, 2), [sr]"""
    import mitsuba as mi

    from lumenray.engine.arrays import upload
    from lumenray.engine.luminaires.emitters.rectangles import draw_place, find_solid_angle

    sizes = [mi.Float(size) for size in half]
    angle = find_solid_angle(mi.Point3f(*q), *sizes)
    numbers = np.random.default_rng(3).random((2, DRAWN))
    sample = mi.Point2f(*(upload(mi.Float, row) for row in numbers))
    place = draw_place(mi.Point3f(*q), *sizes, sample, angle)
    return np.stack([np.array(place.x), np.array(place.y)], axis=1), float(np.array(angle)[0])


@pytest.mark.parametrize("half, q", RECEIVERS.values(), ids=RECEIVERS)
def test_points_are_even_over_the_solid_angle(half, q):
    place, angle = draw(half, q)
    expected = solid_angles(half, q)
    assert angle == pytest.approx(expected.sum(), rel=1e-4)
    assert np.abs(place).max() <= 1.0 + 1e-6
    field = np.minimum(((place + 1.0) * 0.5 * FIELDS).astype(int), FIELDS - 1)
    found = np.bincount(field[:, 0] * FIELDS + field[:, 1], minlength=FIELDS**2)
    wanted = expected.ravel() / expected.sum() * DRAWN
    assert stats.chisquare(found, wanted * found.sum() / wanted.sum()).pvalue > SIGNIFICANCE


def test_points_of_a_small_solid_angle_are_even_over_the_area():
    place, angle = draw((0.1, 0.2), (3.0, 2.0, 4.0))
    assert angle == 0.0
    found = np.histogram2d(*place.T, bins=FIELDS, range=[[-1, 1], [-1, 1]])[0]
    assert stats.chisquare(found.ravel()).pvalue > SIGNIFICANCE


CORNERS = np.array([[-3.0, -0.05, 0.4], [3.0, -0.05, 0.4], [3.0, 0.05, 0.4], [-3.0, 0.05, 0.4]])
"""Of a strip of 6 m by 0.1 m over the plane z = 0, which shines down. [m]"""

PLACES = np.array([[0.0, 0.3, 0.0], [2.9, -0.1, 0.0], [3.5, 0.0, 0.0], [-1.0, 0.0, 0.3]])
NORMALS = np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0], [-0.6, 0.0, 0.8], [0.0, 0.0, 1.0]])

LUMINANCE = 1000.0


def lambert(corners, place, normal):
    """Illuminance from a polygon of even luminance that is wholly above the horizon (J. H. Lambert, 1760). [lx]"""
    towards = corners - place
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    onwards = np.roll(towards, -1, axis=0)
    crossed = np.cross(towards, onwards)
    sines = np.linalg.norm(crossed, axis=1)
    angles = np.arctan2(sines, (towards * onwards).sum(axis=1))
    return abs(float((angles * (crossed @ normal) / sines).sum())) * 0.5 * LUMINANCE


def strip_light():
    """The strip as a light."""
    frame = np.eye(4)
    frame[2, 3] = 0.4
    output = Output(Quantity.LUMINANCE, LUMINANCE)
    return [AreaLight("strip", "strip", output, frame, 6.0, 0.1)]


def strip_of_triangles(order=(0, 1, 2, 3)):
    """The strip as a mesh that glows."""
    mesh = quad("strip", (-3.0, -0.05, 0.4), (0.0, 0.1, 0.0), (6.0, 0.0, 0.0), "glow")
    mesh.triangles[:] = np.array(order)[mesh.triangles]
    glow = Emission(luminance=LUMINANCE, two_sided=False)
    return [mesh, Material("glow", "glow", Black(), glow)]


STRIPS = {
    "light": strip_light(),
    "mesh": strip_of_triangles(),
    "other diagonal": strip_of_triangles((1, 2, 3, 0)),
}


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("items", STRIPS.values(), ids=STRIPS)
def test_a_strip_nearby_follows_its_closed_form_with_little_scatter(transport, items):
    made = session_of(*items).measure(PLACES, NORMALS, StopRule(samples=1024), transport=transport)
    expected = [lambert(CORNERS, *each) for each in zip(PLACES, NORMALS, strict=True)]
    assert np.all(
        np.abs(made.illuminance - expected) < 4.0 * made.standard_error + 1e-3 * np.array(expected)
    )
    # Points that are even over the area scatter by 0.4 to 1.2 of the mean here.
    assert np.all(made.standard_error * np.sqrt(1024) < 0.15 * np.array(expected))


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("shift", [(1.0, 0.0), (0.0, 0.1)], ids=["trapezium", "kite"])
def test_a_face_of_two_triangles_that_is_no_rectangle_shines_all_the_same(transport, shift):
    mesh, glow = strip_of_triangles()
    mesh.vertices[2, :2] += shift
    corners = mesh.vertices.astype(float)
    made = session_of(mesh, glow).measure(
        PLACES[:1], NORMALS[:1], StopRule(samples=4096), transport=transport
    )
    expected = lambert(corners, PLACES[0], NORMALS[0])
    assert abs(made.illuminance[0] - expected) < 4.0 * made.standard_error[0]
