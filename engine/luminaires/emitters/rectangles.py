"""Points of rectangles, drawn evenly over the solid angle that a receiver sees.

Of a long strip or a pane nearby, points that are even over the area lie mostly far away, where they count little; directions
that are even over the solid angle leave the cosine at the receiver alone to vary. Where a rectangle fills a small solid
angle the two are alike, and single precision could not tell the angle, so points are even over the area there.

A rectangle lies in the plane z = 0 of its own axes, with its centre at the origin.

References
----------
C. Ureña, M. Fajardo, A. King: An Area-Preserving Parametrization for Spherical Rectangles, Comput. Graph. Forum 32(4), 2013.
"""

import drjit as dr
import mitsuba as mi

SMALL = 0.01
"""Solid angle below which points are drawn by area: single precision leaves an error of 1e-4 of it there. [sr]"""

TINY = 1e-20


def into_axes(point, centre, x, y):
    """A point in the axes of a rectangle. ``x``, ``y``: along its sides, of unit length. Point3f"""
    away = mi.Vector3f(point) - centre
    return mi.Point3f(dr.dot(away, x), dr.dot(away, y), dr.dot(away, dr.cross(x, y)))


def find_solid_angle(q, half_x, half_y):
    """Solid angle of a rectangle; 0 where it is too small to draw by. [sr]

    Parameters
    ----------
    q : Point3f    The receiver. [m]
    half_x, half_y : Float    Half sizes. [m]
    """
    left, right, low, high, height = _edges(q, half_x, half_y)

    def corner(x, y):
        return dr.atan2(x * y, height * dr.sqrt(dr.square(x) + dr.square(y) + dr.square(height)))

    angle = corner(right, high) - corner(left, high) - corner(right, low) + corner(left, low)
    return dr.select(angle >= SMALL, angle, 0.0)


def draw_place(q, half_x, half_y, sample, angle):
    """Draw a point.

    Parameters
    ----------
    sample : Point2f
    angle : Float    As `find_solid_angle` has it for that receiver.

    Returns
    -------
    Point2f    In -1 to 1 along both sides.
    """
    left, right, low, high, height = _edges(q, half_x, half_y)
    # Components along z of the normals of the planes through the receiver and each side.
    below, above, before = (
        edge * dr.rsqrt(dr.square(edge) + dr.square(height)) for edge in (-low, high, -left)
    )
    start = dr.two_pi - dr.safe_acos(-above * before) - dr.safe_acos(-before * below)
    sine, cosine = dr.sincos(sample.x * angle + start)
    sine = dr.select(dr.abs(sine) > 1e-9, sine, 1e-9)
    slope = (cosine * below - above) / sine
    turn = dr.rsqrt(dr.maximum(dr.square(slope) + dr.square(below), TINY))
    turn = dr.clip(dr.select(slope > 0.0, turn, -turn), -1.0, 1.0)
    x = turn * height * dr.rsqrt(dr.maximum(1.0 - dr.square(turn), 1e-12))
    x = dr.clip(x, left, right)
    reach = dr.square(x) + dr.square(height)
    first, last = (edge * dr.rsqrt(reach + dr.square(edge)) for edge in (low, high))
    rise = dr.lerp(first, last, sample.y)
    y = rise * dr.sqrt(reach / dr.maximum(1.0 - dr.square(rise), 1e-12))
    y = dr.clip(y, low, high)
    place = mi.Point2f((x + q.x) / half_x, (y + q.y) / half_y)
    return dr.select(angle > 0.0, place, 2.0 * sample - 1.0)


def find_density(half_x, half_y, distance, cosine, angle):
    """Density over solid angle of the direction to a point of a rectangle. [1/sr]

    Parameters
    ----------
    distance : Float    To the point. [m]
    cosine : Float    Of the angle to the rectangle's normal.
    angle : Float    As `find_solid_angle` has it for the receiver.
    """
    by_area = dr.square(distance) / dr.maximum(4.0 * half_x * half_y * dr.abs(cosine), TINY)
    return dr.select(angle > 0.0, dr.rcp(dr.maximum(angle, SMALL)), by_area)


def sample_rectangle(rectangle, point, sample):
    """Draw a direction from a receiver to a rectangle.

    Parameters
    ----------
    rectangle : (Vector3f, Vector3f, Vector3f)    Centre, and halves of both sides, whose product is the normal. [m]
    point : Point3f    The receiver. [m]
    sample : Point2f

    Returns
    -------
    DirectionSample3f    With place, normal, direction, distance and density; without the emitter.
    """
    x, y, half_x, half_y, q, angle = _look(rectangle, point)
    place = draw_place(q, half_x, half_y, sample, angle)
    ds = dr.zeros(mi.DirectionSample3f)
    ds.p = rectangle[0] + x * (half_x * place.x) + y * (half_y * place.y)
    ds.n = dr.cross(x, y)
    ds.d = ds.p - point
    ds.dist = dr.norm(ds.d)
    ds.d /= dr.maximum(ds.dist, TINY)
    ds.pdf = find_density(half_x, half_y, ds.dist, dr.dot(ds.d, ds.n), angle)
    return ds


def find_rectangle_density(rectangle, point, distance, cosine):
    """Density over solid angle with which `sample_rectangle` draws a direction. [1/sr]

    ``distance``, ``cosine``: as of `find_density`.
    """
    _, _, half_x, half_y, _, angle = _look(rectangle, point)
    return find_density(half_x, half_y, distance, cosine, angle)


def _look(rectangle, point):
    """Directions of the rectangle's sides, half their lengths, the receiver in these axes, and the solid angle."""
    centre, x, y = rectangle
    half_x, half_y = dr.norm(x), dr.norm(y)
    x, y = x / half_x, y / half_y
    q = into_axes(point, centre, x, y)
    return x, y, half_x, half_y, q, find_solid_angle(q, half_x, half_y)


def _edges(q, half_x, half_y):
    """Ends of the rectangle as the receiver sees them, along x and y, and the distance of its plane. [m]"""
    height = dr.maximum(dr.abs(q.z), 1e-6 * dr.maximum(half_x, half_y))
    return -half_x - q.x, half_x - q.x, -half_y - q.y, half_y - q.y, height
