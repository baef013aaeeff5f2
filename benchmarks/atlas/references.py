"""Converged illuminances of lumels by plain path tracing: the engine's estimator for sensors, which knows no cells.

They are kept in a folder, by what they were computed from, so that a later run need not wait for them.
"""

import hashlib
import time
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...engine import VERSION
from ...engine.accuracy.stopping import StopRule
from ...engine.reading.whole_file import write_whole
from .lumels import LumelPlaces
from .stage import Stage

FOLDER = Path("out/atlas/references")

GROUPS = 16
"""Independent groups, whose spread gives the error of every lumel."""

SEED = 90_001
"""No bake that is judged has it."""


@dataclass(frozen=True, eq=False)
class Reference:
    """Illuminances of lumels.

    Parameters
    ----------
    values, errors : (n,) float64 array    With standard errors. [lx]
    weights : (n,) float64 array    Areas. [m2]
    samples : int    Per lumel.
    seconds : float    That it took when it was computed.
    """

    values: np.ndarray
    errors: np.ndarray
    weights: np.ndarray
    samples: int
    seconds: float

    @property
    def mean(self) -> float:
        """Area-weighted mean. [lx]"""
        return float((self.weights * self.values).sum() / self.weights.sum())

    @property
    def relative_error(self) -> float:
        """Root mean square of the standard errors over the mean, area-weighted. [-]"""
        return self._share(self.errors**2)

    def error_of(self, values: np.ndarray) -> float:
        """Root mean square difference of other values over the mean, without what is the reference's own. [-]"""
        return self._share((values - self.values) ** 2 - self.errors**2)

    def stated(self, errors: np.ndarray) -> float:
        """Root mean square of stated standard errors over the mean. [-]"""
        return self._share(errors**2)

    def ratio(self, values: np.ndarray) -> tuple[float, float]:
        """Mean of other values over the mean, and how well the reference alone lets that be known."""
        total = self.weights.sum()
        spread = np.sqrt(((self.weights * self.errors) ** 2).sum()) / total / self.mean
        return float((self.weights * values).sum() / total / self.mean), float(spread)

    def take(self, rows) -> "Reference":
        """Some of the lumels."""
        return Reference(
            self.values[rows], self.errors[rows], self.weights[rows], self.samples, self.seconds
        )

    def _share(self, squares: np.ndarray) -> float:
        square = (self.weights * squares).sum() / self.weights.sum()
        return float(np.sqrt(max(square, 0.0))) / self.mean


def find_reference(
    stage: Stage, places: LumelPlaces, error: float, longest: float, say, folder: Path = FOLDER
) -> Reference:
    """Return the reference of lumels, from the folder or computed anew.

    Parameters
    ----------
    error : float    Relative standard error to reach. [-]
    longest : float    Time after which less has to do. [s]
    """
    key = hashlib.sha256(
        f"{VERSION} {stage.variant} {stage.scene.hash()} {places.digest()} {error} {longest}".encode()
    ).hexdigest()
    path = folder / f"{key[:32]}.npz"
    if path.is_file():
        with np.load(path, allow_pickle=False) as kept:
            return Reference(
                kept["values"],
                kept["errors"],
                places.area,
                int(kept["samples"]),
                float(kept["seconds"]),
            )
    made = _compute(stage, places, error, longest)
    say(
        f"reference of {len(places)} lumels: {100 * made.relative_error:.2f} % in {made.seconds:.0f} s"
    )
    with write_whole(path) as file:
        np.savez(
            file,
            values=made.values,
            errors=made.errors,
            samples=np.int64(made.samples),
            seconds=np.float64(made.seconds),
        )
    return made


def _compute(stage: Stage, places: LumelPlaces, error: float, longest: float) -> Reference:
    from ...engine.transport.paths.illuminance import compute

    start = time.perf_counter()
    rule = StopRule(error=error, seconds=longest)
    made = compute(stage.compiled, places.receivers(), rule, SEED, GROUPS)
    seconds = time.perf_counter() - start
    return Reference(made.mean, made.standard_error, places.area, made.samples, seconds)
