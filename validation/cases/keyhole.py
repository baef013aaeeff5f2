"""C41: a sun that shines through a small hole into a closed box."""

import numpy as np

from lumenray.engine.scene.light import Output, Quantity, SunLight

from ..bench import Bench, Finding, Findings
from ..reference import Group
from ..stage import box, frame, matt, without
from .means import mean_by_bake, reseeded
from .registry import case

SUN_NORMAL = 1e5
"""Illuminance by the sun of a plane that faces it. [lx]"""

TOWARDS = np.array([0.2, 0.1, -1.0]) / np.linalg.norm([0.2, 0.1, -1.0])

SUN = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, SUN_NORMAL), TOWARDS, np.radians(0.53))

ENOUGH = 1 << 15
"""Samples per lumel at which the bakes end; there are less than a hundred lumels."""

PAINT = matt("paint", 0.5)


@case("C41", "Sun through a keyhole", "stability", quick=("C41.hole",))
def run_keyholes(bench: Bench) -> Findings:
    """Flux over all surfaces of a box of 1 m; labels tell the width of the hole."""
    for group in bench.groups("C41").values():
        yield _bake(bench, group)


def _bake(bench: Bench, group: Group) -> Finding:
    found = []
    for number, label in enumerate(group.labels):
        body, lid = _pierced_box(1e-3 * float(label.split()[0]))
        items, allowed = [PAINT, body, lid, SUN], group.allowed[number]
        # Over an area of 1 m2 the mean is the flux.
        found.append(
            mean_by_bake(reseeded(bench, number), items, (body, lid), allowed, 1.0, ENOUGH)
        )
    return Finding(group, *np.array(found).T)


def _pierced_box(width: float) -> tuple:
    """Box without its lid, and a lid with a square hole in its middle; all face inwards."""
    whole = box("body", (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), "paint", inwards=True)
    is_lid = (whole.vertices[whole.triangles][..., 2] == 1.0).all(axis=1)
    hole = (0.5 - 0.5 * width, 0.5 + 0.5 * width)
    lid = frame("lid", (0.0, 0.0, 1.0), (0.0, 1.0, 0.0), (1.0, 0.0, 0.0), hole, hole, "paint")
    return without(whole, is_lid), lid
