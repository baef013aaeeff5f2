"""What a job keeps of all lumels, and some places on them, found while their blocks are made for the first time.

Blocks that do not fit the memory are made anew at every walk over them, so there should be few.
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
    area : (n,) float32 array    Surface in each lumel. [m2]
    valid : (n,) bool array
    reached : (n,) float32 array    Of the area, what light can reach; lumels may lie half under something. [m2]
    places : (b,) int array    Places in every block.
    positions : (k, 3) float64 array    Some of the places of valid lumels, drawn by area within each block. [m]
    normals : (k, 3) float32 array
    chances : (k,) array    Of sum 1: with these the places stand for all lumels by area.
    """

    area: np.ndarray
    valid: np.ndarray
    reached: np.ndarray
    places: np.ndarray
    positions: np.ndarray
    normals: np.ndarray
    chances: np.ndarray

    def draw(self, count: int, seed: int) -> np.ndarray:
        """Rows of places, by area. (count,)"""
        return np.random.default_rng([seed & 0xFFFFFFFF, 3]).choice(
            len(self.chances), count, p=self.chances
        )


class Surveyor:
    """Gathers a survey block by block.

    Parameters
    ----------
    blocks : int    How many there will be.
    seed : int
    """

    def __init__(self, blocks: int, seed: int):
        self._draw = np.random.default_rng([seed & 0xFFFFFFFF, 4])
        self._each = int(np.clip(POOL // max(blocks, 1), FEWEST, MOST))
        self._area, self._valid, self._reached, self._places = [], [], [], []
        self._positions, self._normals, self._chances = [], [], []

    def add(self, block) -> None:
        """Take note of a `LumelBlock`, the next one of its table."""
        held, each = block.receivers, self._each
        self._area.append(block.area.astype(np.float32))
        self._valid.append(block.valid)
        share = block.valid if block.reached is None else block.reached
        self._reached.append((block.area * share).astype(np.float32))
        self._places.append(len(held.positions))
        share = np.where(block.valid, block.area, 0.0)
        total = float(share.sum())
        if total > 0.0:
            lumels = self._draw.choice(len(share), each, p=share / total)
            rows = held.start[lumels]
            rows = rows + (self._draw.random(each) * held.count[lumels]).astype(np.int64)
            self._positions.append(held.positions[rows])
            self._normals.append(held.normals[rows].astype(np.float32))
            self._chances.append(np.full(each, total / each))

    def survey(self) -> Survey:
        """All that was gathered."""
        chance = np.concatenate([np.zeros(0), *self._chances])
        return Survey(
            np.concatenate([np.zeros(0, dtype=np.float32), *self._area]),
            np.concatenate([np.zeros(0, dtype=bool), *self._valid]),
            np.concatenate([np.zeros(0, dtype=np.float32), *self._reached]),
            np.array(self._places, dtype=np.int64),
            np.concatenate([np.zeros((0, 3)), *self._positions]),
            np.concatenate([np.zeros((0, 3), dtype=np.float32), *self._normals]),
            chance / max(chance.sum(), 1e-300),
        )
