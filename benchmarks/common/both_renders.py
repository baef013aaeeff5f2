"""The scene that is open in Blender's Python module, rendered by either program."""

from pathlib import Path

import bpy
import numpy as np

OURS, CYCLES = "LUMENRAY", "CYCLES"


def render(engine: str, samples: int, seed: int, folder: Path) -> np.ndarray:
    """Render the scene that is open; colours are multiplied by alpha. (h, w, 4), row 0 at the bottom

    Parameters
    ----------
    engine : str    `OURS` or `CYCLES`.
    samples : int    Of every pixel.
    seed : int
    folder : Path    Where the picture may be written.
    """
    scene = bpy.context.scene
    settings = scene.render
    settings.engine = engine
    if hasattr(settings.image_settings, "media_type"):
        settings.image_settings.media_type = "IMAGE"
    settings.image_settings.file_format = "OPEN_EXR"
    settings.image_settings.color_depth, settings.image_settings.color_mode = "32", "RGBA"
    settings.filepath = str(folder / f"{engine}.exr")
    if engine == CYCLES:
        _be_exact(scene.cycles, samples, seed)
    else:
        scene.lumenray.render.stop, scene.lumenray.render.samples = "SAMPLES", samples
        scene.lumenray.seed = seed
        scene.lumenray.exposure = "LUMINANCE"
        scene.lumenray.white_luminance = scene.lumenray.efficacy
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(settings.filepath, check_existing=False)
    width, height = image.size
    pixels = np.empty(width * height * image.channels, np.float32)
    image.pixels.foreach_get(pixels)
    bpy.data.images.remove(image)
    return pixels.reshape(height, width, -1).astype(np.float64)


def _be_exact(settings, samples: int, seed: int) -> None:
    """Take away what Cycles does for speed."""
    settings.samples, settings.seed, settings.device = samples, seed, "CPU"
    settings.use_denoising = settings.use_adaptive_sampling = False
    settings.sample_clamp_direct = settings.sample_clamp_indirect = settings.blur_glossy = 0.0
    settings.light_sampling_threshold = 0.0
    settings.caustics_reflective = settings.caustics_refractive = True
    for name in ("max", "diffuse", "glossy", "transmission", "volume", "transparent_max"):
        setattr(settings, f"{name}_bounces", 128)
