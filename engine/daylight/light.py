"""Illuminances of a year: coefficients times weather, with all that is not known of them as so many other years.

Groups of paths, points of the sun's disk and doubts are causes of error that have nothing to do with each other. Instead of
one number beside every illuminance there are sixteen more matrices: each has every cause once, with a sign from one row of a
Hadamard matrix. For whatever is linear in the illuminances the mean square of what it changes over the sixteen is exactly
the square of its standard error; for all else (hours above a threshold, medians) the sixteen show how it answers to errors
of the size that there are (balanced repeated replication).

References
----------
P. J. McCarthy: Pseudo-replication: half samples, Review of the International Statistical Institute 37(3), 1969, 239-264
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .coefficients import DaylightCoefficients
from .year import Year

BLOCK_BYTES = 400 << 20
"""Memory for the illuminances of a block of sensors."""

UNKNOWN_PLACE = 0.5
"""By how much the light of a sun over surfaces may be off as others stand for it, relative to how these differ. [-]"""


def make_signs(causes: int) -> np.ndarray:
    """Return columns of a Hadamard matrix: signs of every cause in every replicate. (replicates, causes) of -1 and 1"""
    made = np.ones((1, 1))
    while len(made) < causes:
        made = np.block([[made, made], [made, -made]])
    return made[:, :causes]


@dataclass(frozen=True, eq=False)
class YearLight:
    """Illuminances of all sensors and lit hours, block by block of sensors.

    Parameters
    ----------
    coefficients : DaylightCoefficients
    year : Year

    Raises
    ------
    SceneError    They do not belong together.
    """

    coefficients: DaylightCoefficients
    year: Year

    def __post_init__(self):
        """Refuse what was made for other skies or suns."""
        own, year = self.coefficients, self.year
        if own.steps != year.steps or own.direct.shape[1] != len(year.suns):
            raise SceneError(
                "the daylight coefficients were found for other suns than the weather has"
            )

    @property
    def replicates(self) -> int:
        """Matrices beside the mean."""
        return len(self._signs)

    @property
    def _signs(self) -> np.ndarray:
        own = self.coefficients
        return make_signs(len(own.sky) + len(own.doubts) + 3)

    def blocks(self) -> Iterator[tuple[slice, np.ndarray, np.ndarray]]:
        """Yield which sensors, their illuminances (b, h) and the replicates (r, b, h) at the lit hours. [lx]"""
        hours, sensors = len(self.year.lit), self.coefficients.sensors
        bytes_each = 4 * max(hours, 1) * (self.replicates + len(self.coefficients.sky) + 4)
        size = max(BLOCK_BYTES // bytes_each, 1)
        for first in range(0, sensors, size):
            part = slice(first, min(first + size, sensors))
            mean, causes = self.parts(part)
            signs = self._signs.astype(np.float32)
            flat = causes.reshape(len(causes), -1)
            replicates = (signs @ flat).reshape(len(signs), *mean.shape)
            replicates += mean
            yield part, mean, replicates

    def parts(self, part: slice) -> tuple[np.ndarray, np.ndarray]:
        """Illuminances of some sensors at the lit hours and by how much every cause changes them. (b, h), (c, b, h) [lx]"""
        own, year = self.coefficients, self.year
        groups = len(own.sky)
        has_sun = year.sun >= 0
        sun = year.sun[has_sun]
        beam = year.direct_normal[has_sun].astype(np.float32)
        count, hours = own.sky[0, part].shape[0], len(year.lit)
        causes = np.zeros((groups + len(own.doubts) + 3, count, hours), dtype=np.float32)
        by_group = causes[:groups]
        np.matmul(own.sky[:, part], year.sky.T, out=by_group)
        # What suns near to one another make of surfaces, in its place.
        turn = self._turn(sun)
        by_group[..., has_sun] += (own.reflected[:, part] @ turn) * beam
        mean = by_group.mean(axis=0)
        by_group -= mean
        by_group *= np.float32(1.0 / np.sqrt(groups * (groups - 1)))
        for k, doubt in enumerate(own.doubts):
            causes[groups + k][:, has_sun] = (doubt[part] @ turn) * beam
        reflected = own.reflected[:, part].mean(axis=0)
        square = (reflected**2) @ turn - (reflected @ turn) ** 2
        causes[-3][:, has_sun] = UNKNOWN_PLACE * np.sqrt(np.maximum(square, 0.0)) * beam
        np.matmul(own.sky[:, part].mean(axis=0), year.doubt.T, out=causes[-2])
        mean[:, has_sun] += own.direct[part][:, sun] * beam
        causes[-1][:, has_sun] = own.direct_error[part][:, sun] * beam
        return mean, causes

    def _turn(self, sun: np.ndarray) -> np.ndarray:
        """What each of the suns that stand for others counts for some of those. (m, s) float32"""
        own = self.coefficients
        made = np.zeros((own.reflected.shape[2], len(sun)), dtype=np.float32)
        np.add.at(made, (own.neighbours[sun], np.arange(len(sun))[:, None]), own.shares[sun])
        return made

    def direct_sun(self, part: slice = slice(None)) -> np.ndarray:
        """Illuminances by the sun straight at the lit hours. (b, h) float32 [lx]"""
        own, year = self.coefficients, self.year
        has_sun = year.sun >= 0
        made = np.zeros((own.direct[part].shape[0], len(year.lit)), dtype=np.float32)
        seen = own.direct[part][:, year.sun[has_sun]]
        made[:, has_sun] = seen * year.direct_normal[has_sun].astype(np.float32)
        return made

    def illuminance(self) -> tuple[np.ndarray, np.ndarray]:
        """Illuminances at the lit hours and their standard errors. (n, h), (n, h) float32 [lx]"""
        sensors, hours = self.coefficients.sensors, len(self.year.lit)
        made, error = (np.zeros((sensors, hours), dtype=np.float32) for _ in range(2))
        size = max(BLOCK_BYTES // (4 * max(hours, 1) * (len(self._signs) + 2)), 1)
        for first in range(0, sensors, size):
            part = slice(first, min(first + size, sensors))
            made[part], causes = self.parts(part)
            error[part] = np.sqrt((causes**2).sum(axis=0))
        return made, error
