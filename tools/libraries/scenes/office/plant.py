"""Pot plants with single leaves."""

import math

import numpy as np

from ..assembly import Assembly
from ..shapes import Part, curve, lathe, tube
from . import room


def leaf(length, width, droop, fold=0.25):
    """Return one pointed leaf that grows from the origin along +y and droops, in metres."""
    rows, columns = 9, 3
    points, faces = [], []
    for i in range(rows + 1):
        t = i / rows
        half = width / 2 * math.sin(math.pi * (0.03 + 0.96 * t) ** 0.75)
        angle = droop * t
        y = length * (math.sin(angle) / droop) if droop else length * t
        z = -length * (1.0 - math.cos(angle)) / droop if droop else 0.0
        for k in range(-columns, columns + 1):
            u = k / columns
            lift = fold * half * abs(u) + 0.02 * half * math.sin(9.0 * t + 3.0 * u)
            points.append((u * half, y, z + lift))
    wide = 2 * columns + 1
    for i in range(rows):
        for k in range(wide - 1):
            a = i * wide + k
            faces.append((a, a + 1, a + wide + 1, a + wide))
    return Part(np.array(points), faces)


def _place(part, direction, pitch, at):
    return part.turned("x", pitch).turned("z", direction).moved(*at)


def _pot(radius, height):
    r, wall = radius, 0.008
    outer = [(0.0, 0.0), (0.72 * r, 0.0), (0.74 * r, 0.004), (0.93 * r, 0.80 * height)]
    outer += [(1.0 * r, 0.81 * height), (1.02 * r, height - 0.004), (1.01 * r, height)]
    inner = [(r - wall, height), (0.80 * r, 0.2 * height), (0.70 * r, 0.015), (0.0, 0.015)]
    return lathe(outer + inner, 48)


def _soil(radius, height):
    r = 0.90 * radius - 0.004
    rim = [(r - 0.004, 0.72 * height), (r, 0.81 * height), (0.7 * r, 0.835 * height)]
    return lathe([(0.0, 0.72 * height), *rim, (0.0, 0.85 * height)], 40)


def _is_clear(part):
    """Return whether a leaf of the floor plant keeps off the walls and the sideboard."""
    x, y, z = part.points.T
    beside = (y < -0.18) & (z < 0.82)
    return x.max() < 0.40 and y.max() < 0.34 and not beside.any()


def build_floor_plant(palette, collection):
    """Build a rubber plant of a man's height in the corner beside the window."""
    rng = np.random.default_rng(83)
    radius, height = 0.19, 0.34
    plant = Assembly().add(palette["Terracotta"], _pot(radius, height))
    plant.add(palette["Soil"], _soil(radius, height))
    for stem in range(4):
        heading = 2.0 * math.pi * (stem + rng.uniform(-0.2, 0.2)) / 4
        tall = rng.uniform(0.95, 1.40)
        out = np.array([math.cos(heading), math.sin(heading), 0.0])
        foot = 0.05 * out + np.array([0.0, 0.0, 0.27])
        knees = [foot + out * 0.16 * t**1.5 + np.array([0, 0, tall * t]) for t in (0, 0.3, 0.65, 1)]
        path = curve(knees, 6)
        plant.add(palette["Stem"], tube(path, np.linspace(0.011, 0.005, len(path)), 10))
        count = 17
        for k in range(count):
            t = 0.22 + 0.78 * k / (count - 1)
            at = path[min(int(t * (len(path) - 1)), len(path) - 1)]
            direction = math.degrees(heading) + 137.5 * k + rng.uniform(-15.0, 15.0)
            size = rng.uniform(0.15, 0.22) * (1.0 - 0.25 * t)
            blade = leaf(size, 0.46 * size, rng.uniform(0.5, 1.1))
            pitch = 20.0 + 35.0 * t + rng.uniform(-10.0, 10.0)
            stalk = tube([(0, 0, 0), (0, 0.02, 0), (0, 0.045, 0)], 0.0022, 6)
            placed = _place(blade.moved(y=0.04), direction, pitch, at)
            if _is_clear(placed):
                plant.add(palette["Stem"], _place(stalk, direction, pitch, at))
                plant.add(palette["Leaf"], placed)
    at = (room.WIDTH - 0.42, room.DEPTH - 0.37, room.REST)
    plant.build("Rubber Plant", collection, at)


def build_sill_plant(palette, collection):
    """Build a small leafy pot plant for the window sill."""
    rng = np.random.default_rng(97)
    plant = Assembly().add(palette["Porcelain"], _pot(0.06, 0.10))
    plant.add(palette["Soil"], _soil(0.06, 0.10))
    for k in range(22):
        direction = 137.5 * k
        out = rng.uniform(0.0, 0.02)
        c, s = math.cos(math.radians(direction + 90.0)), math.sin(math.radians(direction + 90.0))
        blade = leaf(rng.uniform(0.09, 0.15), 0.028, rng.uniform(0.6, 1.5))
        at = (out * c, out * s, 0.075)
        plant.add(palette["Leaf"], _place(blade, direction, rng.uniform(50.0, 80.0), at))
    at = (1.62, room.DEPTH + 0.035, room.WINDOW_Z[0] + room.REST)
    plant.build("Sill Plant", collection, at)
