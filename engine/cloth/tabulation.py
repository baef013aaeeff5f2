"""From light that was counted by the cells in which it left to the tables of a cloth's sides.

Light goes as well one way as the other, so each pair of directions was counted twice: both ways of light are averaged, which
halves the variance. Near the horizon, where tables are coarse, that would move values by more than their noise, and they
stay as they were counted. All tables are scaled to the light that was counted exactly.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..scattering.data.record import SIDES
from ..scattering.data.surface import make_reciprocal
from ..scattering.data.table import albedos_of, direction_of
from ..scattering.data.tree import square_of
from ..scene.scattering import ScatterTable
from .plan import INCIDENCES

RADIALS = np.radians([0, 8, 16, 24, 34, 45, 57, 70, 85, 100, 120, 140, 160, 180.0])

AZIMUTH_STEP = np.radians(15.0)

AZIMUTHS = AZIMUTH_STEP * np.arange(25)

CELLS = 20
"""Cells along the sides of the square that the disk of directions is mapped to."""

BLUR = 0.8
"""Standard deviation by which counts are smoothed. [cell]"""

LOWEST = np.cos(np.radians(89.0))
"""Directions below take the value there, so that what lies below the horizon does not count as dark."""

TURNED = np.cos(np.radians(75.0))
"""Cosine from which on light is averaged with that of the other way. [-]"""

FLOOR = 0.05
"""Share of the largest albedo over pi that is added to values where errors are told relative to them."""


@dataclass
class Counted:
    """Light that left: by rotation, incidence, half of the rays, cell and band; and straight, by rotation and incidence."""

    reflection: np.ndarray
    transmission: np.ndarray
    straight: np.ndarray
    absorbed: np.ndarray


def tabulate(
    counted: dict[str, Counted], rotations, wavelengths, is_orthotropic: bool
) -> dict[str, ScatterTable]:
    """Make the tables of all sides.

    Parameters
    ----------
    counted : dict of str to Counted
        Of light onto ``front`` and ``back``; of a cloth that is alike from both one and the same.
    rotations, wavelengths, is_orthotropic    Of the tables.

    Returns
    -------
    dict of str to ScatterTable    By the names of `scattering.data.record.SIDES`; of one `Counted` one table.
    """
    is_alike = counted["front"] is counted["back"]
    names = [name for name in SIDES if name.startswith("front") or not is_alike]
    made = {}
    for name in names:
        light, part = name.split("_")
        made[name] = _Side(counted[light], part, rotations, wavelengths, is_orthotropic)
    # Both halves of the rays, and all of them.
    tables = [{name: each.table(half) for name, each in made.items()} for half in (0, 1, None)]
    for half, own in zip((0, 1, None), tables, strict=True):
        before = dict(own)
        for name in names:
            other = name
            if name.endswith("transmission") and not is_alike:
                other = next(n for n in names if n.endswith("transmission") and n != name)
            both_ways = make_reciprocal(before[name], before[other], TURNED)
            own[name] = made[name].scaled(both_ways, half)
    first, second, whole = tables
    for name, each in made.items():
        whole[name] = replace(
            whole[name], error=each.error_of(first[name], second[name], whole[name])
        )
    return {name: whole[name.replace("back", "front") if is_alike else name] for name in SIDES}


class _Side:
    """What was counted of a side, ``reflection`` or ``transmission``, and its tables."""

    def __init__(self, found: Counted, part: str, rotations, wavelengths, is_orthotropic: bool):
        counts = getattr(found, part)
        self._total = counts.sum(axis=3)  # (p, s, half, w)
        i, t, a = np.meshgrid(INCIDENCES, RADIALS, AZIMUTHS, indexing="ij")
        self._is_above = (direction_of(i, t, a)[..., 2] > 0.0)[None, ..., None]
        self._halves = np.zeros((2, len(rotations), *i.shape, len(wavelengths)))
        for shift, share in ((-0.5, 0.25), (0.0, 0.5), (0.5, 0.25)):
            wo = direction_of(i, t, a + shift * AZIMUTH_STEP)
            low = wo[..., 2] < LOWEST
            level = np.hypot(wo[..., 0], wo[..., 1])
            wo[low, :2] *= (np.sqrt(1.0 - LOWEST**2) / np.maximum(level, 1e-12))[low, None]
            for p in range(len(rotations)):
                for s in range(len(INCIDENCES)):
                    for half in range(2):
                        self._halves[half, p, s] += share * _read(
                            counts[p, s, half], wo[s, ..., 0], wo[s, ..., 1]
                        )
        direct = None
        if part == "transmission":
            direct = np.repeat(found.straight[..., None], len(wavelengths), 2).astype(np.float32)
        none = np.zeros(self._halves.shape[1:], np.float32)
        self._empty = ScatterTable(
            rotations,
            INCIDENCES,
            RADIALS,
            AZIMUTHS,
            wavelengths,
            none,
            direct,
            is_orthotropic=is_orthotropic,
        )

    def table(self, half: int | None) -> ScatterTable:
        """Table of a half of the rays, None: of all."""
        values = self._halves.mean(axis=0) if half is None else self._halves[half]
        return self.scaled(replace(self._empty, values=values.astype(np.float32)), half)

    def scaled(self, table: ScatterTable, half: int | None) -> ScatterTable:
        """Bring a table to the light that was counted."""
        want = self._total.mean(axis=2) if half is None else self._total[:, :, half]
        own = albedos_of(table, table.incidences, table.rotations)
        scale = want / np.maximum(own, 1e-12)
        return replace(table, values=(table.values * scale[:, :, None, None]).astype(np.float32))

    def error_of(self, first: ScatterTable, second: ScatterTable, whole: ScatterTable) -> float:
        """Standard error of a table by those of both halves of the rays, see `ScatterTable`. [-]"""
        floor = max(FLOOR * float(self._total.max()) / np.pi, 1e-9)
        apart = 0.5 * (first.values - second.values) / (whole.values + floor)
        square = np.where(self._is_above, apart.astype(np.float64) ** 2, 0.0).sum()
        count = self._is_above.sum() * len(whole.rotations) * len(whole.wavelengths)
        return float(np.sqrt(square / count))


def _read(cells: np.ndarray, x, y) -> np.ndarray:
    """Values at directions of counts on cells of the disk. (c, w), two (t, a) -> (t, a, w) [1/sr]"""
    square = cells.reshape(CELLS, CELLS, -1)
    reach = int(np.ceil(3.0 * BLUR))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / BLUR) ** 2)
    weights /= weights.sum()
    for axis in (0, 1):
        pad = [(reach, reach) if k == axis else (0, 0) for k in range(3)]
        # Mirrored at the horizon, which keeps the light.
        wide = np.pad(square, pad, mode="symmetric")
        square = sum(
            weight * np.take(wide, np.arange(CELLS) + k, axis) for k, weight in enumerate(weights)
        )
    u, v = square_of(x.ravel(), y.ravel())
    found = 0.0
    places = [np.clip(each * CELLS - 0.5, 0.0, CELLS - 1.0) for each in (u, v)]
    lows = [np.minimum(place.astype(np.int64), CELLS - 2) for place in places]
    shares = [place - low for place, low in zip(places, lows, strict=True)]
    for one in (0, 1):
        for two in (0, 1):
            weight = np.abs(1 - one - shares[0]) * np.abs(1 - two - shares[1])
            found = found + weight[:, None] * square[lows[0] + one, lows[1] + two]
    return (found * CELLS * CELLS / np.pi).reshape(*x.shape, -1)
