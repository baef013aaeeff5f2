"""Light that estimators miss, against what is known of it: values of many seeds with stated and true errors.

Scenes are those of `scenes`, true values closed forms. Each is asked as a user would, as a lux map, at sensors or in
a picture; maps and sensors with the witness that errors are widened by. A row passes where no seed is farther off than
`ALLOWED` stated errors and the margin of the scene, the mean of all seeds is within `BIAS` of what is true, no stated error
is above `LARGEST`, and beyond the margin the seeds scatter as they say.
"""

import time
from functools import partial
from pathlib import Path

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.baking.order import BakeOrder
from ...engine.errors import LumenrayError
from ...engine.scene.scene import SceneDelta
from ...engine.session import Session
from ...engine.views import ViewSettings
from ..common.machine import describe_machine
from ..common.output import write_numbers
from ..common.processes import spread
from .scenes import Map, Scene, Sensors, make_scenes

SEEDS = 20

STRIDE = 2000
"""Between the seeds of scenes, so that none makes the same random choices as another."""

ALLOWED = 3.0
"""Stated errors by which a seed may be off beside the margin of its scene. [-]"""

LARGEST = 0.05
"""Share of the value that a stated error may be. [-]"""

RMS = 1.6
"""Most that the root mean square of what is beyond the margin may be of the stated errors, where seeds are `ENOUGH`. [-]"""

ENOUGH = 10

ROUNDING = 1e-6
"""Share of a value below which its stated error is less than single precision leaves open. [-]"""

BIAS = 0.02
"""By which the mean of all seeds may be off. [-]"""


def run(seeds: int = SEEDS, scenes=None, jobs: int = 1, say=lambda text: None) -> dict:
    """Ask about scenes.

    Parameters
    ----------
    seeds : int    How many.
    scenes : sequence of str or None    Their names; None: all.
    jobs : int    Processes that share the scenes.
    say : callable    Told of every scene and seed.

    Raises
    ------
    LumenrayError    There is no scene of a name.
    """
    known = make_scenes()
    unknown = [name for name in scenes or () if name not in known]
    if unknown:
        raise LumenrayError(
            f"there is no scene {', '.join(unknown)}; choose from {', '.join(known)}"
        )
    result = {"machine": describe_machine(), "seeds": seeds, "jobs": jobs}
    result |= {"scenes": {}, "rows": []}
    names = list(scenes or known)
    for name, rows in zip(names, spread(partial(ask_scene, seeds), names, jobs), strict=True):
        result["scenes"][name] = known[name]().words
        result["rows"] += rows
        for row in rows:
            say(f"{name}, seed {row['seed']}: {row['what']} {_tell_off(row)}")
    return result


def ask_scene(seeds: int, name: str) -> list[dict]:
    """Rows of one scene, of so many seeds."""
    known = make_scenes()
    scene = known[name]()
    session = Session()
    session.apply(SceneDelta(changed=scene.items))
    made = []
    for seed in range(1, seeds + 1):
        rows = ask(session, scene, seed + STRIDE * list(known).index(name))
        made += [{"scene": name, "seed": seed, **row} for row in rows]
    return made


def ask(session: Session, scene: Scene, seed: int) -> list[dict]:
    """Values of a scene with their stated errors, their true values, and the time they took."""
    rows = []
    for number, asked in enumerate(scene.asked):
        chance = seed + STRIDE // 2 * number
        begun = time.perf_counter()
        if isinstance(asked, Sensors):
            unit, found = "lx", _measure(session, asked, chance)
        elif isinstance(asked, Map):
            unit, found = "lx" if asked.area is None else "lm", _bake(session, asked, chance)
        else:
            unit, found = "cd/m²", _photograph(session, asked, chance)
        seconds = (time.perf_counter() - begun) / len(found)
        rows += [
            {"what": what, "value": float(value), "error": float(error), "true": float(true),
             "margin": scene.margin, "unit": unit, "seconds": seconds}
            for what, value, error, true in found
        ]  # fmt: skip
    return rows


def _measure(session, asked: Sensors, seed: int) -> list[tuple]:
    made = session.measure(
        np.asarray(asked.places, float),
        np.asarray(asked.normals, float),
        StopRule(samples=asked.samples),
        seed=seed,
    )
    labels = [f"sensor {label}" for label in asked.labels]
    return list(zip(labels, made.illuminance, made.standard_error, asked.true, strict=True))


def _bake(session, asked: Map, seed: int) -> list[tuple]:
    order = BakeOrder(
        ("room",),
        StopRule(samples=asked.samples),
        density=asked.density,
        caustics=asked.caustics,
        seed=seed,
    )
    made = session.bake_objects(order).maps[0]
    scale = 1.0 if asked.area is None else asked.area
    what = "mean of map" if asked.area is None else "flux on map"
    return [(what, scale * made.mean, scale * made.mean_standard_error, asked.true)]


def _photograph(session, asked, seed: int) -> list[tuple]:
    made = session.render(asked.camera, ViewSettings(StopRule(samples=asked.samples), seed=seed))
    errors = made.luminance_error.astype(float)
    value = made.tristimulus[..., 1].mean(dtype=float)
    return [("picture", value, np.sqrt((errors**2).sum()) / errors.size, asked.true)]


def _tell_off(row: dict) -> str:
    off = row["value"] - row["true"]
    is_noisy = row["error"] > ROUNDING * abs(row["true"])
    errors = f"{off / row['error']:+.1f} errors" if is_noisy else "no noise"
    return f"{row['value']:.5g} ± {row['error']:.2g} ({100 * off / row['true']:+.2f} %, {errors})"


