"""Luminous openings on the device: which point of one is seen along a direction, and points drawn on the side that is seen.

In its own axes an opening is the image of a unit body (square, disk, cube, sphere, cylinder along z) under the half sizes
(a, b, c). What a receiver at q sees is a function of q and the direction alone, so every density can be computed anew from
these two. With an area element of the drawn parameters that is ``seen`` by the receiver, the density over solid angle is
density * distance^2 / seen.
"""

import drjit as dr
import mitsuba as mi

from .rectangles import draw_place, find_density, find_solid_angle

POINT, RECTANGLE, ELLIPSE, BOX, ELLIPSOID, CYLINDER = range(6)
"""Kinds of openings, in the order of `scene.distribution.SHAPES`."""

TINY = 1e-20


def projected_area(kind, half, direction, kinds):
    """Area that an opening shows towards a direction of unit length. [m2]

    Parameters
    ----------
    kind : UInt32
    half : Vector3f    Half sizes. [m]
    direction : Vector3f    In the opening's axes.
    kinds : set of int    Those that occur.
    """
    d = direction
    area = mi.Float(1.0)
    if RECTANGLE in kinds:
        area = dr.select(kind == RECTANGLE, 4.0 * half.x * half.y * dr.abs(d.z), area)
    if ELLIPSE in kinds:
        area = dr.select(kind == ELLIPSE, dr.pi * half.x * half.y * dr.abs(d.z), area)
    if BOX in kinds:
        faces = mi.Vector3f(half.y * half.z, half.x * half.z, half.x * half.y)
        area = dr.select(kind == BOX, 4.0 * dr.dot(faces, dr.abs(d)), area)
    if ELLIPSOID in kinds:
        disks = mi.Vector3f(half.y * half.z, half.x * half.z, half.x * half.y)
        area = dr.select(kind == ELLIPSOID, dr.pi * dr.norm(disks * d), area)
    if CYLINDER in kinds:
        wide = dr.sqrt(dr.square(half.x * d.y) + dr.square(half.y * d.x))
        cap = dr.pi * half.x * half.y * dr.abs(d.z)
        area = dr.select(kind == CYLINDER, cap + 4.0 * half.z * wide, area)
    return dr.maximum(area, TINY)


class _Drawn:
    """Collects point, density of its parameters and their area element, by kind."""

    def __init__(self):
        self.point = mi.Point3f(0.0)
        self.density = mi.Float(0.0)
        self.normal = mi.Vector3f(0.0)

    def put(self, mask, point, density, normal):
        self.point = dr.select(mask, point, self.point)
        self.density = dr.select(mask, density, self.density)
        self.normal = dr.select(mask, normal, self.normal)


def draw_point(kind, half, q, sample, kinds):
    """Draw a point of the side of an opening that a receiver sees.

    Parameters
    ----------
    q : Point3f    The receiver, in the opening's axes. [m]
    sample : Point2f

    Returns
    -------
    Point3f, Float, Vector3f    The point, the density of its parameters, and their area element as a vector along the
        outward normal; the density is 0 where nothing is seen.
    """
    made = _Drawn()
    if RECTANGLE in kinds or ELLIPSE in kinds:
        up = mi.Vector3f(0.0, 0.0, dr.sign(q.z))
    if RECTANGLE in kinds:
        angle = find_solid_angle(q, half.x, half.y)
        place = draw_place(q, half.x, half.y, sample, angle)
        point = mi.Point3f(half.x * place.x, half.y * place.y, 0.0)
        away = point - q
        distance = dr.norm(away)
        cosine = away.z / dr.maximum(distance, TINY)
        by_angle = find_density(half.x, half.y, distance, cosine, angle)
        by_area = find_density(half.x, half.y, distance, cosine, 0.0)
        density = by_angle / dr.maximum(by_area, TINY)
        made.put(kind == RECTANGLE, point, density, up * (4.0 * half.x * half.y))
    if ELLIPSE in kinds:
        disk = mi.warp.square_to_uniform_disk_concentric(sample)
        point = mi.Point3f(half.x * disk.x, half.y * disk.y, 0.0)
        made.put(kind == ELLIPSE, point, mi.Float(1.0), up * (dr.pi * half.x * half.y))
    if BOX in kinds:
        made.put(kind == BOX, *_draw_on_box(half, q, sample))
    if ELLIPSOID in kinds:
        made.put(kind == ELLIPSOID, *_draw_on_ellipsoid(half, q, sample))
    if CYLINDER in kinds:
        made.put(kind == CYLINDER, *_draw_on_cylinder(half, q, sample))
    return made.point, made.density, made.normal


