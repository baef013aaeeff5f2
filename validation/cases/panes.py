"""C38 and C39: light that goes to and fro between parallel panes, and lamps that are seen in them."""

import numpy as np

from lumenray.engine.scene.light import Output, Quantity, SunLight

from ..bench import Bench, Finding, Findings
from ..reference import Group
from ..stage import candela, material, quad
from .glass import PANE
from .registry import case

HALF = 200.0
"""Half side of panes that stand for endless ones. [m]"""

SUN_NORMAL = 1e4
"""Illuminance by the sun of a plane that faces it. [lx]"""

DISK = np.radians(0.53)
"""Angular diameter of suns that are disks. [rad]"""

GLASS = material("glass", PANE)


def _pane(key: str, height: float):
    return quad(
        key, (-HALF, -HALF, height), (2.0 * HALF, 0.0, 0.0), (0.0, 2.0 * HALF, 0.0), GLASS.id
    )


@case("C38", "Sun behind parallel panes", "glass", quick=("C38.two",))
def run_parallel(bench: Bench) -> Findings:
    """A sensor behind two and three panes, a sun at several angles."""
    groups = bench.groups("C38")
    for key, count in (("C38.two", 2), ("C38.three", 3)):
        if group := groups.get(key):
            yield _measure_suns(bench, group, count)


def _measure_suns(bench: Bench, group: Group, count: int) -> Finding:
    panes = [_pane(f"pane {i}", 1.0 + 0.5 * i) for i in range(count)]
    values, errors = np.zeros((2, len(group.values)))
    for place, label in enumerate(group.labels):
        tilt = np.radians(float(label.split()[0]))
        towards = np.array([np.sin(tilt), 0.0, -np.cos(tilt)])
        angle = DISK if label.endswith("disk") else 0.0
        output = Output(Quantity.ILLUMINANCE, SUN_NORMAL)
        items = [GLASS, *panes, SunLight("sun", "sun", output, towards, angle)]
        made = bench.measure(
            items, group.positions[place], group.normals[place], group.allowed[place]
        )
        values[place], errors[place] = made.values[0], made.errors[0]
        bench.show(group, items)
    return Finding(group, values, errors)


@case("C39", "Lamp before a pane", "glass", quick=("C39.one", "C39.between"))
def run_lamp(bench: Bench) -> Findings:
    """A lamp in front of one pane, and between two."""
    groups = bench.groups("C39")
    if group := groups.get("C39.one"):
        items = [GLASS, _pane("pane", 0.0), candela("lamp", (0.0, 0.0, 1.0), 1000.0)]
        yield bench.measure_group(items, group)
    if group := groups.get("C39.between"):
        lamp = candela("lamp", (0.0, 0.0, 0.4), 1000.0)
        yield bench.measure_group([GLASS, _pane("low", 0.0), _pane("high", 1.0), lamp], group)
