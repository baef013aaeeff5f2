"""What measured surfaces must fulfil before light is computed with them."""

from dataclasses import replace

import numpy as np

from ..scene.material import Measured
from ..scene.memo import recall
from ..scene.scattering import PatchMatrix, Scatter, ScatterTable, TensorTree
from .evaluation import evaluate, incidences_of, total
from .patches import check_patches
from .record import SIDES
from .table import check_table, direction_of, turned
from .tree import check_tree

ROUNDING = 1e-3
"""By which totals may exceed 1 before they are scaled down: more is light from nothing. [-]"""


LOWEST = 0.02
"""Cosine below which a direction is too near to the horizon to be turned round. [-]"""


def parts_of(surface: Measured) -> list[Scatter | None]:
    """The four scatters of a surface, in the order of `SIDES`."""
    return [getattr(surface, name) for name in SIDES]


def is_grained(surface: Measured) -> bool:
    """Whether the direction of a surface's U counts."""
    return any(
        part is not None
        and not (isinstance(part, ScatterTable) and len(part.rotations) == 1)
        and not (isinstance(part, TensorTree) and part.rank == 3)
        for part in parts_of(surface)
    )


def mirrors_light(surface: Measured) -> bool:
    """Whether some of the light is reflected as by a mirror."""
    return any(
        isinstance(part, ScatterTable) and part.direct is not None and part.direct.any()
        for part in (surface.front_reflection, surface.back_reflection)
    )


def is_coloured(surface: Measured) -> bool:
    """Whether the scattering depends on the wavelength."""
    return any(part is not None and len(part.wavelengths) > 1 for part in parts_of(surface))


def usable(surface: Measured) -> Measured:
    """Return a surface that reflects and lets through no more than comes; one that does already as it is.

    Raises
    ------
    SceneError    Its data break their own rules.
    """
    made = {}
    for side in ("front", "back"):
        names = [f"{side}_reflection", f"{side}_transmission"]
        parts = [getattr(surface, name) for name in names]
        excess = excess_of(*parts) * surface.factor
        for name, part in zip(names, parts, strict=True):
            made[name] = part
            if part is not None and excess > 1.0 + ROUNDING:
                made[name] = replace(part, **_limited(part, parts, surface.factor))
    if all(made[name] is getattr(surface, name) for name in made):
        return surface
    if surface.front_reflection is surface.back_reflection:
        made["back_reflection"] = made["front_reflection"]
    if surface.front_transmission is surface.back_transmission:
        made["back_transmission"] = made["front_transmission"]
    return replace(surface, **made)


def excess_of(reflection: Scatter | None, transmission: Scatter | None) -> float:
    """Largest share of light that a side sends out again, over all incidences and wavelengths. [-]"""
    totals = [_totals(part) for part in (reflection, transmission) if part is not None]
    if len(totals) == 2 and totals[0].shape == totals[1].shape:
        return float((totals[0] + totals[1]).max())
    return float(sum(each.max() for each in totals))


def make_reciprocal(table: ScatterTable) -> ScatterTable:
    """Return a table whose grid points hold the mean of f(i, o) and f(o, i), as tables of one side should be alike."""
    axes = np.meshgrid(
        table.rotations, table.incidences, table.radials, table.azimuths, indexing="ij"
    )
    rotation, incidence, radial, azimuth = (axis.ravel() for axis in axes)
    wo = turned(direction_of(incidence, radial, azimuth), rotation)
    wi = turned(direction_of(-incidence, np.zeros_like(incidence), 0.0), rotation)
    above = wo[:, 2] > LOWEST
    values = table.values.reshape(-1, len(table.wavelengths)).copy()
    values[above] = 0.5 * (values[above] + evaluate(table, wo[above], wi[above]))
    return replace(table, values=values.reshape(table.values.shape))


def _limited(part: Scatter, parts: list[Scatter | None], factor: float) -> dict:
    """Values, and direct shares, scaled down where they and the others of their side are too much.

    Tables are scaled per rotation, incidence and wavelength, matrices per patch, trees as a whole.
    """
    totals = [_totals(each) for each in parts if each is not None]
    own = _totals(part)
    if all(each.shape == own.shape for each in totals):
        share = 1.0 / np.maximum(factor * sum(totals), 1.0)
    else:
        share = np.full(own.shape, 1.0 / (factor * sum(each.max() for each in totals)))
    match part:
        case ScatterTable():
            made = {"values": part.values * share[:, :, None, None, :]}
            if part.direct is not None:
                made["direct"] = part.direct * share
        case PatchMatrix():
            rings = np.repeat(share.min(axis=0), part.incoming.counts, axis=0)
            made = {"values": part.values * rings[:, None, :]}
        case TensorTree():
            made = {"values": part.values * share.min(axis=(0, 1))}
    return {name: values.astype(np.float32) for name, values in made.items()}


def _totals(part: Scatter) -> np.ndarray:
    """Totals of a scatter over incidences and, where it has them, rotations, by wavelength."""
    return recall(part.values, "totals", lambda _: _find_totals(part))


def _find_totals(part: Scatter) -> np.ndarray:
    check(part)
    incidences = incidences_of(part)
    if not isinstance(part, ScatterTable):
        turns = np.arange(8) * np.pi / 4.0
        return np.array([[total(part, s, p) for s in incidences] for p in turns])
    made = np.array([[total(part, s, p) for s in incidences] for p in part.rotations])
    # Between incidences a table may scatter more than at either.
    middles = 0.5 * (incidences[1:] + incidences[:-1])
    if len(middles):
        between = np.array([[total(part, s, p) for s in middles] for p in part.rotations])
        made[:, 1:] = np.maximum(made[:, 1:], between)
        made[:, :-1] = np.maximum(made[:, :-1], between)
    return made


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
