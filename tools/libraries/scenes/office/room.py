"""Measures of the room that its parts agree on. All in metres, origin in the south-west corner."""

WIDTH, DEPTH, HEIGHT = 5.4, 4.2, 2.8
"""Clear size along x, along y and up to the suspended ceiling. [m]"""

LINING = 0.005
"""Space between the finished surfaces and the masonry behind them. [m]"""

WALL, OUTER_WALL = 0.20, 0.30
"""Thickness of the inner walls and of the wall with the window. [m]"""

PLENUM = 0.35
"""Height between suspended ceiling and slab. [m]"""

WINDOW_X = (1.2, 4.5)
"""Window opening in the north wall. [m]"""

WINDOW_Z = (0.90, 2.40)
"""Top of the sill and head of the window. [m]"""

WINDOW_FRAME_Y = 4.36
"""Inner face of the window frame. [m]"""

DOOR_Y, DOOR_Z, DOOR_RECESS = (0.30, 1.22), 2.06, 0.12
"""Door opening in the east wall: along y, its head, and its depth into the wall. [m]"""

MODULE = 0.6
"""Grid of the suspended ceiling. [m]"""

FLANGE = 0.024
"""Visible width of the grid's bars. [m]"""

PANEL_CELLS = ((2, 1), (6, 1), (2, 5), (6, 5))
"""Grid cells (along x, along y) that hold a LED panel instead of a tile."""

SKIRTING = 0.08
"""Height of the skirting boards. [m]"""

REST = 0.0003
"""Gap under things that stand on something, so that no faces coincide. [m]"""


def panel_centers():
    """Return the (x, y) centres of the LED panels, in metres."""
    return [((i + 0.5) * MODULE, (j + 0.5) * MODULE) for i, j in PANEL_CELLS]
