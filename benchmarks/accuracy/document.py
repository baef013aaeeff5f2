"""The document of the benchmark of accuracy, made of its numbers."""

from pathlib import Path

from ..common.document import BEARABLE_LOAD, make_table, tell_demands
from .bars import check_bars
from .programs import OURS, PEERS
from .statistics import (
    TARGETS,
    Comparison,
    Figure,
    honesty_of,
    make_curve,
    ratio_to,
    seconds_to,
    slope_of,
    start_up,
    tell_ratio,
)

PIXEL_TARGET = 0.1
"""Relative error of pixels to which times are compared."""

TITLE = """# Error over time

*Made by `lumenray benchmark accuracy{options}`; do not edit by hand.*

How long it takes to come near the truth. The scenes are cases of the validation suite, whose illuminances are known by
closed forms or by quadrature; so what is shown is the true error, not what a program says of itself: the root mean square
over a scene's sensors of the relative difference from the exact value. All of it was measured in one run, in turns: a
round has every program once with every amount of work. {rounds} rounds, with other random numbers each time.

- **Lumenray** measures as `Session.measure` does: *mono* is photometric transport, which is exact in these neutral scenes
  and what the engine chooses for them by itself; *spectral* is the same with four wavelengths a path. Times are of the
  whole call in a session that has the scene; the first call, which builds the scene's objects and compiles kernels
  where the machine's cache has none, is told as start-up.
- **Radiance** is `rtrace -I` without its caches and shortcuts (`-aa 0 -as 0`, ideal limits of reflections), with more and
  more divisions of the hemisphere (`-ad`) and up to 16 repeats; one process per processor. **Cycles** bakes onto squares
  of 0.5 mm in the sensors' places with more and more samples, no clamping, no filter, all bounces. Both are run as the
  validation suite runs them. Start-up is their whole time with the least work: processes, reading and building the
  scene; **it is taken off their times**, and times that are shorter than the scatter of start-up count as that scatter.
  So the comparison favours them; what they answer without any work that grows has the mark `<`.
- **Live view and pictures** give an error for each pixel and are no way to ask for a few sensors; they are compared below
  with as many sensors in the pixels' place.

Spreads (±, or ×/÷ for ratios) are 99 % intervals from leaving out one round after the other. `<` and `>`: an error that
was met with the least work already, or not with the most. To repeat it:
`lumenray benchmark accuracy --json out/accuracy.json`; with `--check out/accuracy.json` another run compares its
ratios with the earlier ones and fails where they differ by more than both spreads allow.

![Error over time](accuracy.png)
"""

TIMES = """## Time to an error

Times of the others over that of *Lumenray mono*, which is given in seconds.
"""

DETAILS = """## Slopes and start-up

*Slope*: exponent of the error in the amount of work, over the runs whose time can be told from start-up; plain Monte Carlo
has -0.5, and low-discrepancy sequences are steeper where the light varies smoothly.
"""

HONESTY = """## Is the stated error the true one?

Short jobs of *Lumenray mono* again and again, with other random numbers each time: the root mean square of the true errors
over that of the standard errors that came with the values, every sensor counted alike. 1 is honest. Short jobs, because
with few samples an error is hardest to tell. (*Spectral* draws the same paths where nothing has a colour.)
"""

FORECASTS = """## Forecast of the time left

A job to a relative standard error, about twice as long as the longest runs above. The forecast is what its progress says
once a tenth of the time is over, or as soon as there is one; *never*: not before the end.
"""

VIEWS = """## Pictures and the live view

A view of {side} x {side} pixels straight at a place of {scene} whose illuminance is known, and as many sensors there.
The picture gives the illuminance of every pixel; the live view gives luminance alone, which on a matt surface is the
same but for a factor, and makes a frame for the screen ten times a second. *Stated* is the standard error of
pixels; of the live view, what its frames say, which counts pixels darker than the mean by the mean.

![Error of pixels over time](accuracy_views.png)
"""


def write_document(result: dict, path: Path) -> None:
    """Write the document of results of `accuracy.run`."""
    options = " --quick" if result["is_quick"] else ""
    parts = [
        TITLE.format(options=options, rounds=result["rounds"]),
        _machine(result),
        _warnings(result),
        tell_demands(check_bars(result)),
        TIMES,
        _times(result["scenes"]),
        DETAILS,
        _details(result["scenes"]),
        _refusals(result["scenes"]),
        HONESTY,
        _honesty(result["scenes"]),
        FORECASTS,
        _forecasts(result["scenes"]),
        _views(result["views"]),
    ]
    path.write_text("\n".join(part for part in parts if part), encoding="utf-8")


def tell_comparison(rows: list[Comparison]) -> str:
    """Say for a terminal which ratios of two runs agree within their spreads."""
    lines = [
        f"{row.name}: x {row.before:.3g} before, x {row.after:.3g} now, apart by {row.factor:.2f}, "
        f"allowed {row.allowed:.2f}: {'pass' if row.passes else 'FAIL'}"
        for row in rows
    ]
    passed = sum(row.passes for row in rows)
    return "\n".join([*lines, f"{passed} of {len(rows)} ratios agree within their spreads"])


