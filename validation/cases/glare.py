"""Unified glare rating of bright panels in a ceiling."""

import numpy as np

from lumenray.engine.analysis.glare import (
    FlatOpenings,
    Observer,
    guth_position_index,
    sight_angles,
    solid_angles,
    unified_glare_rating,
)

from ..bench import Bench, Finding, Findings
from ..stage import glowing, quad
from .registry import case

OBSERVER = Observer(np.array([0.0, 0.0, 1.2]), np.array([0.0, 1.0, 0.0]))
"""Seated, looking along +y. [m]"""

BACKGROUND = 30.0
"""Background luminance. [cd/m2]"""

LUMINANCE = 5000.0
"""Of the panels. [cd/m2]"""

PANEL = 0.6
"""Side of a panel. [m]"""

CEILINGS = {
    "one": [(0.0, 4.0, 3.0)],
    "one_off": [(1.5, 4.0, 3.0)],
    "four": [(-1.5, 2.5, 3.0), (1.5, 2.5, 3.0), (-1.5, 5.0, 3.0), (1.5, 5.0, 3.0)],
}
"""Centres of the panels by the name of the arrangement. [m]"""


@case("C36", "Unified glare rating", "glare", quick=("C36.ugr",))
def run_glare(bench: Bench) -> Findings:
    """Panels before a seated observer."""
    for group in bench.groups("C36").values():
        # Only our engine rates glare; other instruments say so here.
        _ = bench.engine
        known = {}
        for name, centres in CEILINGS.items():
            sizes, positions = _see(centres)
            rating = unified_glare_rating(
                BACKGROUND, np.full(len(centres), LUMINANCE), sizes, positions
            )
            known[f"{name} UGR"] = rating
            for centre, size, position in zip(centres, sizes, positions, strict=True):
                place = "({:g}, {:g}, {:g})".format(*centre)
                known[f"{place} omega [sr]"] = size
                known[f"{place} Guth p"] = position
        items = [glowing("panel", LUMINANCE)]
        for k, (x, y, z) in enumerate(CEILINGS["four"]):
            corner = (x - 0.5 * PANEL, y - 0.5 * PANEL, z)
            # Its sides are in the order that lets it face downwards.
            items.append(quad(f"{k}", corner, (0.0, PANEL, 0.0), (PANEL, 0.0, 0.0), "panel"))
        bench.show(group, items, OBSERVER.position, OBSERVER.direction)
        yield Finding(
            group, np.array([known[label] for label in group.labels]), np.zeros(len(group.values))
        )


def _see(centres) -> tuple[np.ndarray, np.ndarray]:
    """Solid angles [sr] and position indices of panels that face downwards."""
    normals = np.tile([0.0, 0.0, -1.0], (len(centres), 1))
    openings = FlatOpenings(np.array(centres), normals, np.full(len(centres), PANEL**2))
    turns, eccentricities = sight_angles(OBSERVER, openings.centres)
    return solid_angles(OBSERVER, openings), guth_position_index(turns, eccentricities)
