"""C23 and C29: nine decades of light in one scene, and closed boxes that stay dark."""

import numpy as np

from lumenray.engine.scene.light import Output, Quantity, SunLight, UniformWorld

from .. import stage
from ..bench import Bench, Finding, Findings
from .registry import case

EMITTER_SIZE = 0.01
"""Side of the bright emitter of C23. [m]"""

EMITTER_LUMINANCE = 1e9
"""Its luminance. [cd/m2]"""

FAINT_DOME = UniformWorld(1e-5)
"""The dome beside it. [cd/m2]"""

OUTSIDE = 1e5
"""Luminance of the dome [cd/m2] and illuminance of the sun [lx] around the box of C29."""


@case("C23", "Dynamic range 1e9", "stability", quick=("C23.range",))
def dynamic_range(bench: Bench) -> Findings:
    """A bright emitter and a point in its shadow, without and with a faint dome."""
    groups = bench.groups("C23")
    strip = stage.quad("strip", (1.0, -1.0, 1.0), (0.6, 0.0, 0.0), (0.0, 2.0, 0.0), "black")
    paint = stage.glowing("bright", EMITTER_LUMINANCE)
    half, sides = 0.5 * EMITTER_SIZE, ((0, EMITTER_SIZE, 0), (EMITTER_SIZE, 0, 0))
    emitter = stage.quad("emitter", (-half, -half, 3.0), *sides, paint.id)
    scene = (stage.BLACK, strip, paint, emitter)
    if "C23.range" in groups:
        yield bench.measure_group(scene, groups["C23.range"])
    group = groups.get("C23.range_dome")
    if group is None:
        return
    # In the shadow beside the bright emitter; at the lit point the dome's part is what is left when it is dark.
    dark = (stage.BLACK, strip, stage.quad("emitter", (-half, -half, 3.0), *sides, "black"))
    values, errors = np.zeros(2), np.zeros(2)
    for i, items in enumerate((scene, dark)):
        row = slice(i, i + 1)
        made = bench.measure(
            (*items, FAINT_DOME), group.positions[row], group.normals[row], group.allowed[row]
        )
        values[row], errors[row] = made.values, made.errors
    yield Finding(group, values, errors)


@case("C29", "Light leaks", "stability", quick=("C29.leak",))
def leaks(bench: Bench) -> Findings:
    """A closed box whose faces share edges, in bright surroundings."""
    groups = bench.groups("C29")
    if "C29.leak" in groups:
        output = Output(Quantity.ILLUMINANCE, OUTSIDE, stage.EVEN)
        travels = np.array((-0.6, 0.0, -0.8))
        sun = SunLight("sun", "sun", output, travels, np.radians(0.533))
        box = stage.box("box", (0.0, 0.0, 0.0), (4.0, 4.0, 3.0), "black")
        yield bench.measure_group(
            (stage.BLACK, box, UniformWorld(OUTSIDE), sun), groups["C29.leak"]
        )
