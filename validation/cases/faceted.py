"""C45: a ball of few facets that is shaded smoothly; its lux map holds the light that its facets take in."""

import numpy as np

from lumenray.engine.scene.light import Output, Quantity, SunLight, UniformWorld

from ..bench import Bench, Finding, Findings
from ..reference import Group
from ..stage import matt, sphere
from .means import mean_by_bake, reseeded
from .registry import case

RINGS = 16
"""Parallels; there are twice as many meridians."""

LUMINANCE, SUN_NORMAL = 100.0, 1000.0
"""Of the even world [cd/m2]; illuminance by the sun of a plane that faces it [lx]."""

PAINT = matt("paint", 0.5)

BALL = sphere("ball", (0.0, 0.0, 0.0), 1.0, "paint", rings=RINGS, smooth=True)


@case("C45", "Ball of few facets", "stability", quick=("C45.sun",))
def run_faceted_balls(bench: Bench) -> Findings:
    """Mean under an even world; flux of a sun from the zenith."""
    groups = bench.groups("C45")
    if group := groups.get("C45.world"):
        yield _bake(bench, group, UniformWorld(LUMINANCE), BALL.areas().sum())
    if group := groups.get("C45.sun"):
        output = Output(Quantity.ILLUMINANCE, SUN_NORMAL)
        sun = SunLight("sun", "sun", output, np.array([0.0, 0.0, -1.0]), np.radians(0.53))
        yield _bake(bench, group, sun, 1.0)


def _bake(bench: Bench, group: Group, light, area: float) -> Finding:
    found = [
        mean_by_bake(reseeded(bench, number), [PAINT, BALL, light], (BALL,), allowed, area)
        for number, allowed in enumerate(group.allowed)
    ]
    return Finding(group, *np.array(found).T)
