"""Cloths: parts that can be run alone, and what they come to. Seconds are of the processor, all threads together."""

import time
from dataclasses import asdict
from pathlib import Path

import mitsuba as mi
import numpy as np

from ...engine.cloth.close_up import draw_close_up, seen_from_afar
from ...engine.cloth.reader import read_cloth
from ...engine.cloth.readings import hue_saturation_value, read_sheet, visible_weights
from ...engine.cloth.thread_walk import ThreadOptics, walk_inside
from ...engine.cloth.woven import weave
from ...engine.reading.whole_file import write_whole
from ...engine.scattering.data.evaluation import measure_reciprocity, totals
from ...engine.scattering.data.record import SIDES
from ...libraries import cloths
from ..common.bars import Bar
from ..common.machine import describe_machine
from ..common.output import read_numbers, write_numbers
from ..common.parts import measure_parts
from . import numpy_walk, values
from .direct import compare_directly
from .document import describe
from .uses import compute, light_behind, sheen_like

PARTS = ("reference", "photons", "woven", "direct", "presets", "curtain", "sheen")

SIGMAS = 4.0

TOLERANCES = {
    "B1": 0.0,
    "B2": 0.0,
    "B3": 2e-4,
    "B4": 0.0,
    "B5": 2e-3,
    "B6": 1e-4,
    "B7": 3e-3,
    "B8": 4e-3,
}
"""Beside `SIGMAS` standard errors: of drawn bodies with 32 corners, of windows of directions, of a line of chords."""

PHOTONS, NUMPY_PHOTONS = 1_000_000, 20_000

OPTICS = 20.0, 0.8, 1.557
"""Optical radius, mean cosine and index of the thread that is timed."""

WOVEN = "red_cotton"

PIXELS, SAMPLES = 64, 384
"""Of the close-up."""

LIGHTS, WINDOWS, DIRECT_RAYS = 40, 250, 25_000
"""Of T5: directions of light, windows of each, and rays of each."""

CURTAINS = ("voile", "screen_5")

BRIGHT_WAVELENGTH = 640.0
"""Where the red cotton reflects most. [nm]"""

__all__ = ["PARTS", "check_bars", "read_results", "run", "write_results"]


def read_results(path: Path) -> dict:
    """Read the numbers of an earlier run; as `read_numbers`."""
    return read_numbers(path, {"machine", "parts", "reference_failed"})


def run(parts=None, say=lambda text: None, earlier: dict | None = None) -> dict:
    """Measure.

    Parameters
    ----------
    parts : iterable of str or None    Which of `PARTS`; None: all.
    say : callable    Told of every step.
    earlier : dict or None    Results that are gone on with: without ``parts`` those that they lack are measured.

    Returns
    -------
    dict    Plain data, for JSON: ``machine``, ``parts``, and the figures that demands are made on, None where they were not
        measured: ``reference_failed``, ``photons_seconds``, ``woven_seconds``, ``close_up_percent``.

    Raises
    ------
    LumenrayError    There is no such part.
    """
    measures = {
        "reference": _measure_reference,
        "photons": _measure_photons,
        "woven": _measure_woven,
        "direct": _measure_direct,
        "presets": _measure_presets,
        "curtain": _measure_curtain,
        "sheen": _measure_sheen,
    }
    made = measure_parts(measures, parts, earlier, say)
    reference, photons, woven = (made.get(name) for name in PARTS[:3])
    return {
        "reference_failed": None
        if reference is None
        else [row["id"] for row in reference if row["verdict"] != "pass"],
        "photons_seconds": photons and photons["seconds"],
        "woven_seconds": woven and woven["seconds"],
        "close_up_percent": woven and woven["close_up_percent"],
        "machine": describe_machine(),
        "parts": made,
    }


def _measure_reference(say) -> list[dict]:
    found = values.find_values(say)
    rows = []
    for name, entry in values.entries().items():
        own, want, error = (
            np.atleast_1d(np.asarray(each, float))
            for each in (found[name][0], entry, found[name][1])
        )
        allowed = TOLERANCES[name[:2]] * np.maximum(np.abs(want), 0.1) + SIGMAS * error
        ratio = float((np.abs(own - want) / np.maximum(allowed, 1e-12)).max())
        verdict = "pass" if ratio <= 1.0 else "FAIL"
        rows.append(
            {
                "id": name,
                "ours": own.tolist(),
                "reference": want.tolist(),
                "ratio": ratio,
                "verdict": verdict,
            }
        )
    return rows


def _measure_photons(say) -> dict:
    say("photons")
    depth, g, index = OPTICS
    optics = ThreadOptics(index, depth, values.forward(g))
    rng = np.random.default_rng(2)
    axial, offset = 2.0 * rng.random((2, PHOTONS)) - 1.0
    walk_inside(optics, mi.Float(axial[:1000]), mi.Float(offset[:1000]), 0)
    start = time.process_time()
    ours = np.array(walk_inside(optics, mi.Float(axial), mi.Float(offset), 1).length)
    seconds = time.process_time() - start
    say("photons by NumPy")
    start = time.process_time()
    theirs = numpy_walk.walk(optics, axial[:NUMPY_PHOTONS], offset[:NUMPY_PHOTONS])
    other = (time.process_time() - start) * PHOTONS / NUMPY_PHOTONS
    apart = abs(ours.mean() - theirs.mean()) / np.hypot(
        ours.std() / np.sqrt(len(ours)), theirs.std() / np.sqrt(len(theirs))
    )
    return {
        "seconds": seconds,
        "numpy_seconds": other,
        "ratio": other / seconds,
        "sigmas_apart": float(apart),
    }


