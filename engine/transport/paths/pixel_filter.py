"""The filter of pixels: where within and about a pixel its samples lie."""

import drjit as dr
import mitsuba as mi

FILTER_RADIUS = 0.75
"""Half width of the pixel filter, a tent; it is sampled, so that pixels stay independent. [pixel]"""


def filter_offset(sample):
    """Offset within the pixel filter: a tent, sampled exactly, so that every sample counts alike. [pixel]"""

    def tent(u):
        low = u < 0.5
        root = dr.sqrt(dr.select(low, 2.0 * u, 2.0 * (1.0 - u)))
        return FILTER_RADIUS * dr.select(low, root - 1.0, 1.0 - root)

    return mi.Point2f(tent(sample.x), tent(sample.y))
