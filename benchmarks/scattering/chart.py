"""Pictures of the benchmark of measured materials: size over error, and pictures side by side."""

import math

import numpy as np
from PIL import Image, ImageDraw, ImageFont

SCALE = 2
"""Charts are drawn so many times larger, for smooth lines."""

AXES, MARGIN, RIGHT, BELOW = (420, 300), (70, 30), 190, 50
"""Size of the axes, free space left and above, for the legend, and below. [pixel]"""

COLOURS = ("#1f77b4", "#ff7f0e", "#2ca02c", "#d62728", "#9467bd", "#8c564b", "#e377c2")

ACROSS, UP = (0.003, 0.06), (0.3, 3000.0)
"""Ends of the axes: error [-], size [kB]."""

GREY, INK = "#dddddd", "#222222"

ENLARGED = 2
"""Pixels of the document for one of a picture."""

DIFFERENCE = 10.0
"""By which differences of pictures are enlarged."""


def draw_storage(rows: list[dict]) -> Image.Image:
    """Size of files over the measured error, a line for each material."""
    size = (MARGIN[0] + AXES[0] + RIGHT, MARGIN[1] + AXES[1] + BELOW)
    image = Image.new("RGB", tuple(SCALE * v for v in size), "white")
    pen, font = ImageDraw.Draw(image), ImageFont.load_default(12 * SCALE)

    def place(error, kilobytes):
        spots = []
        for value, (low, high) in zip((error, kilobytes), (ACROSS, UP), strict=True):
            share = math.log(max(value, 1e-9) / low) / math.log(high / low)
            spots.append(min(max(share, 0.0), 1.0))
        return (
            SCALE * (MARGIN[0] + spots[0] * AXES[0]),
            SCALE * (MARGIN[1] + (1.0 - spots[1]) * AXES[1]),
        )

    for error in (0.005, 0.01, 0.02, 0.05):
        pen.line([place(error, UP[0]), place(error, UP[1])], fill=GREY, width=SCALE)
        x, y = place(error, UP[0])
        pen.text((x, y + 4 * SCALE), f"{100 * error:g} %", fill=INK, font=font, anchor="ma")
    for kilobytes in (1, 10, 100, 1000):
        pen.line([place(ACROSS[0], kilobytes), place(ACROSS[1], kilobytes)], fill=GREY, width=SCALE)
        x, y = place(ACROSS[0], kilobytes)
        pen.text((x - 4 * SCALE, y), f"{kilobytes} kB", fill=INK, font=font, anchor="rm")
    middle = SCALE * (MARGIN[0] + AXES[0] / 2)
    pen.text(
        (middle, SCALE * (size[1] - 18)),
        "measured error of the table",
        fill=INK,
        font=font,
        anchor="ma",
    )
    names = list(dict.fromkeys(row["material"] for row in rows))
    for name, colour in zip(names, COLOURS, strict=False):
        points = [place(r["measured"], r["bytes"] / 1e3) for r in rows if r["material"] == name]
        pen.line(points, fill=colour, width=2 * SCALE)
        for x, y in points:
            pen.ellipse([x - 3 * SCALE, y - 3 * SCALE, x + 3 * SCALE, y + 3 * SCALE], fill=colour)
        row = names.index(name)
        x, y = SCALE * (MARGIN[0] + AXES[0] + 16), SCALE * (MARGIN[1] + 16 + 22 * row)
        pen.line([(x, y), (x + 24 * SCALE, y)], fill=colour, width=2 * SCALE)
        pen.text((x + 30 * SCALE, y), name, fill=INK, font=font, anchor="lm")
    return image.resize(size, Image.LANCZOS)


def draw_pictures(rows: list[dict]) -> Image.Image:
    """Mitsuba's own picture, ours, and their difference, a row for each case."""
    side = ENLARGED * len(rows[0]["pictures"][0])
    head = 22
    image = Image.new("RGB", (3 * (side + 8), len(rows) * (side + head + 8)), "white")
    pen, font = ImageDraw.Draw(image), ImageFont.load_default(12)
    for number, row in enumerate(rows):
        ours, theirs = (np.array(p) for p in row["pictures"])
        top = number * (side + head + 8)
        white = float(np.quantile(theirs, 0.98))
        shown = [theirs / white, ours / white, 0.5 + DIFFERENCE * (ours - theirs) / white]
        titles = (row["case"].split(", ")[-1], "our table", f"difference times {DIFFERENCE:g}")
        for column, (pixels, title) in enumerate(zip(shown, titles, strict=True)):
            encoded = (
                np.clip(pixels, 0.0, 1.0) ** (1.0 / 2.2) if column < 2 else np.clip(pixels, 0, 1)
            )
            tile = Image.fromarray((255 * encoded).astype(np.uint8)).resize((side, side))
            image.paste(tile, (column * (side + 8), top + head))
            pen.text((column * (side + 8), top + 4), title, fill=INK, font=font)
    return image
