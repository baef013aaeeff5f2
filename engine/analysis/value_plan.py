"""Plans of values in false colours with lines of equal value and a legend: of grids, and of maps and pictures."""

import numpy as np

from .canvas import LIGHT, Colours
from .colour_scale import WIDTH, ColourScale
from .contours import choose_levels, find_contours, path_length, place_label
from .false_colour import nice_maximum
from .line_smoothing import (
    LINE_NOISE,
    choose_passes,
    keep_certain,
    mean_width,
    noise_left,
    relative_noise,
    sample_points,
    smooth,
)
from .polar_diagram import round_step
from .sheet import Sheet, hexadecimal

MARGIN, TOP, BOTTOM = 20.0, 66.0, 46.0
"""Room around the plan. [pixel]"""

DIGITS, LINE = 30.0, 16.0
"""Least width and height of a cell in which its number is written. [pixel]"""

DARK_LINE, BRIGHT_LINE = "#101418", "#ffffff"

SHORTEST = 12.0
"""Lines that are shorter are left out of maps and pictures: noise makes many. [pixel]"""

LABELLED = 60.0
"""Length from which a line has its value written on it. [pixel]"""

ACROSS, UP = 84.0, 56.0
"""Distances of the points whose values are written on maps and pictures. [pixel]"""

LARGEST = 1600
"""Longer side of a map or picture on its plan. [pixel]"""


def even_scale(values, unit: str, high: float | None = None, is_log: bool = False) -> ColourScale:
    """Return a scale with colours of even lightness that nearly all values lie within.

    ``high``: its upper end, None: a round number. A logarithmic one covers three powers of ten.
    """
    values = np.asarray(values, dtype=np.float64)
    top = nice_maximum(values) if high is None else high
    return ColourScale(top * 1e-3 if is_log else 0.0, top, unit, is_log, "even")


def difference_scale(values, unit: str) -> ColourScale:
    """Return a scale about 0 for differences."""
    top = nice_maximum(np.abs(np.asarray(values, dtype=np.float64)))
    return ColourScale(-top, top, unit, False, "difference")


def draw_grid(
    title: str,
    x,
    y,
    values,
    caption: str = "",
    scale: ColourScale | None = None,
    levels=None,
    unit: str = "lx",
    size: tuple[int, int] = (760, 560),
    colours: Colours = LIGHT,
) -> Sheet:
    """Draw the values of a grid of sensors.

    Parameters
    ----------
    title, caption : str    Above the plan.
    x, y : (columns,), (rows,) array    Places of the sensors, ascending. [m]
    values : (rows, columns) array    NaN where no sensor stands.
    scale : ColourScale or None    None: even colours from 0 to a round number.
    levels : iterable of float or None    Of the lines; None: round ones.
    """
    values = np.asarray(values, dtype=np.float64)
    scale = scale or even_scale(values, unit)
    x, y = (np.asarray(each, dtype=np.float64) for each in (x, y))
    step = [_step(x), _step(y)]
    if len(x) == 1:
        step[0] = step[1] if len(y) > 1 else 1.0
    if len(y) == 1:
        step[1] = step[0]
    low = np.array([x[0] - 0.5 * step[0], y[0] - 0.5 * step[1]])
    extent = np.array([x[-1] + 0.5 * step[0], y[-1] + 0.5 * step[1]]) - low
    sheet = Sheet(size, colours)
    room = np.array([size[0] - 2 * MARGIN - WIDTH, size[1] - TOP - BOTTOM])
    per_metre = float((room / extent).min())
    corner = np.array([MARGIN + 0.5 * (room[0] - per_metre * extent[0]), size[1] - BOTTOM])
    corner[1] -= 0.5 * (room[1] - per_metre * extent[1])

    def place(points):
        return corner + (np.asarray(points) - low) * per_metre * [1.0, -1.0]

    half = 0.5 * np.array(step)
    around = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    fills = scale.colours(values)
    has_room = per_metre * step[0] >= DIGITS and per_metre * step[1] >= LINE
    lines = choose_levels(values) if levels is None else list(levels)
    for row, column in np.argwhere(np.isfinite(values)):
        middle = np.array([x[column], y[row]])
        sheet.area(place(middle + around), hexadecimal(fills[row, column]))
    if has_room:
        for row, column in np.argwhere(np.isfinite(values)):
            ink = _ink(fills[row, column])
            sheet.write(place((x[column], y[row])), number(values[row, column]), 10, "m", ink)
    _draw_lines(sheet, find_contours(x, y, values, lines), place, 0.0)
    scale.draw_on_sheet(sheet, size[0] - WIDTH - MARGIN + 14, TOP + 8, size[1] - BOTTOM)
    _draw_length(sheet, per_metre, float(extent[0]))
    _draw_head(sheet, title, caption)
    return sheet


