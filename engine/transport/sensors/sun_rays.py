"""The sun straight, at sensors and on cells: rays to points of its disk from each of them, for every place of the sun.

Most sensors see all of the disk or nothing of it. Three rays just beyond its rim, through the corners of a triangle around
it, tell: where all find the same, no straight edge lies across the disk. Where they differ, many rays inside it follow.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...errors import Cancelled
from ..paths import gather
from ..paths.sampler import hash_words, random_stream
from ..paths.visibility import transmittance

LANES = 1 << 20
"""Rays of a launch."""

CORNERS = 3
"""Rays around the disk."""

AROUND = 2.0
"""Radius on which these lie, so that their triangle holds the disk, in radii of it. [-]"""

ALIKE = 0.02
"""By how much they may differ, relative to the largest: glass lets a little more or less through. [-]"""

SIDE = 9
"""Rings of a disk that is seen in part, and sectors of each; a ray goes to a random point of every one."""

INSIDE = SIDE * SIDE

SPREAD_OUT = 0.7
"""Error of the mean of points that are spread out over a disk with an edge across it, relative to that of independent ones:
0.41 to 0.68 by the edge's place. [-]"""

GLANCE_SIDE = 3
"""A surface is divided into so many parts along both sides, and `SunRays.glance` looks from a point of each."""

GLANCES = GLANCE_SIDE * GLANCE_SIDE

HALVES = 2
"""Independent answers of `SunRays.glance`."""