def meet(kind, half, q, direction, kinds):
    """Find the point of an opening that a receiver sees along a direction.

    Parameters
    ----------
    direction : Vector3f    Of unit length, from the receiver, in the opening's axes.

    Returns
    -------
    Float, Float    Distance [m], and the density over solid angle [1/sr] with which `draw_point` finds it; the density is 0
        where the ray passes by.
    """
    density, distance = mi.Float(0.0), mi.Float(0.0)
    if RECTANGLE in kinds or ELLIPSE in kinds:
        t = -q.z / dr.select(dr.abs(direction.z) > TINY, direction.z, TINY)
        x, y = (q.x + t * direction.x) / half.x, (q.y + t * direction.y) / half.y
        if RECTANGLE in kinds:
            inside = (t > 0.0) & (dr.abs(x) <= 1.0) & (dr.abs(y) <= 1.0)
            angle = find_solid_angle(q, half.x, half.y)
            found = find_density(half.x, half.y, t, direction.z, angle)
            density = dr.select((kind == RECTANGLE) & inside, found, density)
            distance = dr.select(kind == RECTANGLE, t, distance)
        if ELLIPSE in kinds:
            inside = (t > 0.0) & (dr.square(x) + dr.square(y) <= 1.0)
            over = find_density(half.x, half.y, t, direction.z, 0.0)
            density = dr.select((kind == ELLIPSE) & inside, over * (4.0 / dr.pi), density)
            distance = dr.select(kind == ELLIPSE, t, distance)
    for other, find in ((BOX, _meet_box), (ELLIPSOID, _meet_ellipsoid), (CYLINDER, _meet_cylinder)):
        if other in kinds:
            t, found = find(half, q, direction)
            density = dr.select(kind == other, found, density)
            distance = dr.select(kind == other, t, distance)
    return distance, density


# ---- box ----


def _box_shares(half, q):
    """Probabilities of the three faces that may be seen, by their rough solid angles."""
    height = dr.maximum(dr.abs(q) - half, 0.0)
    faces = mi.Vector3f(half.y * half.z, half.x * half.z, half.x * half.y)
    squared = dr.squared_norm(dr.maximum(dr.abs(q) - half, 0.0)) + dr.squared_norm(half) * 0.05
    weights = faces * height / squared
    # A face that is seen at all must be found.
    weights = dr.select(height > 0.0, weights + 0.02 * dr.sum(weights), 0.0)
    return weights / dr.maximum(dr.sum(weights), TINY)


def _draw_on_box(half, q, sample):
    share = _box_shares(half, q)
    seen = dr.sum(share) > 0.0
    second = sample.x >= share.x
    third = sample.x >= share.x + share.y
    # Rounding must not choose a face that is not seen.
    third = (third & (share.z > 0.0)) | (second & (share.y <= 0.0) & (share.z > 0.0))
    second = second & ~third & (share.y > 0.0)
    first = ~second & ~third
    start = dr.select(third, share.x + share.y, dr.select(second, share.x, 0.0))
    chosen = dr.select(third, share.z, dr.select(second, share.y, share.x))
    u = dr.clip((sample.x - start) / dr.maximum(chosen, TINY), 0.0, 1.0) * 2.0 - 1.0
    v = sample.y * 2.0 - 1.0
    side = dr.sign(q)
    unit = dr.select(
        third,
        mi.Vector3f(u, v, side.z),
        dr.select(second, mi.Vector3f(u, side.y, v), mi.Vector3f(side.x, u, v)),
    )
    normal = dr.select(
        third,
        mi.Vector3f(0.0, 0.0, 4.0 * half.x * half.y * side.z),
        dr.select(
            second,
            mi.Vector3f(0.0, 4.0 * half.x * half.z * side.y, 0.0),
            mi.Vector3f(4.0 * half.y * half.z * side.x, 0.0, 0.0),
        ),
    )
    density = dr.select(seen & (chosen > 0.0) & (first | second | third), chosen, 0.0)
    return mi.Point3f(unit * half), density, normal


