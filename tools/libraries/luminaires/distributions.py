"""Formulas of the library's distributions, and the flux that a grid of intensities stands for.

A formula takes directions (..., 3) of unit length in the luminaire's own axes (it shines along -z, +y is up when it is
aimed at a wall, linear luminaires say where they are long) and returns intensity in proportion, never negative.

What throws light to one side throws it towards +y, which is C90 in both file formats.
"""

import numpy as np

# ---- grids ----


def directions(kind: str, horizontal, vertical) -> np.ndarray:
    """Directions of a file's angles [degree]. (n horizontal, n vertical, 3)

    Type C: C and gamma. Type A: the azimuth to the right of the beam, and the height above it. Type B: the angle to the
    right out of the vertical plane, and the turn upwards of that plane (IES LM-75).
    """
    h, v = np.meshgrid(np.radians(horizontal), np.radians(vertical), indexing="ij")
    if kind == "C":
        return np.stack([np.sin(v) * np.cos(h), np.sin(v) * np.sin(h), -np.cos(v)], axis=-1)
    if kind == "A":
        return np.stack([np.cos(v) * np.sin(h), np.sin(v), -np.cos(v) * np.cos(h)], axis=-1)
    return np.stack([np.sin(h), np.cos(h) * np.sin(v), -np.cos(h) * np.cos(v)], axis=-1)


def grid_flux(kind: str, horizontal, vertical, intensity) -> float:
    """Flux of the bilinear interpolant, all around. [lm]

    Parameters
    ----------
    horizontal, vertical : (n,), (m,) array    Angles of the whole file. [degree]
    intensity : (n, m) array    [cd]
    """
    h, v = np.radians(horizontal), np.radians(vertical)
    # The angle that is counted from the grid's pole, and the one around it.
    if kind == "C":
        polar, around, table = v, h, intensity
    elif kind == "A":
        polar, around, table = v + np.pi / 2.0, h, intensity
    else:
        polar, around, table = h + np.pi / 2.0, v, intensity.T
    if len(around) == 1:
        rows = 2.0 * np.pi * table[0]
    else:
        rows = 0.5 * np.diff(around) @ (table[1:] + table[:-1])
    # The integral of a straight line times the sine: -f cos + slope sin between the nodes.
    a, b, slope = polar[:-1], polar[1:], np.diff(rows) / np.diff(polar)
    pieces = rows[:-1] * np.cos(a) - rows[1:] * np.cos(b) + slope * (np.sin(b) - np.sin(a))
    return float(pieces.sum())


# ---- what the formulas are made of ----


def gamma(d) -> np.ndarray:
    """Angle to the downward vertical. [degree]"""
    return np.degrees(np.arctan2(np.hypot(d[..., 0], d[..., 1]), -d[..., 2]))


def tilt(d, axis: int) -> np.ndarray:
    """Angle to the downward vertical of the direction's picture in the vertical plane of +x (0) or +y (1). [degree]"""
    return np.degrees(np.arctan2(d[..., axis], -d[..., 2]))


def edge(angle, begin: float, end: float) -> np.ndarray:
    """Share that falls smoothly from 1 at ``begin`` to 0 at ``end``. [degree]"""
    t = np.clip((angle - begin) / (end - begin), 0.0, 1.0)
    return 1.0 - t * t * (3.0 - 2.0 * t)


def bell(angle, half: float) -> np.ndarray:
    """Gauss's curve that is 1 at 0 and 1/2 at ``half``. [degree]"""
    return np.exp2(-((angle / half) ** 2))


def lobe(d, c: float, g: float, half_g: float, half_c: float) -> np.ndarray:
    """Beam about a direction of type C, with half widths within its vertical plane and across it. [degree]"""
    c, g = np.radians(c), np.radians(g)
    axis = np.array([np.sin(g) * np.cos(c), np.sin(g) * np.sin(c), -np.cos(g)])
    up = np.array([np.cos(g) * np.cos(c), np.cos(g) * np.sin(c), np.sin(g)])
    side = np.array([-np.sin(c), np.cos(c), 0.0])
    along = d @ axis
    high = np.degrees(np.arctan2(d @ up, along))
    wide = np.degrees(np.arctan2(d @ side, np.hypot(along, d @ up)))
    return bell(high, half_g) * bell(wide, half_c)


