"""Distances to points that are strewn one to a cell, in one to four dimensions.

References
----------
Blender source, ``intern/cycles/kernel/svm/voronoi.h``.
S. Worley, "A Cellular Texture Basis Function", SIGGRAPH 1996.
"""

from dataclasses import dataclass
from itertools import product

import numpy as np

from .hashing import hash_cell, hash_to_colour, hash_to_place

MOST_DETAIL = 15.0
"""Octaves above the first at most."""

_PARALLEL = 1e-4
"""Points closer than the root of this have no edge between them."""

_FARTHEST = np.float32(8.0)
"""Distance to an edge before any octave."""


@dataclass(frozen=True)
class Cells:
    """How points are strewn and measured; numbers or arrays that broadcast, meanings as in Blender's Voronoi Texture.

    Attributes
    ----------
    feature : str    F1, F2, SMOOTH_F1, DISTANCE_TO_EDGE or N_SPHERE_RADIUS.
    metric : str    EUCLIDEAN, MANHATTAN, CHEBYCHEV or MINKOWSKI.
    normalize : bool    Whether distances are divided by the largest possible.
    smoothness : number or array    Half the node's, 0..0.5.
    is_by_bits : bool    Whether points follow from the bits of floats, as before Blender 5.0.
    """

    feature: str
    metric: str
    normalize: bool
    detail: np.ndarray
    roughness: np.ndarray
    lacunarity: np.ndarray
    smoothness: np.ndarray
    exponent: np.ndarray
    randomness: np.ndarray
    is_by_bits: bool = False


@dataclass
class Found:
    """What is found around points: distance, colour of the cell with a last axis of 3, and place of its point."""

    distance: np.ndarray
    colour: np.ndarray
    place: list


def draw_voronoi(point, cells: Cells) -> Found:
    """Return Blender's Voronoi Texture with the features F1, F2 and smooth F1.

    Parameters
    ----------
    point : sequence of one to four float32 arrays of one shape    Coordinates times the node's scale.
    cells : Cells    Its detail within 0..15, roughness and randomness within 0..1.

    Returns
    -------
    Found    Places are scaled as the point is.
    """
    point = [np.asarray(each, np.float32) for each in point]
    total = Found(np.float32(0.0), np.float32(0.0), [np.float32(0.0)] * len(point))
    amplitude = scale = np.float32(1.0)
    largest = np.float32(0.0)
    for share in _shares(cells):
        one = _octave([each * scale for each in point], cells)
        weight = share * amplitude
        total.distance = total.distance + one.distance * weight
        total.colour = total.colour + one.colour * _as_column(weight)
        total.place = [
            before + weight * (now / scale - before)
            for before, now in zip(total.place, one.place, strict=True)
        ]
        largest = largest + weight
        amplitude, scale = amplitude * cells.roughness, scale * cells.lacunarity
    if cells.normalize:
        reach = _reach(len(point), cells) * (2 if cells.feature == "F2" else 1)
        total.distance = total.distance / (largest * reach)
        total.colour = total.colour / _as_column(largest)
    return total


def draw_edges(point, cells: Cells) -> np.ndarray:
    """Return the distance to the edges between cells; parameters as of `draw_voronoi`."""
    point = [np.asarray(each, np.float32) for each in point]
    reach = 0.5 + 0.5 * cells.randomness
    amplitude = scale = np.float32(1.0)
    largest, distance = reach, _FARTHEST
    for share in _shares(cells):
        one = _distance_to_edge([each * scale for each in point], cells) / scale
        largest = largest + share * amplitude * (reach / scale - largest)
        nearer = distance + amplitude * (np.minimum(distance, one) - distance)
        distance = distance + share * (nearer - distance)
        amplitude, scale = amplitude * cells.roughness, scale * cells.lacunarity
    return distance / largest if cells.normalize else distance


