"""Maps before a second witness: what light paths from the lights bring to the objects, beside what gathering has found.

Where the two differ by more than both errors, the stated errors become at least the difference, and the light is named.
"""

from dataclasses import dataclass, replace

import numpy as np

from ..accuracy.witnesses import Verdict, compare
from ..transport.witness.pilot import BATCHES, LOOKS, Witness
from .estimates import Estimates
from .means import ObjectMean
from .order import Departure
from .surfaces import BakedSurface

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
    floors : (n,) array    What the error of each map must be at least. [lx]
    departures : tuple of Departure    What differs, for people.
    decisions : tuple of str    How the two compare on the whole, for people.
    balance : dict    Energy of the whole. [lm]
    """

    floors: np.ndarray
    departures: tuple[Departure, ...]
    decisions: tuple[str, ...]
    balance: dict


def hear(
    scene, surfaces: list[BakedSurface], means: list[ObjectMean], seed: int, cancelled
) -> Testimony:
    """Let the witness speak about all maps.

    What takes no part in light, such as a measuring plane, no path meets. It may lack as much as the rest.

    Parameters
    ----------
    scene : CompiledScene
    surfaces : list of BakedSurface
    means : list of ObjectMean    Of each surface.
    seed : int
    cancelled : callable

    Raises
    ------
    Cancelled    When ``cancelled`` answered true.
    """
    met = {key for key, _, _ in scene.parts()}
    known = [number for number, each in enumerate(surfaces) if each.key in met]
    others = [number for number, each in enumerate(surfaces) if each.key not in met]
    heard = _compare(
        [surfaces[n] for n in known], [means[n] for n in known], scene, seed, cancelled
    )
    floors = np.zeros(len(surfaces))
    floors[known] = heard.floors
    decisions = heard.decisions if known else ()
    if others:
        shares = [floors[n] / means[n].mean for n in known if means[n].mean > 0.0]
        share = max(shares, default=0.0)
        floors[others] = [share * means[n].mean for n in others]
        names = ", ".join(f"'{surfaces[n].mesh.name}'" for n in others[:8])
        said = (
            f"their errors hold the largest share that other maps may lack, {100.0 * share:.2g} %"
            if known
            else "bake what they lie before along with them to hear one"
        )
        decisions += (f"no light path meets {names}, so no second witness was heard; {said}",)
    return replace(heard, floors=floors, decisions=decisions)


def _compare(
    surfaces: list[BakedSurface], found: list[ObjectMean], scene, seed: int, cancelled
) -> Testimony:
    """Run the pilot and compare what it brings to surfaces that light paths meet."""
    sides = [(each.key, each.is_back) for each in surfaces]
    area = np.array([each.reached.sum() for each in found], dtype=np.float64)
    over = np.where(area > 0.0, area, np.inf)
    mean, error = (
        np.array([getattr(e, name) for e in found]) for name in ("reached_mean", "error")
    )
    for look in LOOKS:
        witness = Witness(scene, seed + look - 1, set(sides), cancelled=cancelled)
        report = witness.run(look=look)
        place = {each: row for row, each in enumerate(report.objects)}
        rows = [place[side] for side in sides]
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
        [each.mesh.name for each in surfaces],
        rows,
        verdict,
        mean,
        light,
        report.flux_error[rows] / over,
    )
    told = [Departure("all maps", said, HIDDEN) for said in report.told()] + told
    decision = (
        f"{report.paths} light paths from the lights bring {_digits(report.flux[rows].sum())} lm to the objects, "
        f"the maps hold {_digits((mean * area).sum())} lm"
    )
    return Testimony(floors, tuple(told), (decision,), report.balance())


def widen(estimates: Estimates, means: list[ObjectMean], floors: np.ndarray) -> Estimates:
    """Let the errors of lumels hold what the means of their objects may be wrong by."""
    if not floors.any():
        return estimates
    error = estimates.standard_error.copy()
    for each, floor in zip(means, floors, strict=True):
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