def even_plane(angle, end: float) -> np.ndarray:
    """Intensity that lights a plane evenly out to an angle from its normal: I ~ 1 / cos^3. [degree]"""
    return 1.0 / np.cos(np.radians(np.minimum(np.abs(angle), end))) ** 3


def half_power(width: float) -> float:
    """Exponent n of the beam cos^n whose intensity is half at ``width`` / 2 from its axis. [degree]"""
    return np.log(0.5) / np.log(np.cos(np.radians(0.5 * width)))


# ---- distributions ----


def beam(width: float, begin: float = 90.0, end: float = 90.1):
    """cos^n beam of a width at half its peak; the reflector cuts it off between two angles. [degree]"""
    n = half_power(width)

    def formula(d):
        return np.clip(-d[..., 2], 0.0, 1.0) ** n * edge(gamma(d), begin, end)

    return formula


def beams(below: float, above: float):
    """Two cos^n beams of equal flux, down and up. [degree]"""
    n, m = half_power(below), half_power(above)

    def formula(d):
        z = d[..., 2]
        return np.where(z < 0.0, (n + 1.0) * np.abs(z) ** n, (m + 1.0) * np.abs(z) ** m)

    return formula


def lambertian(d):
    """Flat surface of the same luminance from everywhere: I ~ cos."""
    return np.clip(-d[..., 2], 0.0, None)


def wall_washer(d):
    """Light on a wall at +y, parallel to x, that is even from 26 to 60 degrees above the downward vertical.

    With the wall at a distance a and an angle u above the vertical E = I sin u / (a / sin u)^2, so I ~ 1 / sin^3 u. What
    goes sideways falls to half at 35 degrees.
    """
    up = tilt(d, 1)
    even = 1.0 / np.sin(np.radians(np.clip(up, 18.0, 90.0))) ** 3
    window = edge(-up, -26.0, -18.0) * edge(up, 60.0, 78.0)
    wide = bell(np.degrees(np.arcsin(np.clip(d[..., 0], -1.0, 1.0))), 35.0)
    spill = 0.15 * np.clip(-d[..., 2], 0.0, None) ** 2
    return even * window * wide + spill


def batwing(d):
    """Along y, even on the work plane across it out to 36 degrees, dark above 72 degrees against glare."""
    across = tilt(d, 0)
    shape = even_plane(across, 36.0) * edge(np.abs(across), 36.0, 60.0)
    along = np.cos(np.radians(np.minimum(np.abs(tilt(d, 1)), 90.0))) ** 1.2
    return shape * along * edge(gamma(d), 58.0, 72.0) * (d[..., 2] < 0.0)


def prismatic(d):
    """Micro-prisms: Lambertian in the middle, little from 65 degrees on, slightly square."""
    g = gamma(d)
    around = np.arctan2(d[..., 1], d[..., 0])
    square = 1.0 + 0.06 * np.cos(4.0 * around) * np.sin(np.radians(g)) ** 2
    return np.clip(-d[..., 2], 0.0, None) * square / (1.0 + (g / 60.0) ** 9)


def uplight_line(axis: int):
    """Upwards, even on a ceiling out to 60 degrees across a line; ``axis`` across: 0 is x, 1 is y."""

    def formula(d):
        mirrored = d * np.array([1.0, 1.0, -1.0])
        across, along = np.abs(tilt(mirrored, axis)), np.abs(tilt(mirrored, 1 - axis))
        shape = even_plane(across, 60.0) * edge(across, 60.0, 86.0)
        return shape * np.cos(np.radians(np.minimum(along, 90.0))) * (d[..., 2] > 0.0)

    return formula


