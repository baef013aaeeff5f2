"""Tables about the mirror direction made from any scattering that can be evaluated, as coarse as a wanted error allows.

Grid lines are added where the middle between two differs most from what the table says there, axis by axis, until a random
test of pairs of directions finds the wanted error; bands that lie on the line between their neighbours are left out. At the
end the values of each incidence are scaled so that the table reflects, or lets through, as much as what it was made from: a
chord lies above a lobe's flanks.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ..errors import SceneError
from ..scene.scattering import ScatterTable
from .table import albedo_of, direction_of, interpolate, quadrature, turned

Evaluate = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Values for pairs of directions wi, wo: (n, 3), (n, 3) -> (n, w). [1/sr]"""

RADIALS = np.radians([0, 1, 2, 4, 6, 10, 15, 22, 30, 45, 60, 90, 120, 180.0])
"""Where radial angles begin."""

ROTATIONS = 12
"""Into how many parts a turn is divided where rotations begin."""

INCIDENCES = np.radians([0, 15, 30, 45, 60, 75, 89.0])
"""Where angles of incidence begin; at 90 degrees nothing arrives."""

LOWEST = np.radians(89.0)
"""Directions farther from the normal take the value there: what lies below the horizon must not count as dark."""

FLOOR = 0.05
"""Share of a matt surface's value that is added to values where their error is told relative to them."""

MOST_VALUES = 1 << 23
"""Values that a table may grow to: 16 MB before its file is compressed, some 2 MB then."""

LARGEST_START = 1 << 25
"""Values of the grid to begin with, at most."""

ROUNDS = 48
"""Most rounds of refinement."""

TESTED = 1 << 14
"""Pairs of directions that the error is measured with."""

CHUNK = 1 << 16
"""Pairs that are evaluated in one go."""

SPECTRAL_PART = 0.5
"""Share of the tolerance that may come of bands left out: with the same order of error along all four axes of an isotropic
table, a quarter of the square is theirs."""

AIM = 0.85
"""Share of the tolerance at which refinement ends: other pairs may say more, and totals have to be kept."""

FIRST_THRESHOLD = 2.5
"""Error in the middle between grid lines that is let pass at first, by the tolerance: elsewhere it is smaller."""

FINE = 3
"""Points of Gauss and Legendre in each cell that totals are found with."""

LOOKED_AT = (3, 8, 20, 12)
"""Rotations, incidences, radial angles and azimuths along which the other axes are judged in a round."""

MOST_PARTS = 4
"""Parts that an interval is divided into at a time."""

GRAZING = np.radians(80.0)
"""From here on lobes get narrower than any grid, and totals are kept below 1. [rad]"""

SMALLEST_STEP = np.radians(0.05)
"""Grid lines are never closer."""


