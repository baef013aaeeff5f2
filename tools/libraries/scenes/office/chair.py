"""A swivel chair: cushions, gas lift, star base on castors."""

import math

import numpy as np

from ..assembly import Assembly
from ..shapes import curve, cylinder, lathe, rounded_box, tube
from .room import REST


def _seat():
    def shape(points):
        x, y = points[:, 0], points[:, 1]
        points[:, 2] -= 0.9 * np.maximum(0.0, y - 0.10) ** 2
        points[:, 2] += 0.25 * x**2
        points[:, 0] *= 1.0 - 0.12 * np.maximum(0.0, -y / 0.24)
        return points

    cushion = rounded_box((0.50, 0.48, 0.075), 0.034, segments=3, divisions=7)
    return cushion.warped(shape).moved(z=0.475)


def _back():
    def shape(points):
        x, z = points[:, 0], points[:, 2]
        points[:, 1] += 0.55 * x**2 + 0.022 * np.cos((z + 0.12) * 7.0)
        points[:, 1] -= 0.14 * z
        points[:, 0] *= 1.0 - 0.14 * ((z + 0.1) / 0.29) ** 2
        return points

    cushion = rounded_box((0.47, 0.055, 0.58), 0.026, segments=3, divisions=7)
    return cushion.warped(shape).moved(y=-0.275, z=0.86)


def _castor():
    """Return the tyres, and the fork with its stem, of one twin-wheel castor at the origin."""
    r, half = 0.028, 0.009
    rim = [(r - 0.004, -half), (r, -half + 0.004), (r, half - 0.004), (r - 0.004, half)]
    wheel = lathe([(0.0, -half), *rim, (0.0, half)], 24).turned("y", 90.0)
    tyres = [wheel.moved(x, 0.0, r + REST) for x in (-0.0135, 0.0135)]
    hood = rounded_box((0.006, 0.045, 0.03), 0.0025).moved(z=r + 0.012)
    stem = cylinder(0.006, 0.04, 12).moved(y=0.008, z=r + 0.02)
    return tyres, [hood, stem]


def _base(chair, palette):
    chair.add(palette["Black Plastic"], cylinder(0.048, 0.075, 40, 0.008).moved(z=0.075))
    for k in range(5):
        angle = 72.0 * k + 18.0
        spoke = curve([(0.03, 0, 0.118), (0.12, 0, 0.113), (0.22, 0, 0.100), (0.315, 0, 0.084)], 4)
        bar = tube(spoke, np.linspace(0.026, 0.014, len(spoke)), 14)
        chair.add(palette["Black Plastic"], bar.turned("z", angle))
        tyres, fork = _castor()
        # Castors trail in the directions in which the chair was last pushed.
        swivel = 40.0 + 63.0 * k
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        for material, parts in (("Rubber", tyres), ("Grey Plastic", fork)):
            for part in parts:
                turned = part.moved(y=-0.008).turned("z", swivel)
                chair.add(palette[material], turned.moved(0.30 * c, 0.30 * s))
    chair.add(palette["Black Plastic"], cylinder(0.028, 0.14, 32, 0.003).moved(z=0.145))
    chair.add(palette["Chrome"], cylinder(0.0145, 0.14, 32).moved(z=0.28))


def _arms(chair, palette):
    for side in (-1.0, 1.0):
        path = [
            (side * 0.12, -0.02, 0.425),
            (side * 0.26, -0.02, 0.425),
            (side * 0.295, -0.02, 0.46),
            (side * 0.30, -0.02, 0.56),
            (side * 0.295, -0.01, 0.655),
        ]
        chair.add(palette["Black Plastic"], tube(curve(path, 6), 0.014, 16))
        pad = rounded_box((0.075, 0.25, 0.028), 0.0125, segments=3)
        chair.add(palette["Rubber"], pad.moved(side * 0.29, 0.02, 0.665))


def build_chair(name, palette, collection, location, turn):
    """Build a chair that looks along its own +y.

    Parameters
    ----------
    name : str
    palette : dict of str to bpy.types.Material
    collection : bpy.types.Collection
    location : (2,) sequence    Place on the floor. [m]
    turn : float    Rotation about z. [degrees]
    """
    chair = Assembly().add(palette["Seat Fabric"], _seat(), _back())
    tray = rounded_box((0.40, 0.38, 0.02), 0.009).moved(y=-0.01, z=0.432)
    works = rounded_box((0.13, 0.20, 0.05), 0.012, segments=3).moved(y=-0.02, z=0.405)
    chair.add(palette["Black Plastic"], tray, works)
    spine = [
        (0, -0.08, 0.405),
        (0, -0.24, 0.41),
        (0, -0.325, 0.47),
        (0, -0.325, 0.62),
        (0, -0.30, 0.80),
    ]
    for x in (-0.045, 0.045):
        path = curve(spine, 6) + np.array([x, 0.0, 0.0])
        chair.add(palette["Black Plastic"], tube(path, 0.015, 14))
    lever = tube(
        np.array([(0.06, 0.03, 0.40), (0.20, 0.03, 0.40), (0.25, 0.035, 0.395)]), 0.005, 10
    )
    chair.add(palette["Black Plastic"], lever)
    _base(chair, palette)
    _arms(chair, palette)
    return chair.build(name, collection, (*location, 0.0), turn)