def draw_map(
    title: str,
    values,
    shown=None,
    caption: str = "",
    scale: ColourScale | None = None,
    levels=None,
    unit: str = "lx",
    smoothing: int = 0,
    colours: Colours = LIGHT,
    error=None,
    with_lines: bool = True,
    with_values: bool = False,
    look=None,
) -> Sheet:
    """Draw a map or a picture.

    Parameters
    ----------
    values : (h, w) array    Row 0 is the bottom row.
    shown : (h, w) bool array or None    Elsewhere the background is left, and no line passes.
    scale : ColourScale or None    None: even colours from 0 to a round number.
    levels : iterable of float or None    Of the lines; None: round ones.
    smoothing : int    How often neighbours are averaged before lines are drawn; colours stay as they are.
    error : (h, w) array or None
        Standard error, for which neighbours are averaged more often where lines would show it; what is left is stated.
    with_lines, with_values : bool    Whether lines are drawn, and values written at a grid of points.
    look : (h, w, 3) uint8 array or None    A picture, the top row first, that is shown in place of colours and legend.
    """
    values = np.asarray(values, dtype=np.float64)
    shown = np.ones(values.shape, dtype=bool) if shown is None else np.asarray(shown, dtype=bool)
    shown = shown & np.isfinite(values)
    scale = scale or even_scale(values[shown], unit)
    height, width = values.shape
    zoom = min(max(int(np.ceil(420 / max(width, height))), 1), 8)
    zoom = min(zoom, max(LARGEST / max(width, height), 1e-3))
    size = (
        max(round(width * zoom + 2 * MARGIN + WIDTH), 460),
        max(round(height * zoom + TOP + BOTTOM), 320),
    )
    sheet = Sheet(size, colours)
    corner = np.array([MARGIN, TOP])
    if look is None:
        look = scale.colours(values)
        look[~shown] = [int(colours.background[k : k + 2], 16) for k in (1, 3, 5)]
        look = look[::-1]
        scale.draw_on_sheet(sheet, size[0] - WIDTH - MARGIN + 14, TOP + 8, size[1] - BOTTOM)
    sheet.picture(look, corner, (width * zoom, height * zoom))
    known = values[shown]
    lines = [] if levels is None else list(levels)
    if levels is None and known.size:
        # Of nearly all that is seen: a lamp would take all lines.
        lines = choose_levels(np.percentile(known, [0.5, 99.5]))
    drawn = with_lines or with_values
    noise = relative_noise(known, np.asarray(error)[shown]) if drawn and error is not None else 0.0
    passes = choose_passes(noise, smoothing, min(height, width)) if drawn else 0
    field = np.where(shown, values, np.nan)
    for _ in range(passes):
        field = smooth(field)

    def place(points):
        return corner + (np.asarray(points) * [1.0, -1.0] + [0.0, height]) * zoom

    x, y = np.arange(width) + 0.5, np.arange(height) + 0.5
    if with_lines:
        # Noise that was smoothed makes rings as wide as the means.
        shortest = SHORTEST + 3.0 * zoom * (mean_width(passes) - mean_width(smoothing))
        left = noise * noise_left(passes)
        found = [
            (level, keep_certain(paths, field, passes, left))
            for level, paths in find_contours(x, y, field, lines)
        ]
        _draw_lines(sheet, found, place, shortest)
    if with_values:
        _write_values(sheet, field, place, zoom)
    words = " and ".join(
        name for name, on in (("lines", with_lines), ("values", with_values)) if on
    )
    more = _tell_means(words, passes, noise) if passes and drawn else ""
    _draw_head(sheet, title, "; ".join(filter(None, [caption, more])))
    return sheet


def _tell_means(words: str, passes: int, noise: float) -> str:
    """Say what lines and values are of; ``noise``: relative error of pixels, 0 where none is stated."""
    told = f"{words} of means over about {mean_width(passes):.0f} pixels"
    if noise > 0.0:
        left = noise * noise_left(passes)
        told += f" (noise {100.0 * left:.2g} %{', lines show it' if left > LINE_NOISE else ''})"
    return told


def _write_values(sheet: Sheet, field, place, zoom: float) -> None:
    """Write values beside points in even distances."""
    height, width = field.shape
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    for *middle, value in sample_points(field, width * zoom / ACROSS, height * zoom / UP):
        across, down = place(middle)
        for reach, ink in ((2.5, BRIGHT_LINE), (1.5, DARK_LINE)):
            sheet.area(np.add(reach * square, (across, down)), ink)
        sheet.write((across, down + 10.0), number(value), 10, "m", DARK_LINE, BRIGHT_LINE)


def number(value: float) -> str:
    """Return a value as short as it is told on plans."""
    return f"{value:.0f}" if abs(value) >= 100.0 else f"{value:.3g}"


def _draw_lines(sheet: Sheet, contours, place, shortest: float) -> None:
    labels = []
    for level, paths in contours:
        longest = 0.0
        drawn = [place(path) for path in paths]
        for path in drawn:
            length = path_length(path)
            if length < shortest:
                continue
            sheet.line(path, BRIGHT_LINE, 2.6)
            sheet.line(path, DARK_LINE, 1.1)
            longest = max(longest, length)
        for path in drawn:
            # The longest line of a level has its number however short it is.
            if longest > 0.0 and path_length(path) >= min(LABELLED, longest):
                labels.append((place_label(path), f"{level:g}"))
    written: list[np.ndarray] = []
    for at, text in labels:
        # About the size of a label: one over another could not be read.
        if not any((np.abs(at - other) < (34.0, 13.0)).all() for other in written):
            sheet.write(at, text, 11, "m", DARK_LINE, BRIGHT_LINE)
            written.append(at)


def _draw_head(sheet: Sheet, title: str, caption: str) -> None:
    sheet.write((MARGIN - 2, 20), title, 17)
    if caption:
        sheet.write((MARGIN - 2, 42), caption, 11, colour=sheet.colours.caption)


def _draw_length(sheet: Sheet, per_metre: float, extent: float) -> None:
    """Draw a round length below the plan."""
    length = round_step(extent, 3)
    x, y = MARGIN, sheet.size[1] - 22.0
    end = x + length * per_metre
    sheet.line([(x, y - 4), (x, y), (end, y), (end, y - 4)], sheet.colours.text, 1.4)
    sheet.write((end + 8, y), f"{length:g} m", 11)


def _step(places: np.ndarray) -> float:
    return float(np.median(np.diff(places))) if len(places) > 1 else 0.0


def _ink(colour) -> str:
    return DARK_LINE if np.asarray(colour) @ [0.30, 0.59, 0.11] > 140.0 else BRIGHT_LINE
