"""Plans of sensors in false colours with isolux lines: as files, and as images of Blender."""

from pathlib import Path

import bpy
import numpy as np

from ...engine.analysis.canvas import to_pixels
from ...engine.analysis.sheet import Sheet
from ...engine.analysis.value_plan import draw_grid
from ...engine.formats.names import file_stem
from ...engine.light_mix import NEUTRAL, LightMix
from ..rendering.light_mix import levels_of
from .drawing import axes_of
from .readings import Readings, readings_of
from .settings import find_sensors
from .words import TITLES, brief

PREFIX = "Plan "
"""Beginning of the names of images."""


def has_plan(readings: Readings) -> bool:
    """Whether the sensors stand in a grid, of which there is a plan."""
    return (
        not readings.is_distribution
        and min(readings.shape) > 1
        and bool(np.isfinite(readings.values).any())
    )


def draw_plan(name: str, readings: Readings, levels: LightMix = NEUTRAL) -> Sheet:
    """Draw the plan of a grid, as seen from the side that its plane faces."""
    values, _ = readings.mixed(levels)
    figures = readings.figures(levels)
    caption = brief(readings, levels)
    if not readings.is_rating:
        caption = (
            f"mean {figures.mean:.4g} {readings.unit} (error {figures.mean_error:.2g}), "
            f"{figures.least.value:.4g} to {figures.largest.value:.4g} {readings.unit}, "
            f"U0 {figures.overall.value:.2f}, Ud {figures.diversity.value:.2f}"
        )
    caption = f"{TITLES[readings.quantity].lower()}: {caption}"
    mixed = levels.text() if readings.groups != ("",) else ""
    if mixed:
        caption += f"; {mixed}"
    x, y = axes_of(readings)
    return draw_grid(name, x, y, readings.grid(values), caption, unit=readings.unit)


def write_plans(folder, plans) -> list[Path]:
    """Write plans (name, Sheet), each as PNG and SVG, into a folder; return the paths.

    Raises
    ------
    FileFormatError    A file cannot be written.
    """
    return [
        sheet.save(Path(folder) / f"{file_stem(name)}.{end}")
        for name, sheet in plans
        for end in ("png", "svg")
    ]


def show_plans(scene) -> list:
    """Make an image of the plan of every grid of a scene, in the place of an earlier one; return the images."""
    levels = levels_of(scene)
    made = []
    for empty in find_sensors(scene):
        readings = readings_of(empty)
        if readings is not None and has_plan(readings):
            sheet = draw_plan(empty.name, readings, levels)
            made.append(_to_image(f"{PREFIX}{empty.name}", sheet))
    return made


def _to_image(name: str, sheet: Sheet):
    """Put a sheet into an image of Blender, which the file keeps."""
    pixels = to_pixels(sheet.to_picture())
    height, width = pixels.shape[:2]
    image = bpy.data.images.get(name)
    if image is None or (image.source != "GENERATED" and not image.packed_file):
        image = bpy.data.images.new(name, width, height)
    if tuple(image.size) != (width, height):
        image.scale(width, height)
    image.pixels.foreach_set(np.ascontiguousarray(pixels).ravel())
    image.update()
    image.pack()
    return image
