"""Tree of many lights: each point finds those that count for it in a few steps, however many there are.

Lights lie in leaves of up to eight, nodes have four children, and the way down is drawn step by step: nodes by what all
their lights together give at the point, the lights of the leaf by what each of them gives. Going down to a known light tells
the probability with which it is drawn.

The tree is complete: where a node's children lie follows from its number, and a leaf's number is the way to it. Kernels
loop over its levels, whose number is data, so that more or other lights meet the same kernel.

References
----------
A. Conty Estevez, C. Kulla: Importance Sampling of Many Lights with Adaptive Tree Splitting, Proc. ACM Comput. Graph.
Interact. Tech. 1(2), 2018. Theirs is binary; four children at once take as many weights and spare the choice between the
largest nodes, of which least is known.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload

LEAF = 8
"""Most lights of a leaf."""

FILL = 7
"""Lights of a leaf on the mean, at most: with room to spare, nodes are cut where lights are far apart."""

ARITY_BITS = 2
"""Binary splits from a node to its children."""

ARITY = 1 << ARITY_BITS

MAP = 8
"""Rows of the octahedral map of a node's intensity."""

FINE = 2
"""Directions along the side of a cell of the map over which it is averaged."""

LEAST_INTENSITY = 0.03
"""Share of a node's mean intensity below which its map does not fall: its lights lie around the place that it is for."""

NARROW = 0.01
"""Squared radius of a node over its squared distance below which it is a point."""

TINY = 1e-30
"""Weight of what exists."""

NOWHERE = 0xFFFFFFFF
"""Place of light from infinity, and number of the light at an empty place."""

PRIOR_DRAWS = 8.0
"""Draws that what a node has learned is worth to its parts."""


def map_directions() -> np.ndarray:
    """Directions of the cells of a node's map. (MAP^2, FINE^2, 3)"""
    fine = MAP * FINE
    side = (np.arange(fine) + 0.5) / fine * 2.0 - 1.0
    x, y = np.meshgrid(side, side)
    z = 1.0 - np.abs(x) - np.abs(y)
    fold = np.maximum(-z, 0.0)
    d = np.stack([x - np.copysign(fold, x), y - np.copysign(fold, y), z], axis=-1)
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    cells = d.reshape(MAP, FINE, MAP, FINE, 3).swapaxes(1, 2)
    return cells.reshape(MAP * MAP, FINE * FINE, 3)


