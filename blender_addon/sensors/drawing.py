"""What is drawn of sensors in 3D views: cells in false colours, isolux lines and numbers, as plain arrays."""

from dataclasses import dataclass

import numpy as np

from ...engine.analysis.colour_scale import ColourScale
from ...engine.analysis.contours import choose_levels, find_contours, path_length, place_label
from ...engine.analysis.false_colour import nice_maximum
from ...engine.analysis.value_plan import even_scale
from ...engine.light_mix import LightMix
from ..rendering.light_mix import levels_of
from . import results
from .readings import Readings, readings_of
from .settings import find_sensors
from .words import brief

GREY = (0.45, 0.45, 0.45)
"""Colour of readings that are out of date."""

OPACITY = 0.8
"""Of cells."""

LONE = 0.1
"""Side of the square of a sensor that stands in no grid. [m]"""

LIFT = 0.004
"""By which lines lie before the cells. [m]"""

MOST_LABELS = 600
"""Numbers of sensors that are written in a view at most."""


@dataclass(frozen=True, eq=False)
class Label:
    """A text in the world: place (3,) [m], whether it is a line's, and whether it is out of date."""

    text: str
    place: np.ndarray
    is_line: bool
    is_outdated: bool


@dataclass(frozen=True, eq=False)
class Drawing:
    """What is drawn of all sensors of a view.

    Parameters
    ----------
    corners : (4 n, 3) array    Of the cells' squares. [m]
    fills : (4 n, 4) array    Their colours.
    lines : (2 k, 3) array    Ends of pieces of isolux lines. [m]
    labels : list of Label
    scale : ColourScale or None    Of illuminance; None: none was measured.
    """

    corners: np.ndarray
    fills: np.ndarray
    lines: np.ndarray
    labels: list[Label]
    scale: ColourScale | None


def scale_of(scene, held) -> ColourScale | None:
    """Return the scale of a scene's sensors; ``held``: readings with their values. None without any."""
    settings = scene.lumenray.sensors
    values = [mixed for readings, mixed in held if readings.unit == "lx"]
    if not values:
        return None
    high = nice_maximum(np.concatenate(values)) if settings.automatic else settings.high
    return even_scale([high], "lx", high, settings.logarithmic)


def make_drawing(scene, is_shown=lambda empty: True) -> Drawing:
    """Return what is drawn of the sensors of a scene; ``is_shown`` is asked of every empty."""
    levels = levels_of(scene)
    empties = [e for e in find_sensors(scene) if readings_of(e) is not None and is_shown(e)]
    held = [(readings_of(empty), readings_of(empty).mixed(levels)[0]) for empty in empties]
    scale = scale_of(scene, held)
    parts: list[tuple] = []
    labels: list[Label] = []
    for empty, (readings, values) in zip(empties, held, strict=True):
        is_outdated = results.is_outdated(empty)
        if readings.is_distribution:
            place = readings.frame[:3, 3].astype(np.float64)
            lines = find_curves(readings, values, empty.lumenray.sensor.radius)
            parts.append((np.zeros((0, 3)), np.zeros((0, 4), np.float32), lines))
            if empty.lumenray.sensor.show_values:
                labels.append(Label(brief(readings), place, False, is_outdated))
            continue
        corners = find_corners(readings)
        fills = np.ones((len(corners), 4), np.float32)
        fills[:, :3] = GREY
        if scale is not None and readings.unit == "lx" and not is_outdated:
            fills[:, :3] = np.repeat(scale.colours(values) / 255.0, 4, axis=0)
        fills[:, 3] = OPACITY
        lines = np.zeros((0, 3))
        settings = empty.lumenray.sensor
        if settings.show_isolux and readings.is_field:
            lines, texts = find_lines(readings, values)
            labels += [Label(text, place, True, is_outdated) for text, place in texts]
        if settings.show_values:
            labels += label_values(readings, levels, is_outdated)
        parts.append((corners, fills, lines))
    if not parts:
        return Drawing(np.zeros((0, 3)), np.zeros((0, 4)), np.zeros((0, 3)), [], None)
    joined = [np.concatenate(part) for part in zip(*parts, strict=True)]
    return Drawing(*joined, labels, scale)


def find_curves(readings: Readings, values, radius: float) -> np.ndarray:
    """Pieces of the polar curves of a goniometer's planes in the world, the largest intensity a radius long. (2 k, 3) [m]"""
    top = float(np.max(values))
    share = np.reshape(values, readings.shape) / top if top > 0.0 else np.zeros(readings.shape)
    away = -readings.normals.astype(np.float64).reshape(*readings.shape, 3)
    points = readings.frame[:3, 3] + radius * share[..., None] * away
    return np.stack([points[:, :-1], points[:, 1:]], axis=2).reshape(-1, 3)


