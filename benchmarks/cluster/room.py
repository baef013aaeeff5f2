"""The room in which the jobs of the benchmark take place."""

import numpy as np

from ...engine.scene.light import AreaLight, Output, Quantity
from ...engine.scene.material import Diffuse, Material
from ...engine.scene.spectrum import Constant
from ..common.pieces import SIDES, box, make_mesh, rigid_frame, side_of_box

SIDE, HEIGHT = 8, 0.8
"""Sensors along a side of the room, and their height. [m]"""

SIZE = (6.0, 4.0, 3.0)
"""Of the room. [m]"""


def build_room(open_side: str = "") -> tuple:
    """Items of a room with a block in it and a lamp below its ceiling. ``open_side``: of `SIDES`, the wall it lacks."""
    low = (0.0, 0.0, 0.0)
    walls = [box(low, SIZE, inwards=True)]
    if open_side:
        walls = [side_of_box(low, SIZE, side) for side in SIDES if side != open_side]
    room = make_mesh("room", walls, "paint")
    block = make_mesh("block", [box((2.0, 1.5, 0.01), (3.0, 2.5, 0.7))], "wood")
    frame = rigid_frame((3.0, 2.0, 2.9), (0, 0, -1))
    flux = Output(Quantity.LUMINOUS_FLUX, 4000.0)
    lamp = AreaLight("lamp", "lamp", flux, frame, 1.2, 0.6)
    paints = [
        Material(name, name, Diffuse(Constant(value)))
        for name, value in (("paint", 0.6), ("wood", 0.3))
    ]
    return (*paints, room, block, lamp)


def place_sensors() -> tuple[np.ndarray, np.ndarray]:
    """Positions and normals. (n, 3), (n, 3) [m]"""
    along = (np.arange(SIDE) + 0.5) / SIDE
    x, y = np.meshgrid(SIZE[0] * along, SIZE[1] * along)
    positions = np.stack([x.ravel(), y.ravel(), np.full(x.size, HEIGHT)], axis=1)
    return positions, np.tile([0.0, 0.0, 1.0], (x.size, 1))
