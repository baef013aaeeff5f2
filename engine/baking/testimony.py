"""Maps before a second witness: what light paths from the lights bring to the objects, beside what gathering has found.

Where the two differ by more than both errors, the stated errors become at least the difference, and the light is named.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..accuracy.witnesses import Verdict, compare
from ..transport.witness.pilot import BATCHES, LOOKS, Witness
from .means import ObjectMean
from .order import Departure
from .pages import Estimates

MOST_TOLD = 4
"""Differences that are explained one by one; each takes as long as the pilot."""

BIAS_ERRORS = 3.0
"""Standard errors from which a bias by the cells is believed, and part of the error."""

HIDDEN = "the stated error covers it"


@dataclass(frozen=True)
class Testimony:
    """What the witness says.

    Parameters
    ----------
    floors : (n,) array    What the error of each layout must be at least. [lx]
    departures : tuple of Departure    What differs, for people.
    decision : str    How the two compare on the whole, for people.
    balance : dict    Energy of the whole. [lm]
    """

    floors: np.ndarray
    departures: tuple[Departure, ...]
    decision: str
    balance: dict


def hear(scene, sides, found: list[ObjectMean], seed: int, cancelled) -> Testimony:
    """Run the pilot and compare.

    Parameters
    ----------
    scene : CompiledScene
    sides : list of (str, bool, str)    Id, whether the back is meant, and name of each layout's object.
    found : list of ObjectMean    Of each layout.
    seed : int
    cancelled : callable
    """
    area = np.array([each.reached.sum() for each in found], dtype=np.float64)
    over = np.where(area > 0.0, area, np.inf)
    mean, error = (
        np.array([getattr(e, name) for e in found]) for name in ("reached_mean", "error")
    )
    for look in LOOKS:
        witness = Witness(scene, seed + look - 1, {side[:2] for side in sides}, cancelled=cancelled)
        report = witness.run(look=look)
        place = {each: row for row, each in enumerate(report.objects)}
        rows = [place[side[:2]] for side in sides]
        light = report.flux[rows] / over
        verdict = compare(
            mean,
            error,
            light,
            report.flux_error[rows] / over,
            BATCHES - 1.0,
            area,
            report.heaviest / over,
            report.flux_batches[:, rows] / over,
        )
        if not verdict.is_doubtful:
            break
    floors = np.maximum(verdict.floor, _biases(found))
    # Where nothing at all was found, that is known as well as the pilot can tell.
    nothing = (mean == 0.0) & (error == 0.0) & np.isfinite(over)
    floors[nothing] = np.maximum(floors[nothing], (report.heaviest / over)[nothing])
    told = _tell(
        witness,
        [side[2] for side in sides],
        rows,
        verdict,
        mean,
        light,
        report.flux_error[rows] / over,
    )
    decision = (
        f"{report.paths} light paths from the lights bring {_digits(report.flux[rows].sum())} lm to the objects, "
        f"the maps hold {_digits((mean * area).sum())} lm"
    )
    return Testimony(floors, tuple(told), decision, report.balance())


def widen(estimates: Estimates, found: list[ObjectMean], floors: np.ndarray) -> Estimates:
    """Let the errors of lumels hold what the means of their objects may be wrong by."""
    if not floors.any():
        return estimates
    error = estimates.standard_error.copy()
    for each, floor in zip(found, floors, strict=True):
        error[each.rows] = np.hypot(error[each.rows], np.float32(floor))
    return replace(estimates, standard_error=error)


def _biases(found: list[ObjectMean]) -> np.ndarray:
    is_known = [abs(each.bias) > BIAS_ERRORS * each.bias_error for each in found]
    return np.array([abs(e.bias) if k else 0.0 for e, k in zip(found, is_known, strict=True)])


def _tell(witness, names, rows, verdict: Verdict, mean, light, light_error) -> list[Departure]:
    order = np.argsort(-np.abs(verdict.difference) * verdict.differs)
    order = [int(number) for number in order if verdict.differs[number]]
    told = []
    for number in order[:MOST_TOLD]:
        more = verdict.difference[number] > 0.0
        cause = witness.explain(row=rows[number]).text()
        said = (
            f"the map's mean of {_digits(mean[number])} lx is {'less' if more else 'more'} than the "
            f"{_digits(light[number])} ± {light_error[number]:.2g} lx that light paths from the lights bring"
        )
        why = f": {cause} is not found in full" if more else f": {cause} is found too often"
        told.append(Departure(names[number], said + why, HIDDEN))
    if len(order) > MOST_TOLD:
        more = ", ".join(f"'{names[number]}'" for number in order[MOST_TOLD:][:8])
        said = f"{len(order) - MOST_TOLD} more maps differ from what light paths bring: {more}"
        told.append(Departure("all maps", said, HIDDEN))
    if verdict.rest != 0.0:
        worst = int(np.argmax(np.abs(verdict.difference) * ~verdict.differs))
        cause = witness.explain(row=rows[worst]).text()
        said = (
            f"together the maps have {_digits(abs(verdict.rest))} lx {'less' if verdict.rest > 0 else 'more'} than light "
            f"paths from the lights bring, most of all '{names[worst]}': {cause}"
        )
        told.append(Departure("all maps", said, HIDDEN))
    return told


def _digits(value: float) -> str:
    return f"{float(value):.4g}"
