"""Tasks of a render farm, each called by an expression on Blender's command line, with its words behind ``--``.

A task that raises ends Blender with the exit code of ``--python-exit-code``, so the farm sees that it has failed. Renders
are Blender's own: `prepare` goes before ``--render-frame`` and `check` behind it, as Blender ends well also where a frame
failed.
"""

import csv
import json
import sys
from dataclasses import replace
from pathlib import Path

import bpy

from ...engine.accuracy.stopping import StopRule
from ...engine.errors import LumenrayError
from ...engine.formats.report import find_remarks
from ...engine.reading.whole_file import write_whole
from .. import assumptions
from ..bake import job as bake_job
from ..bake.folders import checkpoint_path
from ..foundation import engine_process
from ..rendering import render_engine
from .words import Words, read_frames, read_words

FRAMES, MAPS = "lumenray_frames.csv", "lumenray_maps.csv"
"""Tables in the folder of a job."""

REPORT = "report.json"

OF_FRAMES = {"frames": read_frames, "error": float, "samples": int, "time": float, "accept": str}

OF_BAKES = {
    "collection": str,
    "density": float,
    "error": float,
    "error_lx": float,
    "samples": int,
    "time": float,
    "accept": str,
}

FIGURES = (
    "name", "quantity", "unit", "mean", "mean_standard_error", "minimum", "maximum", "uniformity", "relative_standard_error",
    "samples",
)  # fmt: skip
"""Columns of the tables that come from reports' quantities."""

_before: dict[int, int] = {}
"""When files of frames that were there had been changed, by frame. [ns]"""


def prepare() -> None:
    """Set the scene up for a task's frames.

    Raises
    ------
    LumenrayError    The words are not understood.
    """
    words, scene = read_words(OF_FRAMES), bpy.context.scene
    scene.render.engine = "LUMENRAY"
    scene.render.use_file_extension = True
    # A frame of a task that was stopped may be half a file.
    scene.render.use_overwrite, scene.render.use_placeholder = True, False
    for goal in ("error", "samples", "time"):
        if goal in words.values:
            scene.lumenray.render.stop = goal.upper()
            setattr(scene.lumenray.render, goal, words.values[goal])
    render_engine.keeps_reports = True
    _before.clear()
    for frame in words.values["frames"]:
        path = _path_of(scene, frame)
        if path.is_file():
            _before[frame] = path.stat().st_mtime_ns


def check() -> None:
    """See whether all frames of a task were rendered, and their scenes are whole.

    Raises
    ------
    LumenrayError    One was not, or something of its scene was left out and nobody accepts that.
    """
    words, scene = read_words(OF_FRAMES), bpy.context.scene
    for frame in words.values["frames"]:
        path = _path_of(scene, frame)
        if not path.is_file() or path.stat().st_mtime_ns == _before.get(frame):
            raise LumenrayError(f"frame {frame} was not rendered to {path}; the log says why")
        _refuse_errors(f"frame {frame}", _read_report(_report_of(path)), words)


def collect_frames() -> None:
    """Write a table of all frames of a job into their folder.

    Raises
    ------
    LumenrayError    One is missing; the others are in the table.
    """
    words, scene = read_words(OF_FRAMES), bpy.context.scene
    rows, missing = [], []
    for frame in words.values["frames"]:
        path = _path_of(scene, frame)
        if not path.is_file() or not _report_of(path).is_file():
            missing.append(str(frame))
            continue
        rows += _rows_of({"frame": frame, "file": path.name}, _read_report(_report_of(path)))
    _write_table(words.folder / FRAMES, ("frame", "file"), rows)
    if missing:
        raise LumenrayError(f"frames are missing in {words.folder}: {', '.join(missing)}")