def _meet_box(half, q, d):
    """By the face where the ray enters."""
    safe = dr.select(dr.abs(d) > TINY, d, TINY)
    enter = (-dr.sign(safe) * half - q) / safe
    leave = (dr.sign(safe) * half - q) / safe
    t = dr.max(enter)
    hit = (t > 0.0) & (t <= dr.min(leave))
    share = _box_shares(half, q)
    areas = 4.0 * mi.Vector3f(half.y * half.z, half.x * half.z, half.x * half.y) * dr.abs(d)
    is_x = enter.x >= dr.maximum(enter.y, enter.z)
    is_y = ~is_x & (enter.y >= enter.z)
    chosen = dr.select(is_x, share.x, dr.select(is_y, share.y, share.z))
    area = dr.select(is_x, areas.x, dr.select(is_y, areas.y, areas.z))
    return t, dr.select(hit, chosen * dr.square(t) / dr.maximum(area, TINY), 0.0)


# ---- ellipsoid: directions that are even over the cone around it in the space where it is the unit sphere ----


def _draw_on_ellipsoid(half, q, sample):
    start = mi.Vector3f(q) / half
    distance = dr.norm(start)
    lift = sample.x * _cone(distance)
    cosine = 1.0 - lift
    sine = dr.safe_sqrt(lift * (1.0 + cosine))
    sin_phi, cos_phi = dr.sincos(dr.two_pi * sample.y)
    frame = mi.Frame3f(-start / dr.maximum(distance, TINY))
    ray = frame.to_world(mi.Vector3f(sine * cos_phi, sine * sin_phi, cosine))
    along = distance * cosine
    back = dr.safe_sqrt(1.0 - dr.square(distance * sine))
    point = mi.Point3f((start + ray * (along - back)) * half)
    away = q - point
    density = _density_of_cone(half, -dr.normalize(away), distance)
    # As if it were an area element: the density is one of directions already.
    return point, dr.select(distance > 1.0, density, 0.0), mi.Vector3f(away * dr.norm(away))


def _cone(distance):
    """One minus the cosine of half the angle under which the unit sphere is seen from so many radii."""
    squared = dr.rcp(dr.square(dr.maximum(distance, 1.0)))
    return squared / (1.0 + dr.safe_sqrt(1.0 - squared))


def _density_of_cone(half, direction, distance):
    """Density of directions [1/sr]; directions of the two spaces differ by the solid angle that the scaling makes of one."""
    scaled = dr.norm(direction / half)
    stretch = dr.rcp(half.x * half.y * half.z * scaled * dr.square(scaled))
    return dr.inv_two_pi * stretch / dr.maximum(_cone(distance), TINY)


def _meet_ellipsoid(half, q, d):
    start, ray = mi.Vector3f(q) / half, d / half
    squared = dr.squared_norm(ray)
    # From the point of the ray that is nearest to the centre: far away, the quadratic formula would lose its digits.
    middle = -dr.dot(start, ray) / squared
    nearest = start + ray * middle
    depth = 1.0 - dr.squared_norm(nearest)
    t = middle - dr.safe_sqrt(depth / squared)
    distance = dr.norm(start)
    hit = (depth > 0.0) & (t > 0.0) & (distance > 1.0)
    return t, dr.select(hit, _density_of_cone(half, d, distance), 0.0)


# ---- cylinder: the arc of the wall that is seen, by the width that it shows, or the cap that is seen ----


def _cylinder_parts(half, q):
    """Probability of the wall, distance from the axis where the wall is the unit circle, and whether a cap is seen."""
    far = dr.sqrt(dr.square(q.x / half.x) + dr.square(q.y / half.y))
    above = dr.maximum(dr.abs(q.z) - half.z, 0.0)
    # Rough projected areas towards the receiver.
    aside = dr.sqrt(dr.square(q.x) + dr.square(q.y))
    wall = dr.select(far > 1.0, 4.0 * half.z * dr.maximum(half.x, half.y) * aside, 0.0)
    cap = dr.pi * half.x * half.y * above
    share = wall / dr.maximum(wall + cap, TINY)
    both = (wall > 0.0) & (cap > 0.0)
    return dr.select(both, dr.clip(share, 0.02, 0.98), share), far, above > 0.0


def _shown(distance):
    """Squared sine of the arc that is seen of a unit circle from so many radii, 0 inside."""
    return 1.0 - 1.0 / dr.square(dr.maximum(distance, 1.0))


