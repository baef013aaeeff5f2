"""A scene by both programs: how far means and blocks of their pictures are apart."""

from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ...blender_addon.sync.scene import convert_scene
from ...engine.photometry.colour import REC709_LUMINANCE
from .stage import SIDE

BLOCK = 8
"""Side of the squares that are compared. [pixel]"""

WHITE = 1.0
"""Ground that pictures are laid over."""

OURS, CYCLES = "LUMENRAY", "CYCLES"

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
    return np.stack([_render(engine, seed, folder) for seed in (1, 2)])


def _render(engine: str, seed: int, folder: Path) -> np.ndarray:
    scene = bpy.context.scene
    render = scene.render
    render.engine = engine
    if hasattr(render.image_settings, "media_type"):
        render.image_settings.media_type = "IMAGE"
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_depth, render.image_settings.color_mode = "32", "RGBA"
    render.filepath = str(folder / f"{engine}.exr")
    if engine == CYCLES:
        _be_exact(scene.cycles, seed)
    else:
        scene.lumenray.render.samples, scene.lumenray.seed = SAMPLES[OURS], seed
        scene.lumenray.white_luminance = scene.lumenray.efficacy
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(render.filepath, check_existing=False)
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    pixels = pixels.reshape(height, width, -1).astype(np.float64)
    # Colours are multiplied by alpha already.
    return pixels[..., :3] + (1.0 - pixels[..., 3:4]) * WHITE


def _be_exact(settings, seed: int) -> None:
    """Take away what Cycles does for speed."""
    settings.samples, settings.seed, settings.device = SAMPLES[CYCLES], seed, "CPU"
    settings.use_denoising = settings.use_adaptive_sampling = False
    settings.sample_clamp_direct = settings.sample_clamp_indirect = settings.blur_glossy = 0.0
    settings.light_sampling_threshold = 0.0
    settings.caustics_reflective = settings.caustics_refractive = True
    for name in ("max", "diffuse", "glossy", "transmission", "volume", "transparent_max"):
        setattr(settings, f"{name}_bounces", 128)
