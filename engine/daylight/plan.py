"""Sensors as a plan in false colours, seen from above."""

import numpy as np
from PIL import Image

from ..analysis.canvas import SCALE, Canvas, open_chart
from ..analysis.colour_scale import WIDTH, ColourScale, nice_scale
from ..analysis.polar_diagram import round_step
from ..errors import SceneError
from ..reading.printable import printable

DIGITS = 26.0
"""Width of a cell in which its number is written. [pixel of nominal size]"""

MOST_PAIRS = 2000
"""Sensors whose nearest ones are looked for."""


def draw_plan(
    points,
    values,
    title: str,
    scale: ColourScale | None = None,
    unit: str = "lx",
    size: tuple[int, int] = (640, 560),
    dark: bool = False,
) -> Image.Image:
    """Draw a value of every sensor at its place.

    Parameters
    ----------
    points : (n, 2) or (n, 3) array    The first two coordinates are drawn, +y up. [m]
    values : (n,) array    NaN leaves a sensor empty.
    title : str
    scale : ColourScale or None    None: from 0 to a round number of ``unit``.
    unit : str
    size : (int, int)    Width and height. [pixel]
    dark : bool    Light letters on a dark ground.

    Returns
    -------
    Image    RGB.

    Raises
    ------
    SceneError    Points and values are not as many, there are none, or a point is no place.
    """
    points = np.asarray(points, dtype=np.float64)
    values = np.asarray(values, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] not in {2, 3} or values.shape != points.shape[:1]:
        raise SceneError(
            f"a plan of {len(points)} sensors has {values.size} values, expected one each"
        )
    if not len(points) or not np.isfinite(points).all():
        raise SceneError("a plan needs sensors whose places are numbers")
    scale = scale or nice_scale(values, unit)
    canvas = open_chart(size, dark)
    pixel, (width, height) = canvas.zoom, canvas.size
    plan, spacing = points[:, :2], find_spacing(points[:, :2])
    low, high = plan.min(axis=0) - 0.5 * spacing, plan.max(axis=0) + 0.5 * spacing
    left, top = 20 * pixel, 62 * pixel
    right, bottom = width - (20 + WIDTH) * pixel, height - 48 * pixel
    extent = high - low
    per_metre = float(min((right - left) / extent[0], (bottom - top) / extent[1]))
    corner = np.array(
        [
            left + 0.5 * (right - left - per_metre * extent[0]),
            bottom - 0.5 * (bottom - top - per_metre * extent[1]),
        ]
    )
    middles = corner + (plan - low) * per_metre * [1.0, -1.0]
    _draw_cells(canvas, middles, spacing * per_metre, values, scale)
    scale.draw_bar(canvas, right + 14 * pixel, top + 8 * pixel, bottom)
    _draw_length(canvas, per_metre, float(extent[0]))
    room = width - 36 * pixel
    canvas.write((18 * pixel, 20 * pixel), printable(title), 17, "lm", room=room)
    known = values[np.isfinite(values)]
    caption = f"{len(values)} sensors" + (
        f": mean {known.mean():.4g}, {known.min():.4g} to {known.max():.4g} {scale.unit}"
        if len(known)
        else " without a value"
    )
    canvas.write((18 * pixel, 40 * pixel), caption, 11, "lm", is_caption=True, room=room)
    return canvas.finish()


def find_spacing(plan) -> float:
    """Return the usual distance of sensors from their nearest ones. (n, 2) [m -> m]"""
    plan = np.unique(np.asarray(plan, dtype=np.float64), axis=0)
    if len(plan) < 2:
        return 1.0
    some = plan[np.linspace(0, len(plan) - 1, min(len(plan), MOST_PAIRS)).astype(int)]
    nearest = []
    for start in range(0, len(some), 256):
        apart = np.hypot(*(some[start : start + 256, None] - plan[None]).transpose(2, 0, 1))
        apart[apart == 0.0] = np.inf
        nearest.append(apart.min(axis=1))
    return float(np.median(np.concatenate(nearest)))


def _draw_cells(canvas: Canvas, middles, side: float, values, scale: ColourScale) -> None:
    colours = scale.colours(values)
    largest = max((len(_number(v)) for v in values if np.isfinite(v)), default=1)
    has_room = side >= DIGITS * canvas.zoom and side >= 7.5 * largest * canvas.zoom
    for (x, y), value, colour in zip(middles, values, colours, strict=True):
        box = [(x - 0.5 * side) * SCALE, (y - 0.5 * side) * SCALE]
        box += [(x + 0.5 * side) * SCALE, (y + 0.5 * side) * SCALE]
        if not np.isfinite(value):
            canvas.pen.rectangle(box, outline=canvas.colours.axis)
            continue
        canvas.pen.rectangle(box, tuple(map(int, colour)))
        if has_room:
            is_bright = colour @ np.array([0.30, 0.59, 0.11]) > 140.0
            canvas.write((x, y), _number(value), 10, "mm", "#101418" if is_bright else "#f4f6f8")


def _number(value: float) -> str:
    return f"{value:.0f}" if abs(value) >= 100.0 else f"{value:.3g}"


def _draw_length(canvas: Canvas, per_metre: float, extent: float) -> None:
    """Draw a round length below the plan."""
    pixel = canvas.zoom
    length = round_step(extent, 3)
    x, y = 20 * pixel, canvas.size[1] - 22 * pixel
    end = x + length * per_metre
    canvas.line(
        [(x, y - 4 * pixel), (x, y), (end, y), (end, y - 4 * pixel)], canvas.colours.text, 1.4
    )
    canvas.write((end + 8 * pixel, y), f"{length:g} m", 11, "lm")
