"""Particles brought into a layer without overlapping: random places, then pushing each other apart.

Spheres that overlap push each other by half the overlap along the line of their centres, and the faces of the layer push
likewise; a particle goes and turns as its spheres are pushed (first order in time, no inertia), until no overlap is more
than a hundredth of a diameter. What comes of it is dense and random, not in equilibrium: more contacts than hard spheres
of statistical mechanics have.

References
----------
W. S. Jodrey, E. M. Tory: Computer simulation of close random packing of equal spheres, Phys. Rev. A 32, 1985, 2347-2351.
J. Neyman, E. L. Scott: Statistical approach to problems of cosmology, J. R. Stat. Soc. B 20, 1958, 1-43 (clusters).
"""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .particles import Population, chain_of

DENSEST = 0.6
"""Largest share of the volume that is tried; spheres jam at 0.64."""

SLACK = 0.01
"""Overlap that is left, over the smaller diameter. [-]"""

GROWN = 1.004
"""Radii while particles push, over their own: the last overlaps go soon then."""

SKIN = 0.3
"""Gap up to which spheres are watched, over the mean diameter."""

MOST_STEPS = 20_000

MOST_SPHERES = 2_000_000

PUSH = 1.4
"""Steps over what the pushes say, of rods the least squares of their spheres'."""

LARGEST_PIECE = 1 << 22
"""Pairs that are looked at in one go."""


