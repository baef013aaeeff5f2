"""Small things: crockery, glass, clock, picture, basket, hooks, steel ball."""

import math

import numpy as np

from ..assembly import Assembly
from ..shapes import blocks, box, curve, cylinder, lathe, quad, rounded_box, sphere, tube
from . import room
from .furniture import SHELF, SHELF_LEVELS, SHELF_Y, SIDEBOARD, SIDEBOARD_Y, against_east, on_desk


def _on_sideboard(x, y):
    """Return a place on the sideboard: ``x`` to its left, ``y`` to its front, in metres."""
    at = against_east(SIDEBOARD[1], SIDEBOARD_Y)
    return (at[0] - y, at[1] + x, SIDEBOARD[2] + 2 * room.REST)


def _mug(name, glaze, palette, collection, location, turn):
    r, h = 0.041, 0.095
    outer = [(0.0, 0.003), (0.027, 0.003), (0.029, 0.0), (0.034, 0.0), (0.039, 0.006), (r, 0.018)]
    outer += [(r, h - 0.002), (r - 0.0012, h)]
    inner = [(r - 0.0032, h), (r - 0.0044, h - 0.002), (r - 0.0045, 0.022), (0.032, 0.009)]
    body = lathe([*outer, *inner, (0.0, 0.007)], 56)
    bow = [
        (r - 0.002, 0, 0.077),
        (r + 0.016, 0, 0.079),
        (r + 0.030, 0, 0.062),
        (r + 0.029, 0, 0.042),
    ]
    bow += [(r + 0.016, 0, 0.024), (r - 0.002, 0, 0.021)]
    handle = tube(curve(bow, 6), 0.0048, 12)
    mug = Assembly().add(palette[glaze], body, handle)
    mug.build(name, collection, location, turn)


def _carafe(palette, collection):
    """Build a carafe and two tumblers of solid glass with walls of real thickness."""
    outer = [(0.0, 0.0), (0.045, 0.0), (0.050, 0.004), (0.052, 0.02), (0.052, 0.10), (0.047, 0.135)]
    outer += [(0.034, 0.17), (0.028, 0.195), (0.029, 0.22), (0.035, 0.245), (0.0352, 0.247)]
    inner = [(0.033, 0.247), (0.0265, 0.22), (0.0255, 0.195), (0.0315, 0.169), (0.0445, 0.1335)]
    inner += [(0.0495, 0.10), (0.0495, 0.022), (0.046, 0.010), (0.0, 0.008)]
    jug = Assembly().add(palette["Glass"], lathe(outer + inner, 64))
    jug.build("Carafe", collection, _on_sideboard(0.17, 0.02))
    outer = [(0.0, 0.0), (0.029, 0.0), (0.031, 0.002), (0.034, 0.092), (0.0335, 0.094)]
    inner = [(0.0325, 0.094), (0.032, 0.092), (0.0293, 0.013), (0.026, 0.009), (0.0, 0.009)]
    for index, place in enumerate((_on_sideboard(0.06, 0.06), on_desk("A", -0.34, -0.02)), start=1):
        tumbler = Assembly().add(palette["Glass"], lathe(outer + inner, 56))
        tumbler.build(f"Tumbler {index}", collection, place)


def _clock(palette, collection):
    radius = 0.15
    rim = [(radius - 0.012, 0.0), (radius, 0.0), (radius, 0.030), (radius - 0.004, 0.036)]
    rim += [(radius - 0.012, 0.036), (radius - 0.013, 0.016)]
    face = cylinder(radius - 0.0125, 0.012, 64)
    clock = Assembly().add(palette["Black Plastic"], lathe(rim, 64)).add(palette["Paper"], face)
    for k in range(60):
        size = (0.004, 0.016, 0.0008) if k % 5 == 0 else (0.0015, 0.007, 0.0008)
        mark = box(size, (0.0, 0.125 - size[1] / 2, 0.0127))
        clock.add(palette["Black Plastic"], mark.turned("z", 6.0 * k))
    hands = (
        (0.006, 0.085, 0.0150, 310.0),
        (0.004, 0.115, 0.0170, 120.0),
        (0.0015, 0.12, 0.0190, 200.0),
    )
    for wide, long, z, angle in hands:
        hand = box((wide, long + 0.02, 0.001), (0.0, long / 2 - 0.01, z)).turned("z", -angle)
        clock.add(palette["Book Red" if z > 0.018 else "Black Plastic"], hand)
    clock.add(palette["Black Plastic"], cylinder(0.006, 0.009, 24).moved(z=0.0122))
    # The dial is drawn in x and y; stand it up and turn it into the room.
    for index, (material, part) in enumerate(clock.entries):
        clock.entries[index] = (material, part.turned("x", 90.0))
    middle = (sum(room.DOOR_Y)) / 2
    clock.build("Wall Clock", collection, (room.WIDTH - 0.0005, middle, 2.42), -90.0)


