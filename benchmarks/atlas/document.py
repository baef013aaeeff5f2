"""The document of the benchmark of the atlas, made of its numbers."""

from pathlib import Path

import numpy as np

from ..common.document import BEARABLE_LOAD, tell_demands
from .bars import check_bars
from .race import OURS, RIVALS, SWITCHES, TARGETS, reach, ways_of
from .scale import growth
from .summary import ratio

TITLE = """# Lux maps: accuracy that is stated, time that is forecast

*Made by `lumenray benchmark atlas{options}`; do not edit by hand.*

Whole maps are baked, and what they state of themselves is compared with the truth. To repeat it:
`lumenray benchmark atlas --json out/atlas.json`; `--scale` also bakes the large buildings anew, as
`python -m lumenray.benchmarks.atlas.scale` does alone (some hours; what was ended is gone on with; otherwise the last
results are told), and `--check out/atlas.json` compares another run with an earlier one.

- **References** are computed by code that the bakes do not use: plain path tracing at every lumel, as for sensors, without
  cells, tiles or light apart, down to a standard error of {reference:g} % where {patience:.0f} s are enough. A random subset
  of the lumels of a scene has one; whole lumels are meant, by {fineness} x {fineness} places on their part of the surface,
  which are found from the finished texture coordinates. Lumels of which less than a quarter lies on a surface, and lumels
  that are partly inside a solid, are left out. The references' own noise is taken off all true errors. They are kept in
  `out/atlas/references`, by the hash of the scene and the lumels, and computed again where they are missing; that time does
  not count.
- **Relative error** is the root mean square over the lumels, weighted by area, over the mean illuminance.
"""

CALIBRATION = """## Is the stated error the true one?

Every scene is baked to {levels} with other random numbers each time. *True over stated*: for the lumels with a reference.
*Held*: share of lumels whose own interval of 95 % (Student's t with the degrees of freedom that the maps state) holds the
reference.

![True over stated error](atlas_calibration.png)
"""

FORECASTS = """## Forecast of the time

Bakes of about {seconds:.0f} s to an error. *First*: the first forecast that was told after 5 % of the time had passed, which
rests on a pilot and a small trial. *After two passes*: that which knows how the error really falls. *At* tells when they
were made. Even work of that length (hashing on all processors, in the same run), foretold from its first
tenth, is off by {unsteadiness} in the median on this machine: what is below that cannot be told here.
"""

RACES = """## Seconds to an error

Lumels, texture coordinates and reference are the same for all. So that all can state the scene alike, it is plain: neutral,
matt and flat, lights by their photometry. Judged are lumels away from the borders of charts, which mean the same to all.

- **Lumenray**: the whole call of `Session.bake_objects`, laying out and preparing included, in a session that has the scene;
  it ran once before, so that kernels come from the machine's cache. The very first call is told apart.
- **Plain gathering**: every lumel gathers by Mitsuba paths of independent random numbers, all lumels alike, with next-event
  to all lights and multiple importance sampling at every vertex and Russian roulette: a good path tracer without the rest.
- **Cycles** bakes the same page (`bpy.ops.object.bake`, diffuse light without colour, all bounces, no clamping, no filter);
  its time is taken inside Blender, and that of a bake with one sample is taken off.
- **Radiance** is `rtrace -I`, one process per processor, at {places} places of each lumel, with more and more divisions,
  both exactly (`-aa 0`) and with its cache of indirect light; the faster of the two counts.

Each run is made twice, those of Radiance once, and the faster one counts: what else the machine does only adds to a time.
Plain gathering and exact Radiance compute the judged lumels only and their times are multiplied up to all lumels, to which
they are proportional. Between runs times are interpolated; *\\** marks times beyond the longest run, on the line through
the last three; `>` an error that more work no longer brings nearer, and `<` one that the least work met.

![Error over time](atlas_races.png)
"""

SWITCHES_TEXT = """## What the parts of the method are worth

Time without a part over the time with it, to the same true error. *qmc*: random numbers in place of low-discrepancy points.
*direct_apart*: direct light and interreflection with as many samples each. *adaptive*: all tiles with as many samples.
"""

GEOMETRY = """## Leaks, seams and hard geometry

*Dark* is what is found where no light can be, over the lit side. *Step*: what a viewer sees at borders between charts of a
smooth cylinder, read bilinearly on both sides; *noise*: the standard error of that. Hard geometry absorbs everything under
an even sky, so its exact illuminance is the same everywhere; *on the maps* is the share of its surface that has lumels.
"""

SCALE = """## Scale

Buildings of rooms with doorways, furniture and a lamp in each, all surfaces divided and bumpy, baked with {samples} samples
per lumel and written to files, each in a process of its own. *Memory* is the most that it ever held.

![Time and memory over lumels](atlas_scale.png)
"""


