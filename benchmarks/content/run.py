"""Blender's content beside Cycles: what agrees, what is said, and what is neither."""

import tempfile
from pathlib import Path

from ...engine.errors import LumenrayError
from ...engine.reading.whole_file import write_whole
from ..common.bars import Bar
from ..common.document import make_table, tell_demands
from ..common.output import read_numbers, write_numbers
from .left_out import REASONS

MEAN, BLOCK, LOOSE = 0.01, 0.03, 0.05
"""Differences that are allowed: of means, of blocks, and of both where light goes below surfaces. [-]"""

SURE = 2.0
"""Errors of a difference below which it is chance."""

TEXT = """# Blender's content

*Made by `lumenray benchmark content`; do not edit by hand.*

Small scenes, one feature of Blender in each, rendered here and by Cycles {version} with all its limits off. *mean*:
difference of the mean luminance, with its standard error where that is above 0.1 %; *block*: root of the mean square over
blocks of {block} x {block} pixels, without noise. Allowed are {mean} % and {blocks} % ({loose} % where light goes below
surfaces). *said*: the worst row of the conversion report. Pictures are laid over a white ground, so that holes in them
count. What is *left out* is so on purpose; why stands below the table.

"""


def run(keys=None, say=None, keep=None, earlier: dict | None = None) -> dict:
    """Measure.

    Parameters
    ----------
    keys : iterable of str or None    Features; None: all.
    say : callable or None    Told in one line what was done.
    keep : callable or None    Given all results so far after every scene.
    earlier : dict or None    Results that are gone on with: of the features that they have only ``keys`` are measured again.

    Returns
    -------
    dict    Plain data, for JSON: ``scenes`` by key, ``silent`` and ``over``: keys of what differs and is not said, and of
        all that differs but for what is said and left out on purpose.

    Raises
    ------
    LumenrayError    There is no such feature.
    """
    from .compare import compare
    from .features import FEATURES
    from .stage import Stage

    say = say or (lambda _line: None)
    unknown = sorted(set(keys or ()) - set(FEATURES))
    if unknown:
        raise LumenrayError(f"there is no feature '{unknown[0]}'")
    scenes = {
        key: {**row, "left_out": REASONS.get(key, "")}
        for key, row in (earlier or {}).get("scenes", {}).items()
        if key in FEATURES
    }
    wanted = keys or [key for key in FEATURES if key not in scenes]
    with tempfile.TemporaryDirectory() as folder:
        for key in wanted:
            feature = FEATURES[key]
            feature.build(Stage())
            made = compare(Path(folder))
            scenes[key] = {
                "group": feature.group,
                "mean": made.mean,
                "mean_error": made.mean_error,
                "block": made.block,
                "agrees": _agrees(made, feature.is_loose),
                "said": list(made.said),
                "left_out": REASONS.get(key, ""),
            }
            verdict = "agrees" if scenes[key]["agrees"] else made.said[0] if made.said else "SILENT"
            say(f"{key}: mean {made.mean:+.2%}, blocks {made.block:.2%}, {verdict}")
            if keep is not None:
                keep(_sum_up(scenes))
    return _sum_up(scenes)


def _sum_up(scenes: dict) -> dict:
    """Return what `run` returns."""
    import bpy

    from .features import FEATURES

    scenes = {key: scenes[key] for key in FEATURES if key in scenes}
    over = [key for key, row in scenes.items() if not (row["agrees"] or is_left_out(row))]
    return {
        "blender": ".".join(map(str, bpy.app.version)),
        "scenes": scenes,
        "silent": [key for key in over if not scenes[key]["said"]],
        "over": over,
    }


def read_results(path: Path) -> dict:
    """Read the numbers of an earlier run; as `read_numbers`."""
    return read_numbers(path, {"scenes", "silent", "over"})


def is_left_out(row: dict) -> bool:
    """Tell whether a feature differs on purpose, and says so."""
    return not row["agrees"] and bool(row["said"]) and bool(row.get("left_out"))


def _agrees(made, is_loose: bool) -> bool:
    mean, block = (LOOSE, LOOSE) if is_loose else (MEAN, BLOCK)
    return abs(made.mean) <= mean + SURE * made.mean_error and made.block <= block


def check_bars(result: dict) -> list[Bar]:
    """Judge by the demands."""
    silent, over = result["silent"], result["over"]
    left_out = sum(map(is_left_out, result["scenes"].values()))
    agreeing = len(result["scenes"]) - len(over) - left_out
    return [
        Bar("differences that nothing is said of", "none", ", ".join(silent) or "none", not silent),
        Bar(
            "features that agree",
            f"of {len(result['scenes'])}",
            f"{agreeing}, {len(over)} differ, {left_out} left out",
            None,
        ),
    ]


def write_results(result: dict, folder: Path, path: Path | None) -> None:
    """Write the document to a folder, and all numbers to a JSON file if one is named."""
    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    text = TEXT.format(
        version=result["blender"],
        block=8,
        mean=f"{100 * MEAN:g}",
        blocks=f"{100 * BLOCK:g}",
        loose=f"{100 * LOOSE:g}",
    )
    groups = dict.fromkeys(row["group"] for row in result["scenes"].values())
    for group in groups:
        rows = [_tell(key, row) for key, row in result["scenes"].items() if row["group"] == group]
        text += f"## {group}\n\n{make_table('| feature | said | mean | block | |', rows, 2)}\n"
        text += _give_reasons(group, result["scenes"])
    text += tell_demands(check_bars(result))
    with write_whole(folder / "content.md", "utf-8") as file:
        file.write(text)


def _tell(key: str, row: dict) -> str:
    said = row["said"][0].replace("|", "/") if row["said"] else ""
    error = f" ± {row['mean_error']:.1%}" if row["mean_error"] > 1e-3 else ""
    verdict = "" if row["agrees"] else "differs" if said else "**silent**"
    verdict = "left out" if is_left_out(row) else verdict
    return f"| {key} | {said} | {row['mean']:+.1%}{error} | {row['block']:.1%} | {verdict} |"


def _give_reasons(group: str, scenes: dict) -> str:
    """Say why features of a group are left out."""
    lines = [
        f"- {key}: {row['left_out']}."
        for key, row in scenes.items()
        if row["group"] == group and is_left_out(row)
    ]
    return "Left out:\n\n" + "\n".join(lines) + "\n\n" if lines else ""
