"""Desks with drawers, cable tray, shelf and sideboard."""

import math
from itertools import pairwise

import numpy as np

from ..assembly import Assembly
from ..shapes import blocks, box, curve, cylinder, rounded_box, tube
from . import room
from .chair import build_chair

DESK = (1.60, 0.80, 0.740)
"""Length, depth and height of a desk. [m]"""

TOP = 0.025
"""Thickness of a desk top. [m]"""

PLACES = {"A": ((2.39, 2.93), 90.0), "B": ((3.21, 2.93), -90.0)}
"""Centre of each desk [m] and the turn [degrees] that puts its user's side, +y, in place."""

SHELF = (0.90, 0.32, 1.96)
"""Width, depth and height of the shelf. [m]"""

SHELF_Y = 2.40
"""Middle of the shelf along the east wall. [m]"""

SHELF_LEVELS = (0.080, 0.450, 0.820, 1.190, 1.560)
"""Upper faces of the shelf's boards. [m]"""

SIDEBOARD = (0.74, 0.42, 0.76)
"""Width, depth and height of the sideboard. [m]"""

SIDEBOARD_Y = 3.25
"""Middle of the sideboard along the east wall. [m]"""


def on_desk(desk, x, y, z=0.0):
    """Return the world position of a point stated in a desk's own axes, in metres."""
    (cx, cy), turn = PLACES[desk]
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    return (cx + c * x - s * y, cy + s * x + c * y, DESK[2] + room.REST + z)


def against_east(depth, y):
    """Return the place of a piece with its back to the east wall, in metres."""
    return (room.WIDTH - 0.016 - depth / 2, y, 0.0)


def _handle(width):
    """Return a bow handle along x that stands off along +y."""
    half = width / 2
    path = [(-half, 0, 0), (-half, 0.022, 0), (-half + 0.012, 0.028, 0)]
    path += [(half - 0.012, 0.028, 0), (half, 0.022, 0), (half, 0, 0)]
    return tube(np.array(path), 0.0045, 12)


def _desk(name, palette, collection, bake):
    length, depth, height = DESK
    (x, y), turn = PLACES[name]
    top = box((length, depth, TOP), (0.0, 0.0, height - TOP / 2))
    Assembly().add(palette["Wood"], top).build(f"Desk Top {name}", bake, (x, y, 0.0), turn)

    steel, under = palette["White Steel"], height - TOP - room.REST
    frame = Assembly()
    for side in (-1.0, 1.0):
        at = side * (length / 2 - 0.06)
        frame.add(steel, rounded_box((0.05, depth - 0.10, 0.03), 0.006, (at, 0.0, under - 0.015)))
        for edge in (-1.0, 1.0):
            leg = rounded_box((0.045, 0.045, under - 0.030 - 0.012), 0.006)
            leg = leg.moved(at, edge * (depth / 2 - 0.08), 0.012 + (under - 0.042) / 2)
            frame.add(steel, leg)
            foot = cylinder(0.016, 0.012, 20, 0.002).moved(z=room.REST)
            frame.add(palette["Rubber"], foot.moved(at, edge * (depth / 2 - 0.08)))
    for edge in (-1.0, 1.0):
        rail = rounded_box((length - 0.17, 0.03, 0.03), 0.005)
        frame.add(steel, rail.moved(0.0, edge * (depth / 2 - 0.08), under - 0.016))
    frame.build(f"Desk Frame {name}", collection, (x, y, 0.0), turn)
    _drawers(name, palette, collection)


def _drawers(name, palette, collection):
    """Build the roller cabinet under a desk, at the end away from the window."""
    width, depth, low, high = 0.42, 0.58, 0.055, 0.60
    side = -1.0 if name == "A" else 1.0
    cabinet = Assembly()
    body = rounded_box((width, depth, high - low), 0.004, (0.0, 0.0, (low + high) / 2))
    cabinet.add(palette["White Lacquer"], body)
    levels = (low + 0.004, low + 0.25, low + 0.40, high - 0.004)
    for bottom, top in pairwise(levels):
        front = rounded_box((width - 0.006, 0.018, top - bottom - 0.004), 0.003)
        middle = (bottom + top) / 2
        cabinet.add(palette["White Lacquer"], front.moved(0.0, depth / 2 + 0.0095, middle))
        bow = _handle(0.14).moved(0.0, depth / 2 + 0.018, top - 0.045)
        cabinet.add(palette["Brushed Steel"], bow)
    lock = cylinder(0.008, 0.004, 20, 0.001).turned("x", -90.0)
    cabinet.add(palette["Chrome"], lock.moved(width / 2 - 0.04, depth / 2 + 0.018, high - 0.035))
    for x in (-0.16, 0.16):
        for y in (-0.22, 0.22):
            wheel = cylinder(0.024, 0.020, 24, 0.003).turned("y", 90.0)
            cabinet.add(palette["Rubber"], wheel.moved(x - 0.01, y, 0.024 + room.REST))
            cabinet.add(palette["Black Plastic"], box((0.03, 0.03, 0.012), (x, y, 0.0488)))
    at = on_desk(name, side * 0.485, 0.08)
    cabinet.build(f"Drawers {name}", collection, (*at[:2], 0.0), PLACES[name][1])


