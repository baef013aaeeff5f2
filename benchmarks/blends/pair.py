"""A .blend file as it is, by both programs, under the same camera and exposure."""

import math
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np
from mathutils import Vector

from ...blender_addon.sync.scene import convert_scene
from ...engine.errors import LumenrayError
from ...engine.photometry.colour import REC709_LUMINANCE
from ..common.both_renders import CYCLES, OURS, render

WIDTH, HEIGHT = 192, 128
"""Most that a picture may have. [pixel]"""

BLOCK = 8
"""Side of the squares that are compared. [pixel]"""

SAMPLES = {OURS: 48, CYCLES: 96}
"""Samples per pixel of each of two pictures."""


@dataclass(frozen=True)
class Pair:
    """What a file gave.

    Parameters
    ----------
    means : (float, float)    Mean luminance of Cycles' picture and of ours, by the lumens per watt of the file. [cd/m2]
    mean, mean_error : float    Difference of the means, relative to Cycles', and what noise makes of it. [-]
    block : float    Root of the mean square over blocks, without what noise makes of it, likewise. [-]
    has_camera : bool    Whether the file has one; else one that sees everything was added.
    said : tuple of str    Rows of the conversion report, the worst first.
    pictures : (2, h, w, 3) array    Cycles' and ours, linear, over black.
    """

    means: tuple[float, float]
    mean: float
    mean_error: float
    block: float
    has_camera: bool
    said: tuple[str, ...]
    pictures: np.ndarray


def compare(path: Path, folder: Path) -> Pair:
    """Render a file twice by each program. ``folder``: for pictures on the way.

    Raises
    ------
    LumenrayError    Blender cannot open it.
    """
    _open(path)
    scene = bpy.context.scene
    has_camera = scene.camera is not None
    if not has_camera:
        _add_camera(scene)
    _make_small(scene.render)
    bpy.context.view_layer.update()
    made = convert_scene(bpy.context.evaluated_depsgraph_get())
    said = tuple(row.text() for row, _ in made.report.by_weight)
    pairs = {}
    for engine in (CYCLES, OURS):
        shots = [render(engine, SAMPLES[engine], seed, folder) for seed in (1, 2)]
        pairs[engine] = np.stack(shots)[..., :3]
    return judge(pairs[CYCLES], pairs[OURS], scene.lumenray.efficacy, has_camera, said)


def judge(theirs, ours, efficacy: float, has_camera: bool, said) -> Pair:
    """Compare two pictures of each program. (2, h, w, 3) each; ``efficacy``: luminance of 1. [cd/m2]"""
    (cycles, cycles_noise), (own, own_noise) = _blocks(theirs), _blocks(ours)
    noise = cycles_noise + own_noise
    # What is black in both is alike.
    scale = float(cycles.mean()) or float(own.mean()) or 1.0
    square = float(((own - cycles) ** 2).mean()) - noise
    return Pair(
        (efficacy * float(cycles.mean()), efficacy * float(own.mean())),
        float(own.mean() - cycles.mean()) / scale,
        math.sqrt(noise / own.size) / scale,
        math.sqrt(max(square, 0.0)) / scale,
        has_camera,
        said,
        np.stack([theirs.mean(axis=0), ours.mean(axis=0)]),
    )


def _blocks(pair: np.ndarray) -> tuple[np.ndarray, float]:
    """Luminance of whole blocks, and the variance that the noise of a mean of both pictures has there."""
    height, width = (side // BLOCK for side in pair.shape[1:3])
    cut = pair[:, : height * BLOCK, : width * BLOCK] @ REC709_LUMINANCE
    luminance = cut.reshape(2, height, BLOCK, width, BLOCK).mean(axis=(2, 4))
    half = 0.5 * (luminance[0] - luminance[1])
    return luminance.mean(axis=0), float((half**2).mean())


def _open(path: Path) -> None:
    try:
        bpy.ops.wm.open_mainfile(filepath=str(path.resolve()), load_ui=False, use_scripts=False)
    except RuntimeError as error:
        raise LumenrayError(f"{path}: Blender cannot open it ({str(error).strip()})") from None
    bpy.ops.preferences.addon_enable(module="cycles")


def _make_small(settings) -> None:
    """Bring the picture below the largest size, whole and as the camera gives it."""
    share = min(WIDTH / settings.resolution_x, HEIGHT / settings.resolution_y, 1.0)
    settings.resolution_x = max(round(settings.resolution_x * share), BLOCK)
    settings.resolution_y = max(round(settings.resolution_y * share), BLOCK)
    settings.resolution_percentage = 100
    settings.use_border = settings.use_compositing = settings.use_sequencer = False
    settings.use_motion_blur = False


def _add_camera(scene) -> None:
    """Look at everything from the front right above."""
    corners = np.array(
        [
            item.matrix_world @ Vector(corner)
            for item in scene.objects
            if item.type == "MESH" and not item.hide_render
            for corner in item.bound_box
        ]
    )
    if not len(corners):
        corners = np.array([[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]])
    low, high = corners.min(axis=0), corners.max(axis=0)
    middle, radius = Vector(0.5 * (low + high)), 0.5 * float(np.linalg.norm(high - low))
    data = bpy.data.cameras.new("Camera")
    away = Vector((1.0, -1.4, 0.9)).normalized()
    distance = radius / math.sin(0.5 * min(data.angle_x, data.angle_y))
    data.clip_end = max(data.clip_end, 4.0 * distance)
    camera = bpy.data.objects.new("Camera", data)
    camera.location = middle + distance * away
    camera.rotation_euler = away.to_track_quat("Z", "Y").to_euler()
    scene.collection.objects.link(camera)
    scene.camera = camera
