"""A sky as a picture: luminances in false colours as on a map, and the ways of the sun through the year."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from datetime import datetime

import numpy as np
from PIL import Image, ImageDraw

from ..reading.printable import printable
from ..sky.place import Place, from_local
from ..sky.solar_position import DAY, find_sun
from .canvas import SCALE, Canvas, open_chart
from .colour_scale import WIDTH, ColourScale, nice_scale

DAYS = ((6, 21), (3, 20), (12, 21))
"""Month and day of the ways of the sun that are drawn."""

DECADES = 3.0
"""Of luminance that are told apart, from the brightest sky down."""

EVEN = 6.0
"""Ratio of the brightest to the darkest sky up to which the scale is linear. [-]"""

RINGS = (0, 30, 60)
"""Elevations with a circle. [degree]"""

STEPS = 24 * 12
"""Places of the sun on a day."""


@dataclass(frozen=True)
class ShownSun:
    """The sun of a moment.

    Parameters
    ----------
    elevation, azimuth : float    Not drawn below the horizon. [degree]
    """

    elevation: float
    azimuth: float


def draw_sky(
    find_luminances: Callable[[np.ndarray], np.ndarray],
    title: str,
    caption: str = "",
    sun: ShownSun | None = None,
    place: Place | None = None,
    year: int = 2001,
    scale: ColourScale | None = None,
    size: tuple[int, int] = (640, 640),
    dark: bool = False,
) -> Image.Image:
    """Draw the luminances of a sky over a map: north above, east on the right, the zenith in the middle.

    The distance from the middle goes with the zenith angle.

    Parameters
    ----------
    find_luminances : callable    From unit vectors (..., 3), +x east, +y north, +z up, to luminances (...). [cd/m2]
    title, caption : str
    sun : ShownSun or None
    place : Place or None    Whose ways of the sun are drawn for the days of `DAYS`, with the hours of its standard time;
        None: none.
    year : int    Of the ways.
    scale : ColourScale or None    None: logarithmic, up to a round number.
    size : (int, int)    Width and height. [pixel]
    dark : bool    Light lines on a dark ground.

    Returns
    -------
    Image    RGB.
    """
    canvas = open_chart(size, dark)
    pixel, (width, height) = canvas.zoom, canvas.size
    top, bottom = 72 * pixel, height - 40 * pixel
    right = width - (16 + WIDTH) * pixel
    radius = min(0.5 * (right - 20 * pixel), 0.5 * (bottom - top)) - 12 * pixel
    disk = _Disk(canvas, 0.5 * (20 * pixel + right), 0.5 * (top + bottom), radius)
    directions, shown = disk.directions()
    luminances = np.where(shown, find_luminances(directions), 0.0)
    scale = scale or _choose_scale(luminances[shown])
    disk.paint(scale.colours(luminances), shown)
    disk.draw_grid(place is None or place.latitude >= 0.0)
    if place is not None:
        disk.draw_ways(place, year)
    if sun is not None and sun.elevation >= 0.0:
        canvas.dot(disk.place(sun.elevation, sun.azimuth), "#ffffff", 6.0, "#101418")
    scale.draw_bar(canvas, right + 10 * pixel, top + 12 * pixel, bottom)
    room = width - 36 * pixel
    canvas.write((18 * pixel, 20 * pixel), printable(title), 17, "lm", room=room)
    canvas.write((18 * pixel, 40 * pixel), caption, 11, "lm", is_caption=True, room=room)
    if place is not None:
        words = "sun on 21 June, 20 March and 21 December, hours of standard time"
        canvas.write((18 * pixel, height - 18 * pixel), words, 11, "lm", is_caption=True, room=room)
    return canvas.finish()


def _choose_scale(luminances: np.ndarray) -> ColourScale:
    """A scale from 0, or a logarithmic one where the sky's parts differ much; its ends are round."""
    known = luminances[np.isfinite(luminances) & (luminances > 0.0)]
    if not len(known):
        return ColourScale(0.0, 1.0, "cd/m²")
    top, least = float(known.max()), float(np.percentile(known, 1.0))
    if top < EVEN * least:
        return nice_scale(known, "cd/m²")
    power = math.floor(math.log10(top))
    rounds = [f * 10.0**p for p in range(power - 5, power + 2) for f in (1.0, 2.0, 5.0)]
    high = min(value for value in rounds if value >= 0.999 * top)
    least = max(least, high * 10.0**-DECADES)
    low = max(value for value in rounds if value <= 1.001 * least)
    return ColourScale(low, high, "cd/m²", is_log=True)