def _draw_on_cylinder(half, q, sample):
    share, far, has_cap = _cylinder_parts(half, q)
    arc = dr.sqrt(_shown(far))
    on_wall = sample.x < share
    u = dr.select(
        on_wall,
        sample.x / dr.maximum(share, TINY),
        (sample.x - share) / dr.maximum(1.0 - share, TINY),
    )
    u = dr.clip(u, 0.0, 0.9999999)
    across = arc * (2.0 * u - 1.0)
    towards = dr.safe_sqrt(1.0 - dr.square(across))
    to_x, to_y = q.x / half.x / dr.maximum(far, TINY), q.y / half.y / dr.maximum(far, TINY)
    cosine, sine = towards * to_x - across * to_y, towards * to_y + across * to_x
    wall = mi.Point3f(half.x * cosine, half.y * sine, half.z * (2.0 * sample.y - 1.0))
    wall_normal = mi.Vector3f(half.y * cosine, half.x * sine, 0.0) * (2.0 * half.z)
    disk = mi.warp.square_to_uniform_disk_concentric(mi.Point2f(u, sample.y))
    side = dr.sign(q.z)
    cap = mi.Point3f(half.x * disk.x, half.y * disk.y, half.z * side)
    cap_normal = mi.Vector3f(0.0, 0.0, dr.pi * half.x * half.y * side)
    density = dr.select(
        on_wall,
        dr.select(arc > 0.0, 0.5 * share * towards / dr.maximum(arc, TINY), 0.0),
        dr.select(has_cap, 1.0 - share, 0.0),
    )
    return dr.select(on_wall, wall, cap), density, dr.select(on_wall, wall_normal, cap_normal)


def _meet_cylinder(half, q, d):
    share, far, has_cap = _cylinder_parts(half, q)
    arc = dr.sqrt(_shown(far))
    x, y, dx, dy = q.x / half.x, q.y / half.y, d.x / half.x, d.y / half.y
    squared = dr.maximum(dr.square(dx) + dr.square(dy), TINY)
    middle = -(x * dx + y * dy) / squared
    near_x, near_y = x + middle * dx, y + middle * dy
    depth = 1.0 - dr.square(near_x) - dr.square(near_y)
    back = dr.safe_sqrt(depth / squared)
    t = middle - back
    on_wall = (depth > 0.0) & (squared > TINY) & (t > 0.0) & (arc > 0.0)
    on_wall &= dr.abs(q.z + t * d.z) <= half.z
    # Over the angle, and along the axis over its whole length.
    px, py = near_x - back * dx, near_y - back * dy
    seen = dr.abs(px * half.y * d.x + py * half.x * d.y) * (2.0 * half.z)
    towards = dr.maximum((px * x + py * y) / dr.maximum(far, TINY), 0.0)
    wall = 0.5 * share * towards / dr.maximum(arc, TINY) * dr.square(t) / dr.maximum(seen, TINY)
    safe = dr.select(dr.abs(d.z) > TINY, d.z, TINY)
    s = (dr.sign(q.z) * half.z - q.z) / safe
    on_cap = has_cap & (s > 0.0) & (dr.square(x + s * dx) + dr.square(y + s * dy) <= 1.0)
    area = dr.pi * half.x * half.y * dr.abs(d.z)
    cap = (1.0 - share) * dr.square(s) / dr.maximum(area, TINY)
    return dr.select(on_wall, t, s), dr.select(on_wall, wall, dr.select(on_cap, cap, 0.0))


# ---- for light tracing: where the light of a direction leaves ----


def draw_departure(kind, half, direction, sample, kinds):
    """Draw the point where light of a direction leaves, evenly over what the opening shows towards it.

    Parameters
    ----------
    direction : Vector3f    The way light travels, of unit length, in the opening's axes.

    Returns
    -------
    Point3f, Vector3f    The point and the outward normal there.
    """
    d = direction
    point, normal = mi.Point3f(0.0), d
    up = mi.Vector3f(0.0, 0.0, dr.select(d.z < 0.0, -1.0, 1.0))
    if RECTANGLE in kinds:
        place = mi.Point3f(half.x * (2.0 * sample.x - 1.0), half.y * (2.0 * sample.y - 1.0), 0.0)
        point, normal = _choose(kind == RECTANGLE, place, up, point, normal)
    disk = mi.warp.square_to_uniform_disk_concentric(sample)
    if ELLIPSE in kinds:
        place = mi.Point3f(half.x * disk.x, half.y * disk.y, 0.0)
        point, normal = _choose(kind == ELLIPSE, place, up, point, normal)
    if BOX in kinds:
        point, normal = _choose(kind == BOX, *_leave_box(half, d, sample), point, normal)
    if ELLIPSOID in kinds:
        point, normal = _choose(kind == ELLIPSOID, *_leave_ellipsoid(half, d, disk), point, normal)
    if CYLINDER in kinds:
        point, normal = _choose(
            kind == CYLINDER, *_leave_cylinder(half, d, up, sample), point, normal
        )
    return point, normal