def summarise(result: dict) -> list[dict]:
    """Rows of the document: one per scene and value, over all seeds."""
    keys = dict.fromkeys((row["scene"], row["what"]) for row in result["rows"])
    return [
        _summarise([row for row in result["rows"] if (row["scene"], row["what"]) == key])
        for key in keys
    ]


def _summarise(rows: list[dict]) -> dict:
    values, errors = (np.array([row[key] for row in rows]) for key in ("value", "error"))
    first, true = rows[0], rows[0]["true"]
    off, mean = values - true, float(values.mean())
    # Values without noise are judged by the margin alone.
    is_noisy = errors > ROUNDING * abs(true)
    counted = off[is_noisy] / errors[is_noisy]
    margin = first["margin"] * abs(true)
    is_within = np.abs(off) <= ALLOWED * errors + margin
    is_useful = errors <= LARGEST * abs(true)
    beyond = np.maximum(np.abs(off[is_noisy]) - margin, 0.0) / errors[is_noisy]
    is_honest = len(beyond) < ENOUGH or float(np.sqrt((beyond**2).mean())) <= RMS
    is_close = abs(mean - true) <= BIAS * abs(true)
    return {
        "scene": first["scene"], "what": first["what"], "unit": first["unit"], "true": true, "mean": mean,
        "spread": float(values.std(ddof=1) / np.sqrt(len(values))) if len(values) > 1 else None,
        "stated": float(np.median(errors)), "stated_most": float(errors.max()),
        "percent": float(100.0 * np.abs(off).max() / abs(true)),
        "largest": float(np.abs(counted).max()) if len(counted) else None,
        "rms": float(np.sqrt((counted**2).mean())) if len(counted) else None,
        "margin": first["margin"], "beyond": int((~is_within).sum()),
        "useless": int((~is_useful).sum()), "honest": bool(is_honest),
        "seconds": float(np.mean([row["seconds"] for row in rows])),
        "passed": bool(is_within.all() and is_useful.all() and is_honest and is_close),
    }  # fmt: skip


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document to a folder, and all numbers to a JSON file if one is named."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "hidden.md").write_text(describe(result), encoding="utf-8")
    write_numbers(result, path)


def describe(result: dict) -> str:
    """The document."""
    summaries, machine = summarise(result), result["machine"]
    failed = [row for row in summaries if not row["passed"]]
    beyond = sum(row["beyond"] for row in summaries)
    lines = [
        "# Light that is hard to find",
        "",
        "*Made by `lumenray benchmark hidden`; do not edit by hand.*",
        "",
        "Light between panes, in bulbs, through keyholes, at walls, in white rooms, on coarse facets, in penumbras, with "
        f"{result['seeds']} seeds each, against closed forms (`benchmarks/hidden/truths.py`). Stated errors are those "
        f"that users are told. A row passes where every seed is within {ALLOWED:.0f} stated errors plus a margin (of what "
        f"facets and closed forms leave open), no stated error is above {100 * LARGEST:.0f} %, deviations beyond the margin "
        f"have a root mean square of at most {RMS:g} stated errors, and the mean of all seeds is within {100 * BIAS:.0f} %. "
        "Values without noise are told in per cent only; times are per value.",
        "",
        f"**{len(summaries) - len(failed)} of {len(summaries)} rows pass**; {beyond} of {len(result['rows'])} values are "
        "farther off than their stated errors and the margin allow.",
        "",
        f"{machine['cpu']}, {machine['cores']} cores; Mitsuba {machine['mitsuba']}, Lumenray {machine['lumenray']}; "
        f"times of {result['jobs']} at once.",
    ]
    if failed:
        lines += ["", "Not met:", ""]
        lines += [f"- {result['scenes'][row['scene']]}, {row['what']}: {_tell_miss(row)}" for row in failed]  # fmt: skip
    lines += [
        "",
        "| scene | value | true | mean of seeds | stated error: median, most | margin | largest off | in errors | "
        "rms of these | time | verdict |",
        "|---|---|--:|--:|--:|--:|--:|--:|--:|--:|---|",
        *(_tell_row(row, result["scenes"][row["scene"]]) for row in summaries),
    ]
    return "\n".join(lines) + "\n"


def _tell_miss(row: dict) -> str:
    off = 100.0 * (row["mean"] / row["true"] - 1.0)
    parts = [f"{row['beyond']} seeds are off by more, the mean by {off:+.2f} %"]
    if row["useless"]:
        parts.append(f"{row['useless']} seeds state more than {100 * LARGEST:.0f} %")
    if not row["honest"]:
        parts.append("stated errors are too small")
    return "; ".join(parts)


def _tell_row(row: dict, words: str) -> str:
    spread = "" if row["spread"] is None else f" ± {row['spread']:.2g}"
    largest, rms = ("–" if row[key] is None else f"{row[key]:.2f}" for key in ("largest", "rms"))
    return (
        f"| {words} | {row['what']} | {row['true']:.5g} {row['unit']} | {row['mean']:.5g}{spread} | "
        f"{row['stated']:.2g}, {row['stated_most']:.2g} | {100 * row['margin']:.2g} % | "
        f"{row['percent']:.2f} % | {largest} | {rms} | {row['seconds']:.1f} s | {'pass' if row['passed'] else 'FAIL'} |"
    )
