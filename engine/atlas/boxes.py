"""Places in a lumel: points of a small low-discrepancy net, and boxes around them."""

from dataclasses import dataclass

import numpy as np

INSET = 1e-3
"""Samples stay so far inside their lumel: what stands on its border is beside it. [lumel]"""


@dataclass(frozen=True)
class Boxes:
    """Parts of a lumel, one around each point of the net of places, alike in size.

    Parameters
    ----------
    points : (p, 2) array    The net, 0..1. [lumel]
    corners : (p, 2) array    Lower left corners. [lumel]
    size : (2,) array    [lumel]
    ends : (float, float)    Between which samples stay along either side of the lumel. [lumel]
    """

    points: np.ndarray
    corners: np.ndarray
    size: np.ndarray
    ends: tuple[float, float] = (INSET, 1.0 - INSET)

    @classmethod
    def around(cls, points: np.ndarray) -> "Boxes":
        """Boxes around the points of `net`, a power of two: each holds one (they are a (0, m, 2)-net in base 2)."""
        bits = len(points).bit_length() - 1
        sides = np.array([2 ** ((bits + 1) // 2), 2 ** (bits // 2)])
        return cls(points, np.floor(points * sides) / sides, 1.0 / sides)


def net(count: int) -> np.ndarray:
    """Points of which every row and every column of ``count`` parts has one: Hammersley's, centred. (count, 2)"""
    number = np.arange(count)
    mirrored = np.zeros(count, dtype=np.int64)
    for bit in range(count.bit_length() - 1):
        mirrored = 2 * mirrored + (number >> bit & 1)
    return (np.stack([number, mirrored], axis=1) + 0.5) / count
