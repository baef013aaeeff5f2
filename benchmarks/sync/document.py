"""The document of the benchmark of edits, made of its numbers."""

from pathlib import Path
from statistics import median

from ..common.document import BEARABLE_LOAD
from .bars import FIRST_SHARE, GROWTH, OBJECT_SHARE, PARAMETER_SHARE, check_bars
from .edits import NAMES
from .figures import PARTS, SCENES
from .grid_scene import VIEW

INTRODUCTION = """# What an edit costs

*Made by `lumenray benchmark sync`; do not edit by hand.*

How long it takes from an edit in Blender until the live view shows the first sample of the changed scene, compared with
a *full sync*: sending the whole scene to an engine that knows nothing of it. Blender runs without a window; the walk over
the scene, the worker process and the live view are those behind the viewport, which is {width} x {height} pixels and
shows its first sample coarsely, as it always does.

- **Scenes**: bumpy patches in a grid, each with a mesh of its own, every other one smooth and with texture coordinates;
  20 coloured materials, half node trees and half physical overrides; an area, a point and a spot light; a uniform sky.
  Transport is spectral.
- **Full sync**: a new session and a new walk, from the start until the first sample; Blender has evaluated the scene and
  the worker process runs. An untimed one goes before, so that libraries are loaded and kernels compiled. The median of
  three, in the same run, is what ratios refer to.
- **Edits**: in rounds, each kind once a round. Every edit takes an object that was not touched before, but *move again*,
  which always takes the same one. Lights and materials take turns. The edits before *add* and those before *delete* are
  each begun with a full sync of their own, so that the first move, addition and deletion are the first edit of all. In
  between the view refines for 0.15 to 0.35 s, so that an edit meets a busy engine.
- **Parts**: *edit*: Blender carries it out; *depsgraph*: Blender evaluates, our handlers included; *walk*: find and convert
  what changed; *transfer*: hand over to the worker; *commit*: change the engine's objects; *first sample*: trace it, a
  kernel that is new included; *rest*: the end of the slice of work the engine was in (0.1 s long), messages, making the
  image. Blender's window waits for the first four only (*blocked*). *Without Blender* leaves out the first two, which
  are nearly all Blender's own.
- *Camera* is a change of the view alone, which is not a change of the scene. *Undo* takes back a move. For *rename* and
  *select* nothing is sent, so the time ends with the walk.

To repeat it: `lumenray benchmark sync --json out/sync.json`. Kernels that an edit needs for the first time on a machine are
compiled then, and kept on disk: the first rounds of the first run are slower. Other programs must rest meanwhile; what they
took of the processors is told with each scene.

![Time from edit to sample against triangles](sync.png)
"""


def write_document(result: dict, path: Path) -> None:
    """Write the document of results of `sync.run`."""
    width, height = VIEW
    parts = [
        INTRODUCTION.format(width=width, height=height),
        _machine(result["machine"]),
        _other_load(result["scenes"]),
        _bars(check_bars(result)),
        _shortfalls(result),
        "## Scenes\n",
        *(_scene(result, scene, objects) for scene, objects in scenes_of(result)),
    ]
    path.write_text("\n".join(part for part in parts if part), encoding="utf-8")


def scenes_of(result: dict) -> list[tuple[str, int]]:
    """Return names and numbers of objects of the scenes that were measured, small ones first."""
    found = {(row["scene"], row["objects"]) for row in result["full"]}
    return sorted(found, key=lambda scene: (SCENES.get(scene[0], 0), *scene))


def _machine(machine: dict) -> str:
    return (
        f"## Machine\n\n{machine['cpu']}, {machine['cores']} cores, {machine['memory_gib']} GiB, "
        f"{machine['system']}; Python {machine['python']}, Blender {machine['blender']}, "
        f"Mitsuba {machine['mitsuba']}, Lumenray {machine['lumenray']}. No GPU is used.\n"
    )


def _other_load(scenes: list[dict]) -> str:
    """Name the scenes during which others kept the machine too busy."""
    spoilt = [
        f"{row['scene']} with {row['objects']} objects ({_percent(row['other_load'])})"
        for row in scenes
        if (row["other_load"] or 0.0) > BEARABLE_LOAD
    ]
    if not spoilt:
        return ""
    return f"**Not to be relied on, because other processes kept the machine busy:** {', '.join(spoilt)}.\n"


def _percent(share: float | None) -> str:
    return "unknown" if share is None else f"{100 * share:.0f} %"


