"""Time to an asked error, all automatic against everything modelled in full, and the true errors of the first."""

import time

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.requirements.plan import DECISIONS
from ...engine.scene.modelling import Modelling, Switch
from ...engine.scene.scene import SceneDelta
from ...engine.session import Session
from .scenes import NeedScene

ERROR = 0.01
"""Relative standard error that is asked for. [-]"""

FULL = Modelling(tuple((name, Switch.OFF) for name in DECISIONS))
"""Nothing is simplified."""

LONGEST = 15.0
"""Of one run of the full model; from its error then the time to the asked one is reckoned. [s]"""

LONGER = 6.0
"""Times as long as that the run may be that the automatic ones are judged by."""

OWN_LONGEST = 60.0
"""Of one automatic run, after which it ends with the error that it states. [s]"""

FEW_SEEDS = 5
"""Automatic runs where these do not come to the asked error."""

WARMING = 16
"""Samples by which the full model's kernels are made before its time counts."""


class Racer:
    """A way of computing a scene, without the second witness, which costs both the same.

    Parameters
    ----------
    scene : NeedScene
    is_full : bool    Whether everything is modelled in full: every decision is switched off.
    """

    def __init__(self, scene: NeedScene, is_full: bool):
        self._scene = scene
        self._session = Session(witness=False)
        self._session.apply(SceneDelta(changed=(*scene.items, *((FULL,) if is_full else ()))))

    def measure(self, rule: StopRule, seed: int):
        """The measurement, and the seconds of processors that it took."""
        begin = time.process_time()
        made = self._session.measure(self._scene.positions, self._scene.normals, rule, seed)
        return made, time.process_time() - begin


def race(scene: NeedScene, seeds: int, longest: float = LONGEST) -> dict:
    """Time both ways, and compare the automatic one's runs with what the full one tells.

    Parameters
    ----------
    seeds : int    Runs of the automatic way.
    longest : float    Of a run of the full one. [s]

    Returns
    -------
    dict    Plain data: seconds to the asked error, errors as root mean squares over the sensors over their mean. [-]
    """
    full = Racer(scene, is_full=True)
    full.measure(StopRule(samples=WARMING), 1)
    runs = [full.measure(StopRule(error=ERROR, seconds=longest), seed) for seed in (1001, 1002)]
    # Of the same kind and longer: what the runs are judged by.
    runs.append(full.measure(StopRule(error=ERROR / 3.0, seconds=LONGER * longest), 1003))
    truth, doubt = _join([made for made, _ in runs])
    needed = [_reckon(*each) for each in runs[:2]]
    ours = Racer(scene, is_full=False)
    rule = StopRule(error=ERROR, seconds=OWN_LONGEST)
    made = [ours.measure(rule, 1)]
    # The first run makes the kernels; where no run comes to the asked error, a few tell as much.
    more = min(seeds, FEW_SEEDS) if _is_reckoned(made[0][0]) else seeds
    made += [ours.measure(rule, seed) for seed in range(2, more + 1)]
    seconds = [_reckon(*each) for each in made[1:] or made]
    size = float(np.mean(truth))
    squares = [float(np.mean((each.illuminance - truth) ** 2)) / size**2 for each, _ in made]
    beside = float(np.mean(doubt**2)) / size**2
    # All runs share the reference, whose chance is seen from sensor to sensor.
    apart = (np.mean([each.illuminance for each, _ in made], axis=0) - truth) ** 2 / size**2
    first = made[0][0]
    return {
        "title": scene.title,
        "sensors": len(truth),
        "seconds": float(np.median(seconds)),
        "full_seconds": float(np.mean(needed)),
        "is_full_reckoned": any(map(_is_reckoned, (each for each, _ in runs[:2]))),
        "is_reckoned": any(map(_is_reckoned, (each for each, _ in made))),
        "squares": squares,
        "reference_square": beside,
        "reference_spread": float(apart.std() / np.sqrt(len(truth))),
        "stated": [relative_error(each.standard_error, each.illuminance) for each, _ in made],
        "decisions": list(first.provenance.decisions),
    }


def relative_error(error, values) -> float:
    """Root mean square of errors over the mean of the values. [-]"""
    return float(np.sqrt(np.mean(np.square(error))) / np.mean(values))


def true_error(row: dict) -> tuple[float, float]:
    """Root mean square of the true errors over the seeds, without that of the reference, and its standard error. [-]

    The latter holds what runs differ by, and what the square of the reference's error may be off by. Of an error that the
    reference hides it is no more than a bound, see `is_hidden`.
    """
    squares = np.array(row["squares"])
    if not is_hidden(row):
        squares = squares - row["reference_square"]
    mean = max(float(squares.mean()), 0.0)
    spread = float(squares.std(ddof=1)) / np.sqrt(len(squares)) if len(squares) > 1 else mean
    spread = float(np.hypot(spread, row.get("reference_spread", 0.0)))
    root = np.sqrt(mean)
    return float(root), float(0.5 * spread / root) if root > 0.0 else 0.0


def is_hidden(row: dict) -> bool:
    """Whether runs differ from the reference by less than that may be off itself: all of it may be the reference's."""
    return float(np.mean(row["squares"])) <= row["reference_square"]


def _is_reckoned(made) -> bool:
    """Whether a run ended before its error was the asked one."""
    return _scatter(made) > 1.05 * ERROR


def _reckon(made, seconds: float) -> float:
    """Seconds to the asked error, by those of a run and its error."""
    return seconds * max(_scatter(made) / ERROR, 1.0) ** 2


def _scatter(made) -> float:
    """Error of a run as far as more samples lower it. [-]"""
    square = made.standard_error**2 - (0.0 if made.floors is None else made.floors**2)
    return relative_error(np.sqrt(np.maximum(square, 0.0)), made.illuminance)


def _join(made: list) -> tuple[np.ndarray, np.ndarray]:
    """Mean of measurements, weighted by the squares of their errors, and its standard error. (n,), (n,) [lx]"""
    # One weight for all sensors of a run: a sensor's own would follow its value, and lean to what is low.
    weights = np.array([1.0 / max(np.mean(m.standard_error**2), 1e-30) for m in made])
    weights /= weights.sum()
    values = np.array([m.illuminance for m in made])
    errors = np.array([m.standard_error for m in made])
    return weights @ values, np.sqrt((weights[:, None] ** 2 * errors**2).sum(axis=0))
