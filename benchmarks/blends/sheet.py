"""One picture with all pairs: Cycles at the left, ours at the right."""

from pathlib import Path

import numpy as np

from ..common.chart import Picture
from .pair import HEIGHT, WIDTH

COLUMNS = 2
"""Pairs in a row."""

GAP, TITLE, HEAD = 8, 34, 24
"""Between pictures, above a pair, and above all. [pixel]"""

BRIGHT = 0.98
"""Share of the pixels of Cycles' picture that are not to be burnt out."""


def draw_sheet(rows: dict, pictures: dict, path: Path) -> None:
    """Write the sheet.

    Parameters
    ----------
    rows : dict    As of `run.run`, by file.
    pictures : dict    (2, h, w, 3) arrays by file: Cycles' and ours, linear, row 0 at the bottom.
    path : Path    Of the PNG.
    """
    width, height = 2 * WIDTH + 2 * GAP, HEIGHT + TITLE + GAP
    lines = -(-len(pictures) // COLUMNS)
    sheet = Picture((COLUMNS * width + GAP, HEAD + lines * height), 11)
    for column in range(COLUMNS):
        for place, name in enumerate(("Cycles", "Lumenray")):
            x = GAP + column * width + place * (WIDTH + GAP)
            sheet.write(x, 0.5 * HEAD, name, "lm")
    for number, (name, pair) in enumerate(pictures.items()):
        line, column = divmod(number, COLUMNS)
        x, y = GAP + column * width, HEAD + line * height
        row, scale = rows[name], _scale_of(pair[0])
        sheet.write(x, y + 9, f"{name}: mean {row['mean']:+.1%}, blocks {row['block']:.1%}", "lm")
        for place, (picture, luminance) in enumerate(zip(pair, row["means"], strict=True)):
            left = x + place * (WIDTH + GAP)
            sheet.write(left, y + 24, f"{luminance:.4g} cd/m2", "lm")
            sheet.paste(_shown(picture, scale), left, y + TITLE)
    sheet.save(path)


def _scale_of(picture: np.ndarray) -> float:
    """What brings a picture into the range of a display; both of a pair have that of Cycles'."""
    bright = float(np.quantile(picture.max(axis=-1), BRIGHT))
    return 1.0 / bright if bright > 0.0 else 1.0


def _shown(picture: np.ndarray, scale: float) -> np.ndarray:
    """Return bytes of sRGB from above."""
    linear = np.clip(picture[::-1] * scale, 0.0, 1.0)
    low, high = 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055
    return np.round(255.0 * np.where(linear <= 0.0031308, low, high)).astype(np.uint8)
