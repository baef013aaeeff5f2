"""Close-ups of cloths as pictures."""

import numpy as np
from PIL import Image

from ..cloth.close_up import CloseUp
from ..cloth.readings import linear_colour

WHITE = 1.5
"""Value of a close-up that is drawn white: facets are brighter than a white Lambert surface. [-]"""

FILTER = 0.7
"""Standard deviation of the Gaussian that a pixel is seen with. [pixel]"""


def draw_threads(made: CloseUp, repeats: int = 1) -> Image.Image:
    """Draw a close-up as it looks in daylight, some repeats along both sides."""
    values = made.values
    reach = np.arange(-3, 4)
    weights = np.exp(-0.5 * (reach / FILTER) ** 2)
    for axis in (0, 1):
        # A repeat goes on with itself.
        copies = [
            weight * np.roll(values, k, axis) for k, weight in zip(reach, weights, strict=True)
        ]
        values = sum(copies) / weights.sum()
    linear = np.clip(linear_colour(values, made.wavelengths) / WHITE, 0.0, 1.0)
    coded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    return Image.fromarray(np.tile(np.rint(255.0 * coded).astype(np.uint8), (repeats, repeats, 1)))
