"""Tables about the mirror direction made from any scattering that can be evaluated, as coarse as a wanted error allows.

Random pairs of directions tell how much of the error comes of each interval of each axis; those are halved that it falls
most by for the values that they cost, until it is as wanted. Bands that lie on the line between their neighbours are left
out. At the end the values of each incidence are scaled so that the table reflects, or lets through, as much as what it was
made from: a chord lies above a lobe's flanks.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from ...errors import SceneError
from ...scene.scattering import ScatterTable
from .table import (
    albedos_of,
    direction_of,
    has_many_cells,
    interpolate,
    place_on,
    quadrature,
    turned,
    weights_of_points,
)

Evaluate = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""Values for pairs of directions wi, wo: (n, 3), (n, 3) -> (n, w). [1/sr]"""

RADIALS = np.radians([0, 1, 2, 4, 6, 10, 15, 22, 30, 45, 60, 90, 120, 180.0])
"""Where radial angles begin."""

ROTATIONS = 12
"""Into how many parts a turn is divided where rotations begin."""

INCIDENCES = np.radians([0, 15, 30, 45, 60, 75, 89.0])
"""Where angles of incidence begin; at 90 degrees nothing arrives."""

LOWEST = np.radians(89.0)
"""Directions farther from the normal take the value there: what lies below the horizon must not count as dark. [rad]"""

FLOOR = 0.05
"""Share of a matt surface's value that is added to values where their error is told relative to them."""

MOST_VALUES = 1 << 21
"""Values that a table may grow to: 4 MB before its file is compressed."""

LARGEST_START = 1 << 25
"""Values of the grid to begin with, at most."""

TESTED, FAR_TESTED = 1 << 14, 1 << 12
"""Pairs of directions that the error is measured with: near the goal, and far from it, where all intervals are coarse."""

CHUNK = 1 << 16
"""Pairs that are evaluated in one go."""

SPECTRAL_PART = 0.5
"""Share of the tolerance that may come of bands left out: with the same order of error along all four axes of an isotropic
table, a quarter of the square is theirs."""

AIM = 0.85
"""Share of the tolerance at which refinement ends: other pairs may say more, and totals have to be kept."""

LEAST_AIM = 0.3
"""Share of the tolerance below which the grid's part of the error is not brought: what is left comes of bands left out."""

FAR = 2.0
"""Times the goal from which on an error is far from it. [-]"""

GROWTH, FAR_GROWTH = 1.2, 1.6
"""By how much a grid grows at most before errors are measured again: near the goal, and far from it."""

WORST = 1.0
"""Square of an error that counts as much as any larger one while a grid is coarse. [-]"""

FINE = 3
"""Points of Gauss and Legendre along both axes in each cell that totals are found with."""

FLOOR_INCIDENCES = 32
"""Angles of incidence, at most, at which the largest total is looked for that the floor follows."""

GRAZING = np.radians(80.0)
"""From here on lobes get narrower than any grid, and totals are kept below 1. [rad]"""

SMALLEST_STEP = np.radians(0.05)
"""Intervals that are shorter are not halved."""


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
    table, goal, is_far = maker.table(), AIM * tolerance, True
    while True:
        shares, error = maker.find_errors(FAR_TESTED if is_far else TESTED)
        is_fine = error <= goal
        if is_fine:
            table = maker.table()
            found = maker.error_of(table)
            if found <= AIM * tolerance or goal < LEAST_AIM * tolerance:
                break
            goal = error * max(0.95 * AIM * tolerance / found, 0.7)
        is_far = error > FAR * goal
        if not maker.divide(shares, most, FAR_GROWTH if is_far else GROWTH):
            # What does not fit is left; the table tells its error.
            table = table if is_fine else maker.table()
            break
    table = maker.keep_totals(table)
    return replace(table, error=maker.error_of(table))


def measure_error(true: Evaluate, made: Evaluate, largest_albedo: float) -> float:
    """Error of an isotropic scattering that stands for another one, measured and told like `ScatterTable.error`.

    Parameters
    ----------
    true, made : Evaluate    What is stood for, and what stands for it, in the same bands.
    largest_albedo : float    Of what is stood for, over incidences and bands. [-]
    """
    makers = [_Maker(each, np.zeros(1), None, (0.0,), False, False, ()) for each in (true, made)]
    *coordinates, is_near = makers[0].random_pairs(TESTED)
    values = [maker.ask(*coordinates, slice(None)) for maker in makers]
    return _larger_error(*values, _floor_of(largest_albedo), is_near)


def _floor_of(albedo: float) -> float:
    """What is added to values where errors are told relative to them, by the largest albedo. [1/sr]"""
    return max(FLOOR * min(albedo, 1.0) / np.pi, 1e-12)


