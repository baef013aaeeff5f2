"""Scattering files and the catalogue, which follow from `recipes` alone; the same sources give the same bytes."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np

from ....engine.scattering.data.evaluation import totals
from ....engine.scattering.data.record import ScatteringFile
from ....engine.scattering.data.resampling import choose_bands, resample
from ....engine.scattering.data.store import FORMAT, write_store
from ....engine.scattering.data.table import direction_of, turned
from ....engine.scattering.data.tree import disk_of, square_of
from ....engine.scattering.file_names import SUFFIX
from ....engine.scene.scattering import Scatter, ScatterTable, TensorTree
from ....libraries.materials.catalogue import LIST
from .colour import WAVELENGTHS
from .microfacets import unit
from .recipes import Part, Recipe, recipes
from .retroreflection import Sheeting, grow_tree

INCIDENCES = np.radians(
    [0.0, 8.0, 20.0, 32.0, 43.0, 53.0, 62.0, 70.0, 76.0, 81.0, 84.5, 86.5, 87.7, 88.5]
)
"""Of all tables: the direct part is linear in between, Fresnel's equations and 1 / cos are steep at last. [rad]"""

LEVELS, STEP = 10, 0.77
"""Halvings of a tree's finest cells, 0.1 degrees near the normal, and by how much values may differ in a cell."""

PAIRS = 1024
"""Pairs of directions whose spectra tell which bands are needed."""

SPECTRAL_ERROR = 0.015
"""Error of bands that are left out, root mean square, relative to the pair's value. [-]"""

LOWEST = np.sin(np.radians(1.0))
"""Cosine of directions from which on tables hold their values: the horizon's."""

DEFAULTS = {"format": 1, "author": "The Lumenray developers", "licence": "CC0-1.0"}
"""What holds for all materials."""


def make_file(recipe: Recipe, path: Path) -> ScatteringFile:
    """Make the content of a material's file; sides with the same part share it."""
    parts = recipe.make()
    different = list(dict.fromkeys(parts.values()))
    bands = bands_of([part for part in different if isinstance(part, Part)])
    # What has a grain chooses the rotations, which the others take over: both are added up.
    made, rotations = {}, None
    for part in sorted(different, key=lambda part: not is_grained(part)):
        made[part] = make_scatter(part, bands, rotations)
        if is_grained(part):
            rotations = made[part].rotations
    made = keep_energy(parts, made)
    sides = {side: made[part] for side, part in parts.items()}
    return ScatteringFile(path, FORMAT, sides, recipe.title, recipe.description, recipe.source)


def is_grained(part: Part | Sheeting) -> bool:
    """Whether it matters how a part is turned about the normal."""
    return isinstance(part, Part) and part.is_grained


