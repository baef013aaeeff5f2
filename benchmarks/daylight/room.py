"""The room whose year is computed, with one window and an overhang, for our engine and as Radiance's text."""

from dataclasses import dataclass

import numpy as np

from ...engine.scene.material import ThinGlass
from ...engine.scene.spectrum import Constant
from ...validation import stage
from ...validation.peers.contents import sort_items
from ...validation.peers.radiance_scene import write_scene

WIDTH, DEPTH, HEIGHT = 5.0, 8.0, 2.9
"""Inside, along x, y and z; the window is in the wall y = 0, which looks south. [m]"""

WINDOW = ((0.8, 4.2), (0.9, 2.4))
"""Ranges of x and z. [m]"""

OVERHANG_DEPTH, OVERHANG_HEIGHT, OVERHANG_ENDS = 0.8, 2.6, (0.3, 4.7)
"""How far it stands out, how high, and its range of x. [m]"""

GROUND_HEIGHT, GROUND_REACH = -0.5, 100.0
"""Of the ground outside, and how far it goes. [m]"""

REFLECTANCES = {"floor": 0.2, "wall": 0.5, "ceiling": 0.7, "outside": 0.4, "ground": 0.2}

INDEX, INTERNAL = 1.52, 0.95841544
"""Refractive index of the pane, and what its body lets through: 0.88 of the light that meets it straight, faces included."""

COLUMNS, ROWS = 10, 20
"""Sensors along x and y."""

WORK_HEIGHT = 0.8
"""Of the sensors, which look up. [m]"""


@dataclass(frozen=True, eq=False)
class Room:
    """A scene without its sky, and where it is measured.

    Parameters
    ----------
    items : tuple    Materials and meshes; +y is north.
    positions, normals : (n, 3) array    [m]
    """

    items: tuple
    positions: np.ndarray
    normals: np.ndarray


def make_room(columns: int = COLUMNS, rows: int = ROWS) -> Room:
    """Return the room with so many sensors along x and y."""
    x = (np.arange(columns) + 0.5) * WIDTH / columns
    y = (np.arange(rows) + 0.5) * DEPTH / rows
    places = np.stack(np.broadcast_arrays(x, y[:, None], WORK_HEIGHT), axis=-1).reshape(-1, 3)
    normals = np.zeros_like(places)
    normals[:, 2] = 1.0
    return Room(_items(), places, normals)


def _items() -> tuple:
    along, back, up = (WIDTH, 0.0, 0.0), (0.0, DEPTH, 0.0), (0.0, 0.0, HEIGHT)
    (x0, x1), (z0, z1) = WINDOW
    shares = np.array(WINDOW[0]) / WIDTH, np.array(WINDOW[1]) / HEIGHT
    left, right = OVERHANG_ENDS
    reach = GROUND_REACH
    return (
        *(stage.matt(key, value) for key, value in REFLECTANCES.items()),
        stage.material("glass", ThinGlass(INDEX, Constant(INTERNAL))),
        stage.quad("floor face", (0.0, 0.0, 0.0), along, back, "floor"),
        stage.quad("ceiling face", (0.0, 0.0, HEIGHT), back, along, "ceiling"),
        stage.quad("west face", (0.0, 0.0, 0.0), back, up, "wall"),
        stage.quad("east face", (WIDTH, 0.0, 0.0), up, back, "wall"),
        stage.quad("north face", (0.0, DEPTH, 0.0), along, up, "wall"),
        stage.frame("south face", (0.0, 0.0, 0.0), along, up, *shares, "wall"),
        stage.quad("pane", (x0, 0.0, z0), (x1 - x0, 0.0, 0.0), (0.0, 0.0, z1 - z0), "glass"),
        stage.quad(
            "overhang",
            (left, -OVERHANG_DEPTH, OVERHANG_HEIGHT),
            (right - left, 0.0, 0.0),
            (0.0, OVERHANG_DEPTH, 0.0),
            "outside",
        ),
        stage.quad(
            "ground face",
            (-reach, -reach, GROUND_HEIGHT),
            (2.0 * reach, 0.0, 0.0),
            (0.0, 2.0 * reach, 0.0),
            "ground",
        ),
    )


def radiance_text(room: Room) -> str:
    """Return the scene without its sky in Radiance's language, as the validation suite translates scenes. [m]"""
    made = write_scene(sort_items(room.items), room.positions, np.zeros(3), 1.0, False, False)
    return "\n".join(made.text)
