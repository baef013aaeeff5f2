"""Pictures of luminaires by the light that they throw on a small stage, as a camera that adapts would take them."""

from pathlib import Path

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.analysis.denoiser import denoise
from ...engine.analysis.false_colour import write_display
from ...engine.luminaires.formats.radiant import require_luminous
from ...engine.luminaires.formats.reader import read_luminaire
from ...engine.luminaires.lamp_spectrum import choose_spectrum
from ...engine.photometry.colour import scene_linear
from ...engine.scene.scene import SceneDelta
from ...engine.session import Session
from ...engine.views import ViewSettings
from ...libraries.luminaires import Model
from .stage import STAGE_INDEX, set_stage, spectrum_of

SIZE = 256
"""Of a picture. [pixel]"""

FINER = 2
"""Pixels of the render in one of the picture, along each side: denoising then leaves small bright things as they are."""

SAMPLES = 48
"""Paths per pixel of the render."""

REFERENCE = np.array([1.0053, 1.0, 0.7042])
"""X, Y, Z of a blackbody of 4200 K, between daylight and lamps."""

ADAPTATION = 0.7
"""How far the camera takes the light itself for white in place of `REFERENCE`: warm light stays warm, cold light cold."""

DAYLIGHT = np.array([0.95047, 1.0, 1.08883])
"""X, Y, Z of the picture's white, D65. (IEC 61966-2-1)"""

BRADFORD = np.array(
    [[0.8951, 0.2664, -0.1614], [-0.7502, 1.7135, 0.0367], [0.0389, -0.0685, 1.0296]]
)
"""From X, Y, Z to the cone responses in which whites are adapted. (ICC.1:2022, annex E)"""

EXPOSURE = ((0.97, 0.9), (0.998, 4.0))
"""Shares of the stage's pixels that the exposure keeps below a value, where 1 is white: most of it, and narrow beams."""


def render_thumbnail(model: Model, samples: int = SAMPLES) -> np.ndarray:
    """Render a model's picture.

    Returns
    -------
    (256, 256, 3) float array    Linear Rec. 709, row 0 at the bottom; 1 is white.

    Raises
    ------
    LumenrayError    The photometric file is refused, or the engine does not work here.
    """
    file = read_luminaire(model.file)
    require_luminous(model.file, file)
    spectrum = spectrum_of(model, choose_spectrum(file).spectrum)
    items, camera = set_stage(model, file, spectrum, SIZE * FINER)
    session = Session()
    session.apply(SceneDelta(changed=items))
    picture = session.render(camera, ViewSettings(StopRule(samples=samples), guides=True))
    return develop(picture)


def develop(picture) -> np.ndarray:
    """Denoise a `Picture`, adapt to the colour of the light in part, expose, and take pixels together."""
    # Of the stage alone: the luminaire itself may be as bright as it is.
    luminance = picture.tristimulus[..., 1][picture.object_index == STAGE_INDEX]
    levels = [float(np.quantile(luminance, share)) / most for share, most in EXPOSURE]
    white = max(*levels, 1e-9)
    linear = scene_linear(picture.tristimulus @ adaptation(picture).T, white)
    linear = denoise(linear, picture.denoising_normal, picture.denoising_albedo)
    # Rolled off before the mean is taken, so that edges of lamps are not ragged.
    curve = film(np.maximum(linear, 0.0))
    return curve.reshape(SIZE, FINER, SIZE, FINER, 3).mean(axis=(1, 3))


def adaptation(picture) -> np.ndarray:
    """Matrix on X, Y, Z that brings what the camera takes for white to the picture's white. (3, 3)"""
    own = picture.tristimulus.reshape(-1, 3).mean(axis=0, dtype=np.float64)
    if own[1] <= 0.0:
        return np.eye(3)
    cones = (BRADFORD @ (own / own[1])) ** ADAPTATION * (BRADFORD @ REFERENCE) ** (1.0 - ADAPTATION)
    return np.linalg.inv(BRADFORD) @ np.diag(BRADFORD @ DAYLIGHT / cones) @ BRADFORD


def film(linear: np.ndarray) -> np.ndarray:
    """Darken shadows and roll bright values off below 1, by the brightest component."""
    peak = linear.max(axis=-1, keepdims=True)
    rolled = 1.0 - np.exp(-1.3 * peak**1.15)
    return linear * (rolled / np.maximum(peak, 1e-9))


def write_thumbnail(model: Model, samples: int = SAMPLES) -> Path:
    """Render a model's picture and write it where the library looks for it."""
    return write_display(model.thumbnail, render_thumbnail(model, samples))