class SunRays:
    """Traces rays to suns.

    Parameters
    ----------
    scene : CompiledScene    Lit by an even world of 1 cd/m2 alone.
    suns : (k, 3) array    Unit vectors.
    angle : float    Diameter of the disk. [rad]
    sampler : WavelengthSampler or None
    seed : int
    cancelled : callable    Asked before every launch.
    """

    def __init__(self, scene, suns: np.ndarray, angle: float, sampler, seed: int, cancelled):
        self._scene, self._sampler, self._seed = scene, sampler, seed
        self._cancelled = cancelled
        self._suns = [upload(mi.Float, suns[:, i]) for i in range(3)]
        self.count = len(suns)
        # Chords, since a cosine next to 1 has few digits.
        self._radius = dr.opaque(mi.Float, 2.0 * np.sin(0.25 * angle))

    def see(self, make_surface, rows: int) -> tuple[np.ndarray, np.ndarray]:
        """Return what surfaces have of every sun for 1 lx on a plane that faces it.

        Parameters
        ----------
        make_surface : callable
            Given numbers of surfaces and a random point of a unit square for each lane, returns an interaction, a function
            of the cosine to the sun that tells what part of its light counts, and whether the point is one of the surface.
        rows : int    Surfaces.

        Returns
        -------
        (rows, k), (rows, k) float32 array    With standard errors, which are 0 where all of the disk is seen or nothing. [-]

        Raises
        ------
        Cancelled    When ``cancelled`` answered true.
        """
        made, error = (np.zeros((rows, self.count), dtype=np.float32) for _ in range(2))
        for part, row, sun in self._pairs(rows, CORNERS):
            around, _ = self._launch(make_surface, row, sun, CORNERS, 0, is_inside=False)
            mean, own = around.mean(axis=1), np.zeros(len(row), dtype=np.float32)
            spread = around.max(axis=1) - around.min(axis=1)
            cut = np.flatnonzero(spread > ALIKE * around.max(axis=1))
            each = LANES // INSIDE
            for start in range(0, len(cut), each):
                some = cut[start : start + each]
                rays = row[some], sun[some], INSIDE
                inside, _ = self._launch(make_surface, *rays, 1, is_inside=True)
                mean[some] = inside.mean(axis=1)
                own[some] = SPREAD_OUT * inside.std(axis=1, ddof=1) / np.sqrt(INSIDE)
            made[part], error[part] = mean.reshape(-1, self.count), own.reshape(-1, self.count)
        return made, error

    def glance(self, make_surfaces, rows: int) -> np.ndarray:
        """As `see`, by few rays to random points of the disk for each of two independent answers: for what many look at.

        They come from all over a surface, one from each of `GLANCES` parts of it.

        Parameters
        ----------
        make_surfaces : pair of callables    One for each answer.

        Returns
        -------
        (2, rows, k) float32 array
        """
        made = np.zeros((HALVES, rows, self.count), dtype=np.float32)
        for part, row, sun in self._pairs(rows, GLANCES):
            for half, make_surface in enumerate(make_surfaces):
                rays = row, sun, GLANCES
                found, exists = self._launch(make_surface, *rays, 2 + half, is_inside=True)
                mean = found.sum(axis=1) / np.maximum(exists.sum(axis=1), 1)
                made[half, part] = mean.reshape(-1, self.count)
        return made

    def _pairs(self, rows: int, times: int):
        """Yield surfaces of a launch, and the numbers of surface and sun of all its pairs."""
        each = max(LANES // max(times * self.count, 1), 1)
        for first in range(0, rows if self.count else 0, each):
            part = slice(first, min(first + each, rows))
            row = np.repeat(np.arange(part.start, part.stop, dtype=np.uint32), self.count)
            sun = np.tile(np.arange(self.count, dtype=np.uint32), part.stop - part.start)
            yield part, row, sun

    def _launch(self, make_surface, row, sun, times: int, salt: int, is_inside: bool):
        """Rays from surfaces to suns, so many for each pair of both, and which there are. (n, times), (n, times)"""
        if self._cancelled():
            raise Cancelled("cancelled")
        many = dr.opaque(mi.UInt32, times)
        lane = dr.arange(mi.UInt32, times * len(row))
        pair, number = lane // many, lane % many
        row = dr.gather(mi.UInt32, upload(mi.UInt32, row), pair)
        sun = dr.gather(mi.UInt32, upload(mi.UInt32, sun), pair)
        seed = dr.opaque(mi.UInt32, self._seed & 0xFFFFFFFF)
        own = hash_words(row, hash_words(sun, hash_words(dr.opaque(mi.UInt32, salt), seed)))
        common = random_stream(sun, own)
        axis = mi.Vector3f(*(dr.gather(mi.Float, column, sun) for column in self._suns))
        wavelengths = None
        turn = common.next_float32()
        if self._sampler is not None:
            wavelengths = self._sampler.sample(common.next_float32())
        point = mi.Point2f(common.next_float32(), common.next_float32())
        if is_inside:
            stream = random_stream(number, own)
            if times == GLANCES:
                part = mi.Point2f(mi.Float(number % GLANCE_SIDE), mi.Float(number // GLANCE_SIDE))
                point = mi.Point2f(stream.next_float32(), stream.next_float32())
                point = (part + point) / GLANCE_SIDE
            side = SIDE if times == INSIDE else 1
            ring = (mi.Float(number % side) + stream.next_float32()) / side
            chord = self._radius * dr.sqrt(ring)
            turn = (mi.Float(number // side) + stream.next_float32()) / side
        else:
            chord = self._radius * AROUND
            turn += mi.Float(number) / times
        towards = mi.Frame3f(axis).to_world(_beside(chord, dr.two_pi * turn))
        si, passes, exists = make_surface(row, point)
        if wavelengths is not None:
            si.wavelengths = wavelengths
        facing = dr.maximum(dr.dot(si.sh_frame.n, towards), 0.0)
        lit = exists & (facing > 0.0) & (dr.dot(si.n, towards) > 0.0)
        ds = dr.zeros(mi.DirectionSample3f)
        ds.p = si.p + towards * (4.0 * self._scene.radius)
        arrives = transmittance(self._scene, si, ds, lit)
        if wavelengths is not None:
            away = dr.zeros(mi.SurfaceInteraction3f)
            away.wi, away.wavelengths = -towards, wavelengths
            arrives *= self._scene.surroundings.eval(away, lit)
        amount = gather.photometric(self._sampler, arrives, wavelengths) * passes(facing, lit)
        amount = dr.select(lit & dr.isfinite(amount), amount * facing, 0.0)
        found = (np.array(each) for each in (mi.Float(amount), mi.Bool(exists)))
        return tuple(np.broadcast_to(each, len(lane)).reshape(-1, times) for each in found)


def _beside(chord, turn):
    """Unit vector whose tip is so far from that of +z."""
    height = 0.5 * dr.square(chord)
    plan = chord * dr.sqrt(dr.maximum(1.0 - 0.25 * dr.square(chord), 0.0))
    sine, cosine = dr.sincos(turn)
    return mi.Vector3f(plan * cosine, plan * sine, 1.0 - height)
