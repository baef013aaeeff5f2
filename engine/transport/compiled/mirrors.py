"""Light that reaches a point by way of plane mirrors and panes: next-event through virtual images.

A chain of mirrors is drawn, the point is reflected at each of them in turn, and an emitter is chosen and sampled as that
image sees it; the path is then traced from the point over the mirrors, which must be met in this order. So even ideal points
and suns shine by mirrors, which no scattered ray would find. The chance of a chain follows from its mirrors alone, so hits
of scattered rays that came over mirrors can be weighed against it (see `path_loop`): their reference
point is the same image.

A pane is a mirror to the chains that it is in and lets all others pass straight. A straight line meets a plane once, so what
a pane does to a ray follows from the chain.
"""

from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import table_size, upload
from ..rays import STEP, spawn_ray
from .polarisation import polarise

MAXIMUM_MIRRORS = 64
"""Most planes; beyond, the smallest are found by scattered rays only."""

LONGEST_CHAIN = 24
"""Most reflections of a chain; longer ones are left to scattered rays."""

GOES_ON = 2.0 / 3.0
"""Chance that a chain gets one mirror more. Between parallel mirrors chains of all lengths have the same light but for the
reflectance R of each; where R^2 exceeds this chance, few long ones would bring most of it."""

PANE_WEIGHT = 0.3
"""How often panes are drawn, of mirrors of the same size and distance. [-]"""

EVEN_SHARE = 0.25
"""Share of the choices of a next mirror that is made without regard to size and distance."""

FLATNESS = 1e-5
"""Largest distance from its plane, relative to its size, of what counts as a plane mirror. [-]"""

SLIVER = 0.02
"""Faces of a pane smaller than this share of its largest, such as its edges, are left to scattered rays. [-]"""

ROUNDING = 64.0
"""By which the bounds of mirrors are wider than the mirrors, in steps by which rays start off surfaces."""

COLUMNS = 10
"""Of the table of planes: normal, distance, lowest and highest corner."""


@dataclass(frozen=True)
class Plane:
    """Plane of a mirror in the world.

    ``normal`` (3,): of unit length; ``distance``: from the origin along it [m]; ``area``: of the mirror in it [m2]; ``low``,
    ``high`` (3,): corners of the mirror's bounds [m]; ``is_pane``: whether light may also pass it.
    """

    normal: np.ndarray
    distance: float
    area: float
    low: np.ndarray
    high: np.ndarray
    is_pane: bool = False

    def order(self) -> tuple:
        """Key that puts planes in an order of their own: true mirrors first, then the largest."""
        return (self.is_pane, -self.area, *self.normal, self.distance, *self.low)

    def holds(self, other: "Plane") -> bool:
        """Whether another plane is the same but for what rounding may do."""
        size = max(float((p.high - p.low).max()) for p in (self, other))
        cosine = float(self.normal @ other.normal)
        if np.linalg.norm(other.normal - np.sign(cosine) * self.normal) > FLATNESS:
            return False
        middle = 0.5 * (other.low + other.high)
        return abs(float(self.normal @ middle) - self.distance) <= FLATNESS * size