def write_document(result: dict, path: Path) -> None:
    """Write the document of results of `run.measure`."""
    from .lumels import FINENESS
    from .ours import REFERENCE_ERROR, REFERENCE_SECONDS

    title = TITLE.format(
        options=" --quick" if result["is_quick"] else "",
        reference=100 * REFERENCE_ERROR,
        patience=REFERENCE_SECONDS,
        fineness=FINENESS,
    )
    parts = [
        title,
        _machine(result),
        _warnings(result),
        tell_demands(check_bars(result)),
        *_calibration(result["scenes"], result["unsteadiness"]),
        *_races(result["races"]),
        *_geometry(result["geometry"]),
        *_scale(result["scale"]),
    ]
    path.write_text("\n".join(part for part in parts if part), encoding="utf-8")


def _machine(result: dict) -> str:
    machine = result["machine"]
    return (
        f"## Machine\n\n{machine['cpu']}, {machine['cores']} cores, {machine['memory_gib']} GiB, {machine['system']}; "
        f"Python {machine['python']}, Mitsuba {machine['mitsuba']}, Lumenray {machine['lumenray']}. The whole run took "
        f"{result['seconds']:.0f} s, references that were missing included.\n"
    )


def _warnings(result: dict) -> str:
    said = []
    if result["is_quick"]:
        said.append("This was a quick run, with fewer scenes and shorter runs.")
    load = result["other_load"]
    if load is not None and load > BEARABLE_LOAD:
        said.append(
            f"Times are not to be relied on: other processes took {100 * load:.0f} % of the processors meanwhile."
        )
    return f"**{' '.join(said)}**\n" if said else ""


def _table(head, rows, words: int) -> str:
    """Markdown table; the first ``words`` columns are to the left."""
    lines = [head, ["---"] * words + ["--:"] * (len(head) - words), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines) + "\n"


def _calibration(scenes: list[dict], unsteadiness: float) -> list[str]:
    if not scenes:
        return []
    head = (
        "scene", "lumels", "judged", "left out", "reference, %", "asked for", "bakes", "replicates", "stated, %",
        "true, %", "true over stated", "held, %", "mean over reference", "seconds",
    )  # fmt: skip
    rows = []
    for scene in scenes:
        for level in sorted({run["level"] for run in scene["runs"]}, reverse=True):
            runs = [run for run in scene["runs"] if run["level"] == level]
            mean = {name: float(np.mean([run[name] for run in runs])) for name in runs[0]}
            spread = np.ptp([run["ratio"] for run in runs]) / 2
            rows.append(
                [
                    f"{scene['title']} (`{scene['key']}`)",
                    str(scene["lumels"]),
                    str(scene["judged"]),
                    str(scene["cut"]),
                    f"{100 * scene['reference_error']:.2f}",
                    f"{100 * level:g} %",
                    str(len(runs)),
                    f"{mean['replicates']:.0f}",
                    f"{100 * mean['stated_here']:.2f}",
                    f"{100 * mean['true']:.2f}",
                    f"{mean['ratio']:.2f} ± {spread:.2f}",
                    f"{100 * mean['covered']:.1f}",
                    f"{mean['mean']:.4f}",
                    f"{mean['seconds']:.1f}",
                ]
            )
    levels = " and ".join(
        f"{100 * level:g} %"
        for level in sorted({run["level"] for run in scenes[0]["runs"]}, reverse=True)
    )
    seconds = np.median([row["seconds"] for scene in scenes for row in scene["forecasts"]])
    return [
        CALIBRATION.format(levels=levels),
        _table(head, rows, 1),
        FORECASTS.format(seconds=seconds, unsteadiness=f"{100 * unsteadiness:.1f} %"),
        _forecasts(scenes),
    ]


def _forecasts(scenes: list[dict]) -> str:
    head = (
        "scene",
        "error, %",
        "took, s",
        "first, over true",
        "at",
        "after two passes, over true",
        "at",
    )
    rows = []
    for scene in scenes:
        for row in scene["forecasts"]:
            words = [f"`{scene['key']}`", f"{100 * row['target']:.2f}", f"{row['seconds']:.2f}"]
            for own in (row["rough"], row["settled"]):
                words += (
                    ["-", "never"]
                    if own is None
                    else [f"{own['share']:.3f}", f"{100 * own['at']:.0f} %"]
                )
            rows.append(words)
    return _table(head, rows, 1)


def _races(races: list[dict]) -> list[str]:
    if not races:
        return []
    from .radiance import PLACES

    head = ("scene", "lumels", "error", f"{OURS}, s", *(f"{title}, s" for title in RIVALS.values()))
    ratios = ("scene", "error", *(f"{title} over ours" for title in RIVALS.values()))
    times, factors = [], []
    for scene in races:
        for target in TARGETS:
            name = f"{scene['title']} (`{scene['key']}`)"
            programs = [scene["programs"].get(key) for key in (OURS, *RIVALS)]
            times.append(
                [
                    name,
                    str(scene["lumels"]),
                    f"{100 * target:g} %",
                    *(_tell_reach(row, target) for row in programs),
                ]
            )
            factors.append(
                [name, f"{100 * target:g} %", *(_tell_ratio(scene, key, target) for key in RIVALS)]
            )
    return [
        RACES.format(places=PLACES),
        _table(head, times, 1),
        _table(ratios, factors, 1),
        _runs(races),
        _refusals(races),
        SWITCHES_TEXT,
        _switches(races),
    ]


