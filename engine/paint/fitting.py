"""The composition of a paint found from what it reflects: colours by a hand instrument, or a measured BRDF.

Fringes make many minima: a core thicker by lambda / (2 n) gives nearly the same colour at the gloss. So thicknesses of cores
are first gone through in steps finer than that, the best of them become starts, and least squares within bounds goes on from
each. Errors are those of the readings, carried through the slopes at the best minimum; where readings are met worse than
their errors say, all errors are larger by that.
"""

import copy
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from ..errors import LumenrayError, SceneError
from .least_squares import Minimum, minimise
from .orange_peel import evaluate
from .reader import parse_paint
from .readings import read_lab
from .solution import WAVELENGTHS, Resolution, Solution, resolution_for, solve

STARTS = 4
"""Places of a scan from which least squares begins."""

SCANNED, MOST_SCANNED = 16, 64
"""Places of a scan for each number, and altogether."""

ORDERS = 6.0
"""Steps of a scan in each interference order."""

MOST_PARAMETERS = 12

COARSE = Resolution(16, 12)
"""Resolution of a scan."""

FLOOR = 0.01
"""Part of a measured value's error that does not go with it. [1/sr]"""


@dataclass(frozen=True)
class Parameter:
    """A number of a composition that is looked for.

    Parameters
    ----------
    place : str    Where it stands, such as ``layers/0/flakes/0/tilt_deg``.
    low, high : float    Between which it is, both above 0; it is looked for on a logarithmic scale.
    """

    place: str
    low: float
    high: float

    def at(self, share: float) -> float:
        """Number at a share of the way from low to high."""
        return self.low * (self.high / self.low) ** share

    def share_of(self, value: float) -> float:
        """What `at` takes for a number."""
        share = math.log(value / self.low) / math.log(self.high / self.low)
        return min(max(share, 0.0), 1.0)


class Readings(Protocol):
    """What a paint was seen to reflect."""

    wavelengths: np.ndarray

    def residuals(self, solution: Solution) -> np.ndarray:
        """How far a solution is from them, in standard errors. (r,)"""
        ...


@dataclass(frozen=True, eq=False)
class LabReadings:
    """Colours by a hand instrument.

    Parameters
    ----------
    angles : (n,) float64 array    Aspecular. [deg]
    lab : (n, 3) float64 array    L*, a*, b* under D65, 10 degrees.
    error : float    Standard error of each.
    incidence : float    [deg]
    """

    angles: np.ndarray
    lab: np.ndarray
    error: float = 0.3
    incidence: float = 45.0
    wavelengths: np.ndarray = field(default_factory=lambda: WAVELENGTHS)

    def residuals(self, solution: Solution) -> np.ndarray:
        """As of `Readings`."""
        return ((read_lab(solution, self.angles, self.incidence) - self.lab) / self.error).ravel()


@dataclass(frozen=True, eq=False)
class BrdfReadings:
    """A measured BRDF.

    Parameters
    ----------
    wi, wo : (n, 3) float64 arrays    Directions.
    values : (n, w) float64 array    [1/sr]
    wavelengths : (w,) float64 array    [nm]
    error : float    Relative standard error. [-]
    """

    wi: np.ndarray
    wo: np.ndarray
    values: np.ndarray
    wavelengths: np.ndarray
    error: float = 0.05

    def residuals(self, solution: Solution) -> np.ndarray:
        """As of `Readings`."""
        found = evaluate(solution, self.wi, self.wo)
        return ((found - self.values) / (self.error * (self.values + FLOOR))).ravel()


@dataclass(frozen=True, eq=False)
class Fitted:
    """A composition that was found.

    Parameters
    ----------
    content : dict    Its description, as of `reader.parse_paint`.
    parameters : tuple of Parameter
    values, errors : (p,) float64 arrays    And their standard errors; infinite where the readings do not tell.
    correlations : (p, p) float64 array
    residual : float    Root mean square of what is left, in standard errors of the readings.
    readings : int    Numbers that were read.
    calls : int    Paints that were solved.
    at_bounds : tuple of str    Places of numbers that ended at a bound.
    """

    content: dict
    parameters: tuple[Parameter, ...]
    values: np.ndarray
    errors: np.ndarray
    correlations: np.ndarray
    residual: float
    readings: int
    calls: int
    at_bounds: tuple[str, ...]


