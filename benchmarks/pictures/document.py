"""The document of the benchmark of pictures, made of its numbers."""

from pathlib import Path

from ..common.document import BEARABLE_LOAD, make_table, tell_demands
from ..common.statistics import Reach
from .bars import check_bars
from .bias import SEEDS
from .card import tell_card
from .chart import STYLES
from .programs import CYCLES, OURS
from .race import BELIEVED, FINER, TRIES, reach
from .scenes import SIZE
from .statistics import BASE, BLOCK, COARSEST, FLATTEST, INDEPENDENT, STEEPEST, TARGETS
from .summary import RIVALS, ratio, scene_calibration, speedup

TITLE = """# Pictures: time to an error

*Made by `lumenray benchmark pictures`; do not edit by hand.*

To repeat it: `lumenray benchmark pictures --json out/pictures.json`; `--scenes`, `--size` and `--budget` make it shorter,
`--resume` goes on with what an earlier run has written to the JSON file.

- **Relative error**: root mean square over the pixels of the error over the larger of a pixel's own and the mean
  luminance, as our pictures state it.
- **True errors** need no converged picture. Each program makes two pictures more, of other seeds and as many samples as its
  longest run, or up to {finer} times as many if there is time; what a picture differs from the one, times what it differs
  from the other, is the square of its error on the mean. In these two our pixels share no light, so that what sharing
  smooths away counts as an error. So a program is compared with itself, and differences of models between programs do not
  count. *Reference* is the error of the mean of these two.
- **Time** is that of the whole call, what is learned of the scene and cells included; compiling the scene (Cycles: building
  it and its tree) is not, and kernels are made before. Every run is made {tries} times with other seeds: the fastest counts,
  and the error of all. Programs run in turn. Times between runs are interpolated; **\\*** marks times that are *extended*:
  the error goes on by the power of the samples of the last {base} runs of {coarsest:g} % at most ({flattest:g} to
  {steepest:g}; {independent:g}, that of independent paths, where these are fewer than three or scatter), the time by that of
  a sample in the last runs. `<`: the least work met the error; `>`: more work brings it no nearer.
- **Lumenray** decides itself how a picture is made (`method="auto"`); *plain paths of ours* follow every path to its end
  (`method="paths"`).{alike}
- **Cycles** is the Python module of Blender, with a pixel filter as narrow as ours, without clamping, denoising and adaptive
  sampling, with 1024 bounces of every kind, caustics and the light tree, and portals at windows.
- **Scenes** are the same for both. Cycles computes with three channels: it is given the colours in Rec. 709 of what has
  a spectrum here, coats as its Principled BSDF, metals by their colour. *Means* tells how near both come.{stand_ins}
"""

ALIKE = " As this version has one method only, both are the same, and one is run."

STAND_INS = """ Measured paints are
  tables here; Cycles has none, so that it gets the Principled BSDF that is fitted to each, which costs it less."""

BIAS = """## Bias

{seeds} pictures of ours whose pixels share no light and as many of plain paths, and the means of their {block} x {block}
blocks: what cells change; all in % of the mean luminance. *Noise* is the standard error of a block's difference, *spread*
what the differences have beyond it, both as root mean squares. *Interval*: what a block's difference may be by chance, so
that all blocks of a picture hold it with 95 %. *Beyond noise*: the largest difference of a block less its interval; 0 means
that none is shown, and none could be that is smaller than the interval.
"""

SHARING = """What sharing light between pixels moves, by {seeds} pictures of the same samples with it and without. It smooths
edges of light away that few samples do not show, and comes to an end with more of them; the stated errors have it.
"""

CALIBRATION = """## Stated errors

*Stated over true*: mean of our runs with at least {believed} samples and a true error of {coarsest:g} % at most; *by run*:
of all, the coarsest first. Forecasts of the time that pictures take have a [page](forecasts.md) of their own.
"""


BY_PROCESSOR = """
All times are of the processors, added up over their cores, since others shared the machine: that a program leaves a core
idle does not count.
"""

PICTURES = """## What equal time gives

Lumenray to the left, Cycles to the right, both with the exposure of the left one; nothing is smoothed.
"""


