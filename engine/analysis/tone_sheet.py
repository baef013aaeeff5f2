"""A picture for looking on a sheet that says what it is, with a legend of which luminance is shown how bright."""

import textwrap

import numpy as np

from .canvas import LIGHT, Colours
from .colour_scale import BAR, WIDTH
from .sheet import Sheet
from .tone import encode_srgb
from .tone_operators import STATEMENT, Toned, legend_range
from .value_plan import LARGEST, MARGIN

TOP, LINE = 44.0, 16.0
"""Room above the picture, and for a line of words below it. [pixel]"""

LETTER = 6.2
"""Mean width of letters of the words. [pixel]"""

SMALLEST = (460, 320)
"""Width of sheets and height of their pictures at least. [pixel]"""


def draw_toned(toned: Toned, caption: str = "", colours: Colours = LIGHT) -> Sheet:
    """Draw a picture with its statement and its legend; ``caption``: what else is to be known of it."""
    height, width = toned.colour.shape[:2]
    zoom = min(max(int(np.ceil(420 / max(width, height))), 1), 8)
    zoom = min(zoom, max(LARGEST / max(width, height), 1e-3))
    across = max(round(width * zoom + 2 * MARGIN + WIDTH), SMALLEST[0])
    lines = textwrap.wrap("; ".join(filter(None, [toned.words, caption])), int(across / LETTER))
    along = max(height * zoom, SMALLEST[1])
    sheet = Sheet((across, round(TOP + along + LINE * (len(lines) + 1.5))), colours)
    sheet.write((MARGIN - 2, 20), STATEMENT, 17)
    sheet.picture(encode_srgb(toned.colour)[::-1], (MARGIN, TOP), (width * zoom, height * zoom))
    for number, line in enumerate(lines):
        place = (MARGIN - 2, TOP + along + LINE * (number + 1))
        sheet.write(place, line, 11, colour=sheet.colours.caption)
    _draw_legend(sheet, toned, across - WIDTH - MARGIN + 14, TOP + 16, TOP + along - 6)
    return sheet


def _draw_legend(sheet: Sheet, toned: Toned, left: float, top: float, bottom: float) -> None:
    low, high = legend_range(toned.curve)
    count = max(round(bottom - top), 2)
    rows = encode_srgb(toned.curve(np.geomspace(high, low, count)))
    pixels = np.repeat(np.repeat(rows[:, None, None], BAR, axis=1), 3, axis=2)
    sheet.picture(pixels, (left, top), (BAR, bottom - top))
    right = left + BAR
    sheet.line(
        [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)],
        sheet.colours.axis,
    )
    for tick in legend_ticks(low, high):
        y = bottom - np.log(tick / low) / np.log(high / low) * (bottom - top)
        sheet.line([(right, y), (right + 4, y)], sheet.colours.axis)
        sheet.write((right + 7, y), f"{tick:g}", 10)
    sheet.write((left, top - 10), "cd/m²", 11, colour=sheet.colours.caption)


def legend_ticks(low: float, high: float) -> list[float]:
    """Powers of ten within a range, and round numbers between them where those are few."""
    powers = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    steps = (1.0, 2.0, 5.0) if len(powers) < 5 else (1.0,)
    ticks = [step * 10.0**power for power in powers for step in steps]
    return [tick for tick in ticks if low * 0.999 <= tick <= high * 1.001]