def bands_of(parts: list[Part]) -> np.ndarray:
    """Numbers of the wavelengths from which linear interpolation gives the others of all parts; one where all are alike."""
    wi, wo = _random_pairs(PAIRS)
    spectra = [part.evaluate(wi, wo) for part in parts]
    spectra = [each for each in spectra if each.shape[1] > 1]
    if not spectra:
        return np.array([len(WAVELENGTHS) // 2])
    # Every pair counts the same: a lobe's peak must not hide what lies beside it.
    values = np.concatenate(spectra)
    values = values / np.maximum(values.mean(axis=1, keepdims=True), 1e-30)
    if np.sqrt(((values - 1.0) ** 2).mean(axis=0)).max() <= SPECTRAL_ERROR:
        return np.array([len(WAVELENGTHS) // 2])
    return choose_bands(WAVELENGTHS, values, SPECTRAL_ERROR)


def _random_pairs(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of directions, half of them near each other's mirror images."""
    draw = np.random.default_rng(3).normal(size=(2, count, 3))
    draw[..., 2] = np.abs(draw[..., 2]) + 0.1
    wi, wo = unit(draw[0]), unit(draw[1])
    near = unit(wi * [-1.0, -1.0, 1.0] + 0.1 * wo)
    return wi, np.where((np.arange(count) % 2 == 0)[:, None], near, wo)


def make_scatter(part: Part | Sheeting, bands: np.ndarray, rotations: np.ndarray | None) -> Scatter:
    """Make the table or the tree of a part.

    Parameters
    ----------
    part : Part or Sheeting
    bands : (w,) array    Numbers of the wavelengths that it has.
    rotations : (p,) array or None    Those of another part of the material, from 0 to pi / 2. [rad]
    """
    wavelengths = WAVELENGTHS[bands]
    if isinstance(part, Sheeting):
        children, values = grow_tree(part.evaluate, disk_of, square_of, LEVELS, STEP)
        middle = len(WAVELENGTHS) // 2
        return TensorTree(3, children, WAVELENGTHS[middle : middle + 1], values.astype(np.float32))

    def evaluate_mean(wi, wo):
        return part.evaluate(wi, wo).mean(axis=1, keepdims=True)

    table = resample(
        evaluate_mean,
        wavelengths[:1],
        incidences=INCIDENCES,
        rotations=rotations if part.is_grained else (0.0,),
        is_symmetric=not part.is_grained,
        is_orthotropic=part.is_grained,
        tolerance=part.tolerance,
    )
    if len(bands) > 1:
        # Of one band alone the mean over all is told.
        table = replace(table, values=table.values * _spectra(part, table, bands))
    rotations = table.rotations if rotations is None else rotations
    shape = (len(rotations), *table.values.shape[1:4], len(bands))
    table = replace(
        table,
        rotations=rotations,
        wavelengths=wavelengths,
        values=np.broadcast_to(table.values, shape).astype(np.float32),
        is_orthotropic=len(rotations) > 1,
    )
    if part.direct is None:
        return table
    shares = part.direct(table.incidences)
    if shares.shape[1] > 1:
        shares = shares[:, bands] if len(bands) > 1 else shares.mean(axis=1, keepdims=True)
    direct = np.broadcast_to(shares, (shape[0], shape[1], shape[4])).astype(np.float32)
    return replace(table, direct=direct)


def _spectra(part: Part, table: ScatterTable, bands: np.ndarray) -> np.ndarray:
    """Values on a table's grid over their mean over all wavelengths. (p, s, t, a, w)"""
    grid = np.meshgrid(
        table.rotations, table.incidences, table.radials, table.azimuths, indexing="ij"
    )
    rotation, incidence, radial, azimuth = (axis.ravel() for axis in grid)
    wi = np.stack([np.sin(incidence), 0.0 * incidence, np.cos(incidence)], axis=1)
    wo = direction_of(incidence, radial, azimuth)
    # What lies below the horizon has the spectrum of what is just above.
    wo[:, 2] = np.maximum(wo[:, 2], LOWEST)
    wi, wo = turned(wi, rotation), turned(unit(wo), rotation)
    values = part.evaluate(wi, wo)
    mean = values.mean(axis=1, keepdims=True)
    ratio = np.where(mean > 0.0, values / np.maximum(mean, 1e-30), 1.0)
    ratio = ratio[:, bands] if ratio.shape[1] > 1 else np.repeat(ratio, len(bands), axis=1)
    return ratio.reshape(*table.values.shape[:4], len(bands))


def keep_energy(parts: dict[str, Part | Sheeting], made: dict) -> dict:
    """Scale tables down where a side would send away more light than comes, by rotation, incidence and wavelength.

    Between incidences tables may be a little above what they were made from.
    """
    shares: dict = {}
    for side in ("front", "back"):
        own = [parts[name] for name in parts if name.startswith(side)]
        own = [part for part in own if isinstance(made[part], ScatterTable)]
        if own:
            share = 1.0 / np.maximum(sum(_totals(made[part]) for part in own), 1.0)
            # Kept between incidences too: by the larger of both sides.
            share = np.minimum(share[:, ::2], np.minimum(_shifted(share, 1), _shifted(share, -1)))
            for part in own:
                shares[part] = np.minimum(share, shares.get(part, 1.0))
    kept = dict(made)
    for part, share in shares.items():
        table = made[part]
        direct = None if table.direct is None else (table.direct * share).astype(np.float32)
        values = (table.values * share[:, :, None, None, :]).astype(np.float32)
        kept[part] = replace(table, values=values, direct=direct)
    return kept


def _totals(table: ScatterTable) -> np.ndarray:
    """Totals at the incidences and in the middles between them. (p, 2 s - 1, w)"""
    axis = table.incidences
    places = np.sort(np.concatenate([axis, 0.5 * (axis[1:] + axis[:-1])]))
    return totals(table, places, table.rotations)


def _shifted(share: np.ndarray, step: int) -> np.ndarray:
    """Shares in the middles before or after incidences, 1 beyond the ends."""
    ends = np.pad(share[:, 1::2], ((0, 0), (1, 1), (0, 0)), constant_values=1.0)
    return ends[:, 1:] if step > 0 else ends[:, :-1]


def write(folder: Path, only: set[str] = frozenset()) -> list[Path]:
    """Write the catalogue and the files, of some materials by name only; return their places."""
    (folder / "files").mkdir(parents=True, exist_ok=True)
    paths = [folder / LIST]
    catalogue = {**DEFAULTS, "materials": [recipe.entry for recipe in recipes()]}
    text = json.dumps(catalogue, indent=1, ensure_ascii=False)
    paths[0].write_bytes(f"{text}\n".encode())
    for recipe in recipes():
        if recipe.make is not None and (not only or recipe.name in only):
            path = folder / "files" / f"{recipe.name}{SUFFIX}"
            write_store(path, make_file(recipe, path))
            paths.append(path)
            print(f"{path}  {path.stat().st_size / 1e3:.1f} kB", flush=True)
    return paths