def resample(
    evaluate: Evaluate,
    wavelengths,
    *,
    incidences=None,
    rotations: Sequence[float] | None = (0.0,),
    is_symmetric: bool = True,
    is_orthotropic: bool = False,
    tolerance: float = 0.02,
    hints: Sequence[float] = (),
    most: int = MOST_VALUES,
) -> ScatterTable:
    """Make a table of scattering.

    Parameters
    ----------
    evaluate : Evaluate    Called with wi at the incidences and rotations of the table, or anywhere where they are chosen.
    wavelengths : (w,) array    Of the values. [nm]
    incidences : array or None    Angles of incidence that are kept as they are; None: chosen. [rad]
    rotations : sequence or None    Azimuths of incidence; one: the same for all. None: chosen. [rad]
    is_symmetric : bool    Whether both sides of the plane of incidence are alike; the side of phi in 0 to pi is asked.
    is_orthotropic : bool    As of `ScatterTable`; rotations that are given go from 0 to pi / 2 then.
    tolerance : float    Wanted error, root mean square, as `ScatterTable.error` says it. [-]
    hints : sequence    Radial angles that the grid should have, where something narrow is known to be. [rad]
    most : int    Values that the table may have; where they do not do, its stated error is larger than wanted.

    Returns
    -------
    ScatterTable    Its ``error`` is what was measured with random pairs of directions; between incidences
        and rotations that were given it is not known, and measured at them.
    """
    turns = ROTATIONS if rotations is None else len(rotations)
    started = len(RADIALS) * 13 * turns * len(np.atleast_1d(wavelengths))
    if started * (1 if incidences is None else len(incidences)) > LARGEST_START:
        raise SceneError(
            f"scattering at {turns} rotations, {len(incidences)} incidences and {len(wavelengths)} bands is too "
            "much for a table; leave out some"
        )
    maker = _Maker(
        evaluate,
        np.asarray(wavelengths, dtype=np.float64),
        incidences,
        rotations,
        is_symmetric,
        is_orthotropic,
        hints,
    )
    maker.choose_bands(tolerance)
    threshold = FIRST_THRESHOLD * tolerance
    table, is_old = maker.table(), True
    for _ in range(ROUNDS):
        if maker.refine(threshold, most):
            is_old = True
            if not maker.is_full:
                continue
        if is_old:
            table, is_old = maker.table(), False
            if maker.is_full or maker.error_of(table) <= AIM * tolerance:
                break
        threshold *= 0.7
    if is_old:
        table = maker.table()
    table = maker.keep_totals(table)
    return replace(table, error=maker.error_of(table))