class _Disk:
    """The sky on the canvas."""

    def __init__(self, canvas: Canvas, x: float, y: float, radius: float):
        self.canvas, self.centre, self.radius = canvas, np.array([x, y]), radius

    def place(self, elevation, azimuth) -> np.ndarray:
        """Pixels (..., 2) of places in the sky. [degree]"""
        share = (90.0 - np.asarray(elevation, dtype=np.float64)) / 90.0 * self.radius
        turn = np.radians(azimuth)
        x, y = self.centre
        return np.stack(
            np.broadcast_arrays(x + share * np.sin(turn), y - share * np.cos(turn)), axis=-1
        )

    def directions(self) -> tuple[np.ndarray, np.ndarray]:
        """Unit vectors of the pixels of the disk's square, and which are in the disk. (n, n, 3), (n, n)"""
        count = 2 * max(round(self.radius), 8)
        across = (np.arange(count) + 0.5) / count * 2.0 - 1.0
        east, north = across[None, :], -across[:, None]
        share = np.hypot(east, north)
        zenith = 0.5 * np.pi * np.minimum(share, 1.0)
        factor = np.sin(zenith) / np.maximum(share, 1e-12)
        parts = np.broadcast_arrays(factor * east, factor * north, np.cos(zenith))
        directions = np.stack(parts, axis=-1)
        return directions / np.linalg.norm(directions, axis=-1, keepdims=True), share <= 1.0

    def paint(self, colours: np.ndarray, shown: np.ndarray) -> None:
        """Fill the disk."""
        side = round(2.0 * self.radius * SCALE)
        corner = tuple(round((edge - self.radius) * SCALE) for edge in self.centre)
        picture = Image.fromarray(colours).resize((side, side), Image.Resampling.BILINEAR)
        mask = Image.new("L", (side, side), 0)
        ImageDraw.Draw(mask).ellipse([0, 0, side - 1, side - 1], 255)
        self.canvas.image.paste(picture, corner, mask)

    def draw_grid(self, is_north: bool) -> None:
        """Circles of elevations, spokes, and the names of the quarters; ``is_north``: of a place north of the equator."""
        canvas, turn = self.canvas, np.linspace(0.0, 360.0, 181)
        for elevation in RINGS:
            canvas.curve(self.place(elevation, turn), "#c8ced6", 0.6)
            if elevation:
                # Where the sun does not come near.
                at = self.place(elevation, 0.0 if is_north else 180.0)
                at = at + np.array([3.0 * canvas.zoom, 0.0])
                canvas.write(at, f"{elevation}°", 9, "ld" if is_north else "la", "#f2f4f7")
        for azimuth in range(0, 360, 30):
            canvas.line(self.place(np.array([0.0, 60.0]), azimuth), "#c8ced6", 0.4)
        for azimuth, name in ((0, "N"), (90, "E"), (180, "S"), (270, "W")):
            turned = np.radians(azimuth)
            away = self.radius + 10 * canvas.zoom
            at = self.centre + away * np.array([np.sin(turned), -np.cos(turned)])
            canvas.write(at, name, 12, "mm")

    def draw_ways(self, place: Place, year: int) -> None:
        """Ways of the sun on some days, with the hours of standard time."""
        # Clocks are put forward in one half of the year.
        offset = min(from_local(datetime(year, m, 1), place.zone).offset for m in (1, 7))
        for month, day in DAYS:
            start = (datetime(year, month, day) - datetime(1970, 1, 1)).total_seconds()
            start -= offset * 3600.0
            times = start + np.arange(STEPS + 1) * DAY / STEPS
            sun = find_sun(times, place)
            above = np.flatnonzero(sun.elevation >= 0.0)
            for piece in np.split(above, np.flatnonzero(np.diff(above) > 1) + 1):
                if len(piece) > 1:
                    path = self.place(sun.elevation[piece], sun.azimuth[piece])
                    self.canvas.line(path, "#101418", 2.6)
                    self.canvas.line(path, "#fff3c4", 1.2)
            for hour in range(24):
                k = hour * STEPS // 24
                if sun.elevation[k] >= 0.0:
                    at = self.place(sun.elevation[k], sun.azimuth[k])
                    self.canvas.dot(at, "#fff3c4", 2.0)
                    if hour % 3 == 0 and (month, day) == DAYS[0]:
                        towards = self.centre - at
                        at = at + 10.0 * self.canvas.zoom * towards / max(np.hypot(*towards), 1.0)
                        self.canvas.write(at, str(hour), 9, "mm", "#fff3c4")
