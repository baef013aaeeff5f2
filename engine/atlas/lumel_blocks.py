"""Lumels of one layout on one page in a row, with their places or without."""

from dataclasses import dataclass

import numpy as np

from ..transport.paths.illuminance import Receivers


@dataclass(frozen=True)
class LumelFacts:
    """Lumels of one layout on one page, in a row, but for their places.

    Parameters
    ----------
    layout : int    Index in the atlas's layouts.
    page : int
    index : (n,) int64 array    Flat pixel index on the page, row 0 at the bottom, ascending.
    chart : (n,) int32 array
    area : (n,) array    Surface in each lumel. [m2]
    valid : (n,) bool array    False: inside a solid or covered all over, to be filled from the neighbours.
    """

    layout: int
    page: int
    index: np.ndarray
    chart: np.ndarray
    area: np.ndarray
    valid: np.ndarray


@dataclass(frozen=True)
class LumelBlock(LumelFacts):
    """Lumels with their places.

    Parameters
    ----------
    receivers : Receivers    n rows, those that are not valid too.
    triangle : (k,) int32 array    Triangle of the mesh for every place of the receivers.
    box : (k,) uint8 array
        Number, from 1, of the part of the lumel that every place stands for, where it stands for all of that: samples may
        lie anywhere in it. 0: only at the place itself. See `Boxes`.
    steps : (n, 2, 3) float32 array    Steps on the surface for one lumel to the right and one upwards. [m]
    reached : (n,) array or None    Share of each lumel's places that light can reach; None: all. [-]
    """

    receivers: Receivers
    triangle: np.ndarray
    box: np.ndarray
    steps: np.ndarray
    reached: np.ndarray | None = None

    def size(self) -> int:
        """Memory that it takes. [byte]"""
        held = self.receivers
        arrays = [self.index, self.chart, self.area, self.valid, self.triangle, held.positions]
        arrays += [self.box, self.steps]
        arrays += [held.geometric_normals, held.start, held.count]
        if held.normals is not held.geometric_normals:
            arrays.append(held.normals)
        return sum(array.nbytes for array in arrays)


class PackedFacts:
    """Facts about a block in little memory: lumels of one chart that follow each other are told as one."""

    def __init__(self, block: LumelBlock):
        step = np.flatnonzero((np.diff(block.index) != 1) | (np.diff(block.chart) != 0)) + 1
        first = np.concatenate([[0], step]) if len(block.index) else step
        self._lengths = np.diff(first, append=len(block.index)).astype(np.int32)
        self._start, self._chart = block.index[first], block.chart[first]
        self._area, self._valid = block.area.astype(np.float32), np.packbits(block.valid)
        self._owner = block.layout, block.page

    def unpack(self) -> LumelFacts:
        """Tell them lumel by lumel."""
        count = len(self._area)
        ends = np.cumsum(self._lengths, dtype=np.int64)
        index = np.arange(count) + np.repeat(self._start - (ends - self._lengths), self._lengths)
        chart = np.repeat(self._chart, self._lengths)
        valid = np.unpackbits(self._valid, count=count).astype(bool)
        return LumelFacts(*self._owner, index, chart, self._area, valid)


@dataclass(frozen=True)
class Correction:
    """What is changed about the places of a block, numbered as they are without it.

    Parameters
    ----------
    dropped : uint8 array or None    Packed bits of places that are of no use; None: there are none.
    moved : (m,) int32 array    Places that are moved.
    shift : (m, 3) float32 array    How far. [m]
    still : uint8 array    Packed bits of lumels whose samples lie at places only.
    """

    dropped: np.ndarray | None
    moved: np.ndarray
    shift: np.ndarray
    still: np.ndarray


def join_receivers(parts: list[Receivers]) -> Receivers:
    """Receivers of several blocks in a row."""
    if len(parts) == 1:
        return parts[0]
    ends = np.cumsum([0, *(len(part.positions) for part in parts)])
    return Receivers(
        *(
            np.concatenate([getattr(part, name) for part in parts])
            for name in ("positions", "normals", "geometric_normals")
        ),
        np.concatenate([part.start + end for part, end in zip(parts, ends, strict=False)]),
        np.concatenate([part.count for part in parts]),
        np.concatenate([part.weights for part in parts]),
    )


def correct(block: LumelBlock, correction: Correction) -> LumelBlock:
    """Apply what was found out about a block's places."""
    held = block.receivers
    positions = held.positions.copy()
    positions[correction.moved] += correction.shift
    still = np.unpackbits(correction.still, count=len(block.index)).astype(bool)
    box = np.where(np.repeat(still, held.count), np.uint8(0), block.box)
    kept, count, valid = np.ones(len(positions), dtype=bool), held.count, block.valid
    reached = None
    if correction.dropped is not None:
        kept = np.unpackbits(correction.dropped, count=len(positions)) == 0
        count = np.add.reduceat(kept, held.start, dtype=np.int64)
        valid, reached = count > 0, count / held.count
        # Lumels without any use keep their places, so that every row has some.
        kept |= np.repeat(~valid, held.count)
        count = np.where(valid, count, held.count)
    normals = held.normals[kept]
    is_flat = held.normals is held.geometric_normals
    receivers = Receivers(
        positions[kept],
        normals,
        normals if is_flat else held.geometric_normals[kept],
        np.cumsum(count) - count,
        count,
        held.weights,
    )
    return LumelBlock(
        block.layout,
        block.page,
        block.index,
        block.chart,
        block.area,
        valid,
        receivers,
        block.triangle[kept],
        box[kept],
        block.steps,
        reached,
    )