def _cable_tray(palette, collection):
    """Build a perforated channel under the joint of the two desks, with the cables in it."""
    ys = np.linspace(-0.62, 0.62, 50)
    floor = blocks(
        (-0.06, -0.03, 0.0, 0.03, 0.06),
        ys,
        (0.0, 0.0015),
        lambda i, j, _: i in (0, 3) or j % 2 == 0,
    )
    # The brackets end right under the rails of the two desks.
    level = DESK[2] - TOP - 0.1055
    tray = Assembly().add(palette["White Steel"], floor)
    for x in (-0.0607, 0.0607):
        tray.add(palette["White Steel"], box((0.0012, 1.24, 0.07), (x, 0.0, 0.035)))
    for y in (-0.5, 0.5):
        tray.add(palette["White Steel"], box((0.30, 0.02, 0.003), (0.0, y, 0.0722)))
    rng = np.random.default_rng(47)
    for k in range(4):
        points = [(-0.035 + 0.022 * k, y, 0.010) for y in np.linspace(-0.57, 0.57, 7)]
        points = np.array(points) + rng.uniform(-0.005, 0.005, (7, 3)) * (1, 1, 0)
        tray.add(palette["Rubber"], tube(curve(points, 4), 0.0035, 8))
    drop = [(0.0, 0.58, 0.006), (0.0, 0.645, 0.03), (0.0, 0.665, -0.12), (0.0, 0.65, -0.40)]
    floor = 0.0045 - level
    drop += [(0.0, 0.665, floor + 0.03), (0.01, 0.70, floor + 0.006), (0.03, 0.80, floor)]
    drop += [(0.05, 1.00, floor), (0.06, 1.25, floor)]
    tray.add(palette["Rubber"], tube(curve(drop, 6), 0.004, 8))
    at = (2.80, PLACES["A"][0][1], level)
    tray.build("Cable Tray", collection, at)


def _shelf(palette, collection):
    width, depth, height = SHELF
    side, thick = 0.020, 0.022
    xs = (-width / 2, -width / 2 + side, width / 2 - side, width / 2)
    ys = (-depth / 2, -depth / 2 + 0.006, depth / 2)
    zs = [room.REST, SHELF_LEVELS[0] - thick]
    for level in SHELF_LEVELS[1:]:
        zs += [zs[-1] + thick, level - thick]
    zs += [zs[-1] + thick, height - thick, height]
    boards = blocks(xs, ys, zs, lambda i, j, k: i != 1 or k % 2 == 1 or (j == 0 and k > 0))
    item = Assembly().add(palette["Wood"], boards)
    plinth = box((width - 2 * side - 0.001, 0.016, SHELF_LEVELS[0] - thick - 0.001))
    item.add(palette["Wood"], plinth.moved(0.0, depth / 2 - 0.03, plinth_height() + room.REST))
    item.build("Shelf", collection, against_east(depth, SHELF_Y), 90.0)


def plinth_height():
    """Return the middle of the shelf's plinth above the floor, in metres."""
    return (SHELF_LEVELS[0] - 0.022) / 2


def _sideboard(palette, collection):
    width, depth, height = SIDEBOARD
    body = box((width, depth - 0.02, height - 0.12), (0.0, -0.01, (height - 0.022 + 0.098) / 2))
    item = Assembly().add(palette["White Lacquer"], body)
    top = rounded_box((width + 0.02, depth + 0.004, 0.022), 0.003)
    item.add(palette["Wood"], top.moved(0.0, 0.002, height - 0.0107))
    for side in (-1.0, 1.0):
        door = rounded_box((width / 2 - 0.004, 0.018, height - 0.13), 0.003)
        item.add(
            palette["White Lacquer"],
            door.moved(side * width / 4, depth / 2 - 0.0105, height / 2 + 0.038),
        )
        bow = _handle(0.16).turned("y", 90.0)
        item.add(
            palette["Brushed Steel"], bow.moved(side * 0.035, depth / 2 - 0.0015, height / 2 + 0.15)
        )
        for edge in (-1.0, 1.0):
            leg = tube([(0, 0, 0.1), (0, 0, room.REST)], (0.018, 0.012), 16)
            item.add(palette["Wood"], leg.moved(side * (width / 2 - 0.06), edge * 0.14))
    item.build("Sideboard", collection, against_east(depth, SIDEBOARD_Y), 90.0)


def build_furniture(palette, furniture, bake):
    """Build the furniture; the desk tops go to ``bake``."""
    for name in PLACES:
        _desk(name, palette, furniture, bake)
    _cable_tray(palette, furniture)
    _shelf(palette, furniture)
    _sideboard(palette, furniture)
    build_chair("Chair A", palette, furniture, (1.54, 2.84), -72.0)
    build_chair("Chair B", palette, furniture, (4.12, 2.90), 104.0)