def read_place(content: dict, place: str) -> float:
    """Number at a place of a description.

    Raises
    ------
    SceneError    There is no number.
    """
    target = content
    try:
        for step in place.split("/"):
            target = target[int(step)] if isinstance(target, list) else target[step]
    except (KeyError, IndexError, ValueError, TypeError):
        raise SceneError(f"the composition has nothing at '{place}'") from None
    if isinstance(target, bool) or not isinstance(target, int | float):
        raise SceneError(f"the composition has no number at '{place}'")
    return float(target)


def with_values(content: dict, parameters: Sequence[Parameter], values) -> dict:
    """A description with numbers in their places."""
    made = copy.deepcopy(content)
    for parameter, value in zip(parameters, values, strict=True):
        *way, last = parameter.place.split("/")
        target = made
        for step in way:
            target = target[int(step)] if isinstance(target, list) else target[step]
        target[int(last) if isinstance(target, list) else last] = float(value)
    return made


def usual_parameters(content: dict) -> tuple[Parameter, ...]:
    """What is looked for where nothing is said: amounts, tilts and thicknesses of cores of all flakes, amounts of grains."""
    found = []
    for number, layer in enumerate(content["layers"]):
        for k, flakes in enumerate(layer.get("flakes", [])):
            here = f"layers/{number}/flakes/{k}"
            ((kind, value),) = flakes["amount"].items()
            found.append(Parameter(f"{here}/amount/{kind}", value / 8.0, value * 8.0))
            if "tilt_deg" in flakes:
                found.append(Parameter(f"{here}/tilt_deg", 1.5, 20.0))
            if "stack" in flakes:
                value = flakes["stack"]["core"]["thickness_nm"]
                found.append(Parameter(f"{here}/stack/core/thickness_nm", 0.5 * value, 2.0 * value))
        for k, pigment in enumerate(layer.get("pigments", [])):
            if "amount" in pigment:
                ((kind, value),) = pigment["amount"].items()
                found.append(
                    Parameter(
                        f"layers/{number}/pigments/{k}/amount/{kind}", value / 8.0, value * 8.0
                    )
                )
    return tuple(found)


def fit_paint(
    content: dict,
    readings: Readings,
    parameters: Sequence[Parameter] | None = None,
    constituents: dict | None = None,
    seed: int = 0,
    starts: int = STARTS,
    scanned: int | None = None,
    path="paint",
) -> Fitted:
    """Find numbers of a composition with which it reflects what was read.

    Parameters
    ----------
    content : dict    A description; its numbers do not count where they are looked for.
    parameters : sequence of Parameter or None    None: `usual_parameters`.
    constituents : dict or None    As of `reader.parse_paint`.
    starts, scanned : int    Places from which least squares goes on at most, and of the scan that finds them.

    Raises
    ------
    SceneError    There is nothing to look for, or too much.
    FileFormatError    The description is none.
    """
    content = parse_paint(content, constituents, path).content
    parameters = tuple(usual_parameters(content) if parameters is None else parameters)
    if not 1 <= len(parameters) <= MOST_PARAMETERS:
        raise SceneError(
            f"found {len(parameters)} numbers to look for, expected 1 to {MOST_PARAMETERS}"
        )
    for each in parameters:
        read_place(content, each.place)
    search = _Search(content, readings, parameters, constituents, path)
    best: Minimum | None = None
    for start in search.scan(seed, scanned or min(SCANNED * len(parameters), MOST_SCANNED))[
        :starts
    ]:
        found = minimise(search.residuals, start)
        if best is None or found.cost < best.cost:
            best = found
        if best.cost < len(best.residuals):
            # Met as well as the readings are known: no other order can be told from it.
            break
    return search.result(best)


