"""C46 to C48: cloudiness, all-weather skies and measured skies, on open sensors and behind the opening of C14."""

import numpy as np

from lumenray.engine.scene.light import CloudySky, PerezSky
from lumenray.engine.sky.measured import SkyGrid, make_grid_world, make_patch_world

from ..bench import Bench, Findings
from ..reference import Group
from ..sky_formulas import direction
from .facade import HOLES
from .registry import case
from .rooms import HORIZONTAL, OPEN, measure_together, room

GROUND = 0.3
"""Reflectance of the ground around. [-]"""


@case("C46", "Cloudiness", "daylight", quick=("C46.open.c0.25", "C46.room.c0.5"))
def cloudiness(bench: Bench) -> Findings:
    """Mixtures of the clear and the overcast sky."""
    yield from _under_skies(
        bench,
        "C46",
        lambda sky: CloudySky(sky["cloudiness"], _towards(sky), HORIZONTAL, GROUND),
    )


@case("C47", "All-weather skies", "daylight", quick=("C47.open.class3", "C47.room.class8"))
def all_weather(bench: Bench) -> Findings:
    """A sky of each class of the model of Perez."""
    yield from _under_skies(
        bench,
        "C47",
        lambda sky: PerezSky(
            sky["clearness"], sky["brightness"], _towards(sky), HORIZONTAL, GROUND
        ),
    )


@case("C48", "Measured skies", "daylight", quick=("C48.open.patches", "C48.room.table"))
def measured(bench: Bench) -> Findings:
    """Luminances of Tregenza's patches, and of a table."""
    yield from _under_skies(bench, "C48", _measured_world)


def _measured_world(sky: dict):
    if "elevations" not in sky:
        return make_patch_world(sky["luminances"], GROUND)
    grid = SkyGrid(*(np.array(sky[key]) for key in ("elevations", "azimuths", "luminances")))
    return make_grid_world(grid, GROUND)


def _towards(sky: dict) -> np.ndarray:
    return direction(sky["sun_elevation"], sky["sun_azimuth"])


def _under_skies(bench: Bench, key: str, make) -> Findings:
    """Measure the groups of a case, each under the sky that its tables state; ``make``: from these to the world."""
    groups = bench.groups(key)
    hall = room("front", HOLES["2x1"], OPEN)
    for group in groups.values():
        world = make(_sky_of(group))
        items = (world,) if ".open." in group.id else (*hall, world)
        yield from measure_together(bench, items, [group])


def _sky_of(group: Group) -> dict:
    return group.tables["sky"]