def direct_indirect(share: float):
    """Pendant along y with ``share`` of its flux below the horizontal."""
    up = uplight_line(0)

    def formula(d):
        # Both parts scaled to the same flux by a fine sum over the sphere.
        horizontal, vertical = np.arange(0.0, 361.0, 2.0), np.arange(0.0, 181.0, 1.0)
        grid = directions("C", horizontal, vertical)
        down_flux, up_flux = (
            grid_flux("C", horizontal, vertical, part(grid)) for part in (batwing, up)
        )
        return share * batwing(d) / down_flux + (1.0 - share) * up(d) / up_flux

    return formula


def torchiere(d):
    """Bowl that shines at the ceiling: cos^1.5 upwards, screened near the horizontal."""
    mirrored = d * np.array([1.0, 1.0, -1.0])
    return np.clip(d[..., 2], 0.0, None) ** 1.5 * edge(gamma(mirrored), 60.0, 84.0)


def street(c: float, g: float, half_c: float, half_g: float, forward: float):
    """Two beams along the road, turned towards it by ``c`` and ``g`` above the vertical, over a base; none from 86 degrees.

    ``forward``: how much more of the base goes to the road (+y) than to the house.
    """

    def formula(d):
        two = lobe(d, c, g, half_g, half_c) + lobe(d, 180.0 - c, g, half_g, half_c)
        base = 0.30 * np.clip(-d[..., 2], 0.0, None) ** 0.6 * (1.0 + forward * d[..., 1])
        return (two + base) * edge(gamma(d), 74.0, 86.0)

    return formula


def ring(g: float, half: float, middle: float, begin: float, end: float):
    """All around: strongest at ``g``, with ``middle`` of it straight down, dark from ``end`` on. [degree]"""

    def formula(d):
        angle = gamma(d)
        return (middle + (1.0 - middle) * bell(angle - g, half)) * edge(angle, begin, end)

    return formula


def even_floor(end: float, dark: float):
    """All around, even on the floor out to ``end``, dark from ``dark`` on. [degree]"""

    def formula(d):
        angle = gamma(d)
        return even_plane(angle, end) * edge(angle, end, dark)

    return formula


def elliptic_beam(half_h: float, half_v: float, spill: float):
    """Gauss's curve in the angles of type B, H and V, over a share of spilled light. [degree]"""

    def formula(d):
        h = np.degrees(np.arcsin(np.clip(d[..., 0], -1.0, 1.0)))
        v = np.degrees(np.arctan2(d[..., 1], -d[..., 2]))
        lens = bell(h, half_h) * bell(v, half_v) * edge(np.abs(h), 60.0, 85.0)
        return lens + spill * np.clip(-d[..., 2], 0.0, None)

    return formula


def asymmetric_flood(d):
    """Strongest 55 degrees towards +y with the glass level, falling softly to the mast and steeply to the horizon."""
    up = tilt(d, 1)
    high = np.where(up < 55.0, bell(up - 55.0, 24.0), bell(up - 55.0, 9.0))
    wide = bell(np.degrees(np.arcsin(np.clip(d[..., 0], -1.0, 1.0))), 32.0)
    spill = 0.03 * np.clip(-d[..., 2], 0.0, None)
    return (high * wide + spill) * edge(gamma(d), 70.0, 85.0) * (d[..., 2] < 0.0)


def flame(radius: float, height: float):
    """Luminous ellipsoid, in proportion to the area that it shows, over the candle that hides it from below.

    The area of an ellipsoid of half axes a, a, c from an angle g to its axis is pi a sqrt(c^2 sin^2 g + a^2 cos^2 g).
    """

    def formula(d):
        c, a = 0.5 * height, radius
        area = np.sqrt(c**2 * (1.0 - d[..., 2] ** 2) + a**2 * d[..., 2] ** 2)
        return area * (1.0 - edge(gamma(d), 15.0, 40.0))

    return formula


def globe(d):
    """Sphere of opal glass: the same to all sides but for the neck that it hangs on."""
    return 0.2 + 0.8 * edge(gamma(d), 158.0, 174.0)


def drum(diameter: float, height: float):
    """Opal drum on a ceiling: in proportion to the area that its bottom and its side show; nothing above the horizontal."""

    def formula(d):
        bottom = 0.25 * np.pi * diameter**2 * np.clip(-d[..., 2], 0.0, None)
        side = diameter * height * np.hypot(d[..., 0], d[..., 1])
        return (bottom + side) * edge(gamma(d), 90.0, 95.0)

    return formula


