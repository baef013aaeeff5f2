"""Rays to bright surfaces: cells are chosen by the light that they send, as lights are by theirs.

Where light comes from small bright surfaces, such as a cove or a sunlit patch, rays that are sent out by the cosine law
alone seldom meet them. A point on a cell that is chosen by its power is reached every time. Both kinds of rays are weighed
by the power heuristic for as many samples as each takes, so that neither counts twice. What a cell sends of light that was
traced to it counts at any distance; the rest where rays would read it.
"""

import weakref
from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import average, table_size, upload
from ..paths import gather
from ..paths.next_event import power_heuristic
from ..paths.visibility import transmittance
from .cell_reader import NEAR, spread_of
from .cells import CellSet

EVEN = 0.05
"""Share of the choices that is spread over all cells by area."""


BOXED = 0.9
"""Share of the points of a cell that go to the box in which its traced light lies, where that is small."""


class Guide:
    """Chooses points on cells.

    Parameters
    ----------
    cells : CellSet    With their light found.
    powers : (2 c,) array or None    What every side sends, as `powers_of` gives it; None: find it.
    sides : (n,) array or None    Sides that count then; None: all.

    Attributes
    ----------
    powers : (2 c,) array
    is_useful : bool    Whether there is anything to choose.
    """

    def __init__(self, cells: CellSet, powers: np.ndarray | None = None, sides=None):
        self.cells = cells
        self.powers = powers_of(cells, sides=sides) if powers is None else powers
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
        # As many entries for all guides to the same cells, so that all have one kernel.
        self._slots = table_size(2 * cells.count)
        choice = np.full(self._slots, self._sides[-1])
        choice[: len(self._sides)] = self._sides
        padded = np.full(self._slots, 2.0)
        padded[: len(cdf) - 1] = cdf[:-1]
        self._choice = upload(mi.UInt32, choice)
        self._cdf = upload(mi.Float, padded)
        self._density = upload(mi.Float, density)
        dr.eval(self._choice, self._cdf, self._density)

    def density(self, side, local, active):
        """Density by which a point of a side is chosen. ``local``: as of `CellSet.locate`. [1/m2]"""
        found = dr.gather(mi.Float, self._density, side, active)
        if self.cells.traced is None:
            return found
        low, high, factor = self.cells.box(side, active)
        width = high - low
        share = dr.select(factor != 1.0, BOXED, 0.0)
        is_in = self.cells.concentration(side, local, active) > 0.0
        return found * (1.0 - share + dr.select(is_in, share / (width.x * width.y), 0.0))

    def _aim(self, side, place):
        """Where in a cell a point is chosen: mostly in the box in which traced light lies."""
        if self.cells.traced is None:
            return place
        low, high, factor = self.cells.box(side, mi.Bool(True))
        share = dr.select(factor != 1.0, BOXED, 0.0)
        boxed = place.x < share
        x = dr.select(boxed, place.x / dr.maximum(share, 1e-9), (place.x - share) / (1.0 - share))
        point = mi.Point2f(x, place.y)
        return dr.select(boxed, low + point * (high - low), point)

    def light(self, scene, receiver, stream, by_width: bool = False):
        """Light of a cell that is chosen; parameters as of `receiving.direct`.

        ``by_width``: whether rays of the receiver read cells by how wide their way is, see `cell_reader.spread_of`.

        Returns
        -------
        (Spectrum, Spectrum)    Of traced light and of what is read of cells, as in `cached_gather.incoming`: spectral
            irradiance [W/(m2 nm)], or illuminance [lx] in photometric variants.
        """
        sample, si = receiver.sample, receiver.si
        # The rest of the number is too coarse for a place where cells are many.
        place = mi.Point2f(stream.next_float32(), sample.y)
        link = self._link(si, sample.x, place, mi.Bool(True))
        width = link.distance
        if by_width:
            width *= spread_of(receiver.answer(link.direction, link.lit)[1])
        reads = link.lit & (width > NEAR * self.cells.near(link.at.shape, link.inside))
        reads &= ~dr.gather(mi.Bool, self.cells.uneven, link.side, reads)
        value = dr.select(reads, self.cells.value(link.side, si.wavelengths, reads), 0.0)
        traced = self._traced(link, si)
        lit = link.lit & dr.any((value != 0.0) | (traced != 0.0))
        passed = self._pass(scene, si, link, receiver.answer, receiver.ratio, lit)
        return passed * traced, passed * value

    def traced_light(self, scene, si, choice, place, respond, active):
        """Traced light of a cell that is chosen, beside one ray from a point that a path has come to.

        Parameters
        ----------
        scene : CompiledScene
        si : SurfaceInteraction3f
        choice : Float
        place : Point2f
        respond : callable    Direction of the scene's frame and Bool to what of the radiance is sent on, and the density of
            the ray. (Spectrum, Float)
        active : Bool

        Returns
        -------
        Spectrum    Spectral radiance that is sent on [W/(m2 sr nm)], or luminance [cd/m2] in photometric variants.
        """
        link = self._link(si, choice, place, active)
        traced = self._traced(link, si)
        lit = link.lit & dr.any(traced != 0.0)
        return self._pass(scene, si, link, respond, mi.Float(1.0), lit) * traced

    # ---- private ----

    def _link(self, si, choice, place, active) -> "_Link":
        """Choose a point on a cell. ``choice``: which cell, ``place``: where on it."""
        index = dr.binary_search(
            0, self._slots - 1, lambda i: dr.gather(mi.Float, self._cdf, i) <= choice
        )
        side = dr.gather(mi.UInt32, self._choice, index)
        local = self._aim(side, place)
        at, row, inside = self.cells.point(side, local)
        if si.wavelengths is not None:
            at.wavelengths = si.wavelengths
        away = at.p - si.p
        distance = dr.norm(away)
        direction = away / dr.maximum(distance, 1e-20)
        facing = -dr.dot(direction, at.n)
        return _Link(
            side,
            local,
            at,
            row,
            inside,
            direction,
            distance,
            facing,
            active & inside & (facing > 0.0),
        )

    def _traced(self, link: "_Link", si):
        """What traced paths bring to the chosen cell."""
        if self.cells.traced is None:
            return mi.Spectrum(0.0)
        found = self.cells.traced_value(link.side, link.local, si.wavelengths, link.lit)
        return dr.select(link.lit, found, 0.0)

    def _pass(self, scene, si, link: "_Link", respond, ratio, lit):
        """What counts of the irradiance of the chosen cell, beside rays; ``respond`` as of `traced_light`."""
        cells, at = self.cells, link.at
        response, competing = respond(link.direction, lit)
        response = mi.Spectrum(response)
        lit = lit & dr.any(response > 0.0)
        cosine = dr.abs(dr.dot(link.direction, at.sh_frame.n))
        at.wi = mi.Vector3f(0.0, 0.0, 1.0)
        matte = scene.bsdf(at, lit).eval_diffuse_reflectance(at, lit) * (
            (1.0 - cells.matt.coat(link.row, cosine, lit))
            * cells.matt.scale(link.row, lit)
            * dr.inv_pi
        )
        density = self.density(link.side, link.local, lit) * dr.square(link.distance)
        density /= dr.maximum(link.facing, 1e-9)
        weight = power_heuristic(density * ratio, competing)
        amount = matte * response * (weight / dr.maximum(density, 1e-30))
        lit &= dr.any(amount != 0.0)
        target = dr.zeros(mi.PositionSample3f)
        target.p, target.n = at.p, at.n
        return dr.select(lit, amount * transmittance(scene, si, target, lit), 0.0)


