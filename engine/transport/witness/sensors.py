"""Sensors before a second witness: what light paths bring to small squares about them, beside gathering on these squares."""

from dataclasses import dataclass

import numpy as np

from ...accuracy.estimate import Estimate
from ...accuracy.stopping import StopRule
from ...accuracy.tails import TRUSTED
from ...accuracy.witnesses import OWN_ERRORS, Verdict, batch_error, compare
from ...scene.sensor import SensorKind
from ..paths.illuminance import compute
from .pilot import BATCHES, LOOKS, PATHS, Witness, WitnessReport
from .sheets import MOST, Sheets

QUICKEST = 1 << 17
"""Paths for a quick look at a few sensors."""

SAMPLES = (1 << 8, 1 << 12)
"""Fewest and most samples of gathering on each square; half as many as the sensors had in between."""

GROUPS = 16
"""Independent groups of them."""

MORE = 4
"""Times as many samples in the last look, at most."""

DOUBT = 0.3
"""Probability of a second look where there is no difference: errors of single sensors are less certain than those of
maps. [-]"""

UNSUPPORTED = 2.0
"""Times what a sensor states that gathering about it has for an error, with as many samples, if there was doubt. [-]"""

SUPPORTED = 2.0 / 3.0
"""Least part of a square's own error that counts where its sensor states less: a lucky sensor has seen none of the rare
light that makes the error of both. [-]"""

STAGE = "second witness"
"""What is being done, for people."""

PATH, GATHERED = 1.0, 1.7
"""What a path from the lights, and a sample of gathering on a square, takes beside one at a sensor in a long pass, about.
(In five scenes 0.6 to 5, and 1.4 to 2.9: the less the longer samples take, and so the longer the witness.)"""

CHUNK = 1 << 12
"""Sensors whose nearest ones are looked for at once."""


@dataclass(frozen=True)
class SensorTestimony:
    """What the witness says.

    Parameters
    ----------
    floors : (n,) array    What the error of each sensor must be at least. [lx]
    notes : tuple of str    What differs, for people.
    decision : str    How the two compare on the whole, for people; empty where no sensor could be looked at.
    balance : dict    Energy of the whole. [lm]
    """

    floors: np.ndarray
    notes: tuple[str, ...]
    decision: str
    balance: dict


def hear_sensors(
    scene,
    positions,
    normals,
    kind: SensorKind,
    found: Estimate,
    seed: int,
    reflections: int | None = None,
    cancelled=lambda: False,
) -> SensorTestimony:
    """Compare gathering at sensors with light paths.

    Parameters
    ----------
    scene : CompiledScene    With all that the measurement used.
    positions, normals : (n, 3) array    In the world. [m]
    kind : SensorKind
    found : Estimate    Of the measurement. (n,) [lx]
    seed : int
    reflections : int or None    Most reflections that counted.
    cancelled : callable    Asked before every launch.
    """
    sheets = Sheets(scene, positions, normals, kind)
    squares = sheets.squares
    for number in LOOKS:
        look = _look(scene, sheets, found, number, seed + number - 1, reflections, cancelled)
        if number == 1:
            floors = np.zeros(len(found.mean))
            # Where nothing at all was found, that is known as well as the pilot can tell of the whole.
            nothing = (found.mean == 0.0) & (found.standard_error == 0.0)
            floors[nothing] = look.report.heaviest / (np.pi * scene.radius**2)
        if look.verdict is None:
            return SensorTestimony(floors, look.report.told(), "", look.report.balance())
        if not look.verdict.is_doubtful:
            break
    report, made, verdict = look.report, look.gathered, look.verdict
    lacks = np.bincount(squares.sensor, verdict.floor * verdict.differs, len(floors))
    telling = _find_telling(made, report, squares.sensor)
    each = lacks[_find_nearest(scene, positions, normals, telling)]
    each = np.maximum(each, abs(verdict.rest) * sheets.faces)
    floors = np.maximum(floors, each * sheets.response)
    lucky = np.zeros(len(floors), dtype=bool)
    if number > 1:
        # What stood in doubt is not known better than more samples about it know it.
        near = _find_nearest(scene, positions, normals, np.unique(squares.sensor))
        known = _rare_errors(made, found, squares.sensor)[near] * sheets.response
        lucky = known > np.maximum(UNSUPPORTED * found.standard_error, floors)
        floors = np.where(lucky, known, floors)
    error = float(batch_error(report.sheet_batches.mean(axis=1)))
    decision = (
        f"{report.paths} light paths from the lights bring {report.sheets.mean():.4g} ± {error:.2g} lx to "
        f"{len(squares.sensor)} squares about sensors, gathering {made.mean.mean():.4g} ± "
        f"{_mean_error(made.standard_error):.2g} lx"
    )
    notes = report.told() + _tell(look.witness, sheets, verdict, made, report)
    if lucky.any():
        notes += (
            f"{lucky.sum()} of {len(lucky)} sensors scatter less than gathering about them does, so they may have missed "
            f"rare light: their stated errors are those of the places about them",
        )
    return SensorTestimony(floors, notes, decision, report.balance())


def expect_work(samples: float, count: int) -> float:
    """How many samples of each sensor one look at a measurement is worth.

    ``samples``: that each of so many sensors had.
    """
    paths, gathered = _amounts(samples, count)
    return (PATH * paths + GATHERED * gathered * min(count, MOST)) / count


