"""What light is aimed at that is traced from the lights: surfaces that bend it, in a few spheres for each light."""

import heapq
from dataclasses import dataclass

import numpy as np

MAXIMUM_TARGETS = 64
"""Most spheres of one light: each of them is asked about every path."""

LEAVES = 1024
"""Most spheres of the tree that they are taken from."""

GAIN = 0.95
"""A sphere is parted if the cross-sections of its parts together are at most this share of its own. [-]"""

FINENESS = 8.0
"""Triangles whose longest edge is more than this part of the whole's radius are halved before they are sorted. [-]"""

MOST_PIECES = 1 << 16
"""Triangles above which none is halved any more, and from which those of one cell of a grid are taken together."""

CELLS = 128
"""Of that grid, along the longest side."""

ROUNDING = 1e-5
"""By which spheres are larger than what they hold, relative to their radius. [-]"""


@dataclass(frozen=True)
class SphereTree:
    """Spheres that hold the same things ever more closely; the first holds everything.

    Parameters
    ----------
    spheres : (n, 4) float64 array    Centre and radius, in the scene's frame. [m]
    children : (n, 2) int array    The two that a sphere is parted into, -1: none.
    least : (n,) float64 array    Smallest sum of squared radii that parting it again and again can give. [m2]
    """

    spheres: np.ndarray
    children: np.ndarray
    least: np.ndarray

    def cut(self, places: np.ndarray, is_far: np.ndarray, limit: int):
        """Choose spheres for each of several lights: close ones finely, far ones coarsely.

        Parameters
        ----------
        places : (k, 3) array    Of the lights. [m]
        is_far : (k,) bool array    Lights at infinity, for which all spheres are equally far.
        limit : int    Most spheres for one light.

        Returns
        -------
        ((k, t, 4) float64 array, (k, t) bool array)    Spheres, and which of them count: some lights need fewer.
        """
        own = self.spheres[:, 3] ** 2
        lights = np.arange(len(places))
        nodes = np.full((len(places), limit), -1)
        nodes[:, 0] = 0
        gains = np.zeros((len(places), limit))
        gains[:, 0] = self._gain(0, places, is_far, own)
        for place in range(1, limit):
            column = gains.argmax(axis=1)
            parted = lights[gains[lights, column] > 0.0]
            if not len(parted):
                break
            column = column[parted]
            pair = self.children[nodes[parted, column]]
            for child, at in ((pair[:, 0], column), (pair[:, 1], place)):
                nodes[parted, at] = child
                gains[parted, at] = self._gain(child, places[parted], is_far[parted], own)
        used = int((nodes >= 0).sum(axis=1).max())
        return self.spheres[np.maximum(nodes[:, :used], 0)], nodes[:, :used] >= 0

    def _gain(self, node, places, is_far, own) -> np.ndarray:
        """Solid angle that parting a sphere can save, roughly."""
        away = ((self.spheres[node, :3] - places) ** 2).sum(axis=-1)
        squared = np.where(is_far, 1.0, np.maximum(away, own[node]))
        # A single sphere gains nothing, whatever the last digits of both areas say.
        return np.where(self.children[node, 0] < 0, 0.0, own[node] - self.least[node]) / squared


@dataclass(frozen=True)
class Targets:
    """Everything that bends light, and the plane mirrors and panes by which light may come there.

    Parameters
    ----------
    tree : SphereTree or None    None where nothing bends light.
    names : tuple of str    Materials that bend light, for people.
    """

    tree: SphereTree | None
    names: tuple[str, ...]


def find_targets(scene) -> Targets:
    """Gather what bends light in a `CompiledScene`, which keeps it until something changes.

    Plane mirrors and panes that next-event knows are no reason to trace light, but on the way to glass it may meet them.
    """
    if scene.kept_targets is None or scene.kept_targets[0] != scene.stamps:
        scene.kept_targets = scene.stamps, _gather(scene)
    return scene.kept_targets[1]


def _gather(scene) -> Targets:
    """As `find_targets`, from nothing."""
    bending, mirrors, names = [], [], set()
    for _, part, material in scene.parts():
        if not material.surface.is_bending or part.triangles == 0:
            continue
        if scene.known_mirrors.holds(part):
            mirrors.append(part)
        else:
            bending.append(part)
            names.add(material.name)
    if not bending:
        return Targets(None, ())
    corners = np.concatenate([scene.triangles(part) for part in (*bending, *mirrors)])
    return Targets(plant(corners), tuple(sorted(names)))


