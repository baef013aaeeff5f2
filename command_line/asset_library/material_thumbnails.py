"""Pictures of materials: a ball under a lamp and a window, all exposed alike, so that they compare."""

from pathlib import Path

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.analysis.denoiser import denoise
from ...engine.analysis.false_colour import write_display
from ...engine.photometry.colour import scene_linear
from ...engine.scene.scene import SceneDelta
from ...engine.session import Session
from ...engine.views import ViewSettings
from ...libraries.materials import Entry
from .material_stage import set_material_stage, surface_of
from .thumbnails import FINER, film

SIZE = 160
"""Of a picture. [pixel]"""

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
    picture = session.render(camera, ViewSettings(StopRule(samples=samples), guides=True))
    linear = scene_linear(picture.tristimulus, WHITE)
    linear = denoise(linear, picture.denoising_normal, picture.denoising_albedo)
    # Rolled off before the mean is taken, so that edges of highlights are not ragged.
    curve = film(np.maximum(linear, 0.0))
    return curve.reshape(size, FINER, size, FINER, 3).mean(axis=(1, 3))


def write_material_thumbnail(entry: Entry, samples: int = SAMPLES) -> Path:
    """Render a material's picture and write it where the library looks for it."""
    return write_display(entry.thumbnail, render_material(entry, samples))