@dataclass(frozen=True)
class _Link:
    """A chosen point on a cell, and the line to it.

    ``side``, ``local``: of the cell, and where in it, as of `CellSet.locate`. ``at``, ``row``, ``inside``: as of
    `CellSet.point`. ``direction``, ``distance`` [m]: from where it is asked. ``facing``: cosine at the cell. ``lit``:
    whether it can be seen, but for what stands between.
    """

    side: object
    local: object
    at: object
    row: object
    inside: object
    direction: object
    distance: object
    facing: object
    lit: object


def choose_spots(cells: CellSet, sides) -> Guide | None:
    """Guide to traced light alone, for `CellSet.spots`; None: there is none."""
    # The cells hold this guide. Were it to hold them too, they and their scene would outlive the job, and a scene that lives
    # on makes kernels of the next one anew.
    made = Guide(weakref.proxy(cells), powers_of(cells, False, sides))
    return made if made.is_useful else None


def powers_of(cells: CellSet, is_whole: bool = True, sides=None) -> np.ndarray:
    """Light that every side sends, up to a factor; 0 where points cannot be chosen. (2 c,)

    Parameters
    ----------
    cells : CellSet
    is_whole : bool    All light, or that which was traced to the cells alone.
    sides : (n,) array or None    Sides that count; None: all.
    """
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
    reflectance = np.array(dr.select(active, average(reflectance), 0.0), dtype=np.float64)
    light = np.zeros(count)
    if is_whole:
        light += (
            np.array(cells.values, dtype=np.float64).reshape(count, -1) @ cells.bands.luminous()
        )
    if cells.traced is not None:
        light += np.array(cells.traced, dtype=np.float64)
    if sides is not None:
        # Nobody looks at the sunlit outside of a house.
        light[np.setdiff1d(np.arange(count), sides)] = 0.0
    return np.where(able, np.maximum(reflectance * light, 0.0) * np.repeat(cells.area, 2), 0.0)
