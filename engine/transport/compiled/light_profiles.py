"""What is known of lights before anything is traced: where they are, and coarsely how much they send which way."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...luminaires.emitters.distribution_arrays import FLOOR
from ...luminaires.emitters.palette import LuminairePalette
from .light_tree import map_directions

PLAIN, FLAT, CONE = range(3)
"""How a light sends light: evenly (luminaires: by their distribution), by the cosine to its axis, or into a cone."""

LAMBERTIAN = 4.0
"""Intensity of a flat emitter along its axis over its mean over all directions."""

FAR = 1e3
"""Distance over size from which the directions of a profile are those from the centre."""

BATCH = 1 << 12
"""Lights whose profiles are made at a time."""


def columns_of(sources) -> dict[str, np.ndarray]:
    """Put what is known of sources into arrays.

    Returns
    -------
    dict    ``flux``, ``radius``, ``kind``, ``cone`` (n,), ``centre``, ``axis`` (n, 3); 0 where there is none.
    """
    nothing = np.zeros(3)
    kinds = [
        PLAIN if source.axis is None else FLAT if source.cone is None else CONE
        for source in sources
    ]
    return {
        "flux": np.array([source.flux for source in sources], dtype=np.float64),
        "radius": np.array([source.radius for source in sources], dtype=np.float64),
        "kind": np.array(kinds),
        "cone": np.array([0.0 if s.cone is None else s.cone for s in sources], dtype=np.float64),
        "centre": np.array([nothing if s.centre is None else s.centre for s in sources], float),
        "axis": np.array([nothing if s.axis is None else s.axis for s in sources], float),
    }


def cone_intensity(cosine):
    """Intensity in a cone over the mean over all directions. ``cosine``: of its half angle."""
    return 2.0 / np.maximum(1.0 - cosine, 1e-6)


def make_profiles(columns: dict, rows: list, palette: LuminairePalette | None):
    """Make the intensities relative to their mean over the directions of a `LightTree`'s maps.

    Parameters
    ----------
    columns : dict    Of `columns_of`; the last lights are the luminaires.
    rows : list of Row    The luminaires.

    Returns
    -------
    (k, cells) float32 array, (n,) int array    The profiles, and which of them each light has.
    """
    cells = map_directions()
    made = [np.ones((1, len(cells)), dtype=np.float32)]
    which = np.zeros(len(columns["kind"]), dtype=np.int64)
    shaped = np.flatnonzero(columns["kind"] != PLAIN)
    table = np.column_stack([columns[name][shaped] for name in ("axis", "kind", "cone")])
    shapes, which_shape = np.unique(table, axis=0, return_inverse=True)
    which[shaped] = 1 + which_shape.reshape(-1)
    for start in range(0, len(shapes), BATCH):
        axis, kind, cone = np.split(shapes[start : start + BATCH], [3, 4], axis=1)
        cosine = np.einsum("ka,cfa->kcf", axis, cells)
        kind, cone = kind[:, None], cone[:, None]
        in_cone = np.where(cosine >= cone, cone_intensity(cone), FLOOR)
        value = np.where(kind == FLAT, LAMBERTIAN * np.maximum(cosine, 0.0), in_cone)
        made.append(value.mean(axis=2).astype(np.float32))
    if rows:
        known: dict[tuple, int] = {}
        examples = []
        for i, row in enumerate(rows):
            key = (row.digest, row.grid.tobytes())
            if key not in known:
                known[key] = len(known)
                examples.append(i)
            which[i - len(rows)] = 1 + len(shapes) + known[key]
        made.append(_luminaire_profiles(np.array(examples), rows, palette, cells))
    return np.concatenate(made), which


def _luminaire_profiles(examples, rows, palette, cells) -> np.ndarray:
    """Profiles of some luminaires, as the palette knows them from afar. (k, cells) float32"""
    directions = cells.reshape(-1, 3)
    made = []
    for start in range(0, len(examples), BATCH):
        some = examples[start : start + BATCH]
        distance = np.array([FAR * max(rows[i].radius, 1.0) for i in some])
        lane = dr.arange(mi.UInt32, len(some) * len(directions))
        many = dr.opaque(mi.UInt32, len(directions))
        row = dr.gather(mi.UInt32, upload(mi.UInt32, some), lane // many)
        away = dr.gather(mi.Vector3f, upload(mi.Float, directions), lane % many)
        away *= dr.gather(mi.Float, upload(mi.Float, distance), lane // many)
        value = np.array(palette.importance(row, away))
        made.append(value.reshape(len(some), *cells.shape[:2]).mean(axis=2))
    return np.concatenate(made)
