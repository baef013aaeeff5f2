"""Light transport by pairs of patches (Klems), sampled exactly in proportion to the value times the cosine."""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...scene.scattering import PatchBasis, PatchMatrix
from ..data.patches import albedos, solid_angles, starts_of

LARGEST_SINE_SQUARED = 1.0 - 2.0**-23
"""Of sampled directions, so that they stay above the horizon."""


def steps_for(count: int) -> int:
    """Halvings with which `find_interval` searches tables of ``count`` intervals and fewer."""
    return max(count - 1, 0).bit_length()


def find_interval(table, first, last, value, steps: int, active):
    """Return the largest index from ``first`` to ``last`` whose entry of an ascending table is not above a value.

    Parameters
    ----------
    first, last : mi.UInt32    The entry at ``first`` must not be above the value.
    steps : int    As of `steps_for`; more do no harm.
    """
    low, high = mi.UInt32(first), mi.UInt32(last)
    for _ in range(steps):
        middle = (low + high + 1) >> 1
        below = dr.gather(mi.Float, table, middle, active) <= value
        low = dr.select(below, middle, low)
        high = dr.select(below, high, middle - 1)
    return low


class Bands:
    """Values by number at wavelengths, linear in between; the first and the last hold beyond."""

    def __init__(self, values: np.ndarray, wavelengths: np.ndarray):
        self.count = values.shape[-1]
        self.values = upload(mi.Float, values)
        self.wavelengths = upload(mi.Float, wavelengths)
        self._first = dr.opaque(mi.Float, float(wavelengths[0]))
        self._last = dr.opaque(mi.UInt32, self.count - 1)

    def look_up(self, number, wavelengths, active):
        """Return mi.Spectrum; with one band wavelengths are not looked at."""
        if self.count == 1:
            return mi.Spectrum(dr.gather(mi.Float, self.values, number, active))
        found = mi.Spectrum(0.0)
        steps = steps_for(self.count - 1)
        for k in range(len(found)):
            wavelength = dr.maximum(wavelengths[k], self._first)
            below = find_interval(
                self.wavelengths, mi.UInt32(0), self._last - 1, wavelength, steps, active
            )
            start = dr.gather(mi.Float, self.wavelengths, below, active)
            end = dr.gather(mi.Float, self.wavelengths, below + 1, active)
            place = number * (self._last + 1) + below
            found[k] = dr.lerp(
                dr.gather(mi.Float, self.values, place, active),
                dr.gather(mi.Float, self.values, place + 1, active),
                dr.minimum((wavelength - start) / (end - start), 1.0),
            )
        return found


class Rings:
    """A basis of patches, on the device."""

    def __init__(self, basis: PatchBasis):
        squares = np.sin(basis.bounds) ** 2
        squares[-1] = LARGEST_SINE_SQUARED
        self.patches = dr.opaque(mi.UInt32, int(basis.counts.sum()))
        self._squares = upload(mi.Float, squares)
        self._counts = upload(mi.Float, basis.counts)
        self._starts = upload(mi.UInt32, starts_of(basis))
        self._rings = upload(mi.UInt32, np.repeat(np.arange(len(basis.counts)), basis.counts))
        self._last = dr.opaque(mi.UInt32, len(basis.counts) - 1)
        self._steps = steps_for(len(basis.counts))

    def patch_of(self, direction, active):
        """Number of the patch in which a direction lies. mi.UInt32"""
        square = dr.square(direction.x) + dr.square(direction.y)
        ring = find_interval(self._squares, mi.UInt32(0), self._last, square, self._steps, active)
        count = dr.gather(mi.Float, self._counts, ring, active)
        turn = dr.atan2(direction.y, direction.x) * dr.inv_two_pi
        place = dr.floor(dr.fma(dr.select(turn < 0.0, turn + 1.0, turn), count, 0.5))
        place = dr.select(place >= count, 0.0, place)
        return dr.gather(mi.UInt32, self._starts, ring, active) + mi.UInt32(place)

    def direction_in(self, patch, sample, active):
        """Direction in a patch, even over its projected solid angle. mi.Vector3f"""
        ring = dr.gather(mi.UInt32, self._rings, patch, active)
        place = mi.Float(patch - dr.gather(mi.UInt32, self._starts, ring, active))
        inner = dr.gather(mi.Float, self._squares, ring, active)
        outer = dr.gather(mi.Float, self._squares, ring + 1, active)
        count = dr.gather(mi.Float, self._counts, ring, active)
        square = dr.minimum(dr.lerp(inner, outer, sample.x), LARGEST_SINE_SQUARED)
        sine, cosine = dr.sincos(dr.two_pi * (place + sample.y - 0.5) / count)
        radius = dr.sqrt(square)
        return mi.Vector3f(radius * cosine, radius * sine, dr.sqrt(1.0 - square))