@dataclass(frozen=True, eq=False)
class Packing:
    """Particles in a layer that repeats sideways.

    Parameters
    ----------
    centres : (n, 3) float64 array    x, y in 0 to the width, z downwards from the upper face. [um]
    axes : (n, 3) float64 array    Unit vectors.
    diameters : (n,) float64 array    Of balls of the same volume. [um]
    kinds : (n,) int array    Number of the population.
    populations : tuple of Population
    width, thickness : float    [um]
    steps : int
    """

    centres: np.ndarray
    axes: np.ndarray
    diameters: np.ndarray
    kinds: np.ndarray
    populations: tuple[Population, ...]
    width: float
    thickness: float
    steps: int

    def spheres(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Centres (m, 3), radii (m,) and particles (m,) of all spheres. [um]"""
        return _members(self, _Chains(self))

    def order(self, number: int) -> float:
        """Mean of P2 of the cosine of a population's axes to the normal: 1 upright, -1/2 lying, 0 anyhow."""
        own = self.axes[self.kinds == number]
        return float(1.5 * (own[:, 2] ** 2).mean() - 0.5) if len(own) else 0.0


def pack(populations, width: float, thickness: float, seed) -> Packing:
    """Fill a layer.

    Parameters
    ----------
    populations : sequence of Population
    width, thickness : float    [um]
    seed : int or sequence of int

    Raises
    ------
    SceneError    They are too many, do not fit, or do not come to rest.
    """
    populations = tuple(populations)
    rng = np.random.default_rng(seed)
    share = sum(each.share for each in populations)
    if share > DENSEST + 1e-9:
        raise SceneError(
            f"particles of {100 * share:.3g} % of the volume do not fit, expected {100 * DENSEST:g} % at most"
        )
    drawn = [_draw(each, width, thickness, rng) for each in populations]
    centres, axes, diameters = (np.concatenate(each) for each in zip(*drawn, strict=True))
    kinds = np.repeat(np.arange(len(populations)), [len(each[0]) for each in drawn])
    packing = Packing(centres, axes, diameters, kinds, populations, width, thickness, 0)
    return _relax(packing) if len(centres) else packing


def count_spheres(populations, width: float, thickness: float) -> int:
    """About how many spheres a packing will have."""
    volume = width**2 * thickness
    return sum(
        int(
            each.share * volume / (np.pi / 6.0 * each.diameter**3)
            * np.exp(-4.5 * each.log_spread**2)
            * len(chain_of(each.shape).radii)
        )
        for each in populations
    )  # fmt: skip


def _draw(population: Population, width: float, thickness: float, rng):
    """Centres, axes and diameters of a population before it is relaxed; its volume is exact."""
    volume = population.share * width**2 * thickness
    mean = np.pi / 6.0 * population.diameter**3 * np.exp(4.5 * population.log_spread**2)
    count = round(volume / mean)
    if count > MOST_SPHERES:
        raise SceneError(
            f"{count:,} particles are too many, expected {MOST_SPHERES:,}; make the cell smaller"
        )
    if volume > 0.0 and count == 0:
        raise SceneError(
            f"no particle of {population.diameter:g} um has room in a cell of {width:g} um for its share of the volume"
        )
    diameters = population.diameter * np.exp(population.log_spread * rng.standard_normal(count))
    if count:
        diameters *= np.cbrt(volume / (np.pi / 6.0 * (diameters**3).sum()))
    if count and diameters.max() > thickness:
        raise SceneError(
            f"a particle of {diameters.max():.3g} um does not fit into a layer of {thickness:g} um"
        )
    axes = _oriented(population.alignment, count, rng)
    centres = rng.random((count, 3)) * [width, width, 1.0]
    centres[:, 2] = 0.5 * diameters + centres[:, 2] * (thickness - diameters)
    if population.cluster_size > 1.0 and count:
        middles = rng.random((max(1, round(count / population.cluster_size)), 3))
        own = middles[rng.integers(len(middles), size=count)] * [width, width, thickness]
        centres = own + population.cluster_radius * rng.standard_normal((count, 3))
        centres[:, 2] = np.clip(centres[:, 2], 0.0, thickness)
    centres[:, :2] %= width
    return centres, axes, diameters


def _oriented(alignment: float, count: int, rng) -> np.ndarray:
    """Axes by Watson's distribution, exp(-alignment z^2) on the sphere."""
    found = np.empty((0, 3))
    while len(found) < count:
        tried = rng.standard_normal((2 * count + 16, 3))
        tried /= np.linalg.norm(tried, axis=1, keepdims=True)
        weight = np.exp(-alignment * tried[:, 2] ** 2 + min(alignment, 0.0))
        found = np.concatenate([found, tried[rng.random(len(tried)) < weight]])
    return found[:count]


class _Chains:
    """Which particle each sphere belongs to, where along its axis it sits, and how large it is."""

    def __init__(self, packing: Packing):
        chains = [chain_of(each.shape) for each in packing.populations]
        sizes = np.array([len(each.radii) for each in chains], int)[packing.kinds]
        self.owners = np.repeat(np.arange(len(sizes)), sizes)
        first = np.cumsum(sizes) - sizes
        within = np.arange(len(self.owners)) - first[self.owners]
        longest = max(len(each.radii) for each in chains)
        table = np.zeros((2, len(chains), longest))
        for number, each in enumerate(chains):
            table[0, number, : len(each.radii)] = each.places
            table[1, number, : len(each.radii)] = each.radii
        kinds = packing.kinds[self.owners]
        scale = packing.diameters[self.owners]
        self.places = table[0, kinds, within] * scale
        self.radii = table[1, kinds, within] * scale
        self.sizes = sizes
        self.spread = np.bincount(self.owners, self.places**2, len(sizes))


def _members(packing: Packing, chains: _Chains):
    centres = packing.centres[chains.owners] + chains.places[:, None] * packing.axes[chains.owners]
    centres[:, :2] %= packing.width
    return centres, chains.radii, chains.owners


def _relax(packing: Packing) -> Packing:
    chains = _Chains(packing)
    if len(chains.owners) > MOST_SPHERES:
        raise SceneError(
            f"{len(chains.owners):,} spheres are too many, expected {MOST_SPHERES:,}; make the cell smaller"
        )
    centres, axes = packing.centres.copy(), packing.axes.copy()
    width, thickness = packing.width, packing.thickness
    radii = GROWN * chains.radii
    skin = SKIN * 2.0 * float(np.mean(radii))
    slack = SLACK * 2.0 * chains.radii
    count = len(centres)
    is_rod = chains.sizes > 1
    watched, steps = None, 0
    while steps < MOST_STEPS:
        steps += 1
        places = centres[chains.owners] + chains.places[:, None] * axes[chains.owners]
        moved = np.inf if watched is None else np.abs(places - watched).max()
        if moved > 0.28 * skin:
            centres[:, :2] %= width
            places = centres[chains.owners] + chains.places[:, None] * axes[chains.owners]
            first, second = _neighbours(places, radii, chains.owners, width, thickness, skin)
            reach = radii[first] + radii[second]
            watched = places.copy()
        apart = places[first] - places[second]
        apart[:, :2] -= width * np.round(apart[:, :2] / width)
        distance = np.sqrt(np.einsum("ij,ij->i", apart, apart))
        touching = np.flatnonzero(distance < reach)
        i, j, gap = first[touching], second[touching], distance[touching]
        overlap = reach[touching] - gap
        # Two at one place part anyhow.
        push = np.where(
            gap[:, None] > 1e-9,
            apart[touching] / np.maximum(gap, 1e-12)[:, None],
            [0.6, 0.48, 0.64],
        )
        push *= 0.5 * overlap[:, None]
        force = np.stack(
            [
                np.bincount(i, push[:, k], len(places)) - np.bincount(j, push[:, k], len(places))
                for k in range(3)
            ],
            axis=1,
        ).astype(np.float64)
        rise = np.maximum(radii - places[:, 2], 0.0) - np.maximum(
            places[:, 2] - (thickness - radii), 0.0
        )
        force[:, 2] += rise
        worst = np.maximum(np.abs(rise) - (GROWN - 1.0) * chains.radii - slack, 0.0).max()
        if len(i):
            true = overlap - (GROWN - 1.0) * (chains.radii[i] + chains.radii[j])
            worst = max(worst, float((true - np.minimum(slack[i], slack[j])).max()))
        if worst <= 0.0:
            break
        mean = _by_owner(chains.owners, force, count) / chains.sizes[:, None]
        centres += PUSH * mean
        if is_rod.any():
            lever = _by_owner(chains.owners, chains.places[:, None] * force, count)
            lever /= np.maximum(chains.spread, 1e-12)[:, None]
            axes += PUSH * lever * is_rod[:, None]
            axes /= np.linalg.norm(axes, axis=1, keepdims=True)
    else:
        raise SceneError(
            f"particles of {100 * sum(each.share for each in packing.populations):.3g} % of the volume still overlap after "
            f"{MOST_STEPS} steps; take fewer, or less long ones"
        )
    centres[:, :2] %= width
    return Packing(
        centres,
        axes,
        packing.diameters,
        packing.kinds,
        packing.populations,
        width,
        thickness,
        steps,
    )


def _by_owner(owners, values, count: int) -> np.ndarray:
    return np.stack([np.bincount(owners, values[:, k], count) for k in range(3)], axis=1)


def _neighbours(places, radii, owners, width: float, thickness: float, skin: float):
    """Pairs of spheres of different particles that are nearer than their radii and the skin. Two (p,) int arrays"""
    reach = 2.0 * float(radii.max()) + skin
    across = max(1, int(width / reach))
    if across < 3:
        across = 1
    down = max(1, int(thickness / reach))
    grid = np.empty((len(places), 3), np.int64)
    grid[:, :2] = (places[:, :2] % width / width * across).astype(np.int64) % across
    grid[:, 2] = np.clip((places[:, 2] / thickness * down).astype(np.int64), 0, down - 1)
    cells = (grid[:, 2] * across + grid[:, 1]) * across + grid[:, 0]
    order = np.argsort(cells, kind="stable")
    counts = np.bincount(cells, minlength=across * across * down)
    starts = np.cumsum(counts) - counts
    sideways = range(-1, 2) if across > 1 else range(1)
    pairs = []
    for dz in (0, 1):
        for dy in sideways:
            for dx in sideways:
                if (dz, dy, dx) < (0, 0, 0):
                    continue
                below = grid[:, 2] + dz
                there = np.flatnonzero(below < down)
                cell = (below[there] * across + (grid[there, 1] + dy) % across) * across
                cell += (grid[there, 0] + dx) % across
                pairs += _pairs(there, cell, counts, starts, order, (dz, dy, dx) == (0, 0, 0),
                                places, radii, owners, width, skin)  # fmt: skip
    return tuple(np.concatenate(each) for each in zip(*pairs, strict=True))


def _pairs(there, cell, counts, starts, order, is_own, places, radii, owners, width, skin):
    """Near pairs of spheres with those of one cell each, in pieces."""
    amount = counts[cell]
    found = [(np.zeros(0, np.int64), np.zeros(0, np.int64))]
    if not amount.any():
        return found
    ends = np.cumsum(amount)
    cuts = np.searchsorted(ends, np.arange(0, ends[-1], LARGEST_PIECE))
    for low, high in zip(cuts, [*cuts[1:], len(there)], strict=True):
        own = amount[low:high]
        i = np.repeat(there[low:high], own)
        within = np.arange(own.sum()) - np.repeat(np.cumsum(own) - own, own)
        j = order[np.repeat(starts[cell[low:high]], own) + within]
        keep = owners[i] != owners[j]
        if is_own:
            keep &= i < j
        i, j = i[keep], j[keep]
        apart = places[i] - places[j]
        apart[:, :2] -= width * np.round(apart[:, :2] / width)
        near = np.einsum("ij,ij->i", apart, apart) < (radii[i] + radii[j] + skin) ** 2
        found.append((i[near], j[near]))
    return found


def pair_correlation(packing: Packing, edges) -> np.ndarray:
    """g(r) of the centres, as distances fall between edges: pairs over those of independent places. (e,) -> (e - 1,)

    Only for distances below half the width.
    """
    edges = np.asarray(edges, np.float64)
    centres, width, thickness = packing.centres, packing.width, packing.thickness
    far = np.full(len(centres), 0.5 * float(edges[-1]))
    first, second = _neighbours(centres, far, np.arange(len(centres)), width, thickness, 0.0)
    apart = centres[first] - centres[second]
    apart[:, :2] -= width * np.round(apart[:, :2] / width)
    seen, _ = np.histogram(np.sqrt((apart**2).sum(axis=1)), edges)
    # A slab between two faces: of a shell of the radius r a share 1 - r / (2 h) lies within, on average over its middle,
    # where the middles fill the height h.
    low, high = centres[:, 2].min(), centres[:, 2].max()
    middle = 0.5 * (edges[1:] + edges[:-1])
    share = 1.0 - middle / (2.0 * max(high - low, 1e-12))
    volume = 4.0 / 3.0 * np.pi * np.diff(edges**3) * share
    density = len(centres) / (width**2 * (high - low))
    return seen / (0.5 * len(centres) * density * volume)


def depth_profile(packing: Packing, slices: int) -> np.ndarray:
    """Share of the volume that particles fill by depth. -> (slices,)"""
    centres, radii, _ = packing.spheres()
    edges = np.linspace(0.0, packing.thickness, slices + 1)
    total = np.zeros(slices)
    for low, high, k in zip(edges[:-1], edges[1:], range(slices), strict=True):
        bottom = np.clip(low - centres[:, 2], -radii, radii)
        top = np.clip(high - centres[:, 2], -radii, radii)
        cut = np.pi * (radii**2 * (top - bottom) - (top**3 - bottom**3) / 3.0)
        total[k] = cut.sum() / (packing.width**2 * (high - low))
    return total