def arrange(centres: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Spread lights over the leaves of a complete binary tree.

    Every node is cut across the axis and at the place where the weighted squared distances of the lights to the middles of
    their halves have the least sum, as far as the halves' leaves have room.

    Parameters
    ----------
    centres : (n, 3) array    [m]
    weights : (n,) array    Above 0.

    Returns
    -------
    (leaves, LEAF) int array    Numbers of the lights, -1 at empty places. `ARITY`^levels leaves.
    """
    count = len(centres)
    levels = int(np.ceil(np.log2(max(count / FILL, 2.0)) / ARITY_BITS))
    splits = ARITY_BITS * levels
    centres = centres - centres.mean(axis=0)
    squares = (centres**2).sum(axis=1)
    moments = weights[:, None] * np.column_stack([np.ones(count), centres, squares])
    orders = [np.argsort(centres[:, axis], kind="stable") for axis in range(3)]
    node = np.zeros(count, dtype=np.int64)
    for below in range(splits - 1, -1, -1):
        orders, is_right = _cut(orders, node[orders[0]], moments, LEAF << below)
        node = 2 * node + is_right
    order = orders[0]
    leaf = node[order]
    places = np.full((1 << splits, LEAF), -1, dtype=np.int64)
    places[leaf, np.arange(count) - np.searchsorted(leaf, leaf)] = order
    return places


def _cut(orders, nodes, moments, capacity):
    """Cut every node in two.

    Parameters
    ----------
    orders : list of (n,) int array    Lights by node and then along an axis, for the three axes.
    nodes : (n,) int array    Their nodes, in this order.
    moments : (n, 5) array    Weight, weighted place and weighted squared place of each light.
    capacity : int    Most lights of a half.

    Returns
    -------
    list of (n,) int array, (n,) bool array
        The orders for the halves as nodes, and which lights are in the second half.
    """
    count = len(nodes)
    first = np.flatnonzero(np.append(True, nodes[1:] != nodes[:-1]))
    sizes = np.diff(np.append(first, count))
    owner = np.repeat(np.arange(len(first)), sizes)
    start, size = first[owner], sizes[owner]
    rank = np.arange(count) - start
    taken = rank + 1
    is_possible = (size - taken <= capacity) & (taken <= capacity) & ((taken < size) | (size == 1))
    best = np.full(len(first), np.inf)
    axes, cuts = np.zeros(len(first), dtype=np.int64), np.ones(len(first), dtype=np.int64)
    for axis, order in enumerate(orders):
        running = np.cumsum(moments[order], axis=0)
        before = np.where(first[:, None] > 0, running[first - 1], 0.0)
        whole = running[first + sizes - 1] - before
        left = running - before[owner]
        cost = _spread_of(left) + _spread_of(whole[owner] - left)
        cost = np.where(is_possible, cost, np.inf)
        least = np.minimum.reduceat(cost, first)
        hits = np.flatnonzero(cost == least[owner])
        hits = hits[np.append(True, owner[hits][1:] != owner[hits][:-1])]
        is_better = least < best
        best = np.where(is_better, least, best)
        axes = np.where(is_better, axis, axes)
        cuts = np.where(is_better, taken[hits], cuts)
    is_right = np.zeros(count, dtype=bool)
    for axis, order in enumerate(orders):
        mine = axes[owner] == axis
        is_right[order[mine]] = (rank >= cuts[owner])[mine]
    halves = []
    for order in orders:
        goes = is_right[order]
        lefts = np.cumsum(~goes)
        before = (lefts - ~goes)[first][owner]
        to_left = start + lefts - before - 1
        to_right = start + cuts[owner] + rank - (lefts - before)
        cut = np.empty(count, dtype=np.int64)
        cut[np.where(goes, to_right, to_left)] = order
        halves.append(cut)
    return halves, is_right


def _spread_of(moments) -> np.ndarray:
    """Weighted sum of squared distances to the weighted middle."""
    weight = np.maximum(moments[:, 0], 1e-300)
    return np.maximum(moments[:, 4] - (moments[:, 1:4] ** 2).sum(axis=1) / weight, 0.0)


class LightTree:
    """Draws lights at finite distance by what they give at a point.

    A node is taken for a uniform disk of lights: its middle, the axis along which they are spread least, and their variance
    along it and across it. The mean of 1 / distance^2 over a disk has a closed form. Intensities follow from the direction
    by an octahedral map, at the disk's middle and nearer to the point.

    Parameters
    ----------
    centres, radii : (n, 3) and (n,) array    Places of the lights and radii of spheres around them. [m]
    profiles : (k, MAP^2) array    Intensities relative to their mean over the directions of the map.
    kinds : (n,) int array    Which profile a light has.
    weights : (n,) array    Strengths by which the lights are arranged.
    """

    def __init__(self, centres, radii, profiles, kinds, weights):
        share = weights / max(weights.sum(), 1e-300)
        # Half of it evenly: weights may change, places matter in any case.
        self.places = arrange(centres, share + 1.0 / len(centres))
        self._is_real = self.places >= 0
        self._centres = np.where(self._is_real[..., None], centres[self.places], 0.0)
        self._spreads = np.where(self._is_real, radii[self.places], 0.0) ** 2
        self._profiles = np.asarray(profiles, dtype=np.float32)
        self._kinds = kinds[self.places]
        self._depth = (len(self.places) - 1).bit_length() // ARITY_BITS
        self._levels = dr.opaque(mi.UInt32, self._depth)
        self.set_strengths(weights)

    def set_strengths(self, strengths: np.ndarray) -> None:
        """Set what the kernels of the lights are multiplied by. (n,), above 0"""
        weights = np.where(self._is_real, strengths[self.places], 0.0)
        sums = {
            "weight": weights.sum(axis=1),
            "place": np.einsum("lp,lpa->la", weights, self._centres),
            "square": np.einsum("lp,lpa,lpb->lab", weights, self._centres, self._centres),
            "radius": (weights * self._spreads).sum(axis=1),
            "map": np.zeros((len(weights), MAP * MAP), dtype=np.float32),
        }
        for member in range(LEAF):
            weight = weights[:, member, None].astype(np.float32)
            sums["map"] += weight * self._profiles[self._kinds[:, member]]
        disks, maps = [], []
        for _ in range(self._depth):
            disk, intensity = _summarise(sums)
            disks.append(disk)
            maps.append(intensity)
            sums = {k: v.reshape(-1, ARITY, *v.shape[1:]).sum(axis=1) for k, v in sums.items()}
        self._disks = upload(mi.Float, np.concatenate(disks[::-1]))
        self._maps = upload(mi.Float, np.concatenate(maps[::-1]))
        dr.eval(self._disks, self._maps)

    def smooth(self, ratios: np.ndarray, draws: np.ndarray) -> np.ndarray:
        """Mean ratios of lights, drawn towards those of the nodes above where draws are few.

        Parameters
        ----------
        ratios : (n,) array    Sums over the draws of a light.
        draws : (n,) array    Their numbers.

        Returns
        -------
        (n,) array    0 for all where nothing was found.
        """
        sums = [np.where(self._is_real, ratios[self.places], 0.0)]
        counts = [np.where(self._is_real, draws[self.places], 0.0)]
        sums.append(sums[0].sum(axis=1))
        counts.append(counts[0].sum(axis=1))
        while len(sums[-1]) > 1:
            sums.append(sums[-1].reshape(-1, 2).sum(axis=1))
            counts.append(counts[-1].reshape(-1, 2).sum(axis=1))
        mean = sums[-1] / np.maximum(counts[-1], 1.0)
        for total, count in zip(sums[-2:0:-1], counts[-2:0:-1], strict=True):
            above = np.repeat(mean, 2)
            mean = (total + PRIOR_DRAWS * above) / (count + PRIOR_DRAWS)
        mean = (sums[0] + PRIOR_DRAWS * mean[:, None]) / (counts[0] + PRIOR_DRAWS)
        made = np.zeros(len(ratios))
        made[self.places[self._is_real]] = mean[self._is_real]
        return made

    # ---- inside kernels ----

    def descend(self, point, u, place, is_given, weigh, outside=None):
        """Go from the root to one light.

        Parameters
        ----------
        u : Float    Draws the way where none is given.
        place : UInt32    Where to go to if it is given: a light's place, or `NOWHERE` for light from infinity.
        is_given : Bool
        weigh : callable    From a place: what the light there gives at the point, 0 if there is none.
        outside : Float or None    What light from infinity gives, on the same scale.

        Returns
        -------
        (UInt32, Float, Float)    The place, its probability, and the stretched remainder of ``u``.
        """
        leaf = mi.UInt32(place) // LEAF
        goes_out = is_given & (place == NOWHERE)
        state = (
            mi.UInt32(0), mi.UInt32(0), mi.Float(u), mi.Float(1.0), mi.Bool(False)
        )  # fmt: skip

        def step(level, node, u, share, is_out):
            # The levels lie behind each other: 4, 16, 64 and so on.
            before = ((ARITY << (ARITY_BITS * level)) - ARITY) // (ARITY - 1)
            first = before + node * ARITY
            weights = [self._weigh_node(first + i, point) for i in range(ARITY)]
            shift = ARITY_BITS * (self._levels - 1 - level)
            child = (leaf >> shift) & (ARITY - 1)
            if outside is not None:
                weights.append(dr.select(level == 0, outside, 0.0))
                child = dr.select(goes_out, ARITY, child)
            child, chance, u = choose(weights, u, child, is_given)
            return level + 1, node * ARITY + child, u, share * chance, child == ARITY

        _, node, u, share, is_out = dr.while_loop(
            state=state,
            cond=lambda level, node, u, share, is_out: (level < self._levels) & ~is_out,
            body=step,
            labels=("level", "node", "u", "share", "is_out"),
        )
        base = dr.select(is_out, 0, node * LEAF)
        weights = [weigh(base + i) for i in range(LEAF)]
        member, chance, rest = choose(weights, u, mi.UInt32(place) % LEAF, is_given)
        found = dr.select(is_out, NOWHERE, base + member)
        return found, dr.select(is_out, share, share * chance), dr.select(is_out, u, rest)

    def _weigh_node(self, number, point):
        """Give what a node's lights together give at a point."""
        first = dr.gather(mi.Vector4f, self._disks, 2 * number)
        second = dr.gather(mi.Vector4f, self._disks, 2 * number + 1)
        away = mi.Vector3f(point) - mi.Vector3f(first.x, first.y, first.z)
        axis = mi.Vector3f(second.x, second.y, second.z)
        height = dr.dot(away, axis)
        across = away - axis * height
        high, wide, radius = dr.square(height) + second.w, dr.squared_norm(across), first.w
        squared = high + wide
        # Mean of 1 / distance^2 over the disk, without cancellation on either side of its rim.
        inside = radius - wide + high
        root = dr.sqrt(dr.square(inside) + 4.0 * high * wide)
        ratio = dr.select(
            inside > 0.0,
            (inside + root) / (2.0 * high),
            2.0 * wide / dr.maximum(root - inside, TINY),
        )
        kernel = dr.log(dr.maximum(ratio, 1.0)) / dr.maximum(radius, TINY)
        kernel = dr.select(radius < NARROW * squared, dr.rcp(squared), kernel)
        nearer = away - across * (radius / dr.maximum(radius + wide, TINY))
        base = number * (MAP * MAP)
        value = mi.Float(0.0)
        for direction in (away, nearer):
            value += dr.gather(mi.Float, self._maps, base + _cell(direction))
        return dr.select(value > 0.0, dr.maximum(0.5 * value * kernel, TINY), 0.0)


def choose(weights, u, given, is_given):
    """Draw one of several in proportion to their weights, or take a given one.

    Returns
    -------
    (UInt32, Float, Float)    Which, its probability, and the stretched remainder of ``u``.
    """
    total = sum(weights[1:], weights[0])
    wanted = u * total
    index, weight, start = mi.UInt32(0), mi.Float(weights[0]), mi.Float(0.0)
    running = mi.Float(weights[0])
    for i, value in enumerate(weights[1:], 1):
        picks = dr.select(is_given, given == i, (wanted >= running) & (value > 0.0))
        index = dr.select(picks, mi.UInt32(i), index)
        weight = dr.select(picks, value, weight)
        start = dr.select(picks, running, start)
        running = running + value
    share = weight / dr.maximum(total, TINY)
    rest = (wanted - start) / dr.maximum(weight, TINY)
    return index, share, dr.clip(rest, 0.0, 0.9999999)


def _cell(direction):
    """Cell of a node's map for a direction of any length."""
    size = dr.abs(direction.x) + dr.abs(direction.y) + dr.abs(direction.z)
    d = direction / dr.maximum(size, TINY)
    # Below the equator of the map the corners are folded out.
    x = (1.0 - dr.abs(d.y)) * dr.sign(d.x)
    y = (1.0 - dr.abs(d.x)) * dr.sign(d.y)
    x, y = dr.select(d.z < 0.0, x, d.x), dr.select(d.z < 0.0, y, d.y)
    last = mi.UInt32(MAP - 1)
    column = dr.minimum(mi.UInt32((x * 0.5 + 0.5) * MAP), last)
    row = dr.minimum(mi.UInt32((y * 0.5 + 0.5) * MAP), last)
    return row * MAP + column


def _summarise(sums: dict) -> tuple[np.ndarray, np.ndarray]:
    """Disks (k, 8) and maps (k, MAP^2) of nodes, from weighted sums over their lights.

    A disk is its middle, squared radius, axis, and squared thickness.
    """
    weight = sums["weight"]
    safe = np.maximum(weight, 1e-300)
    middle = sums["place"] / safe[:, None]
    variance = sums["square"] / safe[:, None, None] - middle[:, :, None] * middle[:, None, :]
    variance[weight <= 0.0] = 0.0
    along, axes = np.linalg.eigh(variance)
    along = np.maximum(along, 0.0)
    # A uniform disk has half its squared radius as variance.
    radius = 2.0 * (along[:, 1] + along[:, 2])
    thickness = np.maximum(along[:, 0] + sums["radius"] / safe, 1e-6)
    disk = np.column_stack([middle, radius, axes[:, :, 0], thickness])
    intensity = sums["map"].astype(np.float64)
    least = LEAST_INTENSITY * intensity.mean(axis=1, keepdims=True)
    return disk, np.maximum(intensity, least)
