"""Pictures of the benchmark of the atlas: error over time, true over stated error, time over size."""

import math
from pathlib import Path

from ..common.panels import HEAD, Axis, Panel, PanelPicture, decades
from .bars import CALIBRATION
from .race import OURS, RIVALS, ways_of

STYLES = {
    OURS: ("#0072b2", "disk"),
    "plain_gather": ("#d55e00", "square"),
    "cycles": ("#cc79a7", "diamond"),
    "radiance": ("#009e73", "triangle"),
    "radiance, cached": ("#56b4e9", "triangle"),
}
"""Colours, which people who see few colours tell apart (Okabe and Ito), and shapes."""

SERIES = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")


def draw_races(races: list[dict], path: Path) -> None:
    """Draw error over time, a panel for every scene."""
    picture = PanelPicture(len(races))
    names = [name for name in STYLES if any(_curves(race).get(name) for race in races)]
    titles = {"radiance": "Radiance", "radiance, cached": "Radiance with cache", **RIVALS}
    picture.legend(20.0, HEAD / 2, [(titles.get(name, name), *STYLES[name]) for name in names])
    points = [p for race in races for curve in _curves(race).values() for p in curve]
    x = decades("time [s]", [seconds for seconds, _ in points])
    y = decades(
        "RMS relative error", [error for _, error in points], lambda value: f"{100 * value:g} %"
    )
    for number, race in enumerate(races):
        panel = Panel(picture, number, f"{race['title']} ({race['key']})", x, y)
        panel.level(0.01)
        panel.level(0.02)
        for name, curve in _curves(race).items():
            panel.line(curve, STYLES[name][0])
            for point in curve:
                panel.mark(*point, *STYLES[name])
    picture.save(path)


def _curves(race: dict) -> dict[str, list]:
    made = {}
    for name, row in race["programs"].items():
        if "refusal" in row:
            continue
        for way, runs in ways_of(row).items():
            made[f"{name}, cached" if way == "cached" else name] = runs["points"]
    return made


def draw_calibration(scenes: list[dict], path: Path) -> None:
    """Draw true over stated error of every bake, scene by scene, and the share of intervals that hold."""
    picture = PanelPicture(2)
    shapes = ("disk", "square", "triangle", "diamond")
    levels = sorted({run["level"] for scene in scenes for run in scene["runs"]}, reverse=True)
    styles = {
        level: (colour, shape) for level, colour, shape in zip(levels, SERIES, shapes, strict=False)
    }
    picture.legend(
        20.0, HEAD / 2, [(f"asked for {100 * level:g} %", *styles[level]) for level in levels]
    )
    names = [scene["key"] for scene in scenes]
    x = Axis(
        "",
        -0.5,
        len(names) - 0.5,
        [float(k) for k in range(len(names))],
        tell=lambda value: names[round(value)],
    )
    ratios = [run["ratio"] for scene in scenes for run in scene["runs"]]
    high = max(1.4, 0.1 * math.ceil(10 * max(ratios)))
    low = min(0.6, 0.1 * math.floor(10 * min(ratios)))
    step = 0.1 if high - low < 1.2 else 0.5
    ticks = [step * k for k in range(math.ceil(low / step), math.floor(high / step) + 1)]
    panel = Panel(picture, 0, "True over stated error", x, Axis("", low, high, ticks, tell=_short))
    for value in (*CALIBRATION, 1.0):
        panel.level(value)
    covered = Panel(
        picture,
        1,
        "Lumels whose 95 % interval holds",
        x,
        Axis("", 85.0, 100.0, [85.0, 90.0, 93.0, 95.0, 97.0, 100.0], tell=lambda v: f"{v:g} %"),
    )
    covered.level(95.0)
    for number, scene in enumerate(scenes):
        for k, run in enumerate(scene["runs"]):
            place = number + 0.5 * ((k + 0.5) / len(scene["runs"]) - 0.5)
            panel.mark(place, run["ratio"], *styles[run["level"]])
            covered.mark(place, 100 * run["covered"], *styles[run["level"]])
    picture.save(path)


def draw_scale(scale: dict, path: Path) -> None:
    """Draw time and memory over lumels."""
    picture = PanelPicture(2)
    rows = scale["runs"]
    kinds = sorted({round(row["triangles"] / 1e6, 1) for row in rows})
    colours = dict(zip(kinds, SERIES, strict=False))
    picture.legend(
        20.0,
        HEAD / 2,
        [(f"{kind:g} M triangles", colour, "disk") for kind, colour in colours.items()],
    )
    x = decades("lumels", [row["lumels"] for row in rows], lambda value: f"{value / 1e6:g} M")
    for number, (name, title) in enumerate((("seconds", "time [s]"), ("memory", "memory [GiB]"))):
        y = decades(title, [row[name] for row in rows])
        panel = Panel(picture, number, f"{title} over lumels", x, y)
        for kind, colour in colours.items():
            mine = [
                (row["lumels"], row[name])
                for row in rows
                if round(row["triangles"] / 1e6, 1) == kind
            ]
            panel.line(sorted(mine), colour)
            for point in mine:
                panel.mark(*point, colour, "disk")
    picture.save(path)


def _short(value: float) -> str:
    return f"{value:.1f}"