def write_document(result: dict, path: Path) -> None:
    """Write the document of results of `run.measure`."""
    scenes = result["scenes"]
    title = TITLE.format(
        tries=TRIES,
        finer=FINER,
        base=BASE,
        coarsest=100 * COARSEST,
        flattest=FLATTEST,
        steepest=STEEPEST,
        independent=INDEPENDENT,
        alike="" if result["has_methods"] else ALIKE,
        stand_ins=STAND_INS if any(scene["stand_ins"] for scene in scenes) else "",
    )
    parts = [
        title,
        _machine(result),
        _warnings(result),
        tell_demands(check_bars(result)),
        *_races(scenes),
        *_bias(scenes),
        *_calibration(scenes),
        tell_card(*result["card"]) if result.get("card") else "",
        *_pictures(scenes),
    ]
    path.write_text("\n".join(part for part in parts if part), encoding="utf-8")


def _machine(result: dict) -> str:
    machine = result["machine"]
    width, height = result["size"]
    return (
        f"## Machine\n\n{machine['cpu']}, {machine['cores']} cores, {machine['memory_gib']} GiB, {machine['system']}; "
        f"Python {machine['python']}, Mitsuba {machine['mitsuba']}, Lumenray {machine['lumenray']}. Pictures of "
        f"{width} x {height} pixels, at most {_budgets(result)} s for each program in a scene.\n"
        f"{BY_PROCESSOR if _is_by_processor(result) else ''}"
    )


def _budgets(result: dict) -> str:
    """Time of all scenes, or of those that had another one too."""
    most: dict[float, list[str]] = {}
    for scene in result["scenes"]:
        most.setdefault(scene.get("budget", result["budget"]), []).append(scene["key"])
    if len(most) == 1:
        return f"{next(iter(most)):g}"
    parts = sorted(most.items(), key=lambda each: len(each[1]))
    return (
        ", ".join(f"{budget:g} ({', '.join(keys)})" for budget, keys in parts[:-1])
        + f" or {parts[-1][0]:g}"
    )


def _is_by_processor(result: dict) -> bool:
    return any(scene.get("by_processor") for scene in result["scenes"])


def _warnings(result: dict) -> str:
    said = []
    if result["size"] != list(SIZE):
        said.append(f"This was a short run; whole ones are of {SIZE[0]} x {SIZE[1]} pixels.")
    loads = [scene["other_load"] for scene in result["scenes"] if scene["other_load"] is not None]
    if max(loads, default=0.0) > BEARABLE_LOAD and not _is_by_processor(result):
        said.append(
            f"Times are not to be relied on: other processes took up to "
            f"{100 * max(loads):.0f} % of the processors meanwhile."
        )
    return f"**{' '.join(said)}**\n" if said else ""


def _races(scenes: list[dict]) -> list[str]:
    names = [name for name in STYLES if any(name in scene["programs"] for scene in scenes)]
    others = [name for name in RIVALS if name in names]
    head = f"| scene | error | {' | '.join(f'{STYLES[name][0]}, s' for name in names)} | "
    head += " | ".join(f"{STYLES[name][0]} over ours" for name in others) + " |"
    if not others:
        head = head.removesuffix("  |")
    rows = []
    for scene in scenes:
        for target in TARGETS:
            times = [_tell_reach(reach(scene["programs"].get(name), target)) for name in names]
            factors = [_tell_ratio(scene, name, target) for name in others]
            cells = [_name(scene), f"{100 * target:g} %", *times, *factors]
            rows.append(f"| {' | '.join(cells)} |")
    rows += _totals(scenes, names, others)
    return [
        "## Seconds to an error\n\n![Error over time](pictures_races.png)\n",
        make_table(head, rows),
        "What was run:\n",
        _runs(scenes),
        _means(scenes),
        _refusals(scenes),
    ]


def _name(scene: dict) -> str:
    return f"{scene['title']} (`{scene['key']}`)"


def _totals(scenes: list[dict], names: list[str], others: list[str]) -> list[str]:
    """Lines of the geometric means, by scene and of all."""
    if not others:
        return []
    rows = []
    for title, chosen in [*((f"`{scene['key']}`", [scene]) for scene in scenes), ("all", scenes)]:
        means = [speedup(chosen, name) for name in others]
        told = ["-" if mean is None else f"x {mean:.3g}" for mean in means]
        rows.append(f"| **{title}, geometric mean** | {'| ' * len(names)}| {' | '.join(told)} |")
    return rows


def _tell_reach(found: Reach | None) -> str:
    if found is None:
        return "-"
    return (
        f"{found.bound} {found.seconds:.3g}{chr(92) + '*' if found.is_thought_on else ''}".strip()
    )


