"""A paint as a picture: its colours along the plane of incidence, a chart of them, and what hand instruments read."""

import numpy as np
from PIL import Image

from ..paint.orange_peel import evaluate
from ..paint.readings import INCIDENCE, SIX, directions, lab_of
from ..paint.solution import Solution
from ..photometry.colour import XYZ_TO_REC709
from ..reading.printable import printable
from ..scattering.data.tristimulus import tristimulus
from .axes import Axes
from .canvas import SCALE, Canvas, open_chart

FIRST, LAST, STEP = -40.0, 115.0, 1.0
"""Aspecular angles that are shown, without those where the lamp is mirrored. [deg]"""

STRIP = 0.16
"""Height of the strip of colours, by that of the picture."""

CURVES = ("#20252c", "#c2437a", "#b08a00")

DARK_CURVES = ("#eceef1", "#ff8dbb", "#f0cf5a")


def draw_paint(
    solution: Solution, size: tuple[int, int] = (800, 600), dark: bool = False
) -> Image.Image:
    """Draw a paint's colours under light from 45 degrees.

    Parameters
    ----------
    size : (int, int)    Width and height. [pixel]
    dark : bool    Light lines on a dark ground.

    Returns
    -------
    Image    RGB. Colours brighter than white are drawn in their hue, as bright as it can be shown.
    """
    canvas = open_chart(size, dark)
    angles = np.arange(FIRST, LAST + 0.5 * STEP, STEP)
    factors = np.pi * evaluate(solution, *directions(angles))
    lab = lab_of(factors, solution.wavelengths)
    low, high = float(min(lab[:, 1:].min(), 0.0)), float(max(lab.max(), 100.0))
    low, high = 20.0 * np.floor(low / 20.0), 20.0 * np.ceil(high / 20.0)
    axes = Axes(canvas, (FIRST, LAST), (low, high))
    left, top, right, bottom = axes.window
    strip = top, top + STRIP * (bottom - top)
    axes.window = left, strip[1] + 10 * canvas.zoom, right, bottom
    levels = np.arange(low, high + 1.0, 20.0 if high - low <= 160.0 else 40.0)
    axes.draw(
        (-15.0, 0.0, *SIX[1:]),
        levels,
        "from the mirror's direction towards the light",
        lambda level: f"{level:g}",
    )
    colours = shown_colours(factors, solution.wavelengths)
    for k, colour in enumerate(colours):
        x = (
            float(axes.place(angles[k] - 0.5 * STEP, high)[0]),
            float(axes.place(angles[k] + 0.5 * STEP, high)[0]),
        )
        _fill(canvas, (max(x[0], left), strip[0], min(x[1], right), strip[1]), colour)
    strokes = DARK_CURVES if dark else CURVES
    for values, stroke in zip(lab.T, strokes, strict=True):
        canvas.curve(axes.place(angles, values), stroke, 1.8)
    read = lab_of(np.pi * evaluate(solution, *directions(SIX)), solution.wavelengths)
    caption = ";  ".join(
        f"{angle:g}°: {'  '.join(f'{round(value):d}' for value in row)}"
        for angle, row in zip(SIX, read, strict=True)
    )
    axes.title(
        printable(solution.paint.name),
        f"L* a* b* (D65, 10°), light from {INCIDENCE:g}°   {caption}",
    )
    canvas.legend(
        [(stroke, name) for stroke, name in zip(strokes, ("L*", "a*", "b*"), strict=True)]
    )
    return canvas.finish()


def shown_colours(factors, wavelengths) -> np.ndarray:
    """Display colours of reflectances under D65; brighter ones than white keep their hue. (n, w) -> (n, 3) in 0..1"""
    linear = np.maximum(tristimulus(factors, wavelengths) @ XYZ_TO_REC709.T, 0.0)
    linear = linear / np.maximum(linear.max(axis=1, keepdims=True), 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)


def _fill(canvas: Canvas, box, colour) -> None:
    canvas.pen.rectangle(
        [value * SCALE for value in box], tuple(int(255.0 * part + 0.5) for part in colour)
    )
