"""A scene by both programs: how far means and blocks of their pictures are apart."""

from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ...blender_addon.sync.scene import convert_scene
from ...engine.photometry.colour import REC709_LUMINANCE
from ..common.both_renders import CYCLES, OURS, render
from .stage import SIDE

BLOCK = 8
"""Side of the squares that are compared. [pixel]"""

WHITE = 1.0
"""Ground that pictures are laid over."""

SAMPLES = {OURS: 256, CYCLES: 512}
"""Samples per pixel of each of two pictures."""


@dataclass(frozen=True)
class Comparison:
    """Differences, relative to the mean of Cycles' picture.

    Parameters
    ----------
    mean, mean_error : float    Of the whole picture, and what noise makes of it. [-]
    block : float    Root of the mean square over blocks, without what noise makes of it. [-]
    said : tuple of str    Rows of the conversion report.
    pictures : (2, h, w, 3) array    Ours and that of Cycles, linear, over white.
    """

    mean: float
    mean_error: float
    block: float
    said: tuple[str, ...]
    pictures: np.ndarray


def compare(folder: Path) -> Comparison:
    """Render the scene that is open by both programs, twice each."""
    said = report_of()
    pairs = {name: _pair(name, folder) for name in (OURS, CYCLES)}
    (ours, ours_noise), (theirs, theirs_noise) = (_blocks(pairs[name]) for name in (OURS, CYCLES))
    scale = max(float(theirs.mean()), 1e-9)
    noise = ours_noise + theirs_noise
    square = ((ours - theirs) ** 2).mean() - noise
    return Comparison(
        float(ours.mean() / scale - 1.0),
        float(np.sqrt(noise / ours.size) / scale),
        float(np.sqrt(max(square, 0.0)) / scale),
        said,
        np.stack([pairs[name].mean(axis=0) for name in (OURS, CYCLES)]),
    )


def report_of() -> tuple[str, ...]:
    """Rows of the conversion of the scene that is open."""
    bpy.context.view_layer.update()
    made = convert_scene(bpy.context.evaluated_depsgraph_get())
    return tuple(row.text() for row, _ in made.report.by_weight)


def _blocks(pair: np.ndarray) -> tuple[np.ndarray, float]:
    """Luminance of blocks, and the variance that the noise of a mean of both pictures has there."""
    count = SIDE // BLOCK
    luminance = (pair @ REC709_LUMINANCE).reshape(2, count, BLOCK, count, BLOCK).mean(axis=(2, 4))
    half = 0.5 * (luminance[0] - luminance[1])
    return luminance.mean(axis=0), float((half**2).mean())


def _pair(engine: str, folder: Path) -> np.ndarray:
    """Two pictures of other seeds. (2, SIDE, SIDE, 3)"""
    pictures = np.stack([render(engine, SAMPLES[engine], seed, folder) for seed in (1, 2)])
    return pictures[..., :3] + (1.0 - pictures[..., 3:4]) * WHITE
