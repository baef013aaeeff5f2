"""Whether bounds hold: random scenes, each simplification alone against the full model."""

import numpy as np

from ...engine.requirements.plan import DECISIONS
from ..common.document import make_table
from ..common.statistics import median
from .random_scenes import find_errors, make_scene

COUNT = 200
"""Scenes."""

SAMPLES = 1 << 14
"""Paths of every sensor, on both ways: beside what a measurement takes anyhow they take hardly any time."""

SURE = 4.0
"""Standard errors by which a difference must be over its bound to have passed it: of some thousand sensors one is over 3.3
by chance."""


AGAIN = 16
"""Times as many samples by which a simplification is tried again that looks off: where rare paths carry much light, errors
that are stated from few samples are too small."""

ROUNDING = 1e-5
"""Relative difference that single precision makes. [-]"""


SEEN = 3.0
"""Standard errors from which on a difference says how large an error is."""


def is_exceeded(trial) -> bool:
    """Whether a simplification (`random_scenes.Trial`) is surely over its bound at some sensor."""
    return bool((trial.error > trial.bound + SURE * trial.noise + ROUNDING).any())


def measure(count: int, say, rows: list[dict] = (), begin: int = 0, save=None) -> list[dict]:
    """Try all simplifications that random scenes allow; a row for each.

    Parameters
    ----------
    count : int    Scenes.
    say : callable    Told of progress in words.
    rows : list of dict    Of an earlier run to go on with, which has tried ``begin`` scenes.
    save : callable or None    Given the rows so far and of how many scenes they are.
    """
    rows = list(rows)
    for number in range(begin, count):
        scene = make_scene(number)
        for first in find_errors(scene, SAMPLES, number):
            trial = first
            if is_exceeded(first):
                say(f"scene {number}: {first.name} looks off, tried again by more samples")
                [trial] = find_errors(scene, AGAIN * SAMPLES, number, (first.name,))
            rows.append(
                {
                    "scene": number,
                    "name": trial.name,
                    "bound": trial.bound,
                    "errors": trial.error.tolist(),
                    "noises": trial.noise.tolist(),
                    "is_exceeded": is_exceeded(trial),
                }
            )
        if (number + 1) % 10 == 0:
            exceeded = sum(row["is_exceeded"] for row in rows)
            say(f"{number + 1} scenes, {len(rows)} simplifications, {exceeded} over their bounds")
            if save is not None:
                save(list(rows), number + 1)
    return rows


def tell(rows: list[dict], count: int) -> str:
    """The chapter of the document."""
    cells = []
    for name in DECISIONS:
        own = [row for row in rows if row["name"] == name]
        if not own:
            continue
        off = np.concatenate([np.array(row["errors"]) for row in own])
        noise = np.concatenate([np.array(row["noises"]) for row in own])
        seen = [each for row in own if row["bound"] > 0.0 for each in _looseness(row)]
        is_exact = not any(row["bound"] for row in own)
        loose = "exact" if is_exact else f"{median(seen):.3g}" if seen else "hidden in noise"
        cells.append(
            f"| {name} | {len(own)} | {sum(row['is_exceeded'] for row in own)} | {loose} | "
            f"{np.sqrt(np.mean(np.square(off / np.maximum(noise, ROUNDING)))):.2f} |"
        )
    head = "| simplification | scenes | over its bound | bound over error, median | difference over noise, rms |"
    return (
        f"## Bounds\n\n{count} random rooms with lamps, things and neighbours, each simplification alone against the full "
        "model at four sensors. A bound counts as passed where the difference is over it by more than four standard errors, "
        f"twice: the second time by {AGAIN} times as many samples, as errors stated from few are too small where rare paths "
        "carry much light. "
        "*Bound over error*: of differences of more than three standard errors that are below the bound. "
        "*Difference over noise*: 1 where nothing "
        f"but noise is left, as of what is exact.\n\n{make_table(head, cells)}\n"
    )


def _looseness(row: dict) -> list[float]:
    """Bound over error, of the errors that are seen beside their noise, where that would not hide a bound either. [-]"""
    pairs = zip(row["errors"], row["noises"], strict=True)
    bound = row["bound"]
    return [bound / error for error, noise in pairs if SEEN * noise < min(error, bound)]