def bake() -> None:
    """Bake a collection, or what `lumenray bake` does without objects; goes on where the same task was stopped.

    Raises
    ------
    LumenrayError    It fails, or something of the scene was left out and nobody accepts that.
    """
    words, scene = read_words(OF_BAKES), bpy.context.scene
    objects = _chosen(scene, words.values.get("collection"))
    settings = bake_job.read_settings(scene.lumenray, objects, _rule(scene, words), words.folder)
    if "density" in words.values:
        settings = replace(settings.ask(density=words.values["density"]), densities={})
    settings = replace(
        settings,
        overwrite=True,
        use_checkpoint=True,
        resume=checkpoint_path(words.folder).is_file(),
    )
    job = bake_job.prepare(bpy.context.evaluated_depsgraph_get(), objects, settings)
    is_accepting = "accept" in words.values
    assumptions.refuse_missing(job.report, is_accepting)
    session = engine_process.open_session("bake", scene)
    try:
        job.run(session)
    finally:
        session.close()
    assumptions.tell(job.report, job.notes, job.shortfall, stream=sys.stdout)
    if not is_accepting:
        _refuse_errors("the bake", _read_report(words.folder / REPORT), words)


def collect_bakes() -> None:
    """Write a table of all maps of a job into its folder.

    Raises
    ------
    LumenrayError    A part is missing; the others are in the table.
    """
    words = read_words({"part": str})
    rows, missing = [], []
    for part in words.parts:
        path = words.folder / part / REPORT
        if not path.is_file():
            missing.append(part)
            continue
        rows += _rows_of({"part": part}, _read_report(path))
    _write_table(words.folder / MAPS, ("part",), rows)
    if missing:
        raise LumenrayError(f"bakes are missing in {words.folder}: {', '.join(missing)}")


def _path_of(scene, frame: int) -> Path:
    return Path(bpy.path.abspath(scene.render.frame_path(frame=frame)))


def _report_of(picture: Path) -> Path:
    return picture.with_name(f"{picture.with_suffix('').name}_{REPORT}")


def _read_report(path: Path) -> dict:
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise LumenrayError(
            f"{path}: the report cannot be read ({error}); do its task again"
        ) from None


def _refuse_errors(what: str, report: dict, words: Words) -> None:
    errors = [row for row in report["conversion"] if row["severity"] == "error"]
    if errors and "accept" not in words.values:
        told = find_remarks(errors)[0]
        raise LumenrayError(
            f"{what} is of another scene: {told}; correct it, or let the job accept errors"
        )


def _chosen(scene, name: str | None) -> list:
    """Objects of a collection, else of the one called Bake, else all."""
    known = {each.name: each for each in scene.collection.children_recursive}
    if name is not None and name not in known:
        raise LumenrayError(f"the scene {scene.name} has no collection named {name}")
    collection = known.get("Bake" if name is None else name)
    return bake_job.bakeable(scene.objects if collection is None else collection.all_objects)


def _rule(scene, words: Words) -> StopRule:
    names = {"error": "error", "error_lx": "absolute", "samples": "samples", "time": "seconds"}
    asked = {names[name]: value for name, value in words.values.items() if name in names}
    return StopRule(**asked) if asked else bake_job.rule_of(scene.lumenray.bake)


def _rows_of(place: dict, report: dict) -> list[dict]:
    """Rows of a table, one for each quantity of a report."""
    common = {
        "seconds": report["seconds"],
        "seed": report["seed"],
        "scene": report["scene"]["hash"],
        "goal": "reached" if report["goal"]["reached"] else report["goal"]["shortfall"],
        "remarks": "; ".join(find_remarks(report["conversion"], report["notes"])),
    }
    return [
        place | {name: quantity.get(name) for name in FIGURES} | common
        for quantity in report["quantities"]
    ]


def _write_table(path: Path, place: tuple[str, ...], rows: list[dict]) -> None:
    columns = (*place, *FIGURES, "seconds", "seed", "scene", "goal", "remarks")
    with write_whole(path, "utf-8") as file:
        writer = csv.DictWriter(file, columns, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    sys.stdout.write(f"written to {path}\n")
