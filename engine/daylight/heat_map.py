"""A year of hourly values as a picture: days across, hours of the clock up, and when the sun rises and sets."""

import calendar
from datetime import date, datetime

import numpy as np
from PIL import Image

from ..analysis.canvas import SCALE, Canvas, open_chart
from ..analysis.colour_scale import WIDTH, ColourScale, nice_scale
from ..errors import SceneError
from ..reading.printable import printable
from ..sky.place import Place, from_local, to_local
from ..sky.solar_position import HORIZON, find_sun

HOUR_STEP = 3
"""Between numbers of hours. [h]"""


def draw_heat_map(
    values,
    times,
    place: Place,
    title: str,
    scale: ColourScale | None = None,
    unit: str = "lx",
    interval: float = 1.0,
    size: tuple[int, int] = (960, 440),
    dark: bool = False,
) -> Image.Image:
    """Draw a value of every interval of a year.

    Parameters
    ----------
    values : (n,) array    NaN leaves an interval empty, as those are that the year lacks.
    times : (n,) array    Middles of the intervals, universal time since 1970, as `weather.find_middles` gives them. [s]
    place : Place    Whose sun and whose clocks.
    title : str
    scale : ColourScale or None    None: from 0 to a round number of ``unit``.
    unit : str
    interval : float    An hour at most. [h]
    size : (int, int)    Width and height. [pixel]
    dark : bool    Light letters on a dark ground.

    Returns
    -------
    Image    RGB.

    Raises
    ------
    SceneError    Values and times are not as many, or there are none.
    """
    values, times = np.asarray(values, dtype=np.float64), np.asarray(times, dtype=np.float64)
    if values.shape != times.shape or values.ndim != 1 or not len(values):
        raise SceneError(f"a year of {times.size} hours has {values.size} values, expected as many")
    clocks = [to_local(time, place.zone) for time in times]
    days = _list_days(clocks)
    scale = scale or nice_scale(values, unit)
    canvas = open_chart(size, dark)
    pixel, (width, height) = canvas.zoom, canvas.size
    window = (
        50 * pixel,
        68 * pixel,
        width - (20 + WIDTH) * pixel,
        height - 66 * pixel,
    )
    grid = arrange(values, clocks, days, interval)
    _paint(canvas, window, scale.colours(grid), np.isfinite(grid))
    _draw_frame(canvas, window, days, place.zone)
    _draw_sun(canvas, window, days, place)
    scale.draw_bar(canvas, window[2] + 14 * pixel, window[1], window[3])
    room = width - 36 * pixel
    canvas.write((18 * pixel, 20 * pixel), printable(title), 17, "lm", room=room)
    canvas.write((18 * pixel, 40 * pixel), _caption(values, scale.unit), 11, "lm", is_caption=True)
    canvas.legend([(canvas.colours.text, "sunrise and sunset")])
    return canvas.finish()


def _caption(values, unit: str) -> str:
    known = values[np.isfinite(values)]
    if not len(known):
        return "no hour has a value"
    missing = f"; {len(values) - len(known)} missing" if len(known) < len(values) else ""
    return f"mean {known.mean():.4g}, highest {known.max():.4g} {unit}, of {len(values)} hours{missing}"