def plant(corners: np.ndarray) -> SphereTree:
    """Make the tree of triangles.

    They are halved again and again at the middle of their longest extent, those in the largest sphere first. The result
    does not depend on their order.

    Parameters
    ----------
    corners : (t, 3, 3) array    At least one triangle. [m]
    """
    low, high = _boxes(corners)
    centres = 0.5 * (low + high)
    spheres = [_enclose(low, high)]
    children = [(-1, -1)]
    waiting = [(-spheres[0][3], 0, np.arange(len(low)))]
    leaves = 1
    while waiting and leaves < LEAVES:
        _, node, members = heapq.heappop(waiting)
        lowest, highest = centres[members].min(axis=0), centres[members].max(axis=0)
        axis = int(np.argmax(highest - lowest))
        is_low = centres[members, axis] <= 0.5 * (lowest[axis] + highest[axis])
        if is_low.all():
            continue
        children[node] = (len(spheres), len(spheres) + 1)
        for half in (members[is_low], members[~is_low]):
            spheres.append(_enclose(low[half], high[half]))
            children.append((-1, -1))
            heapq.heappush(waiting, (-spheres[-1][3], len(spheres) - 1, half))
        leaves += 1
    return _prune(np.array(spheres), np.array(children))


def _boxes(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Bounds of small triangles, or of all in one cell of a grid where there are many. (n, 3), (n, 3) float64 [m]"""
    if len(corners) <= MOST_PIECES:
        corners = corners.astype(np.float64)
        extent = np.ptp(corners.reshape(-1, 3), axis=0)
        corners = _divide(corners, 0.5 * float(np.linalg.norm(extent)) / FINENESS)
    low, high = corners.min(axis=1), corners.max(axis=1)
    if len(corners) > MOST_PIECES:
        first, size = low.min(axis=0), float((high.max(axis=0) - low.min(axis=0)).max())
        cell = ((0.5 * (low + high) - first) * (CELLS / max(size, 1e-30))).astype(np.int64)
        key = cell @ np.array([1, CELLS + 1, (CELLS + 1) ** 2])
        order = np.argsort(key, kind="stable")
        starts = np.flatnonzero(np.diff(key[order], prepend=-1))
        low = np.minimum.reduceat(low[order], starts)
        high = np.maximum.reduceat(high[order], starts)
    return low.astype(np.float64), high.astype(np.float64)


def _divide(corners: np.ndarray, length: float) -> np.ndarray:
    """Halve triangles (t, 3, 3) until no edge is longer. [m]"""
    while len(corners) <= MOST_PIECES:
        edges = np.roll(corners, -1, axis=1) - corners
        squares = (edges**2).sum(axis=2)
        large = squares.max(axis=1) > length**2
        if not large.any():
            break
        # The longest edge goes from the first corner to the second.
        first = squares[large].argmax(axis=1)[:, None]
        order = (first + np.arange(3)) % 3
        a, b, c = np.take_along_axis(corners[large], order[:, :, None], axis=1).transpose(1, 0, 2)
        middle = 0.5 * (a + b)
        halves = [np.stack([a, middle, c], axis=1), np.stack([middle, b, c], axis=1)]
        corners = np.concatenate([corners[~large], *halves])
    return corners


def _enclose(low: np.ndarray, high: np.ndarray) -> tuple[float, ...]:
    """Sphere about the middle of boxes."""
    centre = 0.5 * (low.min(axis=0) + high.max(axis=0))
    farthest = np.maximum(centre - low, high - centre)
    radius = float(np.sqrt((farthest**2).sum(axis=1).max()))
    # Single precision must not lose what lies on the rim, far from the origin too.
    rim = ROUNDING * radius + 1e-6 * float(np.abs(centre).max()) + 1e-9
    return (*centre, radius + rim)


def _prune(spheres: np.ndarray, children: np.ndarray) -> SphereTree:
    """Join what gains nothing by being parted."""
    least = spheres[:, 3] ** 2
    # Children have higher numbers than their parents.
    for node in reversed(range(len(spheres))):
        if children[node, 0] < 0:
            continue
        parts = least[children[node]].sum()
        if parts <= GAIN * least[node]:
            least[node] = parts
        else:
            children[node] = -1
    return SphereTree(spheres, children, least)
