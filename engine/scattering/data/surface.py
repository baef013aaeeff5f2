"""What measured surfaces must fulfil before light is computed with them."""

from dataclasses import replace

import numpy as np

from ...errors import SceneError
from ...scene.material import Measured
from ...scene.memo import recall_latest
from ...scene.scattering import PatchMatrix, Scatter, ScatterTable, TensorTree
from .evaluation import evaluate, incidences_of, totals
from .flake_field import check_sparkle
from .patches import check_patches
from .table import check_table, direction_of, fold_rotation, place_on, rotations_around, turned
from .tree import check_tree

ROUNDING = 1e-3
"""By which totals may exceed 1 before they are scaled down: more is light from nothing. [-]"""

STEEPEST = np.radians(89.5)
"""Farthest incidence at which totals are looked at: behind it nothing arrives. [rad]"""

LOWEST = 0.02
"""Cosine below which a direction is too near to the horizon to be turned round. [-]"""


def usable(surface: Measured) -> Measured:
    """Return a surface that reflects and lets through no more than comes; one that does already as it is.

    Raises
    ------
    SceneError    Its data break their own rules, or its factor is none.
    """
    if not (np.isfinite(surface.factor) and surface.factor >= 0.0):
        raise SceneError(f"a measured surface has the factor {surface.factor}, expected 0 or more")
    for sparkle in surface.sparkles:
        check_sparkle(sparkle, surface.front_reflection)
    made = {}
    for side in ("front", "back"):
        names = [f"{side}_reflection", f"{side}_transmission"]
        parts = [getattr(surface, name) for name in names]
        is_too_much = surface.factor * excess_of(*parts) > 1.0 + ROUNDING
        for name, part in zip(names, parts, strict=True):
            made[name] = part
            if part is not None and is_too_much:
                made[name] = replace(part, **_limited(part, parts, surface.factor))
    if all(made[name] is getattr(surface, name) for name in made):
        return surface
    for kind in ("reflection", "transmission"):
        front, back = (f"{side}_{kind}" for side in ("front", "back"))
        shared = getattr(surface, front)
        if shared is not None and shared is getattr(surface, back):
            made[front] = made[back] = _darker(made[front], made[back])
    return replace(surface, **made)


def excess_of(reflection: Scatter | None, transmission: Scatter | None) -> float:
    """Largest share of light that a side sends out again, over all incidences and wavelengths. [-]"""
    parts = [part for part in (reflection, transmission) if part is not None]
    return float(_side_totals(parts)[1].max()) if parts else 0.0


def _side_totals(parts: list[Scatter]):
    """Totals of all parts of a side together, on the union of their axes: what is asked of them is asked at once.

    Returns
    -------
    axes : tuple of (p,), (s,), (w,) arrays    Rotations, incidences, wavelengths.
    totals : (p, s, w) array
    """
    arrays = [array for part in parts for array in part.arrays()]
    values, *others = sorted(arrays, key=lambda a: -a.size)
    folds = [getattr(part, "is_orthotropic", None) for part in parts]
    return recall_latest(values, "side totals", others, folds, lambda: _find_side_totals(parts))


def _find_side_totals(parts: list[Scatter]):
    for part in parts:
        check(part)
    incidences = np.unique(np.concatenate([[0.0, STEEPEST], *map(incidences_of, parts)]))
    # Between incidences a table may scatter more than at either.
    incidences = np.union1d(incidences, 0.5 * (incidences[1:] + incidences[:-1]))
    turns = [rotations_around(part) for part in parts if isinstance(part, ScatterTable)]
    if not all(isinstance(part, ScatterTable) for part in parts):
        turns.append(np.arange(24) * np.pi / 12.0)
    rotations = np.unique(np.concatenate(turns))
    wavelengths = np.unique(np.concatenate([part.wavelengths for part in parts]))
    made = np.zeros((len(rotations), len(incidences), len(wavelengths)))
    for part in parts:
        is_one = isinstance(part, ScatterTable) and len(part.rotations) == 1
        found = totals(part, incidences, rotations[:1] if is_one else rotations)
        below, share = place_on(part.wavelengths, wavelengths)
        above = np.minimum(below + 1, len(part.wavelengths) - 1)
        made += found[..., below] * (1.0 - share) + found[..., above] * share
    return (rotations, incidences, wavelengths), made