def _list_days(clocks) -> list[date]:
    """Days of the year in their order, each in the year in which its records are."""
    found = {(clock.month, clock.day): clock.date() for clock in reversed(clocks)}
    common = clocks[len(clocks) // 2].year
    kind = 2000 if (2, 29) in found else 2001
    return [
        found.get((month, day)) or date(common, month, day)
        for month in range(1, 13)
        for day in range(1, calendar.monthrange(kind, month)[1] + 1)
    ]


def arrange(values, clocks, days, interval: float) -> np.ndarray:
    """Return values by the hour of the clock, from midnight up, and by the day.

    Parameters
    ----------
    values : (n,) array
    clocks : (n,) sequence of datetime    Middles of the intervals.
    days : sequence of date    Of the columns, told apart by month and day.
    interval : float    [h]

    Returns
    -------
    (rows, days) float64 array    Means of what falls into one cell, as it does where clocks are put back; NaN: nothing.
    """
    column = {(day.month, day.day): i for i, day in enumerate(days)}
    rows = max(round(24.0 / interval), 1)
    sums, counts = np.zeros((rows, len(days))), np.zeros((rows, len(days)))
    for value, clock in zip(values, clocks, strict=True):
        if np.isfinite(value):
            hour = clock.hour + clock.minute / 60.0 + clock.second / 3600.0
            place = min(int(hour / 24.0 * rows), rows - 1), column[clock.month, clock.day]
            sums[place] += value
            counts[place] += 1
    return np.divide(sums, counts, out=np.full(sums.shape, np.nan), where=counts > 0)


def _paint(canvas: Canvas, window, colours: np.ndarray, shown: np.ndarray) -> None:
    """Fill the window with cells; row 0 of the colours is the lowest."""
    left, top, right, bottom = (round(edge * SCALE) for edge in window)
    cells = np.where(shown[..., None], colours, _rgb(canvas.colours.grid)).astype(np.uint8)
    picture = Image.fromarray(np.ascontiguousarray(cells[::-1]))
    canvas.image.paste(
        picture.resize((right - left, bottom - top), Image.Resampling.NEAREST), (left, top)
    )


def _rgb(colour: str) -> tuple[int, int, int]:
    return tuple(int(colour[i : i + 2], 16) for i in (1, 3, 5))


def _place(window, share, hour) -> np.ndarray:
    """Pixels (..., 2) of a share of the year and an hour."""
    left, top, right, bottom = window
    x = left + np.asarray(share) * (right - left)
    y = bottom - np.asarray(hour) / 24.0 * (bottom - top)
    return np.stack(np.broadcast_arrays(x, y), axis=-1)


def _draw_frame(canvas: Canvas, window, days, zone: str) -> None:
    colours, pixel = canvas.colours, canvas.zoom
    left, top, right, bottom = window
    count = len(days)
    for month in range(1, 13):
        inside = [i for i, day in enumerate(days) if day.month == month]
        if month > 1:
            canvas.line(
                _place(window, inside[0] / count, np.array([0.0, 24.0])), colours.caption, 0.5
            )
        middle = 0.5 * (inside[0] + inside[-1] + 1) / count
        x = float(_place(window, middle, 0.0)[0])
        canvas.write((x, bottom + 12 * pixel), calendar.month_abbr[month], 10, "mm")
    for hour in range(0, 25, HOUR_STEP):
        y = float(_place(window, 0.0, hour)[1])
        if 0 < hour < 24:
            canvas.line([(left, y), (right, y)], colours.caption, 0.5)
        canvas.write((left - 6 * pixel, y), f"{hour} h", 10, "rm")
    edge = [(left, top), (right, top), (right, bottom), (left, bottom), (left, top)]
    canvas.line(edge, colours.axis)
    canvas.write((left, top - 11 * pixel), f"clock of {zone}", 11, "lm", is_caption=True)


def find_sun_hours(days, place: Place) -> np.ndarray:
    """Return when the sun rises, passes the meridian and sets, by the clocks of a place.

    Parameters
    ----------
    days : sequence of date
    place : Place

    Returns
    -------
    (days, 3) array    By the closed form for a sun whose declination is that of noon, within some minutes beside the polar
        circles and less than one elsewhere; NaN where it does not rise or set. [h]
    """
    noons = np.array(
        [from_local(datetime(d.year, d.month, d.day, 12), place.zone).seconds for d in days]
    )
    sun = find_sun(noons, place)
    noon = 12.0 + (12.0 - sun.solar_time)
    phi, delta = np.radians(place.latitude), np.radians(sun.declination)
    cosine = (np.sin(np.radians(HORIZON)) - np.sin(phi) * np.sin(delta)) / np.maximum(
        np.cos(phi) * np.cos(delta), 1e-12
    )
    half = np.degrees(np.arccos(np.where(np.abs(cosine) <= 1.0, cosine, np.nan))) / 15.0
    return np.stack([noon - half, noon, noon + half], axis=1)


def _draw_sun(canvas: Canvas, window, days, place: Place) -> None:
    middle = (np.arange(len(days)) + 0.5) / len(days)
    for hours in find_sun_hours(days, place)[:, [0, 2]].T:
        # Clocks far from the sun's time have its set after midnight; that part is left out.
        inside = np.flatnonzero((hours >= 0.0) & (hours <= 24.0))
        for piece in np.split(inside, np.flatnonzero(np.diff(inside) > 1) + 1):
            if len(piece) > 1:
                path = _place(window, middle[piece], hours[piece])
                canvas.line(path, canvas.colours.background, 3.0)
                canvas.line(path, canvas.colours.text, 1.4)
