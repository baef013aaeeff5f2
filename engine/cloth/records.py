"""Exits of photons from a thread, kept so that each way into it has many to draw from.

A way in is the size of the direction's component along the thread, and of the ray's distance from the axis; the signs of
both follow by mirrors. Each is cut into bins; a drawn exit is of the bin of a place that is up to half a bin off, so that
what is drawn changes steadily.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import drjit as dr
import mitsuba as mi
import numpy as np

from .thread_walk import ThreadOptics, walk_inside

BINS = 12
"""Bins along each."""

EXITS = 1024
"""Exits of each bin."""


@dataclass(frozen=True, eq=False)
class Records:
    """Exits by the way in, as of `thread_walk.Exits`. [radius], [rad], [-], [radius]

    Parameters
    ----------
    values : (bins * bins * exits, 6) float32 array    Along, turn, normal, axial, around, length.
    exits : int    Of each bin.
    lost : float    Share of photons that were given up, which are drawn as if they had been others. [-]
    """

    values: np.ndarray
    exits: int
    lost: float


def record(optics: ThreadOptics, exits: int = EXITS, seed: int = 0) -> Records:
    """Send photons into a thread from all sides and keep where they come out."""
    count = BINS * BINS * exits
    number = np.arange(count) // exits
    draw = np.random.default_rng((seed, 11)).random((2, count))
    axial = (number // BINS + draw[0]) / BINS
    offset = (number % BINS + draw[1]) / BINS
    made = walk_inside(optics, mi.Float(axial), mi.Float(offset), seed)
    values = np.stack(
        [
            np.array(each)
            for each in (made.along, made.turn, made.normal, made.axial, made.around, made.length)
        ],
        axis=1,
    )
    lost = np.flatnonzero(np.array(made.lost))
    values[lost] = values[np.maximum(lost - 1, 0)]
    return Records(values.astype(np.float32), exits, len(lost) / count)


class DrawnExits:
    """Records of several threads on the device, from which exits are drawn."""

    def __init__(self, records: list[Records]):
        self.exits = dr.opaque(mi.UInt32, records[0].exits)
        values = np.concatenate([each.values for each in records])
        # Four numbers are fetched at a time.
        self.first = mi.Float(values[:, :4].ravel())
        self.second = mi.Float(np.pad(values[:, 4:], ((0, 0), (0, 2))).ravel())

    def draw(self, thread, axial, around, inward, stream, active):
        """Exits of rays that enter threads.

        Parameters
        ----------
        thread : UInt32    Number of the thread.
        axial, around, inward : Float    Components of the direction along the thread, about it, and inwards.
        active : Bool    Which rays enter a thread; of others the direction may be no number, nor what this gives.

        Returns
        -------
        six Float    As of `Records.values`.
        """
        level = dr.sqrt(dr.maximum(around * around + inward * inward, 1e-12))
        # Half a bin off in both senses, by which light across a thread comes from both signs.
        spots = [value * BINS + stream.next_float32() - 0.5 for value in (axial, around / level)]
        place = [mi.UInt32(dr.minimum(dr.abs(spot), BINS - 0.5)) for spot in spots]
        one = dr.minimum(mi.UInt32(stream.next_float32() * mi.Float(self.exits)), self.exits - 1)
        row = ((thread * BINS + place[0]) * BINS + place[1]) * self.exits + one
        along, turn, normal, out = dr.gather(mi.Vector4f, self.first, row, active)
        about, length, _, _ = dr.gather(mi.Vector4f, self.second, row, active)
        first, second = spots
        return (
            dr.mulsign(along, first),
            dr.mulsign(turn, second),
            normal,
            dr.mulsign(out, first),
            dr.mulsign(about, second),
            length,
        )


@lru_cache(maxsize=24)
def _kept(key, exits: int, seed: int) -> Records:
    index, optical_radius, cosines, roughness = key
    optics = ThreadOptics(index, optical_radius, np.frombuffer(cosines), roughness)
    return record(optics, exits, seed)


def recorded(optics: ThreadOptics, exits: int = EXITS, seed: int = 0) -> Records:
    """What `record` finds, kept: a dye changes nothing of it."""
    cosines = np.ascontiguousarray(optics.cosines, np.float64).tobytes()
    return _kept((optics.index, optics.optical_radius, cosines, optics.roughness), exits, seed)