def _bars(bars) -> str:
    lines = [
        "## Bars\n",
        f"Edits of a parameter: at most {100 * PARAMETER_SHARE:.0f} % of a full sync of 3 M triangles (median of all "
        "repetitions), and independent of the number of triangles: from 10 k to 3 M not more than "
        f"{GROWTH} times the time, *rest* left out since it is mostly chance, and given beside it. Moving, adding or "
        f"deleting one object of 1000 in 3 M triangles: at most {100 * OBJECT_SHARE:.0f} % from the second time on "
        f"(median), {100 * FIRST_SHARE:.0f} % the first time. All with Blender's own work counted, for which a "
        "user waits too. In brackets: from the least to the most.\n",
        "| demand | edit | limit | measured | verdict |",
        "|---|---|---|---|---|",
    ]
    lines += [
        f"| {bar.demand} | {bar.edit} | {bar.limit} | {bar.measured} | {bar.verdict} |"
        for bar in bars
    ]
    return "\n".join(lines) + "\n"


def _shortfalls(result: dict) -> str:
    """Say what misses its bar, and where the time goes."""
    missed = [bar for bar in check_bars(result) if bar.passed is False]
    if not missed:
        return "Every bar that was measured is met.\n"
    lines = ["What misses its bar, and where the time of the middle edit goes in 3 M triangles:\n"]
    for name in dict.fromkeys(bar.edit.partition(",")[0] for bar in missed):
        for objects in dict.fromkeys(row["objects"] for row in result["full"]):
            rows = [
                row
                for row in result["edits"]
                if (row["edit"], row["scene"], row["objects"]) == (name, "3M", objects)
            ]
            if rows:
                lines.append(f"- {name}, {objects} objects: {_largest_parts(rows)}")
    lines.append(
        "\n*Rest* is mostly chance: an edit waits until the engine has ended the slice of samples it is in. *Depsgraph* is "
        "nearly all Blender's own, which builds its dependency graph anew whenever an object comes or goes, at a cost that "
        "follows the number of objects; on few cores it also shares them with the engine that refines the view."
    )
    return "\n".join(lines) + "\n"


def _largest_parts(rows) -> str:
    times = {part: median(row["parts"][part] for row in rows) for part in PARTS}
    largest = sorted(times, key=times.get, reverse=True)[:4]
    told = ", ".join(f"{part} {1e3 * times[part]:.0f} ms" for part in largest)
    return f"{told}; without Blender {100 * median(own_ratio(row) for row in rows):.1f} %"


def _scene(result: dict, scene: str, objects: int) -> str:
    full = [row for row in result["full"] if (row["scene"], row["objects"]) == (scene, objects)]
    edits = [row for row in result["edits"] if (row["scene"], row["objects"]) == (scene, objects)]
    whole = median(row["seconds"] for row in full)
    load = _percent(
        next(
            row["other_load"]
            for row in result["scenes"]
            if (row["scene"], row["objects"]) == (scene, objects)
        )
    )
    times = ", ".join(
        f"{part} {1e3 * median(row['parts'][part] for row in full):.0f}" for part in PARTS[2:]
    )
    lines = [
        f"### {scene} triangles, {objects} objects\n",
        f"Full sync {1e3 * whole:.0f} ms (median of {len(full)}; {times}). Other processes took {load} of the "
        "processors.\n",
        "| edit | first: % | ms | later: % | ms | most ms | without Blender % | sent | blocked ms | "
        + " | ".join(PARTS)
        + " |",
        "|---" + "|--:" * (8 + len(PARTS)) + "|",
    ]
    for name in NAMES:
        rows = [row for row in edits if row["edit"] == name]
        if rows:
            lines.append(_row(name, rows))
    return "\n".join(lines) + "\n"


def _row(name: str, rows: list[dict]) -> str:
    first = next(row for row in rows if row["nth"] == 1)
    later = [row for row in rows if row["nth"] > 1] or rows
    middle = {part: 1e3 * median(row["parts"][part] for row in later) for part in PARTS}
    words = [
        name,
        f"{100 * first['ratio']:.1f}",
        f"{1e3 * first['seconds']:.0f}",
        f"{100 * median(row['ratio'] for row in later):.1f}",
        f"{1e3 * median(row['seconds'] for row in later):.0f}",
        f"{1e3 * max(row['seconds'] for row in later):.0f}",
        f"{100 * median(own_ratio(row) for row in later):.1f}",
        str(max(row["sent"] for row in rows)),
        f"{1e3 * median(blocked(row) for row in later):.0f}",
        *(f"{middle[part]:.1f}" for part in PARTS),
    ]
    return "| " + " | ".join(words) + " |"


def own_ratio(row: dict) -> float:
    """Ratio to a full sync of what an edit takes beyond Blender's own work."""
    own = sum(row["parts"][part] for part in PARTS[2:])
    return row["ratio"] * own / row["seconds"]


def blocked(row: dict) -> float:
    """Time for which an edit keeps Blender's window waiting. [s]"""
    return sum(row["parts"][part] for part in ("edit", "depsgraph", "walk", "transfer"))
