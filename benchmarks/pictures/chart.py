"""Pictures of the benchmark of pictures: error over time, and what programs made in equal time."""

from pathlib import Path

import numpy as np

from ...engine.analysis.false_colour import write_display
from ...engine.photometry.colour import automatic_white
from ..common.panels import HEAD, Panel, PanelPicture, decades
from .programs import BEFORE, CYCLES, OURS, Made
from .statistics import TARGETS

STYLES = {
    OURS: ("Lumenray", "#0072b2", "disk"),
    BEFORE: ("plain paths of ours", "#d55e00", "square"),
    CYCLES: ("Cycles", "#cc79a7", "diamond"),
}
"""Names, colours that people who see few colours tell apart (Okabe and Ito), and shapes."""

GAP = 4
"""Between two pictures. [pixel]"""


def draw_races(scenes: list[dict], path: Path) -> None:
    """Draw error over time, a panel for every scene."""
    picture = PanelPicture(len(scenes))
    curves = [
        {
            name: list(zip(row["seconds"], row["errors"], strict=True))
            for name, row in scene["programs"].items()
            if "refusal" not in row
        }
        for scene in scenes
    ]
    shown = [name for name in STYLES if any(name in each for each in curves)]
    picture.legend(20.0, HEAD / 2, [STYLES[name] for name in shown])
    points = [point for each in curves for curve in each.values() for point in curve]
    x = decades("time [s]", [seconds for seconds, _ in points])
    y = decades(
        "relative error of a pixel",
        [*TARGETS, *(error for _, error in points)],
        lambda value: f"{100 * value:g} %",
    )
    for number, (scene, each) in enumerate(zip(scenes, curves, strict=True)):
        panel = Panel(picture, number, f"{scene['title']} ({scene['key']})", x, y)
        for target in TARGETS:
            panel.level(target)
        for name, curve in each.items():
            _, colour, shape = STYLES[name]
            panel.line(curve, colour)
            for point in curve:
                panel.mark(*point, colour, shape)
    picture.save(path)


def draw_pair(pair: list[Made], path: Path) -> None:
    """Put two pictures side by side, with the exposure of the first."""
    white = automatic_white(pair[0].luminance)
    left, right = (made.linear / white for made in pair)
    gap = np.ones((left.shape[0], GAP, 3))
    write_display(path, np.concatenate([left, gap, right], axis=1))