def find_steps(readings: Readings) -> np.ndarray:
    """Distances of neighbours of a grid along its plane's x and y, of lone sensors a nominal one. (2,) [m]"""
    made = np.full(2, LONE)
    rows, columns = readings.shape
    for axis, count, places in (
        (0, columns, readings.cells % columns),
        (1, rows, readings.cells // columns),
    ):
        spread = np.unique(places)
        if count > 1 and len(spread) > 1:
            along = readings.plane[:, axis].astype(np.float64)
            made[axis] = (along.max() - along.min()) / (spread[-1] - spread[0])
    if min(readings.shape) == 1:
        # A line has squares that do not touch.
        made[:] = min(made.min(), LONE)
    return made


def find_corners(readings: Readings) -> np.ndarray:
    """Corners of the squares of all sensors in the world. (4 n, 3) [m]"""
    half = 0.5 * find_steps(readings)
    around = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * half
    if min(readings.shape) == 1 and len(readings.positions) > 0 and readings.quantity != "PLANAR":
        # Of what looks along a level the square stands upright.
        x, y = np.array([0.0, 0.0, 1.0]), np.cross([0.0, 0.0, 1.0], readings.frame[:3, 0])
    else:
        x, y = readings.frame[:3, 0].astype(np.float64), readings.frame[:3, 1].astype(np.float64)
    offsets = around[:, :1] * x + around[:, 1:] * y
    return (readings.positions[:, None].astype(np.float64) + offsets).reshape(-1, 3)


def axes_of(readings: Readings) -> tuple[np.ndarray, np.ndarray]:
    """Places of the columns and the rows of a grid in its plane. (columns,), (rows,) [m]"""
    rows, columns = readings.shape
    made = []
    places = (readings.cells % columns, readings.cells // columns)
    for axis, count in ((0, columns), (1, rows)):
        along, number = readings.plane[:, axis].astype(np.float64), places[axis]
        step = find_steps(readings)[axis] if count > 1 else 0.0
        first = float(np.median(along - step * number))
        made.append(first + step * np.arange(count))
    return made[0], made[1]


def find_lines(readings: Readings, values) -> tuple[np.ndarray, list[tuple[str, np.ndarray]]]:
    """Pieces of the isolux lines of a grid in the world (2 k, 3), and their labels with places (3,). [m]"""
    x, y = axes_of(readings)
    field = readings.grid(values)
    pieces, texts = [np.zeros((0, 3))], []
    for level, paths in find_contours(x, y, field, choose_levels(field)):
        for path in paths:
            world = to_world(readings, path)
            pieces.append(np.stack([world[:-1], world[1:]], axis=1).reshape(-1, 3))
        if paths:
            place = place_label(max(paths, key=path_length))
            texts.append((f"{level:g}", to_world(readings, place[None])[0]))
    return np.concatenate(pieces), texts


def to_world(readings: Readings, points) -> np.ndarray:
    """Points of the plane of a grid in the world, a little before it. (n, 2) -> (n, 3) [m]"""
    frame = readings.frame.astype(np.float64)
    local = np.column_stack([points, np.full(len(points), LIFT)])
    return local @ frame[:3, :3].T + frame[:3, 3]


def label_values(readings: Readings, levels: LightMix, is_outdated: bool) -> list[Label]:
    """Numbers of all sensors with their errors, none where there are too many."""
    if len(readings.positions) > MOST_LABELS:
        return []
    rows = zip(readings.positions, *readings.mixed(levels), strict=True)
    return [
        Label(_tell(value, error, readings.unit), np.asarray(place, np.float64), False, is_outdated)
        for place, value, error in rows
    ]


def _tell(value: float, error: float, unit: str) -> str:
    """A reading, with its unit where that is not the usual one."""
    if np.isnan(value):
        return "no glare"
    words = format_reading(value, error)
    return words if unit == "lx" else f"{words} {unit}"


def format_reading(value: float, error: float) -> str:
    """Return a reading as short as it can stand beside a sensor: to the first digit of its error, which is told."""
    if not error > 0.0:
        return f"{value:.4g}"
    digits = max(0, -int(np.floor(np.log10(error))))
    if digits > 4:
        return f"{value:.4g}"
    rounded = max(round(error, digits), 10.0**-digits)
    return f"{value:.{digits}f} ±{rounded:.{digits}f}"
