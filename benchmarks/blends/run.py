"""Scenes as people have them beside Cycles: a sheet of pictures, differences, and what the conversion report says."""

import tempfile
from pathlib import Path

import numpy as np

from ...engine.errors import LumenrayError
from ...engine.reading.whole_file import write_whole
from ..common.bars import Bar
from ..common.document import make_table, tell_demands
from ..common.output import write_numbers
from .reasons import REASONS

MEAN, BLOCK = 0.02, 0.05
"""Differences of means and of blocks that need no reason. [-]"""

SURE = 2.0
"""Errors of a difference below which it is chance."""

MOST_SAID = 6
"""Rows of a conversion report that are printed."""

SHEET = "blends.png"

TEXT = """# Scenes as people have them

*Made by `lumenray benchmark blends FOLDER`; do not edit by hand.*

Every .blend file of a folder as it is, rendered by Cycles {version} with all its limits off and by Lumenray, under the same
camera and with the same white, at most {width} x {height} pixels; without compositor, border and motion blur. *mean*:
difference of the mean luminance, with its standard error where that is above 0.1 %; *blocks*: root of the mean square over
blocks of {block} x {block} pixels, without noise, both relative to the mean of Cycles. Luminances are those of the file's
lumens per watt. Differences up to {mean} % and {blocks} % need no explanation; why others differ stands below the table.

![Cycles at the left, Lumenray at the right](blends.png)

Each pair is shown with the exposure that suits Cycles' picture.

"""


def run(folder: Path, names=None, say=None, keep=None) -> tuple[dict, dict]:
    """Measure all files of a folder.

    Parameters
    ----------
    folder : Path
    names : iterable of str or None    Files, with or without their ending; None: all.
    say : callable or None    Told in one line what was done.
    keep : callable or None    Given results and pictures so far after every file.

    Returns
    -------
    (dict, dict)    Plain data, for JSON: ``files`` by name; and (2, h, w, 3) arrays of pictures by name.

    Raises
    ------
    LumenrayError    The folder holds no such file, or Blender cannot open one.
    """
    from .pair import compare

    say = say or (lambda _line: None)
    paths = {path.stem: path for path in sorted(folder.glob("*.blend"))}
    if not paths:
        raise LumenrayError(f"{folder}: holds no .blend files")
    wanted = [Path(name).name.removesuffix(".blend") for name in names or paths]
    unknown = sorted(set(wanted) - paths.keys())
    if unknown:
        raise LumenrayError(f"{folder}: holds no file {unknown[0]}.blend")
    files, pictures = {}, {}
    with tempfile.TemporaryDirectory() as place:
        for name in wanted:
            made = compare(paths[name], Path(place))
            pictures[name] = made.pictures.astype(np.float32)
            files[name] = {
                "means": list(made.means),
                "mean": made.mean,
                "mean_error": made.mean_error,
                "block": made.block,
                "agrees": agrees(made),
                "has_camera": made.has_camera,
                "said": list(made.said),
            }
            say(f"{name}: mean {made.mean:+.2%}, blocks {made.block:.2%}, {len(made.said)} rows")
            if keep is not None:
                keep(_sum_up(files), pictures)
    return _sum_up(files), pictures


def agrees(made) -> bool:
    """Tell whether a pair is so much alike that there is nothing to explain."""
    return abs(made.mean) <= MEAN + SURE * made.mean_error and made.block <= BLOCK


def _sum_up(files: dict) -> dict:
    import bpy

    return {"blender": ".".join(map(str, bpy.app.version)), "files": dict(files)}


def check_bars(result: dict, reasons=REASONS) -> list[Bar]:
    """Judge by the demands."""
    files = result["files"]
    differing = [name for name, row in files.items() if not row["agrees"]]
    open_ = [name for name in differing if name not in reasons]
    return [
        Bar("differences without a reason", "none", ", ".join(open_) or "none", not open_),
        Bar(
            "files that agree",
            f"of {len(files)}",
            f"{len(files) - len(differing)}, {len(differing)} differ",
            None,
        ),
    ]


def write_results(result: dict, pictures: dict, folder: Path, path: Path | None) -> None:
    """Write document and sheet to a folder, and all numbers to a JSON file if one is named."""
    from .pair import BLOCK as SIDE
    from .pair import HEIGHT, WIDTH
    from .sheet import draw_sheet

    write_numbers(result, path)
    folder.mkdir(parents=True, exist_ok=True)
    draw_sheet(result["files"], pictures, folder / SHEET)
    text = TEXT.format(
        version=result["blender"],
        width=WIDTH,
        height=HEIGHT,
        block=SIDE,
        mean=f"{100 * MEAN:g}",
        blocks=f"{100 * BLOCK:g}",
    )
    files = result["files"]
    head = "| file | Cycles [cd/m²] | Lumenray [cd/m²] | mean | blocks | |"
    text += make_table(head, [_tell(name, row) for name, row in files.items()], 1) + "\n"
    text += tell_reasons(files)
    text += "## What the conversion report says\n\n" + "\n".join(
        _tell_report(name, row) for name, row in files.items()
    )
    text += "\n" + tell_demands(check_bars(result))
    with write_whole(folder / "blends.md", "utf-8") as file:
        file.write(text)


def tell_reasons(files: dict, reasons=REASONS) -> str:
    """Say why files differ, one by one."""
    lines = [
        f"- **{name}**: {reasons.get(name, 'not looked into yet')}."
        for name, row in files.items()
        if not row["agrees"] or name in reasons
    ]
    return "## Why they differ\n\n" + "\n".join(lines) + "\n\n" if lines else ""


def _tell(name: str, row: dict) -> str:
    error = f" ± {row['mean_error']:.1%}" if row["mean_error"] > 1e-3 else ""
    cycles, ours = row["means"]
    verdict = "" if row["agrees"] else "differs"
    return f"| {name} | {cycles:.4g} | {ours:.4g} | {row['mean']:+.1%}{error} | {row['block']:.1%} | {verdict} |"


def _tell_report(name: str, row: dict) -> str:
    camera = "" if row["has_camera"] else " (it has no camera: one that sees everything was added)"
    said = [f"  - {line}" for line in row["said"][:MOST_SAID]] or ["  - nothing"]
    more = len(row["said"]) - MOST_SAID
    if more > 0:
        said.append(f"  - and {more} more rows")
    return "\n".join([f"- {name}{camera}", *said]) + "\n"
