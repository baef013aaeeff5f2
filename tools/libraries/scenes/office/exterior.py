"""What is seen through the window: street, trees, and the house opposite."""

import math

import numpy as np

from ..assembly import Assembly
from ..shapes import blocks, box, quad, sphere, tube

GROUND = -3.7
"""Level of the street; the office is on the first floor. [m]"""


def _street(palette, collection):
    wide = 160.0
    ground = quad((-80.0, 5.0, GROUND), (wide, 0, 0), (0, 120.0, 0))
    Assembly().add(palette["Grass"], ground).build("Ground", collection)
    road = box((wide, 7.0, 0.06), (0.0, 15.0, GROUND + 0.035))
    walks = [box((wide, 2.2, 0.16), (0.0, y, GROUND + 0.085)) for y in (10.3, 19.7)]
    street = Assembly().add(palette["Asphalt"], road).add(palette["Concrete"], *walks)
    street.build("Street", collection)


def _house(palette, collection):
    """Brick front with five by three windows, roughly 25 m wide."""
    bay, axes, floors = 3.2, 9, 2
    xs, zs = [0.0], [0.0]
    for k in range(axes):
        xs += [k * bay + 0.8, k * bay + 2.4]
    xs.append(axes * bay)
    for k in range(floors):
        zs += [k * 3.2 + 0.9, k * 3.2 + 2.6]
    zs.append(floors * 3.2 + 0.6)
    front = blocks(xs, (0.0, 0.18, 9.0), zs, lambda i, j, k: j == 1 or i % 2 == 0 or k % 2 == 0)
    glass, frames = [], []
    for i in range(axes):
        for k in range(floors):
            x, z = xs[2 * i + 1], zs[2 * k + 1]
            glass.append(quad((x, 0.15, z), (1.6, 0, 0), (0, 0, 1.7)))
            us, vs = (0.0, 0.07, 0.765, 0.835, 1.53, 1.6), (0.0, 0.07, 1.63, 1.7)
            cells = blocks(us, (0.10, 0.16), vs, lambda i, _, k: i % 2 == 0 or k != 1)
            frames.append(cells.moved(x, 0.0, z))
    eaves = box((xs[-1] + 0.4, 9.4, 0.22), (xs[-1] / 2, 4.5, zs[-1] + 0.1105))
    house = Assembly().add(palette["Brick"], front).add(palette["Facade Glass"], *glass)
    house.add(palette["White Lacquer"], *frames).add(palette["Concrete"], eaves)
    house.build("House Opposite", collection, (-8.0, 24.0, GROUND + 0.003))


def _tree(palette, collection, name, location, rng):
    trunk = tube(
        [(0, 0, 0), (0, 0, 0.2), (0.05, 0.0, 1.2), (0.0, 0.04, 2.6)], (0.15, 0.14, 0.10, 0.07), 12
    )
    tree = Assembly().add(palette["Stem"], trunk)
    for _ in range(15):
        angle, reach = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(0.2, 1.15)
        size = rng.uniform(0.35, 0.65)
        ripple = rng.uniform(0.0, 6.0, 3)

        def crumple(points, size=size, ripple=ripple):
            wave = np.sin(points * 6.0 / size + ripple).sum(axis=1, keepdims=True)
            return points * (1.0 + 0.08 * wave)

        crown = sphere(size, 16, 10).warped(crumple)
        at = (reach * math.cos(angle), reach * math.sin(angle), rng.uniform(2.3, 4.2))
        tree.add(palette["Foliage"], crown.moved(*at))
    tree.build(name, collection, location)


def build_exterior(palette, collection):
    """Build the surroundings that the window shows."""
    rng = np.random.default_rng(31)
    _street(palette, collection)
    _house(palette, collection)
    for index, x in enumerate((1.5, 7.5, 14.5)):
        at = (x, 19.4 + 0.2 * index, GROUND + 0.17)
        _tree(palette, collection, f"Tree {index + 1}", at, rng)