def _limited(part: Scatter, parts: list[Scatter | None], factor: float) -> dict:
    """Values, and direct shares, scaled down where they and the others of their side are too much.

    Tables are scaled per rotation, incidence and wavelength, matrices per ring, trees as a whole.
    """
    axes, shares = _side_totals([each for each in parts if each is not None])
    over = np.maximum(factor * shares, 1.0)
    if isinstance(part, TensorTree):
        made = {"values": part.values / over.max()}
    elif isinstance(part, PatchMatrix):
        rings = _largest_near(over.max(axis=(0, 2)), axes[1], incidences_of(part), 0)
        made = {"values": part.values / np.repeat(rings, part.incoming.counts)[:, None, None]}
    else:
        if len(part.rotations) == 1:
            over = over.max(axis=0, keepdims=True)
        else:
            places = fold_rotation(axes[0])[0] if part.is_orthotropic else axes[0]
            over = _largest_near(over, places, part.rotations, 0)
        over = _largest_near(over, axes[1], part.incidences, 1)
        over = _largest_near(over, axes[2], part.wavelengths, 2)
        made = {"values": part.values / over[:, :, None, None, :]}
        if part.direct is not None:
            made["direct"] = part.direct / over
    return {name: values.astype(np.float32) for name, values in made.items()}


def _largest_near(
    values: np.ndarray, places: np.ndarray, nodes: np.ndarray, axis: int
) -> np.ndarray:
    """Largest values along an axis between the middles to the neighbours of each node, the ends open."""
    middles = 0.5 * (nodes[1:] + nodes[:-1])
    low, high = np.append(-np.inf, middles), np.append(middles, np.inf)
    parts = [
        values.compress((places >= a - 1e-9) & (places <= b + 1e-9), axis=axis).max(axis=axis)
        for a, b in zip(low, high, strict=True)
    ]
    return np.stack(parts, axis=axis)


def _darker(first: Scatter, second: Scatter) -> Scatter:
    """What is the smaller of two scatters that differ by scaling only."""
    made = {"values": np.minimum(first.values, second.values)}
    if isinstance(first, ScatterTable) and first.direct is not None:
        made["direct"] = np.minimum(first.direct, second.direct)
    return replace(first, **made)


def make_reciprocal(
    table: ScatterTable, other: ScatterTable | None = None, least: float = LOWEST
) -> ScatterTable:
    """Return a table whose grid points hold the mean of f(i, o) and f(o, i), as tables of one side should be alike.

    Parameters
    ----------
    other : ScatterTable or None    Of transmission, the table of the other side, in which f(o, i) stands; None: the same.
    least : float    Cosine below which a direction is left as it is: near the horizon tables are coarse.
    """
    axes = np.meshgrid(
        table.rotations, table.incidences, table.radials, table.azimuths, indexing="ij"
    )
    rotation, incidence, radial, azimuth = (axis.ravel() for axis in axes)
    wo = turned(direction_of(incidence, radial, azimuth), rotation)
    wi = turned(direction_of(-incidence, np.zeros_like(incidence), 0.0), rotation)
    above = np.minimum(wo[:, 2], wi[:, 2]) > least
    values = table.values.reshape(-1, len(table.wavelengths)).copy()
    turned_round = evaluate(table if other is None else other, wo[above], wi[above])
    values[above] = 0.5 * (values[above] + turned_round)
    return replace(table, values=values.reshape(table.values.shape))


def check(part: Scatter) -> None:
    """Refuse a scatter that breaks its own rules.

    Raises
    ------
    SceneError    Says what is wrong with it.
    """
    match part:
        case ScatterTable():
            check_table(part)
        case PatchMatrix():
            check_patches(part)
        case TensorTree():
            check_tree(part)
