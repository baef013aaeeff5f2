"""What stands on the desks: monitors, keyboards, mice, paper."""

import math

import numpy as np

from ..assembly import Assembly
from ..shapes import blocks, box, lathe, prism, quad, rounded_box, sphere, tube
from .furniture import PLACES, on_desk

SCREEN = (0.528, 0.298)
"""Luminous size of a monitor. [m]"""


def _screen_parts(rng):
    """Return the page-white and the desktop-dark faces of a screen, which share one plane.

    The faces form one partition of the screen, so that none of them coincide.
    """
    width, height = SCREEN
    xs = [0.0, 0.045, 0.060, 0.335, 0.350, 0.513, width]
    zs = [0.0, 0.020]
    lines = np.linspace(0.034, 0.266, 19)
    zs += [*lines.tolist(), 0.280, height]
    pages, dark = [], []
    for j in range(len(zs) - 1):
        text = 2 <= j < len(zs) - 3
        ends = sorted(rng.uniform(0.16, 0.32, 2)) if text and j % 2 == 0 else None
        row = list(xs)
        ink = None
        if ends is not None and j % 6 != 4:
            row = [*xs[:3], 0.082, float(ends[1]), *xs[3:]]
            ink = 3
        for i in range(len(row) - 1):
            cell = quad((-row[i], 0, zs[j]), (row[i] - row[i + 1], 0, 0), (0, 0, zs[j + 1] - zs[j]))
            page = 0.059 < row[i] < 0.512 and 1 <= j < len(zs) - 2
            gutter = abs(row[i] - 0.335) < 1e-6
            (pages if page and not gutter and i != ink else dark).append(cell)
    return [[p.moved(x=width / 2) for p in side] for side in (pages, dark)]


def _monitor(name, palette, collection, desk, rng):
    """Build a monitor whose screen faces the user, +y of the desk."""
    width, height = SCREEN
    border, chin, middle = 0.010, 0.020, 0.33
    outer = (width + 2 * border, height + border + chin)
    us = (-outer[0] / 2, -width / 2, width / 2, outer[0] / 2)
    vs = (-chin, 0.0, height, height + border)
    low = middle - height / 2
    item = Assembly()
    bezel = blocks(us, (0.0, 0.009), vs, lambda i, _, k: (i, k) != (1, 1))
    item.add(palette["Black Plastic"], bezel.moved(0.0, 0.0, low))
    back = rounded_box((outer[0], 0.024, outer[1]), 0.005)
    back = back.moved(0.0, -0.0125, low + (height + border - chin) / 2)
    hump = rounded_box((0.30, 0.030, 0.19), 0.012, segments=3).moved(0.0, -0.034, middle - 0.01)
    item.add(palette["Black Plastic"], back, hump)
    for material, parts in zip(("Screen Page", "Screen Desktop"), _screen_parts(rng), strict=True):
        item.add(palette[material], *[part.moved(0.0, 0.0035, low) for part in parts])
    neck = rounded_box((0.055, 0.022, 0.32), 0.008).moved(0.0, -0.058, 0.165)
    arm = rounded_box((0.075, 0.014, 0.075), 0.005).moved(0.0, -0.0485, middle - 0.01)
    foot = rounded_box((0.24, 0.19, 0.010), 0.0045, segments=3).moved(0.0, -0.035, 0.005)
    item.add(palette["Brushed Steel"], neck, arm, foot)
    at = on_desk(desk, 0.06, -0.185)
    item.build(name, collection, at, PLACES[desk][1] + (6.0 if desk == "A" else -4.0))


def _keyboard(name, palette, collection, desk):
    pitch, key = 0.019, 0.0165
    rows = [
        [1.0] * 15,
        [1.5] + [1.0] * 12 + [1.5],
        [1.75] + [1.0] * 11 + [2.25],
        [2.25] + [1.0] * 10 + [2.75],
        [1.25, 1.25, 1.25, 6.25, 1.25, 1.25, 1.25, 1.25],
    ]
    keys = []

    def taper(points):
        top = np.clip(points[:, 2] / 0.008, 0.0, 1.0)
        middle = points[:, :2].mean(axis=0)
        points[:, :2] = middle + (points[:, :2] - middle) * (1.0 - 0.14 * top[:, None] * 0.9)
        return points

    for r, row in enumerate(rows):
        x = -7.5 * pitch
        for units in row:
            span = units * pitch
            cap = rounded_box((span - (pitch - key), key, 0.009), 0.0018, segments=1)
            cap = cap.moved(z=0.0035).warped(taper)
            keys.append(cap.moved(x + span / 2, (2 - r) * pitch, 0.0150))
            x += span
    for column in range(3):
        for row in (2, 1, -1, -2):
            if row == -1 and column != 1:
                continue
            cap = rounded_box((key, key, 0.009), 0.0018, segments=1).moved(z=0.0035).warped(taper)
            keys.append(cap.moved((8.4 + column) * pitch, row * pitch, 0.0150))
    body = rounded_box((0.375, 0.118, 0.013), 0.005, segments=3).moved(0.029, 0.0, 0.0065)
    # The user sits at +y of the desk and so reads the keys the other way round.
    item = Assembly().add(palette["Black Plastic"], body.turned("z", 180.0))
    item.add(palette["Key Caps"], *[cap.turned("z", 180.0) for cap in keys])
    item.build(name, collection, on_desk(desk, 0.04, 0.16), PLACES[desk][1] - 2.0)


