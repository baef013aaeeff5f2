"""Pictures of materials: a ball under a lamp and a window, all exposed alike, so that they compare."""

from pathlib import Path

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.analysis.false_colour import write_display
from ...engine.analysis.noise_filter import smooth
from ...engine.photometry.colour import scene_linear
from ...engine.scene.scene import SceneDelta
from ...engine.session import Session, ViewSettings
from ...libraries.materials import Entry
from .material_stage import is_seen_through, lets_through, set_material_stage, surface_of
from .thumbnails import film

SIZE = 160
"""Of a picture. [pixel]"""

FINER = 2
"""Pixels of the render in one of the picture, along each side."""

SAMPLES = 96
"""Paths per pixel of the render."""

WHITE = 330.0
"""Luminance that becomes 1 before the film. [cd/m2]"""


def render_material(entry: Entry, samples: int = SAMPLES, size: int = SIZE) -> np.ndarray:
    """Render a material's picture.

    Returns
    -------
    (size, size, 3) float array    Linear Rec. 709, row 0 at the bottom; 1 is white.

    Raises
    ------
    LumenrayError    Its scattering file is refused, or the engine does not work here.
    """
    surface = surface_of(entry)
    items, camera = set_material_stage(entry, surface, size * FINER)
    session = Session()
    session.apply(SceneDelta(changed=items))
    picture = session.render(camera, ViewSettings(StopRule(samples=samples)))
    linear = scene_linear(picture.tristimulus, WHITE)
    if not is_seen_through(surface):
        error = picture.luminance_error / WHITE
        # The albedo of a sheet is that of what lies behind it.
        albedo = np.ones_like(picture.albedo) if lets_through(surface) else picture.albedo
        linear = smooth(linear, error, picture.normal, picture.depth, albedo)
    # Rolled off before the mean is taken, so that edges of highlights are not ragged.
    curve = film(np.maximum(linear, 0.0))
    return curve.reshape(size, FINER, size, FINER, 3).mean(axis=(1, 3))


def write_material_thumbnail(entry: Entry, samples: int = SAMPLES) -> Path:
    """Render a material's picture and write it where the library looks for it."""
    return write_display(entry.thumbnail, render_material(entry, samples))