def _measure_woven(say) -> dict:
    cloth = read_cloth(cloths.presets()[WOVEN])
    say(f"{cloth.name}: tables")
    start = time.process_time()
    made = weave(cloth)
    seconds = time.process_time() - start
    say(f"{cloth.name}: close-up")
    near = draw_close_up(cloth, PIXELS, SAMPLES, seed=made.seed + 1)
    table = made.sides["front_reflection"]
    weights = visible_weights(table.wavelengths)
    close, far = (
        float(near.values.mean(axis=(0, 1)) @ weights),
        float(seen_from_afar(table) @ weights),
    )
    hues = {}
    for side in ("reflection", "transmission"):
        share = totals(made.sides[f"front_{side}"], [0.0], [0.0])[0, 0]
        share = share - (made.openness if side == "transmission" else 0.0)
        hues[side] = hue_saturation_value(share / share.max(), table.wavelengths).tolist()
    both = {
        side: measure_reciprocity(made.sides[f"front_{side}"], made.sides[f"back_{side}"]).scattered
        for side in ("reflection", "transmission")
    }
    return {
        "cloth": cloth.name,
        "seconds": seconds,
        "rays": made.rays,
        "seed": made.seed,
        "bands": len(table.wavelengths),
        "table_error": max(each.error for each in made.sides.values()),
        "sheet": asdict(read_sheet(made)),
        "close_up": close,
        "from_afar": far,
        "close_up_error_percent": 100.0 * float(near.error @ weights) / close,
        "close_up_percent": 100.0 * abs(close - far) / far,
        "hsv": hues,
        "reciprocity": both,
    }


def _measure_direct(say) -> dict:
    cloth = read_cloth(cloths.presets()[WOVEN])
    say(f"{cloth.name}: tables against light sent anew")
    woven = compute(WOVEN)
    sides = {side: getattr(woven.surface, side) for side in SIDES}
    return {"cloth": cloth.name} | compare_directly(
        cloth, sides, LIGHTS, WINDOWS, DIRECT_RAYS, wavelength=BRIGHT_WAVELENGTH
    )


def _measure_presets(say) -> dict:
    rows = {}
    for name in cloths.presets():
        say(name)
        start = time.process_time()
        woven = compute(name, draft=False)
        rows[name] = asdict(woven.sheet) | {
            "rays": woven.rays,
            "table_error": woven.table_error,
            "seconds": time.process_time() - start,
        }
    return rows


def _measure_curtain(say) -> dict:
    made = {}
    for name in CURTAINS:
        say(f"behind {name}")
        made[name] = light_behind(compute(name, draft=False))
    return made


def _measure_sheen(say) -> dict:
    say("a sheen for a cloth")
    return {"cloth": WOVEN} | sheen_like(compute(WOVEN), BRIGHT_WAVELENGTH)


def _beyond(own: dict[str, float]) -> float:
    """How far a map is off its table's transmittance by more than the standard error of that. [%]"""
    return 100.0 * max(abs(own["map"] - own["table"]) - own["table_error"], 0.0) / own["table"]


def check_bars(result: dict) -> list[Bar]:
    """Demands, and whether they are met."""

    def bar(demand, limit, value, form, passes):
        if value is None:
            return Bar(demand, limit, "-", None)
        return Bar(demand, limit, format(value, form), bool(passes(value)))

    failed = result["reference_failed"]
    photons, woven, direct, _, curtain, _ = (result["parts"].get(name) for name in PARTS[1:])
    hsv = woven and woven["hsv"]
    return [
        bar("reference values apart", "none", None if failed is None else len(failed), "d", lambda v: v == 0),
        bar("10^6 photons, processor", "12 s (6 s on two)", result["photons_seconds"], ".2f", lambda v: v <= 12.0),
        bar("NumPy over that", "more than 1", photons and photons["ratio"], ".1f", lambda v: v > 1.0),
        bar("tables, processor", "240 s (120 s on two)", result["woven_seconds"], ".0f", lambda v: v <= 240.0),
        bar("close-up from afar against the table", "2 %", result["close_up_percent"], ".2f", lambda v: v <= 2.0),
        bar("hue of red cotton", "0.97 to 0.99", hsv and hsv["reflection"][0], ".3f", lambda v: 0.97 <= v <= 0.99),
        bar(
            "saturation of what passes over that of what is reflected",
            "more than 1",
            hsv and hsv["transmission"][1] / hsv["reflection"][1],
            ".3f",
            lambda v: v > 1.0,
        ),
        bar(
            "both ways of light",
            "2 %",
            woven and 100.0 * max(woven["reciprocity"].values()),
            ".2f",
            lambda v: v <= 2.0,
        ),
        bar(
            "tables against light sent anew: the mean",
            "2 %",
            direct and 100.0 * max(abs(direct[part]["mean"]) for part in ("reflection", "transmission")),
            ".2f",
            lambda v: v <= 2.0,
        ),
        bar(
            "lux map behind a curtain against the table, beyond the table's standard error",
            "1 %",
            curtain
            and max(_beyond(each) for own in curtain.values() for each in own.values()),
            ".2f",
            lambda v: v <= 1.0,
        ),
    ]  # fmt: skip


def write_results(result: dict, folder: Path, numbers: Path | None) -> None:
    """Write the document, and all numbers as JSON."""
    text = describe(result, check_bars(result))
    folder.mkdir(parents=True, exist_ok=True)
    with write_whole(folder / "cloth.md") as file:
        file.write(text.encode())
    if numbers is not None:
        write_numbers(result, numbers)
