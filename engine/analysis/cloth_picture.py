"""Close-ups of cloths as pictures."""

import numpy as np
from PIL import Image

from ..cloth.close_up import CloseUp
from ..cloth.readings import linear_colour

WHITE = 1.5
"""Value of a close-up that is drawn white: facets are brighter than a white Lambert surface. [-]"""


def draw_threads(made: CloseUp, repeats: int = 1) -> Image.Image:
    """Draw a close-up as it looks in daylight, some repeats along both sides."""
    linear = np.clip(linear_colour(made.values, made.wavelengths) / WHITE, 0.0, 1.0)
    coded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    return Image.fromarray(np.tile(np.rint(255.0 * coded).astype(np.uint8), (repeats, repeats, 1)))
