"""What a ray file leaves open of the light at places: where between its rays light goes is known to so many rays only.

How well is told when the set is made ready (`RayEmission.information_error`, theory 6.9): of light in a cell with a 192nd of
it, and places see no wider part of the lamp's light. So the light that comes straight from a lamp is known within that share
of it; where less goes than on the mean, fewer rays tell it, and the share grows with the root. Lamps of one set send
the same error wherever they send the same part of it, so theirs add up; errors of different sets have nothing in common, and
add as squares. What is reflected is a mean over much of the lamp's light, of which the whole is known, and is left out.
"""

import numpy as np

from ...luminaires.distribution import (
    azimuth_weights,
    flux,
    intensity,
    peak,
    polar_weights,
)
from ...scene.scene import content_digest
from ...scene.sensor import SensorKind

CLOSE = 5.0
"""Distance over the size of a lamp below which no point tells what it gives, nor from which side. [-]"""

FEWEST_CLOSE = 0.5
"""Least distance over its size that is told apart. [-]"""

CHUNK = 1 << 16
"""Places that are looked at together."""


def find_file_errors(scene, positions, normals, kind: SensorKind, found, bends: bool) -> np.ndarray:
    """What the errors of illuminances must hold for want of rays in the files of lamps.

    Nothing is asked about shadows, so it is too much where light does not arrive, but never more than if all that was found
    came from the lamps. That is taken for it too where mirrors or bodies of glass send their light to places on other ways.

    Parameters
    ----------
    scene : CompiledScene
    positions, normals : (n, 3) array    In the world. [m]
    kind : SensorKind
    found : (n,) array    Illuminance. [lx]
    bends : bool    Whether bodies of glass or curved mirrors may send light of lamps to places.

    Returns
    -------
    (n,) array    [lx]
    """
    found = np.maximum(np.asarray(found, dtype=np.float64), 0.0)
    sets = _find_sets(scene)
    errors = np.zeros(len(found))
    if not sets:
        return errors
    # What panes mirror is little, and little light of lamps comes by way of them.
    goes_on = bends or (scene.mirrors is not None and not scene.mirrors.are_panes)
    places = scene.local(positions).astype(np.float64)
    normals = np.asarray(normals, dtype=np.float64)
    for rows in sets:
        share = np.ones(len(found))
        if not goes_on:
            for first in range(0, len(found), CHUNK):
                part = slice(first, first + CHUNK)
                made = [_receive(row, places[part], normals[part], kind) for row in rows]
                straight, unsure = np.sum(made, axis=0)
                # Light that does not arrive is as sure as the rest of it.
                share[part] = unsure / np.maximum(straight, np.maximum(found[part], 1e-300))
        errors = np.hypot(errors, rows[0].rays.open_error * share * found)
    return errors


def has_open_files(scene) -> bool:
    """Whether any lamp at work has rays between which light is not known."""
    return bool(_find_sets(scene))


# ---- private ----


def _find_sets(scene) -> list[list]:
    """Rows of the lamps at work, by the set whose rays they send."""
    sets: dict[bytes, list] = {}
    for _, source in scene.named_sources():
        row = source.luminaire
        if (
            row is not None
            and row.amount > 0.0
            and row.rays is not None
            and row.rays.open_error > 0.0
        ):
            sets.setdefault(content_digest(row.rays), []).append(row)
    return list(sets.values())


def _receive(row, places: np.ndarray, normals: np.ndarray, kind: SensorKind) -> np.ndarray:
    """Illuminance by a lamp that nothing shades, at most that close by, and what its share is taken of. (2, n) [lx]"""
    away = places - row.centre
    distance = np.linalg.norm(away, axis=1)
    unit = away / np.maximum(distance, 1e-300)[:, None]
    size = row.rays.size
    whole = max(flux(row.distribution), 1e-300)
    scale = row.amount / whole
    candela = intensity(row.distribution, unit @ row.rotation)
    weak = np.sqrt(candela * np.maximum(candela, _mean_intensity(row.distribution) / whole))
    over = _respond(kind, -unit, normals) / np.maximum(distance, 1e-300) ** 2
    most = peak(row.distribution)[0] / np.maximum(distance - size, FEWEST_CLOSE * size) ** 2
    is_close = distance < CLOSE * size
    return scale * np.where(is_close, most, over * np.stack([candela, weak]))


def _mean_intensity(distribution) -> float:
    """Integral of the square of the intensity: over the flux, the mean of the intensity by its own light. [cd2 sr]"""
    square = azimuth_weights(distribution.azimuth) @ distribution.intensity**2
    return float(square @ polar_weights(distribution.polar))


def _respond(kind: SensorKind, towards: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """How much intensity from a direction counts. (n, 3), (n, 3) -> (n,) [-] (EN 12665)"""
    if kind is SensorKind.PLANAR:
        length = np.maximum(np.linalg.norm(normals, axis=1), 1e-300)
        return np.maximum((towards * normals).sum(axis=1) / length, 0.0)
    if kind is SensorKind.SPHERICAL:
        return np.full(len(towards), 0.25)
    sine = np.hypot(towards[:, 0], towards[:, 1])
    if kind is SensorKind.CYLINDRICAL:
        return sine / np.pi
    ahead = normals[:, :2] / np.maximum(np.linalg.norm(normals[:, :2], axis=1), 1e-300)[:, None]
    return np.maximum(sine + (towards[:, :2] * ahead).sum(axis=1), 0.0) / np.pi