def _larger_error(true, made, floor: float, is_near) -> float:
    """Relative root mean square of the error of values (n, w), of the pairs near the centre or of the others."""
    square = (((made - true) / (true + floor)) ** 2).mean(axis=1)
    return float(np.sqrt(max(square[is_near].mean(), square[~is_near].mean())))


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
        self.random = np.random.default_rng(1)
        # A white surface's, until a table tells better.
        self.floor = FLOOR / np.pi
        self.known_axes = [np.empty(0)] * 4
        self.known = np.empty((0, 0, 0, 0, 1), dtype=np.float32)

    def ask(self, rotation, incidence, radial, azimuth, bands=None) -> np.ndarray:
        """What is to be tabulated at coordinates that fit together; of some bands, or of those that are kept. (n, bands)"""
        bands = self.bands if bands is None else bands
        shape = np.broadcast_shapes(*map(np.shape, (rotation, incidence, radial, azimuth)))
        wo = _raised(direction_of(incidence, radial, azimuth))
        wi = np.stack([np.sin(incidence), np.zeros_like(incidence), np.cos(incidence)], axis=-1)
        wi, wo = (np.broadcast_to(each, (*shape, 3)).reshape(-1, 3) for each in (wi, wo))
        if np.any(rotation):
            turns = np.broadcast_to(rotation, shape).ravel()
            wi, wo = turned(wi, turns), turned(wo, turns)
        parts = [
            self.evaluate(wi[k : k + CHUNK], wo[k : k + CHUNK])[:, bands]
            for k in range(0, len(wi), CHUNK)
        ]
        return np.maximum(np.concatenate(parts), 0.0)

    def ask_grid(self, *axes) -> np.ndarray:
        """What is to be tabulated on a grid of rotations, incidences, radials and azimuths. (p, s, t, a, bands)"""
        shape = tuple(len(axis) for axis in axes)
        return self.ask(*np.ix_(*axes)).reshape(*shape, len(self.bands))

    def grid_values(self) -> np.ndarray:
        """What is to be tabulated on the grid as it is, asked where an earlier one has no point. (p, s, t, a, bands)"""
        axes = self.axes()
        made = np.empty((*map(len, axes), len(self.bands)), dtype=np.float32)
        is_old = [np.isin(axis, own) for axis, own in zip(axes, self.known_axes, strict=True)]
        made[np.ix_(*is_old)] = self.known
        for k, old in enumerate(is_old):
            # Lines that one axis got, where those before it have their old ones: each point once.
            chosen = [*is_old[:k], ~old, *(np.ones_like(each) for each in is_old[k + 1 :])]
            if all(each.any() for each in chosen):
                new = [axis[each] for axis, each in zip(axes, chosen, strict=True)]
                made[np.ix_(*chosen)] = self.ask_grid(*new)
        self.known_axes, self.known = axes, made
        return made

    def axes(self) -> list[np.ndarray]:
        """The grid as it is."""
        return [self.rotations, self.incidences, self.radials, self.azimuths]

    def choose_bands(self, tolerance: float) -> None:
        """Leave out bands that linear interpolation between others gives back."""
        if len(self.wavelengths) == 1:
            return
        *coordinates, _ = self.random_pairs(TESTED // 16)
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
            self.grid_values(),
            is_orthotropic=self.is_orthotropic,
        )
        # Near grazing incidence a coarse grid may scatter more than comes, until totals are kept.
        step = -(-len(self.incidences) // FLOOR_INCIDENCES)
        self.floor = _floor_of(albedos_of(made, self.incidences[::step], self.rotations).max())
        return made

    def find_errors(self, count: int) -> tuple[list[np.ndarray], float]:
        """Squares of errors by axis and interval, as they count by the values that an interval costs; and the whole error.

        Of so many random pairs, along each axis alone: between its grid lines there is a chord, elsewhere what is to be
        tabulated.
        """
        *places, is_near = self.random_pairs(count)
        true = self.ask(*places)
        axes = [self._closed_rotations(), *self.axes()[1:]]
        squares = [self._squares_along(k, axis, places, true) for k, axis in enumerate(axes)]
        both = [sum(square[those].mean() for square in squares) for those in (is_near, ~is_near)]
        # As the larger one of both populations tells the error, that one counts for more.
        weight = np.where(is_near, both[0] / is_near.sum(), both[1] / (~is_near).sum())
        shares = []
        for axis, place, square in zip(axes, places, squares, strict=True):
            below = place_on(axis, place)[0] if len(axis) > 1 else np.zeros(len(place), dtype=int)
            share = np.bincount(below, square * weight, max(len(axis) - 1, 0)) * len(axis)
            shares.append(np.where(np.diff(axis) > SMALLEST_STEP, share[: len(axis) - 1], 0.0))
        return shares, float(np.sqrt(max(both)))

    def _squares_along(self, number: int, axis: np.ndarray, places: list, true) -> np.ndarray:
        """Squares of the relative errors of pairs between the grid lines of one axis, mean over the bands. (n,)"""
        is_kept = (self.has_own_rotations, self.has_own_incidences, False, False)[number]
        if is_kept or len(axis) == 1:
            return np.zeros(len(true))
        below, share = place_on(axis, places[number])
        ends = [
            self.ask(*places[:number], axis[below + step], *places[number + 1 :]) for step in (0, 1)
        ]
        made = ends[0] + share[:, None] * (ends[1] - ends[0])
        return np.minimum((((made - true) / (true + self.floor)) ** 2).mean(axis=1), WORST)

    def divide(self, shares: list[np.ndarray], most: int, growth: float) -> bool:
        """Halve the intervals that count most; tells whether there were any for which there is room."""
        axes = [self._closed_rotations(), *self.axes()[1:]]
        counts = np.array([len(axis) for axis in axes], dtype=float)
        room = min(growth * counts.prod(), most / len(self.bands))
        added: list[list[float]] = [[], [], [], []]
        numbers = np.repeat(range(4), [len(share) for share in shares])
        places = np.concatenate([np.arange(len(share)) for share in shares])
        shares = np.concatenate(shares)
        for best in np.argsort(-shares, kind="stable")[: np.count_nonzero(shares)]:
            number, place = numbers[best], places[best]
            counts[number] += 1
            # The first one may be more than the growth of a round.
            if counts.prod() > (room if any(added) else most / len(self.bands)):
                break
            added[number].append(axes[number][place : place + 2].mean())
        axes = [np.union1d(axis, new) for axis, new in zip(axes, added, strict=True)]
        turns, self.incidences, self.radials, self.azimuths = axes
        if not self.has_own_rotations:
            self.rotations = turns if self.is_orthotropic else turns[:-1]
        return any(added)

    def _closed_rotations(self) -> np.ndarray:
        """The rotations, and where they end that are chosen: what lies behind the last one is an interval too."""
        if self.has_own_rotations or self.is_orthotropic:
            return self.rotations
        return np.append(self.rotations, 2.0 * np.pi)

    def keep_totals(self, table: ScatterTable) -> ScatterTable:
        """A table whose every incidence scatters as much as it should."""
        values = table.values.copy()
        for s, incidence in enumerate(self.incidences):
            points = FINE
            if has_many_cells(table):
                # What the table and the truth differ by is 0 at grid points, but not where the horizon cuts cells.
                points = 1 if incidence <= GRAZING else FINE - 1
            radial, azimuth, weight = quadrature(table, incidence, points)
            weights = weights_of_points(table, radial, azimuth, weight)
            for p, rotation in enumerate(self.rotations):
                true = weight @ self.ask(rotation, incidence, radial, azimuth)
                if incidence > GRAZING:
                    true = np.minimum(true, 1.0)
                made = np.tensordot(values[p, s], weights, ((0, 1), (0, 1)))
                values[p, s] *= np.where(made > 0.0, true / np.maximum(made, 1e-30), 1.0)
        return replace(table, values=values)

    def error_of(self, table: ScatterTable) -> float:
        """Error of a table, root mean square over random pairs and all bands, as `ScatterTable.error` says it.

        Of pairs spread by the cosine and of those crowded about the centre, whichever is larger: a narrow lobe is missed by
        the ones, and what lies beside it by the others.
        """
        *coordinates, is_near = self.random_pairs(TESTED)
        true = self.ask(*coordinates, slice(None))
        made = _between(self.wavelengths, self.bands, interpolate(table, *coordinates))
        return _larger_error(true, made, self.floor, is_near)

    def random_pairs(self, count: int) -> tuple[np.ndarray, ...]:
        """Pairs of directions above the horizon, half of them crowded about the centre, the others spread by the cosine.

        Returns
        -------
        Rotation, incidence, radial angle, azimuth : (n,) arrays    [rad]
        is_near : (n,) bool array    Whether a pair is one of the crowded ones.
        """
        # More than enough, as most lie above the horizon.
        draw = self.random.random((6, 4 * count))[:, : 2 * count]
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


def _coordinates(incidence, wo) -> tuple[np.ndarray, np.ndarray]:
    """Radial angle and azimuth of directions, light coming in the xz-plane."""
    sin_s, cos_s = np.sin(incidence), np.cos(incidence)
    centre = -sin_s * wo[:, 0] + cos_s * wo[:, 2]
    outward = -cos_s * wo[:, 0] - sin_s * wo[:, 2]
    radial = np.arctan2(np.hypot(outward, wo[:, 1]), centre)
    return radial, np.arctan2(wo[:, 1], outward) % (2.0 * np.pi)


def _raised(wo) -> np.ndarray:
    """Directions, those below `LOWEST` brought up to it in their plane with the normal."""
    low = np.cos(LOWEST)
    is_low = wo[..., 2] < low
    flat = wo[is_low, :2]
    flat *= np.sqrt(1.0 - low**2) / np.maximum(np.hypot(*flat.T), 1e-12)[:, None]
    made = wo.copy()
    made[is_low] = np.column_stack([flat, np.full(len(flat), low)])
    return made


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