def find_planes(vertices, triangles, is_pane=False) -> tuple[list[Plane], np.ndarray]:
    """Planes of triangles, none when there are more than `MAXIMUM_MIRRORS` (a curved mirror).

    Parameters
    ----------
    vertices, triangles : (v, 3) array [m], (t, 3) int array
    is_pane : bool    Whether they let light pass; the smallest faces are left out then.

    Returns
    -------
    (list of Plane, (t,) int array)    And which of them each triangle lies in, -1: none.
    """
    member = np.full(len(triangles), -1)
    corners = vertices[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    double = np.linalg.norm(cross, axis=1)
    normals = cross / np.maximum(double, 1e-300)[:, None]
    size = float(np.ptp(vertices, axis=0).max(initial=0.0))
    planes: list[Plane] = []
    left = np.flatnonzero(double > 0.0)
    while len(left):
        if len(planes) == MAXIMUM_MIRRORS:
            return [], np.full(len(triangles), -1)
        normal, point = normals[left[0]], corners[left[0], 0]
        off = np.abs((corners[left] - point) @ normal).max(axis=1)
        same = left[off <= FLATNESS * size]
        member[same] = len(planes)
        # One sign for both sides of a plane.
        sign = 1.0 if tuple(normal) >= tuple(-normal) else -1.0
        places = corners[same].reshape(-1, 3)
        planes.append(
            Plane(
                sign * normal,
                sign * float(normal @ point),
                0.5 * float(double[same].sum()),
                places.min(axis=0),
                places.max(axis=0),
                is_pane,
            )
        )
        left = left[off > FLATNESS * size]
    if is_pane and planes:
        largest = max(plane.area for plane in planes)
        kept = np.array([plane.area >= SLIVER * largest for plane in planes])
        member = np.where((member >= 0) & kept[member], (np.cumsum(kept) - 1)[member], -1)
        planes = [plane for plane, is_kept in zip(planes, kept, strict=True) if is_kept]
    return planes, member


def choose_planes(planes: list[Plane]) -> tuple[list[Plane], dict[int, int]]:
    """Planes that chains are drawn from: true mirrors before panes, the largest first, and the same plane once.

    Returns
    -------
    (list of Plane, dict of int to int)    And for the `id` of every given plane that one of them stands for its place.
    """
    chosen: list[Plane] = []
    known: dict[int, int] = {}
    for plane in sorted(planes, key=Plane.order):
        place = next((i for i, other in enumerate(chosen) if other.holds(plane)), None)
        if place is not None:
            other = chosen[place]
            low, high = np.minimum(other.low, plane.low), np.maximum(other.high, plane.high)
            chosen[place] = replace(other, area=other.area + plane.area, low=low, high=high)
        elif len(chosen) < MAXIMUM_MIRRORS:
            place = len(chosen)
            chosen.append(plane)
        if place is not None:
            known[id(plane)] = place
    return chosen, known


def choice_chances(planes: list[Plane]) -> np.ndarray:
    """Chance of every mirror to come next in a chain, by the last one; in the last row of all to be the first. (m + 1, m)

    Near mirrors that face each other, such as the panes of one window, follow each other most.
    """
    weight = np.array([PANE_WEIGHT if plane.is_pane else 1.0 for plane in planes])
    centres = np.array([0.5 * (plane.low + plane.high) for plane in planes])
    normals, areas = (np.array([getattr(p, name) for p in planes]) for name in ("normal", "area"))
    away = centres[None] - centres[:, None]
    square = (away**2).sum(axis=2) + 1e-6 * areas
    facing = np.abs((away * normals[None]).sum(axis=2)) / np.sqrt(square)
    near = weight * areas * (facing + 0.05) / square
    even = np.tile(weight, (len(planes), 1))
    for each in (near, even):
        np.fill_diagonal(each, 0.0)
    near, even = (
        each / np.maximum(each.sum(axis=1, keepdims=True), 1e-300) for each in (near, even)
    )
    return np.vstack([(1.0 - EVEN_SHARE) * near + EVEN_SHARE * even, weight / weight.sum()])


def make_aliases(chances: np.ndarray) -> np.ndarray:
    """Share of each cell that it keeps, and which number has the rest, to draw by a single look-up. (n, m) -> (n, m, 2)

    References
    ----------
    M. D. Vose: A Linear Algorithm for Generating Random Numbers with a Given Distribution, IEEE TSE 17 (1991).
    """
    count = chances.shape[1]
    made = np.zeros((*chances.shape, 2))
    for row, chance in zip(made, chances, strict=True):
        left = chance * count
        row[:, 0], row[:, 1] = 1.0, np.arange(count)
        small, large = (list(np.flatnonzero(flag)) for flag in (left < 1.0, left >= 1.0))
        while small and large:
            less, more = small.pop(), large[-1]
            row[less] = left[less], more
            left[more] -= 1.0 - left[less]
            if left[more] < 1.0:
                small.append(large.pop())
    return made


class MirrorSet:
    """Plane mirrors on the device.

    Parameters
    ----------
    planes : list of Plane    At least one.
    origin : (3,) array    Of the compiled scene's frame. [m]

    Attributes
    ----------
    planes : list of Plane
    origin : (3,) array    As given.
    are_panes : bool    Whether there is no true mirror. Scattered rays find the sky in panes well enough, so light from
        infinity is sampled from suns alone.
    """

    def __init__(self, planes: list[Plane], origin: np.ndarray):
        self.planes, self.origin = planes, origin
        self.are_panes = all(plane.is_pane for plane in planes)
        rows = np.zeros((table_size(len(planes)), COLUMNS))
        for row, plane in zip(rows, planes, strict=False):
            row[:3], row[3] = plane.normal, plane.distance - float(plane.normal @ origin)
            row[4:7], row[7:] = plane.low - origin, plane.high - origin
        chances = choice_chances(planes)
        choices = np.zeros((table_size(len(chances)), MAXIMUM_MIRRORS, 3))
        choices[: len(chances), : len(planes), 0] = chances
        choices[: len(chances), : len(planes), 1:] = make_aliases(chances)
        self._rows, self._choices = upload(mi.Float, rows), upload(mi.Float, choices)
        self._count = dr.opaque(mi.UInt32, len(planes))
        dr.eval(self._rows, self._choices)

    def plane(self, index, active):
        """Unit normal and distance of a plane in the scene's frame."""
        x, y, z, w = (self._entry(index, k, active) for k in range(4))
        return mi.Vector3f(x, y, z), w

    def may_meet(self, index, ray, slack, active):
        """Whether a ray may meet the mirrors in a plane; most cannot, and need not be traced. ``slack``: of bounds [m]."""
        normal, distance = self.plane(index, active)
        way = (distance - dr.dot(normal, ray.o)) / dr.dot(normal, ray.d)
        # Steep rays lose digits on a long way.
        place, reach = ray.o + ray.d * way, slack + 1e-5 * dr.abs(way)
        low, high = (
            mi.Point3f(*(self._entry(index, first + k, active) for k in range(3)))
            for first in (4, 7)
        )
        is_inside = dr.all((place >= low - reach) & (place <= high + reach))
        return active & is_inside & (way > -slack)

    def shows(self, index, point, image, slack, active):
        """Whether an image is seen from a point within the bounds of the mirrors in a plane. ``slack``: of bounds [m]."""
        ray = mi.Ray3f(mi.Point3f(point), dr.normalize(mi.Vector3f(image - point)))
        normal, distance = self.plane(index, active)
        ends = (distance - dr.dot(normal, point), distance - dr.dot(normal, image))
        return self.may_meet(index, ray, slack, active & (ends[0] * ends[1] < 0.0))

    def _entry(self, index, column, active):
        return dr.gather(mi.Float, self._rows, index * COLUMNS + column, active)

    def _choice(self, row, cell, column, active):
        place = (row * MAXIMUM_MIRRORS + cell) * 3 + column
        return dr.gather(mi.Float, self._choices, place, active)

    def probability(self, length, chance):
        """Chance of one chain: of its length, and of its mirrors as `extend` gives it; 1 without any mirror."""
        share = (1.0 - GOES_ON) * dr.power(GOES_ON, mi.Float(length) - 1.0)
        # All that would be longer is cut to the longest.
        share = dr.select(length == LONGEST_CHAIN, share / (1.0 - GOES_ON), share)
        # With a single mirror all chains have one reflection.
        share = dr.select(self._count == 1, dr.select(length == 1, 1.0, 0.0), share)
        return dr.select(length == 0, 1.0, dr.select(length <= LONGEST_CHAIN, share * chance, 0.0))

    def length(self, u):
        """Number of reflections of a chain, from a number in [0, 1)."""
        drawn = 1.0 + dr.floor(dr.log(dr.maximum(1.0 - u, 1e-9)) / float(np.log(GOES_ON)))
        drawn = dr.minimum(mi.UInt32(drawn), LONGEST_CHAIN)
        return dr.select(self._count == 1, 1, drawn)

    def next(self, u, last, is_first, active=True):
        """Index of a chain's next mirror, another than the last, and its chance."""
        row = dr.select(is_first, self._count, last)
        place = u * mi.Float(self._count)
        cell = dr.minimum(mi.UInt32(place), self._count - 1)
        keeps = place - mi.Float(cell) < self._choice(row, cell, 1, active)
        index = dr.select(keeps, cell, mi.UInt32(self._choice(row, cell, 2, active)))
        return index, self._choice(row, index, 0, active)

    def extend(self, chain, number, is_mirrored, is_turned):
        """Follow a chain that scattered rays run into.

        Parameters
        ----------
        chain : (UInt32, UInt32, Float)    Its length, its last mirror, and the chance of its mirrors.
        number : UInt32    Of the mirror that is met, plus 1, as of `KnownMirrors.at`.
        is_mirrored, is_turned : Bool    Whether light is reflected there; whether it goes on in any other direction.
        """
        length, last, chance = chain
        index = number - 1
        row = dr.select(length == 0, self._count, last)
        step = self._choice(row, index, 0, is_mirrored)
        chance = dr.select(is_mirrored, dr.select(length == 0, step, chance * step), chance)
        length = dr.select(is_mirrored, length + 1, dr.select(is_turned, 0, length))
        return length, dr.select(is_mirrored, index, last), chance

    def image(self, point, stream, length, active):
        """Reflect a point over a chain.

        Returns
        -------
        (Point3f, Matrix3f, Float)
            The image, the linear part of the reflections, and the chance of the mirrors, see `probability`.
        """
        state = (
            mi.Point3f(point),
            mi.Matrix3f(1.0),
            mi.Float(1.0),
            mi.PCG32(stream),
            mi.UInt32(0),
            mi.UInt32(0),
        )

        def body(image, turn, chance, numbers, last, step):
            index, share = self.next(numbers.next_float32(), last, step == 0, active)
            normal, distance = self.plane(index, active)
            image = mi.Point3f(image - 2.0 * (dr.dot(normal, image) - distance) * normal)
            turn = turn - 2.0 * _outer(normal, turn.T @ normal)
            return image, turn, chance * share, numbers, index, step + 1

        image, turn, chance, *_ = dr.while_loop(
            state=state,
            cond=lambda image, turn, chance, numbers, last, step: active & (step < length),
            body=body,
            labels=("image", "turn", "chance", "numbers", "last", "step"),
        )
        return image, turn, chance


def _outer(a, b):
    return mi.Matrix3f(
        a.x * b.x, a.x * b.y, a.x * b.z,
        a.y * b.x, a.y * b.y, a.y * b.z,
        a.z * b.x, a.z * b.y, a.z * b.z,
    )  # fmt: skip


def walk(scene, si, direction, stream, length, closest_hit, active):
    """Follow a chain from a surface.

    Parameters
    ----------
    direction : Vector3f    From the surface, to where the chain begins.
    stream, length : PCG32, UInt32    The numbers that the chain was drawn with.
    closest_hit : callable    As in `visibility`.

    Returns
    -------
    (SurfaceInteraction3f, Vector3f, Vector3f, Spectrum, Bool)
        The last mirror's surface, where it reflects to, the light's polarisation there, the chain's reflectance, and whether
        it was met.
    """
    context = mi.BSDFContext()
    mirrors = scene.mirrors
    ray = spawn_ray(scene, si, direction)
    state = {
        "ray": ray,
        "at": mi.SurfaceInteraction3f(si),
        "value": mi.Spectrum(1.0),
        "polar": mi.Vector3f(0.0),
        "numbers": mi.PCG32(stream),
        "last": mi.UInt32(0),
        "step": mi.UInt32(0),
        "passes": mi.UInt32(0),
        "going": mi.Bool(active),
    }

    slack = ROUNDING * STEP * scene.extent

    def body(ray, at, value, polar, numbers, last, step, passes, going):
        drawn = mi.PCG32(numbers)
        index, _ = mirrors.next(drawn.next_float32(), last, step == 0, going)
        going = mirrors.may_meet(index, ray, slack, going)
        hit = closest_hit(scene, ray, going)
        hit.wavelengths = ray.wavelengths
        going &= hit.is_valid()
        bsdf = scene.bsdf(hit, going)
        is_meant = going & (scene.mirror_at(hit, going) == index + 1)
        # The least number makes panes reflect; the chance of it is taken back.
        bs, weight = bsdf.sample(context, hit, 0.0, mi.Point2f(0.5), is_meant)
        is_meant &= mi.has_flag(bs.sampled_type, mi.BSDFFlags.DeltaReflection)
        through = bsdf.eval_null_transmission(hit, going & ~is_meant)
        onwards = dr.select(is_meant, hit.to_world(bs.wo), ray.d)
        factor, polar = polarise(scene, hit, ray.d, onwards, polar, is_meant, going)
        value = value * dr.select(is_meant, weight * bs.pdf, through) * factor
        going &= dr.any(value != 0.0)
        step = dr.select(is_meant, step + 1, step)
        last = dr.select(is_meant, index, last)
        numbers = dr.select(is_meant, drawn, numbers)
        at = dr.select(is_meant, hit, at)
        following = spawn_ray(scene, hit, onwards)
        following.wavelengths = ray.wavelengths
        passes += 1
        return following, at, value, polar, numbers, last, step, passes, going & (passes < 1000)

    result = dr.while_loop(
        state=tuple(state.values()),
        cond=lambda ray, at, value, polar, numbers, last, step, passes, going: (
            going & (step < length)
        ),
        body=body,
        labels=tuple(state),
    )
    ray, at, value, polar, step, going = (result[k] for k in (0, 1, 2, 3, 6, 8))
    return at, ray.d, polar, value, going & (step == length)