def _picture(palette, collection):
    width, height, border = 0.70, 0.52, 0.02
    us = (-width / 2, -width / 2 + border, width / 2 - border, width / 2)
    vs = (-height / 2, -height / 2 + border, height / 2 - border, height / 2)
    frame = blocks(us, (-0.025, 0.0), vs, lambda i, _, k: (i, k) != (1, 1))
    picture = Assembly().add(palette["Black Plastic"], frame)
    us = (us[1], us[1] + 0.07, us[2] - 0.07, us[2])
    vs = (vs[1], vs[1] + 0.07, vs[2] - 0.07, vs[2])
    mount = blocks(us, (-0.013, -0.011), vs, lambda i, _, k: (i, k) != (1, 1))
    picture.add(palette["Paper"], mount)
    size = (us[2] - us[1] + 0.004, vs[2] - vs[1] + 0.004)
    sheet = quad(
        (us[1] - 0.002, -0.0105, vs[1] - 0.002), (size[0], 0, 0), (0, 0, size[1]), (1.0, 1.0)
    )
    picture.add(palette["Picture"], sheet)
    at = (room.WIDTH - 0.0005, SIDEBOARD_Y, 1.52)
    picture.build("Picture", collection, at, -90.0)


def _basket(palette, collection):
    """Build a waste basket of steel mesh bars between two rims."""
    low, high, height, bars = 0.105, 0.135, 0.32, 44
    basket = Assembly().add(palette["Black Plastic"], cylinder(low + 0.002, 0.006, 48, 0.001))
    for z in (0.10, 0.21, height):
        r = low + (high - low) * z / height
        ring = [(r * math.cos(a), r * math.sin(a), z) for a in np.linspace(0, 2 * np.pi, 48, False)]
        thick = 0.005 if z == height else 0.002
        basket.add(palette["Black Plastic"], tube(np.array(ring), thick, 8, closed=True))
    for k in range(bars):
        bar = tube([(low, 0.0, 0.003), (high, 0.0, height)], 0.0016, 6)
        basket.add(palette["Black Plastic"], bar.turned("z", 360.0 * k / bars))
    rng = np.random.default_rng(67)
    for x, y, z in (
        (0.03, 0.02, 0.045),
        (-0.045, 0.01, 0.045),
        (0.0, -0.045, 0.046),
        (0.0, 0.01, 0.11),
    ):
        ripple = rng.uniform(0.0, 6.0, 3)

        def crumple(points, ripple=ripple):
            wave = np.sin(points * 160.0 + ripple).sum(axis=1, keepdims=True)
            return points * (1.0 + 0.07 * wave)

        ball = sphere(0.034, 14, 10).warped(crumple).moved(x, y, z)
        basket.add(palette["Paper"], ball)
    basket.build("Waste Basket", collection, (1.98, 1.93, room.REST))


def _coat_hooks(palette, collection):
    rail = Assembly().add(palette["Wood"], rounded_box((0.40, 0.018, 0.08), 0.003).moved(y=-0.009))
    for x in (-0.135, -0.045, 0.045, 0.135):
        path = [
            (x, -0.018, 0.012),
            (x, -0.03, 0.010),
            (x, -0.052, -0.002),
            (x, -0.072, 0.02),
            (x, -0.075, 0.042),
        ]
        rail.add(palette["Brushed Steel"], tube(curve(path, 4), 0.0045, 12))
        knob = sphere(0.008, 14, 8).moved(x, -0.075, 0.047)
        plate = cylinder(0.016, 0.003, 28, 0.001).turned("x", 90.0).moved(x, -0.0178, 0.012)
        rail.add(palette["Brushed Steel"], knob, plate)
    rail.build("Coat Hooks", collection, (room.WIDTH - 0.0005, 1.66, 1.70), -90.0)


def _steel_ball(palette, collection):
    """Build a polished ball on a turned foot, on the middle board of the shelf."""
    foot = lathe(
        [(0.0, 0.0), (0.038, 0.0), (0.038, 0.010), (0.026, 0.016), (0.022, 0.020), (0.0, 0.018)], 48
    )
    ball = Assembly().add(palette["Wood"], foot)
    ball.add(palette["Chrome"], sphere(0.055, 64, 32).moved(z=0.0735))
    x, y, _ = against_east(SHELF[1], SHELF_Y)
    ball.build("Steel Ball", collection, (x - 0.03, y + 0.30, SHELF_LEVELS[2] + room.REST))


def _bowl(palette, collection):
    outer = [
        (0.0, 0.0),
        (0.045, 0.0),
        (0.05, 0.004),
        (0.085, 0.03),
        (0.105, 0.065),
        (0.1045, 0.067),
    ]
    inner = [(0.1015, 0.067), (0.082, 0.034), (0.05, 0.011), (0.0, 0.008)]
    bowl = Assembly().add(palette["Blue Glaze"], lathe(outer + inner, 64))
    bowl.build("Bowl", collection, _on_sideboard(-0.19, 0.0))


def build_objects(palette, collection):
    """Build the small things that stand and hang about."""
    _mug("Mug A", "Blue Glaze", palette, collection, on_desk("A", 0.40, 0.12), 40.0)
    _mug("Mug B", "Porcelain", palette, collection, on_desk("B", -0.58, 0.04), 200.0)
    _mug("Mug C", "Book Ochre", palette, collection, _on_sideboard(-0.02, -0.08), 120.0)
    _carafe(palette, collection)
    _clock(palette, collection)
    _picture(palette, collection)
    _basket(palette, collection)
    _coat_hooks(palette, collection)
    _steel_ball(palette, collection)
    _bowl(palette, collection)