def choose_bands(wavelengths: np.ndarray, values: np.ndarray, tolerance: float) -> np.ndarray:
    """Choose bands from which linear interpolation gives the others back.

    Parameters
    ----------
    wavelengths : (w,) array    Ascending. [nm]
    values : (n, w) array    Some spectra of the material. [1/sr]
    tolerance : float    Root mean square of the error over the value plus a part of a matt surface's, in each band. [-]

    Returns
    -------
    (k,) int array    Numbers of the bands; one if all are alike.
    """
    if np.allclose(values, values[:, :1], rtol=1e-5, atol=0.0):
        return np.array([len(wavelengths) // 2])
    # A matt surface's, or less: a peak must not hide what lies beside it.
    scale = values + FLOOR * min(1.0 / np.pi, max(float(values.mean()), 1e-12))
    kept = [0, len(wavelengths) - 1]
    while len(kept) < len(wavelengths):
        made = _between(wavelengths, np.array(kept), values[:, kept])
        error = np.sqrt((((made - values) / scale) ** 2).mean(axis=0))
        worst = int(np.argmax(error))
        if error[worst] <= tolerance:
            break
        kept = sorted([*kept, worst])
    return np.array(kept)


class _Maker:
    """A grid that grows, and what is known on it."""

    def __init__(self, evaluate, wavelengths, incidences, rotations, symmetric, orthotropic, hints):
        self.evaluate = evaluate
        self.wavelengths = wavelengths
        self.bands = np.arange(len(wavelengths))
        self.has_own_incidences = incidences is not None
        self.incidences = np.unique(
            np.asarray(INCIDENCES if incidences is None else incidences, dtype=np.float64)
        )
        self.has_own_rotations = rotations is not None
        self.is_orthotropic = orthotropic
        self.last_rotation = (0.5 if orthotropic else 2.0) * np.pi
        if rotations is None:
            step = 2.0 * np.pi / ROTATIONS
            rotations = step * np.arange(ROTATIONS // 4 + 1 if orthotropic else ROTATIONS)
        self.rotations = np.asarray(rotations, dtype=np.float64)
        hints = np.asarray(hints, dtype=np.float64)
        self.radials = np.unique(np.concatenate([RADIALS, hints]))
        end = np.pi if symmetric else 2.0 * np.pi
        self.azimuths = np.linspace(0.0, end, 7 if symmetric else 13)
        self.is_full = False
        self.random = np.random.default_rng(1)
        # A white surface's, until a table tells better.
        self.floor = FLOOR / np.pi

    def ask(self, rotation, incidence, radial, azimuth, bands=None) -> np.ndarray:
        """What is to be tabulated at flat arrays of coordinates; of some bands, or of those that are kept. (n, bands)"""
        bands = self.bands if bands is None else bands
        wo = _lift(incidence, direction_of(incidence, radial, azimuth), radial, azimuth)
        wi = np.stack([np.sin(incidence), np.zeros_like(incidence), np.cos(incidence)], axis=1)
        wi, wo = turned(wi, rotation), turned(wo, rotation)
        parts = [
            self.evaluate(wi[k : k + CHUNK], wo[k : k + CHUNK])[:, bands]
            for k in range(0, len(wi), CHUNK)
        ]
        return np.maximum(np.concatenate(parts), 0.0)

    def ask_grid(self, *axes) -> np.ndarray:
        """What is to be tabulated on a grid of rotations, incidences, radials and azimuths. (p, s, t, a, bands)"""
        shape = tuple(len(axis) for axis in axes)
        flat = [m.ravel() for m in np.meshgrid(*axes, indexing="ij")]
        return self.ask(*flat).reshape(*shape, len(self.bands))

    def axes(self) -> list[np.ndarray]:
        """The grid as it is."""
        return [self.rotations, self.incidences, self.radials, self.azimuths]

    def choose_bands(self, tolerance: float) -> None:
        """Leave out bands that linear interpolation between others gives back."""
        if len(self.wavelengths) == 1:
            return
        *coordinates, _ = self._random_pairs(TESTED // 16)
        values = self.ask(*coordinates)
        self.bands = choose_bands(self.wavelengths, values, SPECTRAL_PART * tolerance)

    def table(self) -> ScatterTable:
        """The table on the grid."""
        made = ScatterTable(
            self.rotations,
            self.incidences,
            self.radials,
            self.azimuths,
            self.wavelengths[self.bands],
            self.ask_grid(*self.axes()).astype(np.float32),
            is_orthotropic=self.is_orthotropic,
        )
        # Near grazing incidence a coarse grid may scatter more than comes, until totals are kept.
        albedo = min(max(albedo_of(made, s).max() for s in self.incidences), 1.0)
        self.floor = max(FLOOR * albedo / np.pi, 1e-12)
        return made

    def refine(self, threshold: float, most: int) -> bool:
        """Add grid lines where the table would be off by more than a threshold; tells whether any were."""
        axes = self.axes()
        axes[0] = self._closed_rotations()
        excess = [None] * 4
        kept = (self.has_own_rotations, self.has_own_incidences, False, False)
        for number, axis in enumerate(axes):
            if len(axis) > 1 and not kept[number]:
                excess[number] = self._errors(number, axis) / threshold
        while True:
            grown = [
                axis if by is None else np.union1d(axis, _divide(axis, by))
                for axis, by in zip(axes, excess, strict=True)
            ]
            size = np.prod([float(len(axis)) for axis in grown]) * len(self.bands)
            if size <= most:
                break
            # What does not fit is left; the worst intervals are divided first.
            self.is_full = True
            if all(len(new) == len(old) for new, old in zip(grown, axes, strict=True)):
                break
            excess = [None if by is None else by / 1.3 for by in excess]
        turns, self.incidences, self.radials, self.azimuths = grown
        if not self.has_own_rotations:
            self.rotations = turns if self.is_orthotropic else turns[:-1]
        return any(len(a) > len(b) for a, b in zip(grown, axes, strict=True))

    def _closed_rotations(self) -> np.ndarray:
        """The rotations, and where they end that are chosen: what lies behind the last one is an interval too."""
        if self.has_own_rotations or self.is_orthotropic:
            return self.rotations
        return np.append(self.rotations, 2.0 * np.pi)

    def _errors(self, number: int, axis: np.ndarray) -> np.ndarray:
        """Error in the middles between grid lines of one axis, along some of the lines of the others. (m,)"""
        axes = [self._some(each, LOOKED_AT[k]) for k, each in enumerate(self.axes())]
        axes[number] = axis
        values = self.ask_grid(*axes)
        axes[number] = 0.5 * (axis[1:] + axis[:-1])
        true = self.ask_grid(*axes)
        ends = [np.take(values, np.arange(len(axis) - 1) + k, axis=number) for k in (0, 1)]
        square = ((0.5 * (ends[0] + ends[1]) - true) / (true + self.floor)) ** 2
        wo = direction_of(*np.meshgrid(*axes[1:], indexing="ij"))
        weight = np.maximum(wo[..., 2], 0.0) + 1e-9
        if number != 2:
            # Of radial intervals the first is as wide as its neighbours, not as narrow as its ring.
            weight = weight * (np.sin(axes[2])[:, None] + 1e-9)
        square = square.mean(axis=-1)
        over = tuple(k for k in (2, 3) if k != number)
        sums = (square * weight).sum(over), weight.sum(tuple(k - 1 for k in over))
        mean = sums[0] / sums[1]
        return np.sqrt(mean.max(axis={0: 1, 1: 0}.get(number, (0, 1))))

    def _some(self, axis: np.ndarray, count: int) -> np.ndarray:
        """At most so many entries of an axis, others each time."""
        if len(axis) <= count:
            return axis
        return np.sort(self.random.choice(axis, count, replace=False))

    def keep_totals(self, table: ScatterTable) -> ScatterTable:
        """A table whose every incidence scatters as much as it should."""
        values = table.values.copy()
        for s, incidence in enumerate(self.incidences):
            radial, azimuth, weight = quadrature(table, incidence, FINE)
            tilt = np.full_like(radial, incidence)
            for p, rotation in enumerate(self.rotations):
                turn = np.full_like(radial, rotation)
                true = weight @ self.ask(turn, tilt, radial, azimuth)
                if incidence > GRAZING:
                    true = np.minimum(true, 1.0)
                made = weight @ interpolate(table, turn, tilt, radial, azimuth)
                values[p, s] *= np.where(made > 0.0, true / np.maximum(made, 1e-30), 1.0)
        return replace(table, values=values)

    def error_of(self, table: ScatterTable) -> float:
        """Error of a table, root mean square over random pairs and all bands, as `ScatterTable.error` says it.

        Of pairs spread by the cosine and of those crowded about the centre, whichever is larger: a narrow lobe is missed by
        the ones, and what lies beside it by the others.
        """
        *coordinates, is_near = self._random_pairs(TESTED)
        true = self.ask(*coordinates, slice(None))
        made = _between(self.wavelengths, self.bands, interpolate(table, *coordinates))
        square = (((made - true) / (true + self.floor)) ** 2).mean(axis=1)
        return float(np.sqrt(max(square[is_near].mean(), square[~is_near].mean())))

    def _random_pairs(self, count: int) -> tuple[np.ndarray, ...]:
        """Pairs of directions above the horizon, half of them crowded about the centre, the others spread by the cosine.

        Returns
        -------
        Rotation, incidence, radial angle, azimuth : (n,) arrays    [rad]
        is_near : (n,) bool array    Whether a pair is one of the crowded ones.
        """
        draw = self.random.random((6, 4 * count))
        near = draw[2] < 0.5
        if self.has_own_incidences:
            incidence = self.incidences[(draw[0] * len(self.incidences)).astype(int)]
        else:
            lowest, highest = self.incidences[[0, -1]]
            # Light from everywhere, or lobes at all incidences alike.
            sines = np.sin(lowest) ** 2, np.sin(highest) ** 2
            incidence = np.where(
                near,
                lowest + draw[0] * (highest - lowest),
                np.arcsin(np.sqrt(sines[0] + draw[0] * (sines[1] - sines[0]))),
            )
        if self.has_own_rotations:
            rotation = self.rotations[(draw[1] * len(self.rotations)).astype(int)]
        else:
            rotation = draw[1] * self.last_rotation
        end = self.azimuths[-1]
        sine = np.sqrt(draw[3])
        turn = 2.0 * np.pi * draw[4]
        spread = np.stack([sine * np.cos(turn), sine * np.sin(turn), np.sqrt(1.0 - draw[3])], 1)
        radial, azimuth = _coordinates(incidence, spread)
        radial = np.where(near, 0.5 * np.pi * draw[5] ** 2, radial)
        azimuth = np.where(near, end * draw[4], azimuth)
        azimuth = np.where(azimuth > end, 2.0 * np.pi - azimuth, azimuth)
        good = direction_of(incidence, radial, azimuth)[:, 2] > np.cos(LOWEST)
        return tuple(
            values[good][:count] for values in (rotation, incidence, radial, azimuth, near)
        )


def _divide(axis: np.ndarray, excess: np.ndarray) -> np.ndarray:
    """Points to be added within the intervals of an axis, by how many times too large the error in their middles is.

    It falls with the square of the interval's length, so that several points are added at once where it is far too large.
    """
    made = [np.zeros(0)]
    for low, high, by in zip(axis[:-1], axis[1:], excess, strict=True):
        parts = min(int(np.ceil(np.sqrt(by))), MOST_PARTS, int((high - low) / SMALLEST_STEP))
        if by > 1.0 and parts > 1:
            made.append(np.linspace(low, high, parts + 1)[1:-1])
    return np.concatenate(made)


def _coordinates(incidence, wo) -> tuple[np.ndarray, np.ndarray]:
    """Radial angle and azimuth of directions, light coming in the xz-plane."""
    sin_s, cos_s = np.sin(incidence), np.cos(incidence)
    centre = -sin_s * wo[:, 0] + cos_s * wo[:, 2]
    outward = -cos_s * wo[:, 0] - sin_s * wo[:, 2]
    radial = np.arctan2(np.hypot(outward, wo[:, 1]), centre)
    return radial, np.arctan2(wo[:, 1], outward) % (2.0 * np.pi)


def _lift(incidence, wo, radial, azimuth) -> np.ndarray:
    """Directions, those below `LOWEST` brought up to it along their azimuth about the centre."""
    low = np.cos(LOWEST)
    across = np.cos(azimuth) * np.sin(incidence)
    reach = np.hypot(np.cos(incidence), across)
    edge = np.arccos(np.clip(low / np.maximum(reach, 1e-12), -1.0, 1.0)) - np.arctan2(
        across, np.cos(incidence)
    )
    below = wo[:, 2] < low
    drawn_in = np.where(below, np.clip(np.minimum(radial, edge), 0.0, None), radial)
    wo = np.where(below[:, None], direction_of(incidence, drawn_in, azimuth), wo)
    flat = np.hypot(wo[:, 0], wo[:, 1])
    factor = np.where(wo[:, 2] < low, np.sqrt(1.0 - low**2) / np.maximum(flat, 1e-12), 1.0)
    return np.stack([wo[:, 0] * factor, wo[:, 1] * factor, np.maximum(wo[:, 2], low)], axis=1)


def _between(wavelengths: np.ndarray, kept: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Values of all bands from those of the ones that are kept, linear between them. (n, k) -> (n, w)"""
    if len(kept) == 1:
        return np.broadcast_to(values, (len(values), len(wavelengths)))
    below = np.clip(
        np.searchsorted(wavelengths[kept], wavelengths, side="right") - 1, 0, len(kept) - 2
    )
    low, high = wavelengths[kept[below]], wavelengths[kept[below + 1]]
    share = (wavelengths - low) / (high - low)
    return values[:, below] * (1.0 - share) + values[:, below + 1] * share
