"""Disks that face the directions of light from infinity, and its rays on them: led to what is asked about, and to panes."""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

PORTAL_SHARE = 0.5
"""Share of the world's rays that are aimed at panes, where there are any."""

DISKS = 4
"""Disks that rays from infinity are spread over, from what is asked about to the whole scene."""


@dataclass(frozen=True)
class Focus:
    """Sphere around what is asked about: centre (3,) in the scene's frame and radius. [m]"""

    centre: np.ndarray
    radius: float


@dataclass
class Disk:
    """Of a focus, as data: ``middle`` Vector3f, ``radius`` Float. [m]"""

    middle: object
    radius: object


class FarDisks:
    """Disks from what is asked about to the whole scene, each larger than the one before.

    Parameters
    ----------
    focus : Focus or None    What is asked about; None: everything.
    radius : float    Of the whole scene about the origin of its frame. [m]
    """

    def __init__(self, focus: Focus | None, radius: float):
        whole = Focus(np.zeros(3), radius)
        if focus is None or np.linalg.norm(focus.centre) + focus.radius > 2.0 * radius:
            focus = whole
        self._disks = _make_disks(focus, whole)

    @property
    def nearest(self) -> "Disk":
        """That of what is asked about."""
        return self._disks[0]

    @property
    def widest(self) -> "Disk":
        """That of the whole scene."""
        return self._disks[-1]

    def draw(self, direction, lanes):
        """Point that a ray from infinity passes, on one of the disks that face its direction."""
        frame = mi.Frame3f(direction)
        disk = mi.warp.square_to_uniform_disk_concentric(lanes.pair())
        choice, point = lanes.stream.next_float32() * len(self._disks), mi.Vector3f(0.0)
        for number, each in enumerate(self._disks):
            own = each.middle + (frame.s * disk.x + frame.t * disk.y) * each.radius
            point = dr.select(choice >= float(number), own, point)
        return point

    def density(self, point, direction):
        """Density of such rays over the area that faces them. [1/m2]"""
        density = mi.Float(0.0)
        for each in self._disks:
            away = point - each.middle
            off = dr.squared_norm(away - direction * dr.dot(away, direction))
            own = dr.inv_pi / dr.square(each.radius)
            density += dr.select(off <= dr.square(each.radius) * (1.0 + 1e-6), own, 0.0)
        return density * (1.0 / len(self._disks))


def _make_disks(focus: Focus, whole: Focus) -> list[Disk]:
    """Disks from the focus to the whole scene, each as many times as wide as the one before."""
    ratio = max((whole.radius / focus.radius) ** (1.0 / (DISKS - 1)), 1.0)
    made = []
    for number in range(DISKS):
        is_whole = number == DISKS - 1 or ratio == 1.0
        own = whole if is_whole else Focus(focus.centre, focus.radius * ratio**number)
        disk = Disk(mi.Vector3f(*map(float, own.centre)), mi.Float(float(own.radius)))
        dr.make_opaque(disk.middle, disk.radius)
        made.append(disk)
    return made


def aim_at_portals(portals, middle, direction, lanes):
    """Lead a share of the world's rays through panes.

    Returns
    -------
    (Vector3f, Float)    A point of the ray, and the density of rays so aimed over the area that faces the direction. [1/m2]
    """
    areas = [4.0 * np.linalg.norm(p.half_u) * np.linalg.norm(p.half_v) for p in portals.portals]
    shares = np.array(areas) / np.sum(areas)
    choice, sample = lanes.stream.next_float32(), lanes.pair()
    aims = lanes.stream.next_float32() < PORTAL_SHARE
    start = 0.0
    rectangles = []
    for portal, share, area in zip(portals.portals, shares, areas, strict=True):
        centre, u, v = (mi.Vector3f(*map(float, x)) for x in (portal.centre, portal.half_u, portal.half_v))  # fmt: skip
        chance, size = mi.Float(float(share)), mi.Float(float(area))
        dr.make_opaque(centre, u, v, chance, size)
        point = centre + u * (2.0 * sample.x - 1.0) + v * (2.0 * sample.y - 1.0)
        middle = dr.select(aims & (choice >= start), point, middle)
        start = start + chance
        rectangles.append((centre, u, v, chance, size))
    density = mi.Float(0.0)
    for centre, u, v, chance, size in rectangles:
        normal = dr.normalize(dr.cross(u, v))
        cosine = dr.dot(direction, normal)
        way = dr.dot(centre - middle, normal) / dr.select(cosine == 0.0, 1e-12, cosine)
        at = middle + direction * way - centre
        inside = dr.abs(dr.dot(at, u)) <= dr.squared_norm(u) * (1.0 + 1e-5)
        inside &= dr.abs(dr.dot(at, v)) <= dr.squared_norm(v) * (1.0 + 1e-5)
        own = PORTAL_SHARE * chance / (size * dr.maximum(dr.abs(cosine), 1e-6))
        density += dr.select(inside, own, 0.0)
    return middle, density
