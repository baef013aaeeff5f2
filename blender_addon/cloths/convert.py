"""Cloths of Blender as surfaces of the engine."""

from dataclasses import replace

import numpy as np

from ...engine.scene.material import Measured
from ..compositions.convert import obtain_table
from ..foundation.report import ConversionReport
from .tables import cloth_tables


def convert_cloth(
    settings, report: ConversionReport, datablock: str, remedy: str, is_patient: bool = True
) -> Measured | None:
    """Convert the composition of a material; parameters as of `compositions.convert.obtain_table`.

    Returns
    -------
    Measured or None    None when it cannot be computed, or is not yet.
    """
    woven = obtain_table(cloth_tables, settings, report, datablock, remedy, is_patient)
    if woven is None:
        return None
    report.info(
        datablock,
        "its warp runs along V of the UV map",
        "meshes without a UV map take the world's X for the weft",
    )
    surface = woven.surface
    # Sides that are one table did not come through the border between processes as one.
    shared = {
        f"back_{part}": getattr(surface, f"front_{part}")
        for part in ("reflection", "transmission")
        if _is_one(surface, part)
    }
    return replace(surface, rotation=settings.turn, **shared)


def _is_one(surface: Measured, part: str) -> bool:
    """Whether both sides hold the same."""
    front, back = (getattr(surface, f"{side}_{part}") for side in ("front", "back"))
    return front.values.shape == back.values.shape and np.array_equal(front.values, back.values)