def _tell_ratio(scene: dict, name: str, target: float) -> str:
    value, bound, is_extended = ratio(scene, name, target)
    if value is None:
        return "-"
    return f"x {bound} {value:.3g}{chr(92) + '*' if is_extended else ''}".replace("  ", " ")


def _runs(scenes: list[dict]) -> str:
    rows = []
    for scene, name, row in _rows(scenes):
        runs = zip(row["samples"], row["errors"], row["seconds"], strict=True)
        told = ", ".join(f"{n}: {100 * e:.1f} % in {s:.3g} s" for n, e, s in runs)
        error = f"{100 * row['reference_error']:.2f}"
        rows.append(f"| `{scene['key']}` | {STYLES[name][0]} | {told} | {error} |")
    return make_table("| scene | program | samples: error in time | reference, % |", rows, 3)


def _means(scenes: list[dict]) -> str:
    rows = []
    for scene in scenes:
        ours, theirs = (scene["programs"].get(name) for name in (OURS, CYCLES))
        if theirs is None or "refusal" in theirs:
            continue
        told = [f"{row['mean']:.4g} ± {row['mean_error']:.2g}" for row in (ours, theirs)]
        off = 100.0 * (theirs["mean"] / ours["mean"] - 1.0)
        rows.append(f"| `{scene['key']}` | {told[0]} | {told[1]} | {off:+.2f} % |")
    head = "| scene | Lumenray, mean cd/m² | Cycles, mean cd/m² | apart |"
    return make_table(head, rows) if rows else ""


def _rows(scenes: list[dict]):
    """All programs of all scenes that ran."""
    for scene in scenes:
        for name, row in scene["programs"].items():
            if "refusal" not in row:
                yield scene, name, row


def _refusals(scenes: list[dict]) -> str:
    lines = [
        f"- `{scene['key']}`, {STYLES[name][0]}: {row['refusal']}"
        for scene in scenes
        for name, row in scene["programs"].items()
        if "refusal" in row
    ]
    return "\n".join(["Not measured:\n", *lines]) + "\n" if lines else ""


def _bias(scenes: list[dict]) -> list[str]:
    known = [scene for scene in scenes if scene["bias"] is not None]
    if not known:
        return []
    parts = [
        BIAS.format(seeds=SEEDS, block=BLOCK),
        _blocks((scene, scene["bias"]) for scene in known),
    ]
    # Results of earlier versions, which a run may go on with, do not tell it.
    moved = [(scene, scene["bias"]["sharing"]) for scene in known if "sharing" in scene["bias"]]
    return [*parts, SHARING.format(seeds=SEEDS), _blocks(moved)] if moved else parts


def _blocks(found) -> str:
    """Differences by blocks: pairs of a scene and what `statistics.find_bias` has found."""
    rows = []
    for scene, each in found:
        whole = f"{each['mean']:+.3f} ± {each['mean_interval']:.3f}"
        numbers = [f"{each[k]:.3f}" for k in ("noise", "spread", "largest", "interval", "worst")]
        cells = [_name(scene), f"{scene['bias']['samples']}", str(each["blocks"]), whole, *numbers]
        rows.append(f"| {' | '.join(cells)} |")
    return make_table(
        "| scene | samples | blocks | whole | noise | spread | largest | interval | beyond noise |",
        rows,
    )


def _calibration(scenes: list[dict]) -> list[str]:
    rows = []
    for scene in scenes:
        stated = scene_calibration(scene)
        told = "-" if stated is None else f"{stated:.2f}"
        ours = scene["programs"][OURS]
        runs = zip(ours["stated"], ours["errors"], strict=True)
        by_run = ", ".join(f"{own / true:.2f}" for own, true in runs)
        rows.append(f"| {_name(scene)} | {told} | {by_run} |")
    return [
        CALIBRATION.format(believed=BELIEVED, coarsest=100 * COARSEST),
        make_table("| scene | stated over true | by run |", rows),
    ]


def _pictures(scenes: list[dict]) -> list[str]:
    parts = []
    for scene in scenes:
        if scene["pair"] is not None:
            ours, theirs = scene["pair"]
            parts.append(
                f"{scene['title']}: Lumenray after {ours:.3g} s, Cycles after {theirs:.3g} s\n\n"
                f"![{scene['title']}](pictures_{scene['key']}.png)\n"
            )
    return [PICTURES, *parts] if parts else []
