"""Books and binders that fill the shelf."""

import math

import numpy as np

from ..assembly import Assembly
from ..shapes import box, cylinder, prism, quad, rounded_box
from .furniture import SHELF, SHELF_LEVELS, SHELF_Y, against_east
from .room import REST

COVERS = ("Book Red", "Book Blue", "Book Green", "Book Ochre", "Book Cream", "Book Charcoal")
"""Materials of the covers."""

BINDER = (0.075, 0.285, 0.318)
"""Thickness, depth and height of a binder. [m]"""

LEAN = 11.0
"""By how much the last book of a row leans on the others. [degrees]"""


def book(thickness, depth, height):
    """Return cover, pages and title band of a book that stands on z = 0.

    Its spine faces +y at y = 0, its thickness runs from x = 0. [m]
    """
    t, board, fold = thickness, 0.0025, 0.25 * thickness
    inner = -fold - board
    outline = [(0, -depth), (board, -depth), (board, inner), (t - board, inner)]
    outline += [(t - board, -depth), (t, -depth), (t, -fold), (0.85 * t, -0.35 * fold)]
    outline += [(0.65 * t, 0), (0.35 * t, 0), (0.15 * t, -0.35 * fold), (0, -fold)]
    cover = prism(outline, height)
    front, back = inner - 0.0003, -depth + 0.004
    pages = box((t - 2 * board - 0.0006, front - back, height - 0.006))
    pages = pages.moved(t / 2, (front + back) / 2, height / 2)
    band = quad((0.65 * t, 0.0003, 0.62 * height), (-0.3 * t, 0, 0), (0, 0, 0.22 * height))
    return cover, pages, band


def _row(shelf, palette, rng, start, end, headroom):
    """Fill a stretch of a board with books of random size; the last one leans."""
    x = start
    while True:
        last = x > end - 0.12
        height = min(rng.uniform(0.185, 0.29), headroom - 0.03)
        thickness = 0.020 if last else rng.uniform(0.014, 0.046)
        depth = min(rng.uniform(0.14, 0.215), 0.8 * height)
        lean = LEAN if last else 0.0
        # A leaning book touches its neighbour with the upper corner only.
        at = x + (0.002 + 0.18 * math.sin(math.radians(lean)) if last else 0.0)
        parts = book(thickness, depth, 0.18 if last else height)
        material = COVERS[rng.integers(len(COVERS))]
        title = "Book Cream" if material != "Book Cream" else "Book Charcoal"
        push = SHELF[1] / 2 - 0.030 - rng.uniform(0.0, 0.014)
        for name, part in zip((material, "Paper", title), parts, strict=True):
            shelf.add(palette[name], part.turned("y", -lean).moved(at, push))
        if last:
            return
        x += thickness + 0.0008


def _binders(shelf, palette, start, materials):
    thickness, depth, height = BINDER
    for index, material in enumerate(materials):
        x = start + index * (thickness + 0.002) + thickness / 2
        y = SHELF[1] / 2 - 0.018
        body = rounded_box((thickness, depth, height), 0.003).moved(x, y - depth / 2, height / 2)
        label = quad((x + 0.027, y + 0.0003, 0.15), (-0.054, 0, 0), (0, 0, 0.14))
        hole = cylinder(0.011, 0.0006, 24).turned("x", -90.0).moved(x, y + 0.0002, 0.06)
        shelf.add(palette[material], body).add(palette["Paper"], label)
        shelf.add(palette["Black Plastic"], hole)


def _boxes(shelf, palette, start):
    """Two lidded cardboard boxes on top of each other."""
    for size, z in (((0.30, 0.25, 0.14), 0.0), ((0.28, 0.24, 0.10), 0.1405)):
        body = rounded_box(size, 0.003, (start + 0.15, 0.0, z + size[2] / 2))
        shelf.add(palette["Book Charcoal" if z == 0.0 else "Book Cream"], body)
        tag = quad((start + 0.19, size[1] / 2 + 0.0004, z + 0.04), (-0.08, 0, 0), (0, 0, 0.04))
        shelf.add(palette["Paper"], tag)


def build_books(palette, collection):
    """Fill the shelf, one object for each board."""
    rng = np.random.default_rng(71)
    left, right = -SHELF[0] / 2 + 0.022, SHELF[0] / 2 - 0.022
    x, y, _ = against_east(SHELF[1], SHELF_Y)
    for index, level in enumerate(SHELF_LEVELS):
        row = Assembly()
        headroom = 0.37 - 0.022
        if index == 0:
            _binders(row, palette, left, ["Book Charcoal"] * 6 + ["Book Blue"] * 2)
        elif index == 4:
            _binders(
                row, palette, left, ["Book Red", "Book Charcoal", "Book Charcoal", "Book Green"]
            )
            _boxes(row, palette, right - 0.36)
        elif index == 2:
            _row(row, palette, rng, left, 0.16, headroom)
        else:
            _row(row, palette, rng, left, right, headroom)
        name = "Binders" if index in (0, 4) else "Books"
        row.build(f"{name} {index + 1}", collection, (x, y, level + REST), 90.0)