def tube(axis: int):
    """Luminous cylinder without ends along x (0), y or z (2): I ~ sine of the angle to its axis."""

    def formula(d):
        return np.sqrt(np.clip(1.0 - d[..., axis] ** 2, 0.0, None))

    return formula


def coil(length: float, diameter: float):
    """Upright coil of a filament: in proportion to the area that it shows."""

    def formula(d):
        side = length * diameter * np.hypot(d[..., 0], d[..., 1])
        return side + 0.25 * np.pi * diameter**2 * np.abs(d[..., 2])

    return formula


def batten(d):
    """Tube along x below a narrow channel, which takes most of the light that goes up."""
    across = np.abs(np.degrees(np.arctan2(d[..., 1], -d[..., 2])))
    return tube(0)(d) * (0.12 + 0.88 * edge(across, 105.0, 150.0))


def capped(formula, begin: float, end: float):
    """Light another formula gives, less what a cap below (gamma 0) hides: all of it to ``begin``, nothing from ``end``."""

    def covered(d):
        return formula(d) * (1.0 - edge(gamma(d), begin, end))

    return covered


def low_beam(d):
    """Passing beam for traffic on the right: flat cut-off 0.57 degrees below the horizon, rising by 15 degrees to the right.

    The sum of a hot spot, a middle and a wide foreground beam; what passes the cut-off is 0.6 %.
    """
    h = np.degrees(np.arctan2(d[..., 0], -d[..., 2]))
    v = np.degrees(np.arcsin(np.clip(d[..., 1], -1.0, 1.0)))
    light = 20000.0 * bell(h - 1.8, 3.6) * bell(v + 1.1, 1.1)
    light += 9000.0 * bell(h, 11.0) * bell(v + 2.2, 2.4)
    light += 2600.0 * bell(h, 26.0) * bell(v + 5.0, 5.0)
    limit = -0.57 + np.clip(h, 0.0, 12.0) * np.tan(np.radians(15.0))
    passed = 1.0 / (1.0 + np.exp(np.clip((v - limit + 0.12) / 0.07, -60.0, 60.0)))
    front = np.clip(-d[..., 2], 0.0, None)
    return light * (0.006 + 0.994 * passed) + 30.0 * front * (v < 10.0)


def escape_route(d):
    """Band along x: even on the floor out to 64 degrees, 14 degrees to each side."""
    along = np.abs(tilt(d, 0))
    shape = even_plane(along, 64.0) * edge(along, 64.0, 76.0)
    side = np.degrees(np.arcsin(np.clip(d[..., 1], -1.0, 1.0)))
    return shape * bell(side, 14.0) * (d[..., 2] < 0.0)


def step(d):
    """Out of a wall that lies at -y, down on the tread in front of it."""
    up = tilt(d, 1)
    high = edge(-up, -8.0, 0.0) * bell(up - 48.0, 22.0) * edge(up, 70.0, 85.0)
    wide = bell(np.degrees(np.arcsin(np.clip(d[..., 0], -1.0, 1.0))), 38.0)
    return high * wide * (d[..., 2] < 0.0)


def task(d):
    """Head of a desk lamp, whose lenses throw the light away from the foot."""
    return lobe(d, 90.0, 24.0, 30.0, 38.0) * edge(gamma(d), 62.0, 78.0)


FORMULAS = {
    formula.__name__: formula
    for formula in (
        asymmetric_flood, batten, batwing, escape_route, globe, lambertian, low_beam, prismatic, step, task, torchiere,
        wall_washer,
    )
}  # fmt: skip
"""Formulas by name."""

FAMILIES = {
    family.__name__: family
    for family in (
        beam, beams, capped, coil, direct_indirect, drum, elliptic_beam, even_floor, flame, ring, street, tube,
        uplight_line,
    )
}  # fmt: skip
"""What makes a formula of numbers, and of other formulas, by name."""