def _amounts(samples: float, count: int) -> tuple[int, int]:
    """Paths from the lights, and samples of gathering on each square; parameters as of `expect_work`."""
    # A quick look at a few sensors gets a quick witness.
    return int(np.clip(samples * count, QUICKEST, PATHS)), int(np.clip(samples // 2, *SAMPLES))


@dataclass(frozen=True)
class _Look:
    """What light paths bring to squares about sensors, and what gathering finds on them; None where there are none."""

    witness: Witness
    report: WitnessReport
    gathered: Estimate | None = None
    verdict: Verdict | None = None


def _look(
    scene, sheets: Sheets, found: Estimate, number: int, seed: int, reflections, cancelled
) -> _Look:
    """Compare both; ``number``: of `LOOKS`."""
    paths, samples = _amounts(found.samples, len(found.mean))
    has_some = len(sheets) > 0
    witness = Witness(scene, seed, set(), sheets if has_some else None, cancelled)
    report = witness.run(paths, reflections, number)
    if not has_some:
        return _Look(witness, report)
    squares = sheets.squares
    gathered = compute(
        scene,
        sheets.receivers(seed),
        StopRule(samples=min(number, MORE) * samples),
        seed,
        GROUPS,
        cancelled=cancelled,
        reflections=reflections,
    )
    error = gathered.standard_error
    verdict = compare(
        gathered.mean,
        _supported(gathered, found, squares.sensor) if sheets.faces == 1 else error,
        report.sheets,
        report.sheet_errors,
        BATCHES - 1.0,
        np.ones(len(squares.sensor)),
        report.heaviest / squares.area,
        report.sheet_batches,
        DOUBT,
    )
    return _Look(witness, report, gathered, verdict)


def _supported(made: Estimate, found: Estimate, sensor: np.ndarray) -> np.ndarray:
    """Errors of gathering on squares as far as those of their sensors support them, for these are what is stated. [lx]"""
    stated = found.standard_error[sensor] * np.sqrt(found.samples / made.samples)
    return np.clip(stated, SUPPORTED * made.standard_error, made.standard_error)


def _rare_errors(made: Estimate, found: Estimate, sensor: np.ndarray) -> np.ndarray:
    """Errors of the squares of each sensor with as many samples as it had; 0 where many events make them. (n,) [lx]

    Many events are not missed by luck: there the light differs over the square, or well-distributed samples are better.
    """
    few = made.events * found.samples < TRUSTED * made.samples
    squares = made.standard_error**2 * (made.samples / found.samples)
    return np.sqrt(np.bincount(sensor, np.where(few, squares, 0.0), len(found.mean)))


def _mean_error(errors: np.ndarray) -> float:
    return float(np.sqrt((errors**2).sum()) / len(errors))


def _find_telling(made: Estimate, report: WitnessReport, sensor: np.ndarray) -> np.ndarray:
    """Sensors whose squares tell something of the places beside them. (m,) int

    Where gathering scatters by more than light paths bring, as after one lucky find of a small lamp in a bulb, nothing
    differs, whatever is missing. If all are like that, all of them stand for themselves.
    """
    looked, own = np.unique(sensor, return_inverse=True)
    errors = np.sqrt(np.bincount(own, made.standard_error**2))
    telling = OWN_ERRORS * errors <= np.bincount(own, report.sheets)
    return looked[telling] if telling.any() else looked


def _find_nearest(scene, positions, normals, chosen: np.ndarray) -> np.ndarray:
    """Of every sensor the one among those looked at that stands for it: near by, and turned alike. (n,) int"""
    normals = np.asarray(normals, dtype=np.float64)
    facing = normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-300)
    place = np.concatenate([scene.local(positions) / scene.radius, facing], axis=1)
    nearest = np.zeros(len(place), dtype=np.int64)
    for first in range(0, len(place), CHUNK):
        part = slice(first, first + CHUNK)
        away = np.linalg.norm(place[part, None] - place[chosen], axis=2)
        nearest[part] = chosen[away.argmin(axis=1)]
    return nearest


def _tell(witness, sheets, verdict: Verdict, made: Estimate, report) -> tuple[str, ...]:
    if verdict.agrees:
        return ()
    size = np.abs(verdict.difference)
    worst = int(np.argmax(size * verdict.differs if verdict.differs.any() else size))
    more = (verdict.difference[worst] if verdict.differs.any() else verdict.rest) > 0.0
    cause = witness.explain(sheet=worst).text()
    sensors = np.unique(sheets.squares.sensor[verdict.differs])
    who = f"{len(sensors)} of the sensors looked at" if len(sensors) else "the sensors together"
    first = sheets.squares.sensor[worst] + 1
    return (
        f"{who} get {'more' if more else 'less'} light than gathering finds, sensor {first} most of all: "
        f"{report.sheets[worst]:.4g} ± {report.sheet_errors[worst]:.2g} lx by light paths from the lights, "
        f"{made.mean[worst]:.4g} ± {made.standard_error[worst]:.2g} lx by gathering about it: {cause} is "
        f"{'not found in full' if more else 'found too often'}; the stated errors cover the difference",
    )