def _machine(result: dict) -> str:
    machine = result["machine"]
    return (
        f"## Machine\n\n{machine['cpu']}, {machine['cores']} cores, {machine['memory_gib']} GiB, {machine['system']}; "
        f"Python {machine['python']}, Mitsuba {machine['mitsuba']}, Lumenray {machine['lumenray']}. The whole run took "
        f"{result['seconds']:.0f} s.\n"
    )


def _warnings(result: dict) -> str:
    said = []
    if result["is_quick"]:
        said.append("This was a quick run, with fewer scenes, few rounds and short times.")
    load = result["other_load"]
    if load is not None and load > BEARABLE_LOAD:
        said.append(
            f"Times are not to be relied on: other processes took {100 * load:.0f} % of the processors meanwhile."
        )
    return f"**{' '.join(said)}**\n" if said else ""


def _times(scenes: list[dict]) -> str:
    others = [*OURS[1:], *(name for name in PEERS if any(name in s["programs"] for s in scenes))]
    head = f"| scene | sensors | error | {OURS[0]}, s | " + " | ".join(others) + " |"
    lines = []
    for scene in scenes:
        programs = scene["programs"]
        for target in TARGETS:
            own = seconds_to(make_curve(programs[OURS[0]]), target)
            words = [f"{scene['title']} (`{scene['key']}`)", str(scene["sensors"])]
            words += [f"{100 * target:g} %", f"{own.bound} {own.value:.2g}".strip()]
            words += [_ratio(programs, name, target) for name in others]
            lines.append("| " + " | ".join(words) + " |")
    return make_table(head, lines, 1)


def _ratio(programs: dict, name: str, target: float) -> str:
    row = programs.get(name)
    if row is None or "refusal" in row:
        return "-"
    return tell_ratio(ratio_to(programs[OURS[0]], row, target))


def _details(scenes: list[dict]) -> str:
    head = (
        "| scene | program | slope | start-up, s | largest error, % | smallest, % | "
        "runs from, s | to, s |"
    )
    lines = []
    for scene in scenes:
        for name, row in scene["programs"].items():
            if "refusal" in row:
                continue
            curve = make_curve(row)
            words = [f"`{scene['key']}`", name, _plain(slope_of(row)), f"{start_up(row):.2f}"]
            words += [f"{100 * curve.errors[0]:.2g}", f"{100 * curve.errors[-1]:.2g}"]
            words += [f"{curve.seconds[0]:.2g}", f"{curve.seconds[-1]:.2g}"]
            lines.append("| " + " | ".join(words) + " |")
    return make_table(head, lines, 2)


def _honesty(scenes: list[dict]) -> str:
    head = "| scene | samples per sensor | jobs | true over stated |"
    lines = [
        f"| `{scene['key']}` | {row['work']} | {row['runs']} | {row['share']:.3f} ± {row['spread']:.3f} |"
        for scene in scenes
        for row in scene["honesty"]
    ]
    return make_table(head, lines, 1)


def _plain(figure: Figure) -> str:
    if figure.bound:
        return "-"
    told = f"{figure.value:.2f}"
    return told if figure.spread is None else f"{told} ± {figure.spread:.2f}"


def _refusals(scenes: list[dict]) -> str:
    lines = [
        f"- `{scene['key']}`, {name}: {row['refusal']}"
        for scene in scenes
        for name, row in scene["programs"].items()
        if "refusal" in row
    ]
    return "\n".join(["Not measured:\n", *lines]) + "\n" if lines else ""


def _forecasts(scenes: list[dict]) -> str:
    head = "| scene | error, % | took, s | forecast taken at | forecast of the rest, s | true rest, s | forecast over true |"
    lines = []
    for scene in scenes:
        for row in scene["forecasts"]:
            words = [f"`{scene['key']}`", f"{100 * row['target']:.2g}", f"{row['seconds']:.2f}"]
            if row["forecast"] is None:
                words += ["never"] + 3 * ["-"]
            else:
                words += [f"{100 * row['share']:.0f} %", f"{row['forecast']:.2f}"]
                words += [f"{row['left']:.2f}", f"x {row['forecast'] / row['left']:.2f}"]
            lines.append("| " + " | ".join(words) + " |")
    return make_table(head, lines, 1)


def _views(views: dict) -> str:
    from .views import PIXELS, SCENE, WAYS

    target = f"{100 * PIXEL_TARGET:g} %"
    head = f"| way | time to {target}, s | over sensors | slope | true over stated |"
    lines = []
    for way in WAYS:
        row, first = views[way], views[WAYS[0]]
        own = seconds_to(make_curve(row), PIXEL_TARGET)
        ratio = "" if way == WAYS[0] else tell_ratio(ratio_to(first, row, PIXEL_TARGET))
        words = [way, f"{own.bound} {own.value:.2g}".strip(), ratio]
        words += [_plain(slope_of(row)), _plain(honesty_of(row))]
        lines.append("| " + " | ".join(words) + " |")
    return f"{VIEWS.format(side=PIXELS, scene=f'`{SCENE}`')}\n{make_table(head, lines, 1)}"
