"""Pictures of the office by Lumenray and by Cycles, with the processor time that they took.

Processor time is that of all cores together: other programs on the machine hardly change it.
"""

import os
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import bpy
import numpy as np
import OpenEXR

from ...blender_addon.foundation.exposure import white_luminance
from ...blender_addon.sync.scene import convert_scene
from ...command_line.blend_file import open_blend, quiet
from ...engine.accuracy.stopping import StopRule
from ...engine.analysis.block_means import keep_means
from ...engine.analysis.denoiser import denoise
from ...engine.photometry.colour import REC709_LUMINANCE, scene_linear
from ...engine.session import Session
from ...engine.views import ViewSettings
from ...libraries.scenes import scene_path

REFERENCE_SEED = 1000
"""Of the first picture that others are held against."""

TRIALS = 4, 16
"""Samples of the pictures that tell what a sample of Cycles costs, and all else."""

BOUNCES = 64
"""Of Cycles; ours have no limit."""


def processor_time() -> float:
    """Processor time of this process and of those that it waited for. [s]"""
    return sum(os.times()[:4])


class Lumenray:
    """Our pictures, by a session that has its kernels already."""

    def __init__(self, size: tuple[int, int]):
        depsgraph = open_blend(scene_path("office"))
        converted = convert_scene(depsgraph)
        self._camera = replace(
            converted.camera,
            width=size[0],
            height=size[1],
            extent_y=converted.camera.extent_x * size[1] / size[0],
        )
        self.white = white_luminance(depsgraph.scene.lumenray)
        self._session = Session()
        self._session.apply(converted.delta)
        self._is_warm = False

    def reference(self, samples: int) -> dict:
        """Return ``colour`` and the standard ``error`` of its luminance."""
        made = self._render(samples, REFERENCE_SEED)
        return {"colour": self._expose(made), "error": made.luminance_error / self.white}

    def picture(self, samples: int) -> dict:
        """Return ``raw``, ``network`` (denoised), ``shown`` (with kept means), ``stated`` error, and their ``seconds``."""
        if not self._is_warm:
            self._render(2, 0)
            self._is_warm = True
        begin = processor_time()
        made = self._render(samples, 0)
        raw, rendered = self._expose(made), processor_time()
        network = denoise(raw, made.denoising_normal, made.denoising_albedo)
        shown = keep_means(network, raw)
        return {
            "raw": raw,
            "network": network,
            "shown": shown,
            "stated": made.relative_error,
            "seconds": [rendered - begin, processor_time() - rendered],
        }

    def _render(self, samples: int, seed: int):
        settings = ViewSettings(StopRule(samples=samples), seed=seed, guides=True)
        return self._session.render(self._camera, settings)

    def _expose(self, made) -> np.ndarray:
        return scene_linear(made.tristimulus, self.white)


class Cycles:
    """Pictures by Cycles of the same file: no clamping, its light tree, its denoiser as Blender sets it at first."""

    def __init__(self, size: tuple[int, int]):
        open_blend(scene_path("office"))
        self._scene = scene = bpy.context.scene
        render, cycles = scene.render, scene.cycles
        render.engine, cycles.device = "CYCLES", "CPU"
        render.resolution_x, render.resolution_y, render.resolution_percentage = *size, 100
        render.use_persistent_data = True
        cycles.use_adaptive_sampling = False
        cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.0
        for name in ("max", "diffuse", "glossy", "transmission", "transparent_max"):
            setattr(cycles, f"{name}_bounces", BOUNCES)
        bpy.context.view_layer.cycles.denoising_store_passes = True
        image = render.image_settings
        if hasattr(image, "media_type"):
            image.media_type = "MULTI_LAYER_IMAGE"
        image.file_format, image.color_depth = "OPEN_EXR_MULTILAYER", "32"
        self._cost = None

    def reference(self, samples: int) -> dict:
        """Return ``colour`` and the standard ``error`` of its luminance, of two halves."""
        halves = [self._render(samples // 2, REFERENCE_SEED + k, False)["Combined"] for k in (0, 1)]
        error = 0.5 * np.abs((halves[0] - halves[1]) @ REC709_LUMINANCE)
        return {"colour": 0.5 * (halves[0] + halves[1]), "error": error}

    def picture(self, seconds: float) -> dict:
        """Return ``raw``, ``shown`` (denoised), ``samples`` and ``seconds`` of a picture that takes so much time."""
        if self._cost is None:
            self._render(1, 0, True)
            spent = [self._timed(n)[1] for n in TRIALS]
            each = (spent[1] - spent[0]) / (TRIALS[1] - TRIALS[0])
            self._cost = each, spent[0] - each * TRIALS[0]
        samples = max(round((seconds - self._cost[1]) / self._cost[0]), 1)
        made, taken = self._timed(samples)
        return {
            "raw": made["Noisy Image"],
            "shown": made["Combined"],
            "seconds": taken,
            "samples": samples,
        }

    def _timed(self, samples: int) -> tuple[dict, float]:
        begin = processor_time()
        made = self._render(samples, 0, True)
        return made, processor_time() - begin

    def _render(self, samples: int, seed: int, is_denoised: bool) -> dict:
        """Colours by the name of their pass."""
        cycles = self._scene.cycles
        cycles.samples, cycles.seed, cycles.use_denoising = samples, seed, is_denoised
        with TemporaryDirectory() as folder:
            path = Path(folder, "picture.exr")
            self._scene.render.filepath = str(path)
            with quiet():
                bpy.ops.render.render(write_still=True)
            with OpenEXR.File(str(path), separate_channels=True) as file:
                channels = {
                    name.split(".", 1)[1]: channel.pixels.copy()
                    for part in file.parts
                    for name, channel in part.channels.items()
                }
        names = {name.rpartition(".")[0] for name in channels} & {"Combined", "Noisy Image"}
        # Row 0 is the upper one in files.
        return {n: np.stack([channels[f"{n}.{c}"][::-1] for c in "RGB"], axis=-1) for n in names}