def _mouse(name, palette, collection, desk):
    def shape(points):
        y = points[:, 1]
        points[:, 2] = np.maximum(points[:, 2], 0.0) * (1.0 - 90.0 * (y + 0.01) ** 2)
        points[:, 0] *= 1.0 - 14.0 * np.abs(y) ** 1.7
        return points

    body = sphere(1.0, 40, 20)
    body.points[:] *= (0.034, 0.058, 0.037)
    shell = body.warped(shape)
    wheel = tube([(-0.003, 0, 0), (0.003, 0, 0)], 0.010, 20).moved(0.0, -0.034, 0.0225)
    mat = rounded_box((0.22, 0.18, 0.003), 0.0014, segments=2).moved(0.0, 0.0, 0.0015)
    item = Assembly().add(palette["Grey Plastic"], shell.moved(z=0.0033))
    item.add(palette["Rubber"], wheel.moved(z=0.002)).add(palette["Book Charcoal"], mat)
    item.build(name, collection, on_desk(desk, -0.33, 0.17), PLACES[desk][1] + 4.0)


def _papers(palette, collection):
    rng = np.random.default_rng(59)
    stack = Assembly()
    for k in range(14):
        sheet = box((0.21, 0.297, 0.0011), (0, 0, 0.0006 + 0.0013 * k))
        stack.add(palette["Paper"], sheet.turned("z", rng.normal(0.0, 1.6)))
    stack.build("Paper Stack", collection, on_desk("B", 0.50, -0.10), PLACES["B"][1] + 8.0)

    note = Assembly()
    note.add(palette["Book Blue"], rounded_box((0.148, 0.210, 0.0025), 0.001).moved(z=0.00125))
    pages = box((0.142, 0.204, 0.009), (0.002, 0.0, 0.0072))
    lid = rounded_box((0.148, 0.210, 0.0025), 0.001).moved(z=0.0133)
    note.add(palette["Paper"], pages).add(palette["Book Blue"], lid)
    note.build("Notebook", collection, on_desk("A", -0.62, 0.10), PLACES["A"][1] - 12.0)

    pen = tube([(0, -0.07, 0), (0, 0.055, 0), (0, 0.07, 0)], (0.0042, 0.0042, 0.0012), 16)
    ball = Assembly().add(palette["Book Red"], pen.moved(z=0.0193))
    ball.build("Pen", collection, on_desk("A", -0.62, 0.10), PLACES["A"][1] + 28.0)


def _pen_cup(palette, collection):
    rng = np.random.default_rng(61)
    radius, height, wall = 0.04, 0.10, 0.0015
    inner = radius - wall
    walls = [(radius, 0.0), (radius, height), (inner, height), (inner, wall)]
    cup = Assembly().add(palette["Brushed Steel"], lathe([(0.0, 0.0), *walls, (0.0, wall)], 48))
    for k, material in enumerate(
        ("Book Ochre", "Book Red", "Book Blue", "Black Plastic", "Book Green")
    ):
        angle = 2.0 * math.pi * k / 5 + rng.uniform(-0.2, 0.2)
        foot, head = 0.018, 0.026
        rise = rng.uniform(0.13, 0.16)
        path = np.array(
            [
                (foot * math.cos(angle + 2.2), foot * math.sin(angle + 2.2), 0.006),
                (head * math.cos(angle), head * math.sin(angle), rise - 0.01),
                (1.03 * head * math.cos(angle), 1.03 * head * math.sin(angle), rise),
            ]
        )
        cup.add(palette[material], tube(path, (0.0036, 0.0036, 0.0008), 6))
    cup.build("Pen Cup", collection, on_desk("B", -0.50, -0.25), PLACES["B"][1])


def _telephone(palette, collection):
    wedge = prism([(-0.09, 0.0), (0.09, 0.0), (0.09, 0.022), (-0.09, 0.062)], 0.17)
    body = wedge.turned("x", 90.0).turned("z", 90.0).moved(x=-0.085)
    phone = Assembly().add(palette["Black Plastic"], body)
    handset = rounded_box((0.045, 0.20, 0.030), 0.013, segments=3, divisions=3)
    phone.add(palette["Grey Plastic"], handset.turned("x", 12.5).moved(-0.055, 0.0, 0.063))
    for r in range(4):
        for c in range(3):
            button = rounded_box((0.014, 0.010, 0.006), 0.002, segments=1).turned("x", 12.5)
            y = -0.052 + 0.020 * r
            phone.add(
                palette["Grey Plastic"],
                button.moved(0.010 + 0.021 * c, y, 0.042 + 0.2222 * y + 0.0018),
            )
    phone.build("Telephone", collection, on_desk("B", 0.52, 0.20), PLACES["B"][1] + 170.0)


def build_desktop(palette, collection):
    """Build what stands on the two desks."""
    rng = np.random.default_rng(53)
    for desk in PLACES:
        _monitor(f"Monitor {desk}", palette, collection, desk, rng)
        _keyboard(f"Keyboard {desk}", palette, collection, desk)
        _mouse(f"Mouse {desk}", palette, collection, desk)
    _papers(palette, collection)
    _pen_cup(palette, collection)
    _telephone(palette, collection)
