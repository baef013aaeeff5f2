"""Several lux maps side by side on one sheet."""

from dataclasses import dataclass

import numpy as np

GAP = 8
"""Free lumels between maps."""

CAPTION = 18
"""Free lumels above every map, for its name in pictures."""


@dataclass(frozen=True)
class Sheet:
    """Maps on one sheet. Row 0 is the bottom row.

    Parameters
    ----------
    illuminance, standard_error : (h, w) float32    [lx]
    covered : (h, w) bool
    places : list of (name, x, y, width, height)    Lower left corner and size of every map.
    """

    illuminance: np.ndarray
    standard_error: np.ndarray
    covered: np.ndarray
    places: list[tuple[str, int, int, int, int]]


def compose_sheet(maps) -> Sheet:
    """Put maps on shelves, tallest first, about as wide as high."""
    ordered = sorted(maps, key=lambda made: (-made.illuminance.shape[0], made.name))
    area = sum((m.illuminance.shape[0] + CAPTION) * (m.illuminance.shape[1] + GAP) for m in ordered)
    widest = max(made.illuminance.shape[1] for made in ordered)
    limit = max(widest, int(1.15 * np.sqrt(area))) + GAP
    places, x, y, shelf = [], GAP, GAP, 0
    for made in ordered:
        height, width = made.illuminance.shape
        if x + width > limit and x > GAP:
            x, y, shelf = GAP, y + shelf + CAPTION, 0
        places.append((made.name, x, y, width, height))
        x += width + GAP
        shelf = max(shelf, height)
    shape = (y + shelf + CAPTION, max(p[1] + p[3] for p in places) + GAP)
    layers = [np.zeros(shape, dtype=np.float32) for _ in range(2)]
    covered = np.zeros(shape, dtype=bool)
    for made, (_, left, low, width, height) in zip(ordered, places, strict=True):
        window = (slice(low, low + height), slice(left, left + width))
        layers[0][window] = made.illuminance
        layers[1][window] = made.standard_error
        covered[window] = made.covered
    return Sheet(layers[0], layers[1], covered, places)
