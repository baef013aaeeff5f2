"""Colours of scales: stops from low to high, display-encoded, straight lines between them."""

import numpy as np

from .false_colour import STOPS

EVEN = np.array(
    [
        [0.267, 0.004, 0.329],
        [0.278, 0.176, 0.482],
        [0.231, 0.318, 0.545],
        [0.173, 0.447, 0.557],
        [0.129, 0.569, 0.549],
        [0.157, 0.682, 0.502],
        [0.369, 0.788, 0.384],
        [0.678, 0.863, 0.188],
        [0.992, 0.906, 0.145],
    ]
)
"""Nine colours of the map viridis (S. van der Walt, N. Smith, E. Firing; CC0): lightness rises evenly, and people who do not
tell red from green see all of it."""

DIFFERENCE = np.array(
    [
        [0.12, 0.30, 0.62],
        [0.45, 0.62, 0.83],
        [0.95, 0.95, 0.95],
        [0.88, 0.60, 0.36],
        [0.66, 0.30, 0.04],
    ]
)
"""From blue over a light grey to orange, which all people tell apart; the middle is no difference."""

MAPS = {"hues": STOPS, "even": EVEN, "difference": DIFFERENCE}
"""By name: many hues, that neighbours are told apart; even in lightness; of differences."""


def colours_of(shares, name: str) -> np.ndarray:
    """Colours of shares 0..1 of a map. (...) -> (..., 3) uint8"""
    stops = MAPS[name]
    place = np.clip(np.nan_to_num(np.asarray(shares, dtype=np.float64)), 0.0, 1.0) * (
        len(stops) - 1
    )
    below = np.minimum(place.astype(int), len(stops) - 2)
    part = (place - below)[..., None]
    mixed = stops[below] * (1.0 - part) + stops[below + 1] * part
    return np.round(255.0 * mixed).astype(np.uint8)