def _tell_reach(row: dict | None, target: float) -> str:
    found = None if row is None else reach(row, target)
    if found is None:
        return "-"
    star = "\\*" if found.is_thought_on else ""
    return f"{found.bound} {found.seconds:.3g}{star}".strip()


def _tell_ratio(scene: dict, name: str, target: float) -> str:
    value, bound, is_thought_on = ratio(scene, name, target)
    if value is None or bound == "?":
        return "-"
    return f"x {bound} {value:.3g}{chr(92) + '*' if is_thought_on else ''}".replace("  ", " ")


def _runs(races: list[dict]) -> str:
    head = ("scene", "program", "times multiplied", "runs: error in seconds", "mean over reference")
    rows = []
    for scene in races:
        for name, row in scene["programs"].items():
            if "refusal" in row:
                continue
            for way, runs in ways_of(row).items():
                told = ", ".join(f"{100 * e:.2f} % in {s:.3g}" for s, e in runs["points"])
                title = f"{RIVALS.get(name, name)} {way}".strip()
                rows.append(
                    [
                        f"`{scene['key']}`",
                        title,
                        f"{runs['scaled']:.1f}",
                        told,
                        f"{runs['mean']:.4f}",
                    ]
                )
        rows.append(
            [
                f"`{scene['key']}`",
                f"{OURS}, very first call",
                "",
                f"{scene['first_seconds']:.3g} s",
                "",
            ]
        )
    return _table(head, rows, 2)


def _refusals(races: list[dict]) -> str:
    lines = [
        f"- `{scene['key']}`, {RIVALS.get(name, name)}: {row['refusal']}"
        for scene in races
        for name, row in scene["programs"].items()
        if "refusal" in row
    ]
    return "\n".join(["Not measured:\n", *lines]) + "\n" if lines else ""


def _switches(races: list[dict]) -> str:
    head = ("scene", "error", *SWITCHES)
    rows = [
        [f"`{scene['key']}`", f"{100 * target:g} %"]
        + [_tell_ratio(scene, name, target) for name in SWITCHES]
        for scene in races
        for target in TARGETS
    ]
    return _table(head, rows, 1)


def _geometry(geometry: dict | None) -> list[str]:
    if geometry is None:
        return []
    leaks = [
        [
            row["case"],
            f"{row['lit']:.1f}",
            f"{100 * row['dark']:.4f}",
            f"{100 * row['largest']:.4f}",
            str(row["lumels"]),
        ]
        for row in geometry["leaks"]
    ]
    seams = [
        [
            f"{100 * row['error']:g} %",
            str(row["charts"]),
            str(row["places"]),
            f"{row['mean']:.0f}",
            f"{row['step']:.3g}",
            f"{row['noise']:.3g}",
            f"{row['before']:.3g}",
            f"{row['after']:.3g}",
        ]
        for row in geometry["seams"]
    ]
    hard = [
        [row["case"], str(row["triangles"]), "-", "-", "-", "-", f"fails: {row['failure']}"]
        if "failure" in row
        else [
            row["case"],
            str(row["triangles"]),
            str(row["lumels"]),
            str(row["not_finite"]),
            f"{100 * row['area']:.2f}",
            "-" if row["low"] is None else f"{row['low']:.3f} to {row['high']:.3f}",
            "; ".join(row["reported"]) or "nothing",
        ]
        for row in geometry["hard"]
    ]
    return [
        GEOMETRY,
        _table(("case", "lit, lx", "dark, %", "largest, %", "dark lumels"), leaks, 1),
        _table(
            (
                "asked for", "charts", "places", "mean, lx", "step, lx", "noise, lx", "said before, lx",
                "said after, lx",
            ),
            seams,
            1,
        ),
        _table(
            (
                "case", "triangles", "lumels", "not finite", "on the maps, %", "over exact", "reported",
            ),
            hard,
            1,
        ),
    ]  # fmt: skip


def _scale(scale: dict | None) -> list[str]:
    if scale is None:
        return []
    head = (
        "triangles", "charts", "lumels", "pages", "lumels per m", "before samples, s", "samples, s", "after, s", "all, s",
        "s per M lumels", "memory, GiB", "of it the scene",
    )  # fmt: skip
    rows = [
        [
            str(row["triangles"]),
            str(row["charts"]),
            str(row["lumels"]),
            str(row["pages"]),
            f"{row['density']:.1f}",
            f"{row['setup']:.1f}",
            f"{row['tracing']:.1f}",
            f"{row['finishing']:.1f}",
            f"{row['seconds']:.1f}",
            f"{row['seconds'] / row['lumels'] * 1e6:.2f}",
            f"{row['memory']:.1f}",
            f"{row['memory_before']:.1f}",
        ]
        for row in scale["runs"]
    ]
    power = growth(scale["runs"])
    end = (
        "" if power is None else f"Time grows with the power {power:.2f} of the number of lumels.\n"
    )
    return [SCALE.format(samples=scale["samples"]), _table(head, rows, 0), end]
