"""What a job keeps of all lumels, and some places on them, found in one walk over their blocks.

Blocks that do not fit the memory are made anew at every walk, so there should be few.
"""

from dataclasses import dataclass

import numpy as np

POOL, FEWEST, MOST = 1 << 17, 64, 1 << 14
"""Places that are drawn in all, and bounds on how many in a block."""


@dataclass(frozen=True)
class Survey:
    """Facts about the lumels of a table.

    Parameters
    ----------
    area : (n,) array    Surface in each lumel. [m2]
    valid : (n,) bool array
    places : (b,) int array    Places in every block.
    positions : (k, 3) float64 array    Some of the places of valid lumels, drawn by area within each block. [m]
    normals : (k, 3) float32 array
    chances : (k,) array    Of sum 1: with these the places stand for all lumels by area.
    """

    area: np.ndarray
    valid: np.ndarray
    places: np.ndarray
    positions: np.ndarray
    normals: np.ndarray
    chances: np.ndarray

    def draw(self, count: int, seed: int) -> np.ndarray:
        """Rows of places, by area. (count,)"""
        return np.random.default_rng([seed & 0xFFFFFFFF, 3]).choice(
            len(self.chances), count, p=self.chances
        )


def survey(table, seed: int) -> Survey:
    """Walk over the blocks of a `LumelTable`."""
    draw = np.random.default_rng([seed & 0xFFFFFFFF, 4])
    each = int(np.clip(POOL // max(len(table.counts), 1), FEWEST, MOST))
    area, valid, places, positions, normals, chances = [], [], [], [], [], []
    for number in range(len(table.counts)):
        block = table.block(number)
        held = block.receivers
        area.append(block.area)
        valid.append(block.valid)
        places.append(len(held.positions))
        share = np.where(block.valid, block.area, 0.0)
        total = float(share.sum())
        if total > 0.0:
            lumels = draw.choice(len(share), each, p=share / total)
            rows = held.start[lumels] + (draw.random(each) * held.count[lumels]).astype(np.int64)
            positions.append(held.positions[rows])
            normals.append(held.normals[rows].astype(np.float32))
            chances.append(np.full(each, total / each))
    chance = np.concatenate(chances) if chances else np.zeros(0)
    return Survey(
        np.concatenate(area),
        np.concatenate(valid),
        np.array(places, dtype=np.int64),
        np.concatenate(positions) if positions else np.zeros((0, 3)),
        np.concatenate(normals) if normals else np.zeros((0, 3), dtype=np.float32),
        chance / max(chance.sum(), 1e-300),
    )