class _Search:
    """Residuals of a composition's numbers, each by its share of the way between its bounds."""

    def __init__(self, content, readings, parameters, constituents, path):
        self.content, self.readings, self.parameters = content, readings, parameters
        self.constituents, self.path = constituents, path
        self.calls = 0
        self.resolution: Resolution | None = None

    def paint(self, place):
        values = [each.at(share) for each, share in zip(self.parameters, place, strict=True)]
        return parse_paint(
            with_values(self.content, self.parameters, values), self.constituents, self.path
        )

    def residuals(self, place) -> np.ndarray:
        paint = self.paint(place)
        self.calls += 1
        size = self.resolution or resolution_for(paint)
        return self.readings.residuals(solve(paint, self.readings.wavelengths, resolution=size))

    def scan(self, seed: int, scanned: int) -> list[np.ndarray]:
        """Places to start from, the best first."""
        rng = np.random.default_rng(seed)
        count = len(self.parameters)
        # Even in every number, and in their order at random.
        shares = (
            np.argsort(rng.random((count, scanned)), axis=1) + rng.random((count, scanned))
        ) / scanned
        places = list(shares.T)
        self.resolution = COARSE
        costs = [self._cost(place) for place in places]
        self.resolution = None
        order = np.argsort(costs)
        starts = [places[k] for k in order[: 2 * STARTS] if np.isfinite(costs[k])]
        return self._through_orders(starts)

    def _cost(self, place) -> float:
        try:
            found = self.residuals(place)
        except LumenrayError:
            # Numbers that together are no paint, as more particles than there is room for.
            return math.inf
        # What is far off counts little more than what is off: a scan looks for what fits in most readings.
        return float(np.log1p(found**2 * 1e-2).sum())

    def _through_orders(self, starts: list[np.ndarray]) -> list[np.ndarray]:
        """Starts with the thicknesses of their cores gone through, the best first."""
        cores = [
            k for k, each in enumerate(self.parameters) if each.place.endswith("core/thickness_nm")
        ]
        self.resolution = COARSE
        ranked = [(self._cost(place), place) for place in starts]
        for core in cores:
            own = self.parameters[core]
            # A quarter of the wavelength by the index, of which there are so many steps in each order.
            step = 550.0 / (2.0 * 1.6) / ORDERS
            values = np.arange(own.low, own.high, step)[:MOST_SCANNED]
            tried = []
            for _, place in sorted(ranked, key=lambda each: each[0])[:2]:
                for value in values:
                    moved = place.copy()
                    moved[core] = own.share_of(value)
                    tried.append((self._cost(moved), moved))
            ranked += tried
        self.resolution = None
        ranked.sort(key=lambda each: each[0])
        chosen: list[np.ndarray] = []
        for _, place in ranked:
            # Starts that differ: neighbours end in the same minimum.
            if all(np.abs(place - other).max() > 0.5 / ORDERS for other in chosen):
                chosen.append(place)
        return chosen

    def result(self, best: Minimum) -> Fitted:
        values = np.array(
            [each.at(share) for each, share in zip(self.parameters, best.place, strict=True)]
        )
        ranges = np.log([each.high / each.low for each in self.parameters])
        square = best.slopes.T @ best.slopes
        spare = max(len(best.residuals) - len(values), 1)
        scale = max(best.cost / spare, 1.0)
        known = np.diag(square) > 1e-12
        covariance = np.full(square.shape, 0.0)
        inner = np.ix_(known, known)
        covariance[inner] = np.linalg.pinv(square[inner], rcond=1e-12) * scale
        spread = np.sqrt(np.diag(covariance))
        errors = np.where(known, values * ranges * spread, np.inf)
        both = np.outer(spread, spread)
        correlations = np.divide(covariance, both, out=np.eye(len(values)), where=both > 0.0)
        at_bounds = tuple(
            each.place
            for each, share in zip(self.parameters, best.place, strict=True)
            if not 0.0 < share < 1.0
        )
        return Fitted(
            with_values(self.content, self.parameters, values),
            self.parameters,
            values,
            errors,
            correlations,
            float(np.sqrt(best.cost / len(best.residuals))),
            len(best.residuals),
            self.calls,
            at_bounds,
        )