def draw_radius(point, cells: Cells) -> np.ndarray:
    """Return half the distance between the nearest point and its own nearest; parameters as of `draw_voronoi`."""
    point = [np.asarray(each, np.float32) for each in point]
    cell, local = _split(point)
    nearest = _nearest(cell, local, cells)
    least, closest = np.float32(np.inf), nearest.place
    for step in _steps(len(point), 1):
        if not any(step):
            continue
        offset = [own + part for own, part in zip(nearest.offset, step, strict=True)]
        other = _strewn(cell, offset, cells)
        squared = _squared(other, nearest.place)
        closest = _chosen(squared < least, other, closest)
        least = np.minimum(squared, least)
    return np.sqrt(_squared(closest, nearest.place)) / 2


def _as_column(weight):
    return np.asarray(weight)[..., None]


def _shares(cells):
    """Yield by how much each octave counts, place by place: 1, at last the rest of the detail, then 0."""
    detail = np.where(np.equal(cells.roughness, 0), np.float32(0.0), cells.detail)
    whole = np.floor(detail)
    for number in range(int(np.ceil(detail.max())) + 1):
        yield np.where(
            number <= whole, np.float32(1.0), np.where(number < detail + 1, detail - whole, 0)
        )


def _reach(size, cells):
    """Return the largest distance to the nearest point."""
    far = np.asarray(0.5 + 0.5 * cells.randomness, np.float32)
    return far if size == 1 else _measure([far] * size, cells)


def _octave(point, cells):
    cell, local = _split(point)
    if cells.feature == "F2":
        return _second(cell, local, cells)
    if cells.feature == "F1" or not np.any(cells.smoothness):
        return _first(cell, local, cells)
    smooth = _smooth(cell, local, cells)
    if np.all(cells.smoothness):
        return smooth
    sharp, is_smooth = _first(cell, local, cells), np.not_equal(cells.smoothness, 0)
    return Found(
        np.where(is_smooth, smooth.distance, sharp.distance),
        np.where(_as_column(is_smooth), smooth.colour, sharp.colour),
        _chosen(is_smooth, smooth.place, sharp.place),
    )


def _split(point):
    """Return the cells that points lie in, and where in them."""
    floors = [np.floor(each) for each in point]
    return floors, [each - floor for each, floor in zip(point, floors, strict=True)]


def _steps(size, reach):
    """Yield the steps to the cells around, the first coordinate running fastest."""
    for step in product(range(-reach, reach + 1), repeat=size):
        yield [np.float32(part) for part in step[::-1]]


def _strewn(cell, offset, cells):
    """Return the point of a neighbour cell, as seen from a cell."""
    neighbour = [each + step for each, step in zip(cell, offset, strict=True)]
    is_by_bits = cells.is_by_bits or len(cell) == 1
    numbers = hash_to_place(*neighbour) if is_by_bits else hash_cell(neighbour)
    return [step + number * cells.randomness for step, number in zip(offset, numbers, strict=True)]


def _colour(cell, offset, cells):
    neighbour = [each + step for each, step in zip(cell, offset, strict=True)]
    if cells.is_by_bits or len(cell) == 1:
        return hash_to_colour(*neighbour)
    if len(cell) == 2:
        neighbour.append(np.zeros_like(neighbour[0]))
    return np.stack(hash_cell(neighbour)[:3], axis=-1)


def _squared(first, second):
    return sum((one - other) ** 2 for one, other in zip(first, second, strict=True))


def _measure(away, cells):
    """Return the length of a vector by the metric."""
    parts = [np.abs(each) for each in away]
    if len(parts) == 1:
        return parts[0]
    if cells.metric == "EUCLIDEAN":
        return np.sqrt(sum(each * each for each in parts))
    if cells.metric == "MANHATTAN":
        return sum(parts)
    if cells.metric == "CHEBYCHEV":
        return np.max(np.broadcast_arrays(*parts), axis=0)
    with np.errstate(all="ignore"):
        return sum(each**cells.exponent for each in parts) ** (np.float32(1.0) / cells.exponent)


def _away(place, local):
    return [each - own for each, own in zip(place, local, strict=True)]


