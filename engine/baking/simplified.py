"""What maps may be off by because the scene was simplified, or because files of lamps have few rays."""

from dataclasses import replace

import numpy as np

from ..atlas.lumels import LumelTable
from ..scene.sensor import SensorKind
from ..transport.sensors.file_errors import find_file_errors, has_open_files
from .estimates import Estimates
from .means import ObjectMean


def hold_simplifications(
    estimates: Estimates, means: list[ObjectMean], floors: np.ndarray, bound: float
) -> tuple[Estimates, np.ndarray]:
    """Let the errors of lumels and of the means of maps hold the share ``bound`` of their light. [-]

    Parameters
    ----------
    floors : (m,) array    What the error of each mean must be at least by others. [lx]
    """
    if not bound:
        return estimates, floors
    error = np.hypot(estimates.standard_error, np.float32(bound) * estimates.illuminance)
    own = np.array([each.mean for each in means])
    return replace(estimates, standard_error=error), np.hypot(floors, bound * own)


def hold_file_errors(
    estimates: Estimates, means: list[ObjectMean], floors: np.ndarray, table: LumelTable, scene
) -> tuple[Estimates, np.ndarray]:
    """Let the errors of lumels and of the means of maps hold what ray files leave open of the light, see `file_errors`.

    Parameters
    ----------
    floors : (m,) array    What the error of each mean must be at least by others. [lx]
    table : LumelTable    Of the lumels.
    scene : CompiledScene
    """
    if not has_open_files(scene):
        return estimates, floors
    errors, first, bends = np.zeros(len(estimates.illuminance)), 0, _has_curved(scene)
    for number, count in enumerate(table.counts):
        held, part = table.block(number).receivers, slice(first, first + count)
        # The first place stands for its lumel.
        places = held.positions[held.start], held.normals[held.start]
        found = estimates.illuminance[part]
        errors[part] = find_file_errors(scene, *places, SensorKind.PLANAR, found, bends)
        first += count
    # Lumels beside each other see the same part of a lamp's light, so their errors do not cancel.
    own = [(errors[e.rows] @ e.areas) / max(e.areas.sum(), 1e-300) for e in means]
    error = np.hypot(estimates.standard_error, errors.astype(np.float32))
    return replace(estimates, standard_error=error), np.hypot(floors, own)


def _has_curved(scene) -> bool:
    """Whether glass or mirrors that are not flat may send light of lamps on."""
    return any(
        material.surface.is_bending and (part.planes is None or (part.planes < 0).any())
        for _, part, material in scene.parts()
    )
