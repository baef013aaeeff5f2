"""Paints of few layers, and directions of the angles by which their readings are stated."""

from lumenray.benchmarks.paint.makers import interference, make_paint, mirrors, one_layer, sample
from lumenray.benchmarks.paint.values import SAMPLE_ANGLES, aspecular

__all__ = [
    "SAMPLES",
    "SAMPLE_ANGLES",
    "aspecular",
    "interference",
    "make_paint",
    "mirrors",
    "one_layer",
]

SAMPLES = {number: sample(number) for number in (1, 2, 3)}
"""The reference's samples, by number."""
