"""Pigment layers as pictures: the spectrum of a print with its patch, and sheets of printed patches."""

import numpy as np
from PIL import Image

from ..ink.computed import Computed
from ..photometry.colour import XYZ_TO_REC709
from ..reading.printable import printable
from ..scattering.data.tristimulus import tristimulus
from .axes import Axes
from .canvas import SCALE, Canvas, open_chart

PATCH = 0.16
"""Height of the patch, by that of the picture."""

COLOURS = ("#3b82c4", "#2f9e6e", "#d0331f", "#8a5bb5", "#b8860b")
"""Of curves of amounts."""

LEGEND = 34
"""Height of the room for a legend. [pixel]"""

SPREAD = 2.0
"""Standard errors on either side of the curve."""


def draw_ink(made: Computed, size: tuple[int, int] = (800, 600), dark: bool = False) -> Image.Image:
    """Draw the reflectance of a print at 45:0 over the wavelength, with its errors, and its colour.

    Parameters
    ----------
    size : (int, int)    Width and height. [pixel]
    dark : bool    Light lines on a dark ground.
    """
    canvas = open_chart(size, dark)
    wavelengths, values = made.printed.wavelengths, made.readings
    top_value = max(1.0, 0.2 * np.ceil(5.0 * float(values.max())))
    axes = Axes(canvas, (wavelengths[0], wavelengths[-1]), (0.0, top_value), suffix="")
    left, top, right, bottom = axes.window
    below = top + PATCH * (bottom - top)
    _fill(canvas, (left, top, right, below), shown_colour(values, wavelengths))
    # No legend stands below.
    axes.window = left, below + 10 * canvas.zoom, right, bottom + LEGEND * canvas.zoom
    axes.draw(
        np.arange(400.0, 701.0, 50.0),
        np.arange(0.0, top_value + 0.01, 0.2),
        "wavelength in nm",
        lambda level: f"{level:.1f}",
    )
    errors = SPREAD * made.standard_errors
    for nm, value, error in zip(wavelengths, values, errors, strict=True):
        ends = [tuple(map(float, axes.place(nm, at))) for at in (value - error, value + error)]
        canvas.line(ends, canvas.colours.text, 1.4)
        canvas.dot(axes.place(nm, value), COLOURS[0], 3.0)
    canvas.curve(axes.place(wavelengths, values), COLOURS[0], 1.8)
    lab = "  ".join(f"{value:.1f}" for value in made.lab)
    axes.title(
        printable(made.printed.ink.name),
        f"reflectance 45:0; L* a* b* {lab} (D50, 2°; within {made.lab_error:.2g}); bars: two standard errors",
    )
    return canvas.finish()


def draw_patches(rows, wavelengths, size: tuple[int, int] = (900, 420)) -> Image.Image:
    """Draw printed patches.

    Parameters
    ----------
    rows : list of (str, list of (str, (w,) array))    Names of rows, and in each of patches with their reflectances.
    wavelengths : (w,) array    [nm]
    """
    canvas = open_chart(size, False)
    unit, (width, height) = canvas.zoom, canvas.size
    left, top, room = 110 * unit, 34 * unit, 8 * unit
    tall = (height - top - 10 * unit) / len(rows)
    for number, (name, patches) in enumerate(rows):
        wide = (width - left - 10 * unit) / len(patches)
        y = top + number * tall
        canvas.write((left - room, y + 0.5 * tall), printable(name), 12, "rm")
        for k, (title, values) in enumerate(patches):
            x = left + k * wide
            box = (x, y, x + wide - room, y + tall - room)
            _fill(canvas, box, shown_colour(np.asarray(values), wavelengths))
            if number == 0:
                canvas.write((x + 0.5 * wide, 0.5 * top), printable(title), 12, "mm")
    return canvas.finish()


def draw_amounts(curves, size: tuple[int, int] = (900, 640)) -> Image.Image:
    """Draw reflectances over the amount of pigment: waves with their errors, transfer dashed, Kubelka and Munk dotted.

    Parameters
    ----------
    curves : list of (str, shares, waves, standard errors, transfer, Kubelka-Munk)    Name of the curve, then numbers. [-]
    """
    canvas = open_chart(size, False)
    last = max(max(shares) for _, shares, *_ in curves)
    axes = Axes(canvas, (0.0, 100.0 * last), (0.0, 1.0), suffix=" %")
    axes.draw(
        np.arange(0.0, 100.0 * last + 0.1, 10.0),
        np.arange(0.0, 1.01, 0.2),
        "pigment by volume",
        lambda level: f"{level:.1f}",
    )
    for (_, shares, *values), colour in zip(curves, COLOURS, strict=False):
        at = 100.0 * np.asarray(shares)
        waves, errors, transfer, munk = (np.asarray(each) for each in values)
        for place, value, error in zip(at, waves, errors, strict=True):
            ends = [
                tuple(map(float, axes.place(place, value + k * SPREAD * error))) for k in (-1, 1)
            ]
            canvas.line(ends, canvas.colours.text, 1.4)
            canvas.dot(axes.place(place, value), colour, 3.0)
        canvas.curve(axes.place(at, waves), colour, 1.8)
        canvas.dashed(axes.place(at, transfer), colour, 1.2, (7.0, 4.0))
        canvas.dashed(axes.place(at, munk), colour, 1.2, (1.5, 3.0))
    canvas.legend(
        [(colour, printable(name)) for (name, *_), colour in zip(curves, COLOURS, strict=False)]
    )
    axes.title(
        "Reflectance over the amount of pigment",
        "45:0; lines: waves, bars: two standard errors; dashes: spheres one by one; dots: Kubelka and Munk",
    )
    return canvas.finish()


def shown_colour(values, wavelengths) -> np.ndarray:
    """Display colour of a reflectance under D65, (3,) in 0..1; what a screen has not is cut."""
    linear = np.clip(XYZ_TO_REC709 @ tristimulus(values, wavelengths), 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)


def _fill(canvas: Canvas, box, colour) -> None:
    canvas.pen.rectangle(
        [value * SCALE for value in box], tuple(int(255.0 * part + 0.5) for part in colour)
    )
