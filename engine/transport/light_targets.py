"""What light is aimed at that is traced from the lights: surfaces that bend it, in a few spheres."""

import heapq
from dataclasses import dataclass

import numpy as np

from ..scene.material import Conductor, Dielectric, Glossy, Mix, TabulatedPane, ThinGlass
from .surfaces import SMOOTH_ROUGHNESS, is_mirror

MAXIMUM_TARGETS = 64
"""Most spheres: each of them is asked about every path."""

GAIN = 0.95
"""A sphere is replaced by two if their cross-sections together are at most this share of its own. [-]"""

ROUNDING = 1e-5
"""By which spheres are larger than what they hold, relative to their radius. [-]"""


def is_bending(surface) -> bool:
    """Tell whether a surface sends light on in single directions other than straight on: ideal mirrors, glass, panes."""
    match surface:
        case Dielectric():
            return surface.roughness < SMOOTH_ROUGHNESS
        case Glossy() | Conductor():
            return is_mirror(surface)
        case ThinGlass():
            return surface.ior != 1.0
        case TabulatedPane():
            return bool(np.any(np.asarray(surface.reflectance) > 0.0))
        case Mix():
            return is_bending(surface.first) or is_bending(surface.second)
    return False


@dataclass(frozen=True)
class Targets:
    """Spheres that hold everything that bends light, and the plane mirrors by which light may come there.

    Parameters
    ----------
    spheres : (k, 4) float64 array    Centre and radius, in the scene's frame; none where nothing bends light. [m]
    names : tuple of str    Materials that bend light, for people.
    """

    spheres: np.ndarray
    names: tuple[str, ...]


def find_targets(scene, limit: int = MAXIMUM_TARGETS) -> Targets:
    """Gather what bends light in a `CompiledScene`.

    Plane mirrors that next-event knows are no reason to trace light, but on the way to glass it may meet them.

    Parameters
    ----------
    scene : CompiledScene
    limit : int    Most spheres.
    """
    known = None if scene.is_mirror is None else np.array(scene.is_mirror)
    bending, mirrors, names = [], [], set()
    for part, material in scene.parts():
        if not is_bending(material.surface) or part.triangles == 0:
            continue
        if known is not None and known[part.number]:
            mirrors.append(part)
        else:
            bending.append(part)
            names.add(material.name)
    if not bending:
        return Targets(np.zeros((0, 4)), ())
    corners = np.concatenate([scene.triangles(part) for part in (*bending, *mirrors)])
    return Targets(cover(corners.astype(np.float64), limit), tuple(sorted(names)))


def cover(corners: np.ndarray, limit: int) -> np.ndarray:
    """Cover triangles with spheres of small cross-section in all.

    The triangles are halved again and again at the middle of their longest extent, those in the largest sphere first; then
    halves are joined where that makes the sum of the cross-sections no larger. The result does not depend on their order.

    Parameters
    ----------
    corners : (t, 3, 3) float64 array    At least one triangle. [m]
    limit : int    Most spheres.

    Returns
    -------
    (k, 4) float64 array    Centres and radii. [m]
    """
    centroids = corners.mean(axis=1)
    spheres = [_enclose(corners)]
    children: dict[int, tuple[int, int]] = {}
    waiting = [(-spheres[0][3], 0, np.arange(len(corners)))]
    leaves = 1
    while waiting and leaves < limit:
        _, node, members = heapq.heappop(waiting)
        low, high = centroids[members].min(axis=0), centroids[members].max(axis=0)
        axis = int(np.argmax(high - low))
        is_low = centroids[members, axis] <= 0.5 * (low[axis] + high[axis])
        if is_low.all():
            continue
        halves = (members[is_low], members[~is_low])
        children[node] = (len(spheres), len(spheres) + 1)
        for half in halves:
            spheres.append(_enclose(corners[half]))
            heapq.heappush(waiting, (-spheres[-1][3], len(spheres) - 1, half))
        leaves += 1
    return np.array(_join(spheres, children))


def _enclose(corners: np.ndarray) -> tuple[float, ...]:
    """Sphere about the middle of the bounds."""
    points = corners.reshape(-1, 3)
    centre = 0.5 * (points.min(axis=0) + points.max(axis=0))
    radius = float(np.sqrt(((points - centre) ** 2).sum(axis=1).max()))
    # Single precision must not lose what lies on the rim, far from the origin too.
    rim = ROUNDING * radius + 1e-6 * float(np.abs(centre).max()) + 1e-9
    return (*centre, radius + rim)


def _join(spheres: list, children: dict[int, tuple[int, int]]) -> list:
    """Cut the tree of spheres where the sum of their cross-sections is smallest."""
    best: dict[int, float] = {}
    # Children have higher numbers than their parents.
    for node in reversed(range(len(spheres))):
        own = spheres[node][3] ** 2
        if node in children:
            halves = sum(best[child] for child in children[node])
            if halves <= GAIN * own:
                best[node] = halves
                continue
            del children[node]
        best[node] = own
    kept, open_nodes = [], [0]
    while open_nodes:
        node = open_nodes.pop()
        if node in children:
            open_nodes.extend(reversed(children[node]))
        else:
            kept.append(spheres[node])
    return kept