def _leave_box(half, d, sample):
    """Point and outward normal where light leaves a box, evenly over what is seen of it."""
    faces = mi.Vector3f(half.y * half.z, half.x * half.z, half.x * half.y) * dr.abs(d)
    # As seen from very far along the direction, each face's share is its projected area.
    share = faces / dr.maximum(dr.sum(faces), TINY)
    third = sample.x >= share.x + share.y
    second = (sample.x >= share.x) & ~third
    start = dr.select(third, share.x + share.y, dr.select(second, share.x, 0.0))
    chosen = dr.select(third, share.z, dr.select(second, share.y, share.x))
    u = dr.clip((sample.x - start) / dr.maximum(chosen, TINY), 0.0, 1.0) * 2.0 - 1.0
    v = sample.y * 2.0 - 1.0
    side = dr.select(d < 0.0, mi.Vector3f(-1.0), mi.Vector3f(1.0))
    unit = dr.select(
        third,
        mi.Vector3f(u, v, side.z),
        dr.select(second, mi.Vector3f(u, side.y, v), mi.Vector3f(side.x, u, v)),
    )
    axis = dr.select(
        third,
        mi.Vector3f(0.0, 0.0, side.z),
        dr.select(second, mi.Vector3f(0.0, side.y, 0.0), mi.Vector3f(side.x, 0.0, 0.0)),
    )
    return mi.Point3f(unit * half), axis


def _leave_ellipsoid(half, d, disk):
    """Point and outward normal where light leaves an ellipsoid. ``disk``: Point2f of the unit disk."""
    # Parallel projections stay parallel under the affine map, so the unit sphere's disk serves.
    axis = dr.normalize(d / half)
    unit = mi.Frame3f(axis).to_world(
        mi.Vector3f(disk.x, disk.y, dr.safe_sqrt(1.0 - dr.squared_norm(disk)))
    )
    return mi.Point3f(unit * half), dr.normalize(unit / half)


def _leave_cylinder(half, d, up, sample):
    """Point and outward normal where light leaves an upright cylinder, by its wall or the cap that faces ``up``."""
    cap = dr.pi * half.x * half.y * dr.abs(d.z)
    wall = 4.0 * half.z * dr.sqrt(dr.square(half.x * d.y) + dr.square(half.y * d.x))
    share = wall / dr.maximum(wall + cap, TINY)
    on_wall = sample.x < share
    u = dr.select(on_wall, sample.x / dr.maximum(share, TINY), (sample.x - share) / (1.0 - share))
    u = dr.clip(u, 0.0, 1.0)
    # Evenly across the silhouette of the unit circle.
    across = 2.0 * u - 1.0
    along = dr.safe_sqrt(1.0 - dr.square(across))
    to_x, to_y = d.x / half.x, d.y / half.y
    scale = dr.rsqrt(dr.maximum(dr.square(to_x) + dr.square(to_y), TINY))
    to_x, to_y = to_x * scale, to_y * scale
    px, py = along * to_x - across * to_y, along * to_y + across * to_x
    wall_point = mi.Point3f(half.x * px, half.y * py, half.z * (2.0 * sample.y - 1.0))
    wall_normal = dr.normalize(mi.Vector3f(px / half.x, py / half.y, 0.0))
    disk = mi.warp.square_to_uniform_disk_concentric(mi.Point2f(u, sample.y))
    cap_point = mi.Point3f(half.x * disk.x, half.y * disk.y, half.z * up.z)
    return dr.select(on_wall, wall_point, cap_point), dr.select(on_wall, wall_normal, up)


def _choose(mask, point, normal, other_point, other_normal):
    return dr.select(mask, point, other_point), dr.select(mask, normal, other_normal)
