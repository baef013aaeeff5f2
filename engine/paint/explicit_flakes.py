"""Flakes as discs in their places, in a cell that repeats: for flakes that are wide against the gaps between them.

Light that a disc turned back finds the hole by which it came, so wide opaque flakes reflect more than a continuum of the
same area: exactly parallel ones r (1 - exp(-a H)) in place of r a H / (1 + r a H). Discs may cut each other, and reach
into what lies above and below their layer.
"""

from dataclasses import replace

import numpy as np

from ..errors import SceneError
from .composition import Paint, face_densities
from .photon_walk import Walked, walk

CELLS = 8.0
"""Side of the cell, times the diameter by which area goes."""

MOST_DISCS = 40_000
"""Discs of a cell."""

REALISATIONS = 16
"""Cells over which results are averaged."""

NEAREST = 1e-7
"""Distance below which a disc is that which light just left. [um]"""

CHUNK = 1 << 19
"""Photons times discs that are compared in one go."""


class DiscField:
    """Discs of a paint's flakes in a cell with the sides ``side``. [um]"""

    def __init__(self, paint: Paint, side: float, rng):
        self.side = side
        centres, normals, radii, kinds = [], [], [], []
        top, kind = 0.0, 0
        for layer in paint.layers:
            for flakes, area in zip(layer.flakes, face_densities(layer), strict=True):
                if area <= 0.0:
                    continue
                # Cells alike in their area differ less from each other than such cut out of a wide paint.
                number = area * layer.thickness_um * side**2 / flakes.diameters.face_um2
                count = int(number + rng.random())
                spread = rng.normal(size=count) * flakes.diameters.log_spread
                radius = 0.5 * flakes.diameters.median_um * np.exp(spread)
                slope = rng.normal(size=(count, 2)) * flakes.slope
                normal = np.column_stack([-slope, np.ones(count)])
                normal /= np.linalg.norm(normal, axis=1, keepdims=True)
                place = rng.random((count, 3)) * [side, side, layer.thickness_um]
                place[:, 2] = -top - place[:, 2]
                centres.append(place)
                normals.append(normal)
                radii.append(np.minimum(radius, 0.45 * side))
                kinds.append(np.full(count, kind))
                kind += 1
            top += layer.thickness_um
        self.bottom = -top
        centre, normal = np.concatenate(centres), np.concatenate(normals)
        radius, kind = np.concatenate(radii), np.concatenate(kinds)
        # Discs that reach beyond the cell stand on its other side too.
        shifts = [(x, y) for x in (-1, 0, 1) for y in (-1, 0, 1)]
        moved = np.concatenate([centre + np.array([x * side, y * side, 0.0]) for x, y in shifts])
        radius, kind, normal = np.tile(radius, 9), np.tile(kind, 9), np.tile(normal, (9, 1))
        beyond = np.abs(moved[:, :2] - 0.5 * side).max(axis=1) - 0.5 * side
        near = beyond < radius
        self.centre, self.normal, self.radius, self.kind = (
            each[near] for each in (moved, normal, radius, kind)
        )
        self.offset = (self.centre * self.normal).sum(axis=1)

    def enter(self, count: int, rng) -> np.ndarray:
        """Places over the paint where photons come in. (n, 2) [um]"""
        return rng.random((count, 2)) * self.side

    def meet(self, position, direction, layer, rng):
        """As of `photon_walk.FlakeField`."""
        del layer, rng
        count = len(position)
        distance, disc = np.full(count, np.inf), np.zeros(count, np.int64)
        upright = np.where(np.abs(direction[:, 2]) < 1e-9, -1e-9, direction[:, 2])
        most = np.where(upright < 0.0, self.bottom - position[:, 2], -position[:, 2]) / upright
        gone = np.zeros(count)
        left = np.flatnonzero(most > 0.0)
        place = position.copy()
        while len(left):
            place[left, :2] %= self.side
            with np.errstate(divide="ignore", invalid="ignore"):
                ways = np.where(
                    direction[left, :2] > 0.0,
                    (self.side - place[left, :2]) / direction[left, :2],
                    -place[left, :2] / direction[left, :2],
                )
            way = np.nanmin(np.where(direction[left, :2] == 0.0, np.inf, ways), axis=1)
            nearest, number = self._nearest(place[left], direction[left], np.minimum(way, 1e9))
            hit = number >= 0
            distance[left[hit]] = gone[left[hit]] + nearest[hit]
            disc[left[hit]] = number[hit]
            step = np.minimum(way, 1e9) + NEAREST
            gone[left] += step
            place[left] += step[:, None] * direction[left]
            left = left[~hit & (gone[left] < most[left])]
        return distance, self.kind[disc], self.normal[disc]

    def _nearest(self, place, direction, most) -> tuple[np.ndarray, np.ndarray]:
        """Distances to the nearest discs within ways, and their numbers, -1 where there is none."""
        found, number = most.copy(), np.full(len(place), -1)
        step = max(CHUNK // max(len(self.radius), 1), 1)
        for k in range(0, len(place), step):
            own, way = place[k : k + step], direction[k : k + step]
            with np.errstate(divide="ignore", invalid="ignore"):
                distance = (self.offset - own @ self.normal.T) / (way @ self.normal.T)
            distance = np.where(np.isfinite(distance) & (distance > NEAREST), distance, np.inf)
            distance = np.where(distance < most[k : k + step, None], distance, np.inf)
            rows, columns = np.nonzero(np.isfinite(distance))
            where = own[rows] + distance[rows, columns][:, None] * way[rows] - self.centre[columns]
            out = (where**2).sum(axis=1) >= self.radius[columns] ** 2
            distance[rows[out], columns[out]] = np.inf
            nearest = distance.argmin(axis=1)
            least = distance[np.arange(len(own)), nearest]
            hit = np.isfinite(least)
            found[k : k + step][hit] = least[hit]
            number[k : k + step][hit] = nearest[hit]
        return found, number


def walk_among_discs(
    paint: Paint,
    wavelength: float,
    incidence: float,
    photons: int,
    seed: int = 0,
    realisations: int = REALISATIONS,
) -> Walked:
    """Send photons among discs.

    Parameters
    ----------
    wavelength : float    [nm]
    incidence : float    [rad]
    photons : int    In all cells together.
    realisations : int    Cells; the error is that of their spread.

    Raises
    ------
    SceneError    Flakes lack a diameter, or are too small for the cell; or as of `photon_walk.walk`.
    """
    side = _side_of(paint)
    results = []
    for number in range(realisations):
        field = DiscField(paint, side, np.random.default_rng((seed, number)))
        results.append(
            walk(paint, wavelength, incidence, photons // realisations, seed * 1000 + number, field)
        )
    albedo = np.array([each.albedo for each in results])
    shares = np.array([each.shares for each in results])
    scale = 1.0 / np.sqrt(realisations)
    return replace(
        results[0],
        albedo=float(albedo.mean()),
        absorbed=float(np.mean([each.absorbed for each in results])),
        error=float(albedo.std(ddof=1) * scale),
        shares=shares.mean(axis=0),
        errors=shares.std(axis=0, ddof=1) * scale,
        photons=photons,
        seed=seed,
    )


def _side_of(paint: Paint) -> float:
    """Side of the cell: many flakes wide, and twice as wide as the paint is thick if discs are few. [um]"""
    owners = [(layer, each) for layer in paint.layers for each in layer.flakes]
    if not owners:
        raise SceneError(f"'{paint.name}' has no flakes to stand in their places")
    if any(each.diameters is None for _, each in owners):
        raise SceneError("flakes need a 'diameter' to stand in their places")
    least = CELLS * max(np.sqrt(each.diameters.face_um2 * 4.0 / np.pi) for _, each in owners)
    number = sum(
        area * layer.thickness_um / each.diameters.face_um2
        for layer in paint.layers
        for each, area in zip(layer.flakes, face_densities(layer), strict=True)
    )
    if number * least**2 > MOST_DISCS:
        raise SceneError(
            f"a cell would hold {number * least**2:.3g} discs, expected {MOST_DISCS} at most"
        )
    thickness = sum(layer.thickness_um for layer in paint.layers)
    wide = min(2.0 * thickness, np.sqrt(0.05 * MOST_DISCS / number))
    return float(max(least, wide))
