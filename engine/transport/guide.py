"""Rays to bright surfaces: cells are chosen by the light that they send, as lights are by theirs.

Where light comes from small bright surfaces, such as a cove or a sunlit patch, rays that are sent out by the cosine law
alone seldom meet them. A point on a cell that is chosen by its power is reached every time. Both kinds of rays are weighed
by the power heuristic for as many samples as each takes, so that neither counts twice. What a cell sends of light that was
traced to it counts at any distance; the rest where rays would read it.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ..arrays import table_size, upload
from . import gather, paths
from .cached_gather import NEAR
from .cells import CellSet

EVEN = 0.05
"""Share of the choices that is spread over all cells by area."""


class Guide:
    """Chooses points on cells.

    Parameters
    ----------
    cells : CellSet    With their light found.
    powers : (2 c,) array or None    What every side sends, as `powers_of` gives it; None: find it.
    sides : (n,) array or None    Sides that count then; None: all.
    """

    def __init__(self, cells: CellSet, powers: np.ndarray | None = None, sides=None):
        self.cells = cells
        if powers is None:
            powers = powers_of(cells)
            if sides is not None:
                # Nobody looks at the sunlit outside of a house.
                powers[np.setdiff1d(np.arange(len(powers)), sides)] = 0.0
        self.powers = powers
        room = np.repeat(np.where(cells.whole > 0.0, cells.area, 0.0), 2)
        lit = np.where(self.powers > 0.0, room, 0.0)
        self.is_useful = bool(self.powers.sum() > 0.0 and lit.sum() > 0.0)
        if not self.is_useful:
            return
        share = (1.0 - EVEN) * self.powers / self.powers.sum() + EVEN * lit / lit.sum()
        self._sides = np.flatnonzero(share > 0.0)
        cdf = np.cumsum(share[self._sides])
        cdf /= cdf[-1]
        density = np.zeros(len(share))
        density[self._sides] = np.diff(cdf, prepend=0.0) / np.repeat(cells.whole, 2)[self._sides]
        # Filled up to a power of two, so that a few cells more need no new kernel.
        self._slots = table_size(len(self._sides))
        choice = np.full(self._slots, self._sides[-1])
        choice[: len(self._sides)] = self._sides
        padded = np.full(self._slots, 2.0)
        padded[: len(cdf) - 1] = cdf[:-1]
        self._choice = upload(mi.UInt32, choice)
        self._cdf = upload(mi.Float, padded)
        self._density = upload(mi.Float, density)
        dr.eval(self._choice, self._cdf, self._density)

    def density(self, side, active):
        """Density by which a point of a side is chosen. [1/m2]"""
        return dr.gather(mi.Float, self._density, side, active)

    def light(self, scene, receiver, stream):
        """Light of a cell that is chosen; parameters as of `receiving.direct`.

        Returns
        -------
        (Spectrum, Spectrum)    Of traced light and of what is read of cells, as in `cached_gather.incoming`: spectral
            irradiance [W/(m2 nm)], or illuminance [lx] in photometric variants.
        """
        cells, si = self.cells, receiver.si
        u = receiver.sample.x
        index = dr.binary_search(
            0, self._slots - 1, lambda i: dr.gather(mi.Float, self._cdf, i) <= u
        )
        side = dr.gather(mi.UInt32, self._choice, index)
        # The rest of the number is too coarse for a place where cells are many.
        place = mi.Point2f(stream.next_float32(), receiver.sample.y)
        at, row, inside = cells.point(side, place)
        if si.wavelengths is not None:
            at.wavelengths = si.wavelengths
        away = at.p - si.p
        distance = dr.norm(away)
        direction = away / dr.maximum(distance, 1e-20)
        facing = -dr.dot(direction, at.n)
        response = receiver.respond(direction)
        lit = inside & (facing > 0.0) & (response > 0.0)
        reads = lit & (distance > NEAR * cells.near(at.shape, inside))
        reads &= ~dr.gather(mi.Bool, cells.uneven, side, reads)
        value = dr.select(reads, cells.value(side, si.wavelengths, reads), 0.0)
        traced = mi.Spectrum(0.0)
        if cells.traced is not None:
            traced = dr.select(lit, cells.traced_value(side, si.wavelengths, lit), 0.0)
        lit &= dr.any((value != 0.0) | (traced != 0.0))
        cosine = dr.abs(dr.dot(direction, at.sh_frame.n))
        at.wi = mi.Vector3f(0.0, 0.0, 1.0)
        matte = scene.bsdf(at, lit).eval_diffuse_reflectance(at, lit) * (
            (1.0 - cells.matt.coat(row, cosine, lit)) * cells.matt.scale(row, lit) * dr.inv_pi
        )
        density = self.density(side, lit) * dr.square(distance) / dr.maximum(facing, 1e-9)
        competing = receiver.density(direction)
        weight = paths.power_heuristic(density * receiver.ratio, competing)
        amount = matte * (response * weight / dr.maximum(density, 1e-30))
        lit &= dr.any(amount != 0.0)
        target = dr.zeros(mi.PositionSample3f)
        target.p, target.n = at.p, at.n
        passed = dr.select(lit, amount * paths.transmittance(scene, si, target, lit), 0.0)
        return passed * traced, passed * value


def powers_of(cells: CellSet) -> np.ndarray:
    """Light that every side sends, up to a factor; 0 where points cannot be chosen. (2 c,)"""
    count = 2 * cells.count
    side = dr.arange(mi.UInt32, count)
    able = np.repeat((cells.area > 0.0) & (cells.whole > 0.0), 2)
    active = upload(mi.Bool, able)
    si, row = cells.place(side, mi.UInt32(0), active)
    wavelengths = gather.typical_wavelengths()
    if wavelengths is not None:
        si.wavelengths = wavelengths
    active &= row > 0
    reflectance = cells.scene.bsdf(si, active).eval_diffuse_reflectance(si, active)
    reflectance = np.array(dr.select(active, dr.mean(reflectance), 0.0), dtype=np.float64)
    light = np.array(cells.values, dtype=np.float64).reshape(count, -1) @ cells.bands.luminous()
    if cells.traced is not None:
        light += np.array(cells.traced, dtype=np.float64)
    return np.where(able, np.maximum(reflectance * light, 0.0) * np.repeat(cells.area, 2), 0.0)