class PatchLobe:
    """One side of a material, known by pairs of patches.

    Parameters
    ----------
    matrix : PatchMatrix
    weigh : callable
        (values (..., w), wavelengths (w,)) -> (..., b): what transport uses of the wavelengths, all or one mean of them.
    factor : float    On all values. [-]
    """

    def __init__(self, matrix: PatchMatrix, weigh, factor: float = 1.0):
        values = weigh(matrix.values * np.float32(factor), matrix.wavelengths)
        matrix = replace(matrix, values=values)
        solid = solid_angles(matrix.outgoing)
        shares = matrix.values.mean(axis=-1, dtype=np.float64) * solid
        total = shares.sum(axis=1, keepdims=True)
        # Where nothing is scattered samples spread like the cosine, and carry nothing.
        shares = np.where(total > 0.0, shares / np.where(total > 0.0, total, 1.0), solid / np.pi)
        sums = np.zeros((len(shares), len(solid) + 1))
        np.cumsum(shares, axis=1, out=sums[:, 1:])
        sums = (sums / sums[:, -1:]).astype(np.float32)
        self._incoming, self._outgoing = Rings(matrix.incoming), Rings(matrix.outgoing)
        self._bands = Bands(matrix.values, matrix.wavelengths)
        self._sums = upload(mi.Float, sums)
        # Of the sums as they are stored, so that it is the density of what is sampled.
        self._density = upload(mi.Float, np.diff(sums.astype(np.float64), axis=1) / solid)
        self._albedos = upload(mi.Float, albedos(matrix).mean(axis=1))
        self._steps = steps_for(len(solid))

    def evaluate(self, wi, wo, wavelengths, active):
        """Value times the cosine of wo, and the density of `sample`. mi.Spectrum [1/sr], mi.Float [1/sr]

        Both directions must be above the horizon where ``active``.
        """
        incoming = self._incoming.patch_of(wi, active)
        outgoing = self._outgoing.patch_of(wo, active)
        number = incoming * self._outgoing.patches + outgoing
        value = self._bands.look_up(number, wavelengths, active) * wo.z
        return value, dr.gather(mi.Float, self._density, number, active) * wo.z

    def sample(self, wi, sample, active):
        """Direction for a point of the unit square. mi.Vector3f"""
        first = self._incoming.patch_of(wi, active) * (self._outgoing.patches + 1)
        last = first + self._outgoing.patches - 1
        place = find_interval(self._sums, first, last, sample.x, self._steps, active)
        low = dr.gather(mi.Float, self._sums, place, active)
        high = dr.gather(mi.Float, self._sums, place + 1, active)
        rest = dr.clip((sample.x - low) / dr.maximum(high - low, 1e-12), 0.0, 1.0)
        return self._outgoing.direction_in(place - first, mi.Point2f(rest, sample.y), active)

    def reflectance(self, wi, wavelengths, active):
        """Share of light that is scattered, the mean over the bands at every wavelength. (Spectrum)"""
        return mi.Spectrum(self.albedo(wi, active))

    def albedo(self, wi, active):
        """Share of light that is scattered, mean over the wavelengths. mi.Float [-]"""
        return dr.gather(mi.Float, self._albedos, self._incoming.patch_of(wi, active), active)
