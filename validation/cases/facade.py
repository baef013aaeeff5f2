"""C14 to C17: light of sky and ground through an opening in the facade, without and with glass and obstructions."""

import numpy as np

from lumenray.engine.scene.material import Material
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.sky.cie import sun_direction

from .. import stage
from ..bench import Bench, Findings
from .registry import case
from .rooms import (
    FACES,
    HORIZONTAL,
    OPEN,
    SUN_ELEVATION,
    UNIFORM,
    glass,
    measure_under_skies,
    room,
    sky,
    with_prefix,
)

HOLES = {"2x1": ((1.0, 3.0), (1.0, 2.0)), "4x3": ((0.0, 4.0), (0.0, 3.0))}
"""Openings in the wall y = 0 by their sizes. [m]"""

TOWARDS_SUN = sun_direction(SUN_ELEVATION, np.pi)
"""The sun stands before the opening."""

GROUND = 0.3
"""Reflectance of the ground in C14 and C15, and of the lit ground and mask of C17. [-]"""

OVERHANGS = {"mask0.5": 0.5, "mask1": 1.0, "mask2": 2.0}
"""Depths of the horizontal masks. [m]"""

OPPOSITES = {"mask3": 3.0, "mask6": 6.0, "mask9": 9.0}
"""Heights of the vertical masks. [m]"""

MASK_DISTANCE = 6.0
"""Of the vertical masks from the facade. [m]"""

REACH = 500.0
"""Half the length of the masks, which are infinite in x. [m]"""

STREET_REACH = 1000.0
"""The same where light is reflected between mask and ground. [m]"""


@case(
    "C14",
    "Sky and ground through an unglazed facade opening",
    "daylight",
    quick=("C14.2x1.wall.sky5", "C14.2x1.ceiling"),
)
def unglazed(bench: Bench) -> Findings:
    """Wall, floor and ceiling under all skies."""
    yield from _facade(bench, "C14", OPEN)


@case("C15", "Sky and ground through a glazed facade opening", "daylight")
def glazed(bench: Bench) -> Findings:
    """As C14 with the pane of C07."""
    yield from _facade(bench, "C15", glass("pane"))


@case("C16", "Horizontal mask", "daylight", quick=("C16.mask1.sky5",))
def overhang(bench: Bench) -> Findings:
    """Black masks under all skies, then masks that glow."""

    def mask(depth: float, paint: str) -> Mesh:
        # Faces down.
        edges = (0.0, depth, 0.0), (2.0 * REACH, 0.0, 0.0)
        return stage.quad("mask", (-REACH, -depth, 3.0), *edges, paint)

    yield from _masks(bench, "C16", OVERHANGS, mask)


@case("C17", "Vertical mask", "daylight")
def opposite(bench: Bench) -> Findings:
    """Black masks under all skies, masks that glow, and masks that light from the ground meets."""

    def mask(height: float, paint: str) -> Mesh:
        return _opposite(height, REACH, paint)

    yield from _masks(bench, "C17", OPPOSITES, mask)
    groups = bench.groups("C17")
    for name, height in OPPOSITES.items():
        number = name.removeprefix("mask")
        # Percent of the horizontal illuminance on the floor, parts of it on ground and mask.
        factors = {f"C17.phys{number}": 100.0, f"C17.physE{number}": 1.0}
        street = _street(height)
        for key, factor in factors.items():
            if key in groups:
                yield bench.measure_group(street, groups[key], factor / HORIZONTAL)


def _facade(bench: Bench, key: str, pane: Material) -> Findings:
    groups = bench.groups(key)
    for size, hole in HOLES.items():
        chosen = with_prefix(groups, f"{key}.{size}.")
        yield from measure_under_skies(
            bench, room("front", hole, pane), chosen, TOWARDS_SUN, GROUND
        )


def _masks(bench: Bench, key: str, sizes: dict[str, float], mask) -> Findings:
    """Groups of black and of glowing masks. ``mask``: from size and material to the mesh."""
    groups = bench.groups(key)
    hall = room("front", HOLES["2x1"], OPEN)
    for name, size in sizes.items():
        chosen = with_prefix(groups, f"{key}.{name}.sky")
        yield from measure_under_skies(bench, (*hall, mask(size, "black")), chosen, TOWARDS_SUN)
    # A mask of this luminance gives its configuration factor in percent.
    paint = stage.glowing("glowing", 100.0 / np.pi)
    for name, size in sizes.items():
        group = groups.get(f"{key}.{name}.Fm")
        if group is not None:
            yield bench.measure_group((*hall, paint, mask(size, paint.id)), group)


def _opposite(height: float, reach: float, paint: str) -> Mesh:
    """Vertical mask that faces the building."""
    edges = (0.0, 0.0, height), (2.0 * reach, 0.0, 0.0)
    return stage.quad("mask", (-reach, -MASK_DISTANCE, 0.0), *edges, paint)


def _street(height: float) -> tuple:
    """Mask and ground that reflect, before a black building with the room in it, under a uniform sky."""
    across = (2.0 * STREET_REACH, 0.0, 0.0)
    corner = np.array((-STREET_REACH, 0.0, 0.0))
    hole = HOLES["2x1"]
    ground = corner - (0.0, MASK_DISTANCE, 0.0)
    shares = (np.array(hole[0]) + STREET_REACH) / across[0], np.array(hole[1]) / 3.0
    return (
        stage.BLACK,
        OPEN,
        stage.matt("stone", GROUND),
        _opposite(height, STREET_REACH, "stone"),
        stage.quad("ground", ground, across, (0.0, MASK_DISTANCE, 0.0), "stone"),
        stage.frame("front", corner, across, (0.0, 0.0, 3.0), *shares, "black"),
        stage.quad("opening", (1.0, 0.0, 1.0), (2.0, 0.0, 0.0), (0.0, 0.0, 1.0), "open"),
        # The roof is the room's ceiling too.
        stage.quad("roof", (*corner[:2], 3.0), across, (0.0, STREET_REACH, 0.0), "black"),
        *(stage.quad(key, *FACES[key], "black") for key in ("floor", "back", "left", "right")),
        sky(UNIFORM, TOWARDS_SUN),
    )