def _chosen(is_first, first, second):
    return [np.where(is_first, one, other) for one, other in zip(first, second, strict=True)]


@dataclass
class _Nearest:
    """The nearest point: cell that it belongs to, as seen from the point's own, and place."""

    distance: np.ndarray
    offset: list
    place: list

    def replaced(self, is_nearer, distance, offset, place):
        """Return the nearest point with another one where that is nearer."""
        return _Nearest(
            np.where(is_nearer, distance, self.distance),
            _chosen(is_nearer, offset, self.offset),
            _chosen(is_nearer, place, self.place),
        )

    def found(self, cell, cells):
        """Return the point's own look."""
        place = [each + part for each, part in zip(self.place, cell, strict=True)]
        return Found(self.distance, _colour(cell, self.offset, cells), place)


def _nowhere(size):
    return _Nearest(np.float32(np.inf), [np.float32(0.0)] * size, [np.float32(0.0)] * size)


def _nearest(cell, local, cells, measure=None):
    """Return the nearest point in straight lines, or by another measure."""
    nearest = _nowhere(len(cell))
    for step in _steps(len(cell), 1):
        place = _strewn(cell, step, cells)
        away = _away(place, local)
        distance = measure(away) if measure else sum(each * each for each in away)
        nearest = nearest.replaced(distance < nearest.distance, distance, step, place)
    return nearest


def _first(cell, local, cells):
    return _nearest(cell, local, cells, lambda away: _measure(away, cells)).found(cell, cells)


def _second(cell, local, cells):
    first, second = _nowhere(len(cell)), _nowhere(len(cell))
    for step in _steps(len(cell), 1):
        place = _strewn(cell, step, cells)
        distance = _measure(_away(place, local), cells)
        is_first = distance < first.distance
        is_second = ~is_first & (distance < second.distance)
        second = second.replaced(is_second, distance, step, place)
        second = second.replaced(is_first, first.distance, first.offset, first.place)
        first = first.replaced(is_first, distance, step, place)
    return second.found(cell, cells)


def _smooth(cell, local, cells):
    softness = np.where(np.equal(cells.smoothness, 0), np.float32(1.0), cells.smoothness)
    total = None
    for step in _steps(len(cell), 2):
        place = _strewn(cell, step, cells)
        distance, colour = _measure(_away(place, local), cells), _colour(cell, step, cells)
        if total is None:
            total = Found(distance, colour, place)
            continue
        share = np.clip(0.5 + 0.5 * (total.distance - distance) / softness, 0, 1)
        share = share * share * (3 - 2 * share)
        dip = softness * share * (1 - share)
        lesser = dip / (1 + 3 * softness)
        total.distance = total.distance + share * (distance - total.distance) - dip
        total.colour = (
            total.colour + _as_column(share) * (colour - total.colour) - _as_column(lesser)
        )
        total.place = [
            before + share * (now - before) - lesser
            for before, now in zip(total.place, place, strict=True)
        ]
    total.place = [each + own for each, own in zip(total.place, cell, strict=True)]
    return total


def _distance_to_edge(point, cells):
    cell, local = _split(point)
    if len(cell) == 1:
        left, middle, right = (_strewn(cell, [np.float32(step)], cells)[0] for step in (-1, 0, 1))
        sides = [np.abs((middle + other) / 2 - local[0]) for other in (left, right)]
        return np.minimum(*sides)
    nearest = _away(_nearest(cell, local, cells).place, local)
    least = np.float32(np.finfo(np.float32).max)
    for step in _steps(len(cell), 1):
        away = _away(_strewn(cell, step, cells), local)
        across = _away(away, nearest)
        squared = sum(each * each for each in across)
        is_other = squared > _PARALLEL
        middle = sum(
            (one + other) / 2 * part for one, other, part in zip(nearest, away, across, strict=True)
        )
        distance = middle / np.sqrt(np.where(is_other, squared, 1))
        least = np.where(is_other, np.minimum(least, distance), least)
    return least
