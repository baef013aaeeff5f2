"""A spectrum as a picture: its curve over the wavelength, coloured as the light of each wavelength looks."""

import numpy as np
from PIL import Image

from ..formats.spd import SpectrumFile
from ..photometry.colour import XYZ_TO_REC709
from ..photometry.spectra import GRID, luminous_efficiency, observer
from ..photometry.units import VISIBLE
from ..reading.printable import printable
from .axes import Axes
from .canvas import SCALE, Canvas, open_chart
from .polar_diagram import round_step
from .spectrum_figures import SpectrumFigures, find_figures

MOST_TICKS = 9
"""Numbers across."""

LEAST_RANGE = 100.0
"""That is shown, of a table of few wavelengths. [nm]"""


def draw_spectrum(
    file: SpectrumFile, size: tuple[int, int] = (640, 480), dark: bool = False
) -> Image.Image:
    """Draw a spectrum, relative to its largest value, beside what the eye sees, dashed.

    Parameters
    ----------
    file : SpectrumFile
    size : (int, int)    Width and height. [pixel]
    dark : bool    Light lines on a dark ground.

    Returns
    -------
    Image    RGB.
    """
    canvas = open_chart(size, dark)
    nm, values = file.table.wavelengths, file.table.values
    shown = values / max(float(values.max()), 1e-300)
    low, high = float(nm[0]), float(nm[-1])
    spare = max(0.5 * (LEAST_RANGE - (high - low)), 0.0)
    axes = Axes(canvas, (low - spare, high + spare), (0.0, 1.0), suffix="")
    _fill(canvas, axes, nm, shown)
    step = round_step(high - low + 2.0 * spare, MOST_TICKS)
    ticks = np.arange(np.ceil((low - spare) / step) * step, high + spare + 1e-9, step)
    axes.draw(ticks, np.linspace(0.0, 1.0, 6), "wavelength [nm]", lambda level: f"{level:g}")
    inside = (low - spare <= GRID) & (high + spare >= GRID)
    entries = [(canvas.colours.text, "relative to the largest value")]
    if inside.sum() > 1:
        sight = axes.place(GRID[inside], luminous_efficiency()[inside])
        canvas.dashed(sight, canvas.colours.caption, 1.2, (5, 4))
        entries.append((canvas.colours.caption, "sensitivity of the eye, dashed"))
    canvas.curve(axes.place(nm, shown), canvas.colours.text, 1.8)
    axes.title(printable(file.table.name), describe(find_figures(file.table)))
    canvas.legend(entries)
    return canvas.finish()


def describe(figures: SpectrumFigures) -> str:
    """Say the figures of a light in one line."""
    if figures.peak is None:
        return "zero at all wavelengths"
    words = [f"peak {figures.peak:g} nm", f"{figures.efficacy:.4g} lm/W"]
    if figures.chromaticity is not None:
        words.append("x {:.4f}, y {:.4f}".format(*figures.chromaticity))
    if figures.temperature is not None:
        words.append(f"{figures.temperature:.0f} K, Duv {figures.duv:+.4f}")
    return "; ".join(words)


def _fill(canvas: Canvas, axes: Axes, nm: np.ndarray, shown: np.ndarray) -> None:
    """Fill what lies under the curve, column by column of the large picture."""
    left, _, right, bottom = axes.window
    columns = np.arange(round(left * SCALE), round(right * SCALE) + 1)
    across = axes.across[0] + (columns / SCALE - left) / (right - left) * (
        axes.across[1] - axes.across[0]
    )
    heights = np.interp(across, nm, shown, left=0.0, right=0.0)
    tops = axes.place(across, heights)[:, 1] * SCALE
    for column, top, colour, height in zip(columns, tops, colours_of(across), heights, strict=True):
        if height > 0.0:
            canvas.pen.line([(int(column), float(top)), (int(column), bottom * SCALE)], colour, 1)


def colours_of(wavelengths) -> list[tuple[int, int, int]]:
    """Colours in which light of single wavelengths is shown, as near as sRGB comes; grey beyond what is visible."""
    linear = (
        np.stack([np.interp(wavelengths, GRID, each) for each in observer().T], axis=1)
        @ np.asarray(XYZ_TO_REC709).T
    )
    linear = np.maximum(linear, 0.0)
    strength = linear.max(axis=1, keepdims=True)
    # As bright in the middle as at the ends, where the eye hardly sees anything.
    linear = linear / np.maximum(strength, 1e-12) * np.minimum(strength / 0.2, 1.0) ** 0.4
    is_visible = (wavelengths >= VISIBLE[0]) & (wavelengths <= VISIBLE[1])
    grey = np.full_like(linear, 0.22)
    encoded = np.clip(np.where(is_visible[:, None], linear, grey), 0.0, 1.0) ** (1.0 / 2.2)
    return [tuple(int(c) for c in row) for row in np.round(255.0 * encoded)]
