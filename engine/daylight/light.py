"""Illuminances of a year: coefficients times weather, with all that is not known of them as so many other years.

Groups of paths, what is seen of the sun's disk and doubts are causes of error that have nothing to do with each other. Each
says by how much it may change every illuminance, all sensors and hours together, and figures of the year get their errors
from years in which all causes are there at once with balanced signs (`replicated`).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from .coefficients import DaylightCoefficients
from .lm83 import SunlitAreas, close_blinds
from .replicated import balanced_signs
from .year import Year

BLOCK_BYTES = 400 << 20
"""Memory for the illuminances of a block of sensors."""

MOST_CAUSES = 32
"""That may change illuminances, with as many balanced versions."""

UNKNOWN_PLACE = 0.5
"""By how much the light of a sun over surfaces may be off as others stand for it, relative to how these differ. [-]"""


class Light:
    """Illuminances of sensors at the lit hours of a year, block by block of sensors.

    Kinds of it give ``year``, ``sensors``, ``freedom``: degrees of freedom of the errors, ``opened``: the light with all
    blinds open, and `parts`.
    """

    year: Year
    sensors: int
    freedom: float
    opened: "YearLight"

    def parts(self, part: slice) -> tuple[np.ndarray, np.ndarray]:
        """Illuminances of some sensors at the lit hours and by how much every cause changes them. (b, h), (c, b, h) [lx]"""
        raise NotImplementedError

    def blocks(self) -> Iterator[slice]:
        """Yield ranges of sensors whose illuminances, and how causes change them, fit into memory."""
        each = 4 * max(len(self.year.lit), 1) * (MOST_CAUSES + 6)
        size = max(BLOCK_BYTES // each, 1)
        for first in range(0, self.sensors, size):
            yield slice(first, min(first + size, self.sensors))

    def versions(self, part: slice) -> Iterator[np.ndarray]:
        """Yield illuminances of some sensors, and what is balanced about them (`replicated`), one by one. (b, h) [lx]"""
        mean, causes = self.parts(part)
        yield mean
        for signs in balanced_signs(len(causes)).astype(np.float32):
            yield mean + np.tensordot(signs, causes, axes=1)

    def illuminance(self) -> tuple[np.ndarray, np.ndarray]:
        """Illuminances at the lit hours and their standard errors. (n, h), (n, h) float32 [lx]"""
        shape = (self.sensors, len(self.year.lit))
        made, error = (np.zeros(shape, dtype=np.float32) for _ in range(2))
        for part in self.blocks():
            made[part], causes = self.parts(part)
            error[part] = np.sqrt((causes**2).sum(axis=0))
        return made, error


@dataclass(frozen=True, eq=False)
class YearLight(Light):
    """Light of a year's weather.

    Parameters
    ----------
    coefficients : DaylightCoefficients    The suns of the year come first.
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
        if own.steps != year.steps or own.direct.shape[1] < len(year.suns):
            raise SceneError(
                "the daylight coefficients were found for other suns than the weather has"
            )

    @property
    def opened(self) -> "YearLight":
        """Itself: there are no blinds."""
        return self

    @property
    def sensors(self) -> int:
        """Number of sensors."""
        return self.coefficients.sensors

    @property
    def freedom(self) -> float:
        """Of the groups of paths."""
        return len(self.coefficients.sky) - 1.0

    def parts(self, part: slice) -> tuple[np.ndarray, np.ndarray]:
        """Illuminances of some sensors at the lit hours and by how much every cause changes them. (b, h), (c, b, h) [lx]"""
        own, year = self.coefficients, self.year
        groups = len(own.sky)
        has_sun = year.sun >= 0
        sun = year.sun[has_sun]
        beam = year.direct_normal[has_sun].astype(np.float32)
        count, hours = own.sky[0, part].shape[0], len(year.lit)
        causes = np.zeros((groups + len(own.doubts) + 4, count, hours), dtype=np.float32)
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
        np.multiply(mean, own.reading[part][:, None], out=causes[-4])
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
        return self._by_sun(self.coefficients.direct[part])

    def direct_sun_error(self, part: slice = slice(None)) -> np.ndarray:
        """Standard errors of `direct_sun`. (b, h) float32 [lx]"""
        return self._by_sun(self.coefficients.direct_error[part])

    def _by_sun(self, seen: np.ndarray) -> np.ndarray:
        """From shares of the suns' light to illuminances. (b, k) -> (b, h) [lx]"""
        year = self.year
        has_sun = year.sun >= 0
        made = np.zeros((len(seen), len(year.lit)), dtype=np.float32)
        beam = year.direct_normal[has_sun].astype(np.float32)
        made[:, has_sun] = seen[:, year.sun[has_sun]] * beam
        return made


@dataclass(frozen=True, eq=False)
class ShadedLight(Light):
    """Light of a year in which blinds are closed and opened.

    What each group of windows changes when its blinds are closed adds up.

    Parameters
    ----------
    opened : YearLight    All blinds open.
    closed : tuple of YearLight    The blinds of one group closed, by group.
    is_closed : (groups, h) bool array
    """

    opened: YearLight
    closed: tuple[YearLight, ...]
    is_closed: np.ndarray

    @property
    def year(self) -> Year:
        """Of all."""
        return self.opened.year

    @property
    def sensors(self) -> int:
        """Number of sensors."""
        return self.opened.sensors

    @property
    def freedom(self) -> float:
        """Of the groups of paths."""
        return self.opened.freedom

    def parts(self, part: slice) -> tuple[np.ndarray, np.ndarray]:
        """As of `Light`."""
        mean, causes = self.opened.parts(part)
        total, changes = mean.copy(), causes.copy()
        for light, hours in zip(self.closed, self.is_closed, strict=True):
            own, own_causes = light.parts(part)
            total[:, hours] += (own - mean)[:, hours]
            changes[..., hours] += (own_causes - causes)[..., hours]
        return total, changes


def find_closed(opened: YearLight, closed: tuple[YearLight, ...], areas=None) -> np.ndarray:
    """Return when the blinds of each group of windows are closed by the rule of LM-83. (groups, h) bool

    ``areas``: that sensors stand for, (n,); None: all alike. [m2]
    """
    hours = len(opened.year.lit)
    sunlit = SunlitAreas(len(closed), hours)
    areas = np.ones(opened.sensors) if areas is None else np.asarray(areas)
    for part in opened.blocks():
        whole = opened.direct_sun(part)
        through = [np.maximum(whole - each.direct_sun(part), 0.0) for each in closed]
        sunlit.add(np.stack(through), areas[part])
    return close_blinds(sunlit.shares)
