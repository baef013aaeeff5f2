"""C12 and C13: light of the sky through an opening in the roof, without and with glass."""

from lumenray.engine.scene.material import ThinGlass
from lumenray.engine.sky.cie import sun_direction

from ..bench import Bench, Findings
from .registry import case
from .rooms import OPEN, SUN_ELEVATION, glass, measure_under_skies, room, with_prefix

HOLES = {"1x1": ((1.5, 2.5), (1.5, 2.5)), "4x4": ((0.0, 4.0), (0.0, 4.0))}
"""Openings in the ceiling by their sizes. [m]"""

TOWARDS_SUN = sun_direction(SUN_ELEVATION, 0.0)
"""The wall with the sensors, y = 0, faces the sun."""


@case(
    "C12",
    "Sky component, unglazed roof opening",
    "daylight",
    quick=("C12.1x1.sky1", "C12.1x1.sky12"),
)
def unglazed(bench: Bench) -> Findings:
    """Both openings under all skies."""
    groups = bench.groups("C12")
    for size, hole in HOLES.items():
        chosen = with_prefix(groups, f"C12.{size}.sky")
        yield from measure_under_skies(bench, room("ceiling", hole, OPEN), chosen, TOWARDS_SUN)


@case("C13", "Sky component, glazed roof opening", "daylight", quick=("C13.1x1.sky5",))
def glazed(bench: Bench) -> Findings:
    """Both openings under all skies, with the pane of C07 and with one that absorbs nothing."""
    groups = bench.groups("C13")
    panes = {"": glass("pane"), ".lossless": glass("pane", ThinGlass(1.52))}
    for variant, pane in panes.items():
        for size, hole in HOLES.items():
            chosen = with_prefix(groups, f"C13.{size}{variant}.sky")
            yield from measure_under_skies(bench, room("ceiling", hole, pane), chosen, TOWARDS_SUN)
