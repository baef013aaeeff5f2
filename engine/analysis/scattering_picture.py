"""Pictures of scattering: cuts through the plane of incidence, totals by incidence, measurements before and after."""

import math
from dataclasses import dataclass

import numpy as np
from PIL import Image

from ..photometry.spectra import GRID, luminous_efficiency
from ..scattering.data.evaluation import evaluate, total
from ..scattering.data.record import SIDES, ScatteringFile
from ..scattering.data.table import direct_share
from ..scattering.measuring.processing import ProcessedMeasurement
from ..scene.scattering import Scatter, ScatterTable
from .axes import Axes
from .canvas import Canvas, open_chart, to_pixels
from .polar_diagram import round_step

INCIDENCES = (0, 15, 30, 45, 60, 75)
"""Angles of incidence that are drawn. [degree]"""

CURVES = {
    False: ("#1d68b3", "#11968a", "#5b9a1f", "#d18b00", "#d0331f", "#8e3aa8"),
    True: ("#6cb6ff", "#3fd0c0", "#a3d65c", "#f2bd4a", "#ff7d60", "#d48cf0"),
}
"""Colours of curves, on a light and on a dark ground."""

STEEP = 20.0
"""Ratio of the largest value to the median from which the scale is logarithmic."""

MOST_DECADES = 5
"""Of a logarithmic scale."""

MOST_RINGS = 5
"""Of a linear scale."""

FINE, COARSE = math.radians(0.1), math.radians(0.5)
"""Steps of curves, near the mirror direction and elsewhere. [rad]"""

LITTLE = 5e-4
"""Share of light below which a direct part is not drawn."""

HEAD = "incidence"
"""Before the entries of legends."""

HORIZON = math.radians(89.5)
"""Curves end there."""

ANGLES_OF_TOTALS = np.radians(
    [0, 5, 10, 15, 20, 25, 30, 35, 40, 45, 50, 55, 60, 65, 70, 75, 80, 84, 87, 89]
)
"""Angles of incidence at which totals are computed. [rad]"""

NAMES = {
    "front_reflection": "reflection", "front_transmission": "transmission",
    "back_reflection": "reflection, back", "back_transmission": "transmission, back",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Cut:
    """A curve in the plane of incidence: angles to the normal, positive to the right of it [rad]; values [1/sr]."""

    incidence: float
    angles: np.ndarray
    values: np.ndarray
    is_below: bool
    direct: float
    colour: str


def polar_cuts(source, incidences_deg=INCIDENCES, side: str = "front", **options) -> np.ndarray:
    """Picture of `draw_polar_cuts`, whose options it takes, as Blender keeps images.

    Returns
    -------
    (h, w, 4) float32 array    Display-encoded RGBA 0..1, the bottom row first.
    """
    return to_pixels(draw_polar_cuts(source, incidences_deg, side, **options))


def albedo_chart(source, **options) -> np.ndarray:
    """Picture of `draw_albedo_chart`, whose options it takes, as Blender keeps images: (h, w, 4) float32."""
    return to_pixels(draw_albedo_chart(source, **options))


def draw_polar_cuts(
    source: ScatteringFile | dict[str, Scatter] | Scatter,
    incidences_deg=INCIDENCES,
    side: str = "front",
    size: tuple[int, int] = (640, 480),
    dark: bool = False,
    rotation: float = 0.0,
    title: str = "",
) -> Image.Image:
    """Draw scattering in the plane of incidence: light comes from the left, mirrors throw it to the right.

    Reflection goes up and transmission down, with the same scale. What is reflected as by a mirror or passes straight is a
    dashed ray with its share. Spectra count by the eye's sensitivity.

    Parameters
    ----------
    source : ScatteringFile, dict of str to Scatter by the names of `SIDES`, or Scatter
    incidences_deg : sequence    Angles of incidence. [degree]
    side : str
        ``front`` or ``back``, for what is there of both reflection and transmission, or one of `SIDES`. A Scatter without a
        name is taken to be that of the side.
    size : (int, int)    Width and height. [pixel]
    dark : bool    Light lines on a dark ground.
    rotation : float    Azimuth of incidence. [rad]
    title : str    Empty: the file's name.

    Returns
    -------
    Image    RGB.
    """
    shown = _shown_sides(source, side)
    canvas = open_chart(size, dark)
    cuts = []
    for number, degrees in enumerate(incidences_deg):
        colour = CURVES[dark][number % len(CURVES[dark])]
        incidence = math.radians(min(max(float(degrees), 0.0), 89.0))
        cuts += [_cut(name, shown[name], incidence, rotation, colour) for name in shown]
    name = title or (source.name if isinstance(source, ScatteringFile) else "")
    _PolarPlot(canvas, cuts).draw(name or _title(shown))
    return canvas.finish()


def _title(shown) -> str:
    return " and ".join(NAMES[name] for name in shown).capitalize()


def _shown_sides(source, side: str) -> dict[str, Scatter]:
    """Scatters that are drawn, by their names."""
    if side not in {"front", "back", *SIDES}:
        raise ValueError(f"no side of a surface: {side!r}")
    names = [name for name in SIDES if name == side or name.startswith(f"{side}_")]
    if isinstance(source, ScatteringFile):
        source = source.sides
    if not isinstance(source, dict):
        source = {names[0]: source}
    return {name: source[name] for name in names if source.get(name) is not None}


def luminous_mean(scatter_wavelengths, values) -> np.ndarray:
    """Mean of values (n, w) over wavelengths, linear in between, by the eye's sensitivity in even light. (n,)"""
    weight = luminous_efficiency()
    hats = np.stack(
        [np.interp(GRID, scatter_wavelengths, unit) for unit in np.eye(len(scatter_wavelengths))]
    )
    return np.asarray(values, dtype=np.float64) @ (hats @ weight / weight.sum())


def _cut(name, scatter, incidence, rotation, colour) -> _Cut:
    fine = incidence + np.arange(-4.0, 4.0 + 1e-9, math.degrees(FINE)) * math.pi / 180.0
    angles = np.concatenate([np.arange(-HORIZON, HORIZON, COARSE), fine, [HORIZON]])
    angles = np.unique(angles[np.abs(angles) <= HORIZON])
    wi = _in_plane(np.full(1, -incidence), rotation)
    wo = _in_plane(angles, rotation)
    values = evaluate(scatter, np.broadcast_to(wi, wo.shape), wo)
    direct = 0.0
    if isinstance(scatter, ScatterTable) and scatter.direct is not None:
        direct = float(luminous_mean(scatter.wavelengths, direct_share(scatter, wi))[0])
    mean = luminous_mean(scatter.wavelengths, values)
    return _Cut(incidence, angles, mean, "transmission" in name, direct, colour)


def _in_plane(angles, rotation: float) -> np.ndarray:
    """Directions at angles to the normal, positive away from where light comes from. (n, 3)"""
    sine = -np.sin(angles)
    return np.stack([sine * math.cos(rotation), sine * math.sin(rotation), np.cos(angles)], axis=1)


# ---- polar ----


@dataclass(frozen=True)
class _Scale:
    """What share of the radius a value takes: 0 at ``low``, 1 at ``high``; logarithmic where ``is_log``."""

    low: float
    high: float
    is_log: bool
    rings: tuple[float, ...]

    def place(self, value):
        if not self.is_log:
            return np.clip(np.asarray(value) / self.high, 0.0, 1.0)
        value = np.maximum(np.asarray(value), self.low)
        return np.clip(np.log(value / self.low) / math.log(self.high / self.low), 0.0, 1.0)


def _choose_scale(values: np.ndarray) -> _Scale:
    """A scale from 0, or a logarithmic one where a peak dwarfs everything else; its ends are round."""
    values = values[np.isfinite(values) & (values > 0.0)]
    top = float(values.max()) if len(values) else 1.0
    middle = float(np.median(values)) if len(values) else 1.0
    if top < STEEP * middle:
        step = round_step(top, MOST_RINGS)
        count = max(math.ceil(top / step - 1e-6), 1)
        return _Scale(0.0, count * step, False, tuple(step * k for k in range(1, count + 1)))
    low = max(0.6 * float(np.percentile(values, 2.0)), top * 10.0**-MOST_DECADES)
    powers = range(math.floor(math.log10(low)) - 1, math.ceil(math.log10(top)) + 2)
    rounds = [f * 10.0**power for power in powers for f in (1.0, 2.0, 5.0)]
    low = max(value for value in rounds if value <= low)
    high = min(value for value in rounds if value >= 0.999 * top)
    is_short = high < 120.0 * low
    rings = [
        value
        for number, value in enumerate(rounds)
        if low < value <= high * 1.001 and (is_short or number % 3 == 0 or value > 0.999 * high)
    ]
    return _Scale(low, high, True, tuple(rings))


def _number(value: float) -> str:
    if value >= 1e4 or value < 1e-3:
        power = math.floor(math.log10(value))
        return f"{value / 10.0**power:g}e{power}"
    return f"{value:.3g}"


class _PolarPlot:
    """Half a disk, or a whole one where something passes."""

    def __init__(self, canvas: Canvas, cuts: list[_Cut]):
        self.canvas, self.cuts = canvas, cuts
        self.halves = [False, True] if any(cut.is_below for cut in cuts) else [False]
        self.scale = _choose_scale(np.concatenate([cut.values for cut in cuts] or [np.ones(1)]))
        self.entries = self._entries()
        unit, (width, height) = canvas.zoom, canvas.size
        top = 66 * unit
        bottom = height - (30 + 17 * canvas.count_rows(self.entries, HEAD)) * unit
        # Room for the labels of the rim, or below the ground for those of the rings.
        count = len(self.halves)
        self.radius = max(min(0.5 * width - 42 * unit, (bottom - top - 12 * unit) / count), 10.0)
        spare = 0.5 * (bottom - top - 12 * unit - count * self.radius)
        self.centre = 0.5 * width, top + spare + self.radius

    def place(self, angle, share, is_below: bool):
        """Pixels (..., 2) of an angle to the normal, positive to the right, at a share of the radius."""
        sign = 1.0 if is_below else -1.0
        x = self.centre[0] + self.radius * share * np.sin(angle)
        y = self.centre[1] + sign * self.radius * share * np.cos(angle)
        return np.stack(np.broadcast_arrays(x, y), axis=-1)

    def draw(self, title: str) -> None:
        canvas = self.canvas
        for is_below in self.halves:
            self._draw_grid(is_below)
        for cut in self.cuts:
            self._draw_curve(cut)
        for cut in self.cuts:
            self._draw_light(cut)
        self._label_rings()
        unit = canvas.zoom
        canvas.write((18 * unit, 20 * unit), title, 17, "lm", room=canvas.size[0] - 36 * unit)
        kind = "logarithmic" if self.scale.is_log else "linear"
        what = f"in the plane of incidence, luminous mean, 1/sr, {kind}"
        if any(cut.direct > LITTLE for cut in self.cuts):
            what += "; dashed: shares mirrored or passed straight"
        room = canvas.size[0] - 36 * unit
        canvas.write((18 * unit, 40 * unit), what, 11, "lm", is_caption=True, room=room)
        canvas.legend(self.entries, HEAD)

    def _draw_grid(self, is_below: bool) -> None:
        canvas, colours = self.canvas, self.canvas.colours
        arc = np.linspace(-0.5 * math.pi, 0.5 * math.pi, 181)
        for ring in self.scale.rings:
            line = colours.axis if ring == self.scale.rings[-1] else colours.grid
            canvas.curve(self.place(arc, self.scale.place(ring), is_below), line)
        for degrees in range(-75, 90, 15):
            angle = math.radians(degrees)
            canvas.line(self.place(np.full(2, angle), np.array([0.0, 1.0]), is_below), colours.grid)
        canvas.line(self.place(np.zeros(2), np.array([0.0, 1.0]), is_below), colours.axis)
        ground = self.place(np.array([-0.5, 0.5]) * math.pi, np.ones(2), is_below)
        canvas.line(ground, colours.axis, 1.5)
        for degrees in range(-75, 90, 15):
            if degrees % 30 and self.radius < 130 * canvas.zoom:
                continue
            share = 1.0 + 13 * canvas.zoom / self.radius
            at = self.place(math.radians(degrees), share, is_below)
            canvas.write(at, f"{abs(degrees)}°", 10, "mm", is_caption=True)

    def _draw_curve(self, cut: _Cut) -> None:
        path = self.place(cut.angles, self.scale.place(cut.values), cut.is_below)
        self.canvas.curve(path, cut.colour, 2.0)
        if cut.direct > LITTLE:
            ray = self.place(np.full(2, cut.incidence), np.array([0.0, 1.0]), cut.is_below)
            self.canvas.dashed(ray, cut.colour, 1.4, (6, 4))
            self.canvas.dot(ray[1], cut.colour)

    def _draw_light(self, cut: _Cut) -> None:
        """An arrow at the rim from where light comes."""
        lengths = 1.0 + np.array([-6.0, -30.0]) * self.canvas.zoom / self.radius
        start, end = self.place(np.full(2, -cut.incidence), lengths, False)
        self.canvas.arrow(start, end, cut.colour)

    def _label_rings(self) -> None:
        """Values of the rings along the ground, as many as there is room for, the outermost first."""
        canvas, unit = self.canvas, self.canvas.zoom
        values = [*reversed(self.scale.rings), *([self.scale.low] if self.scale.is_log else [])]
        last = math.inf
        for value in values:
            x = self.centre[0] + self.radius * float(self.scale.place(value))
            if last - x < 32 * unit:
                continue
            last = x
            canvas.write((x, self.centre[1] + 9 * unit), _number(value), 10, "mm", has_halo=True)

    def _entries(self) -> list[tuple[str, str]]:
        """Colours and texts of the legend, the direct shares of each incidence behind it."""
        found: dict[float, tuple[str, list[str]]] = {}
        for cut in self.cuts:
            shares = found.setdefault(cut.incidence, (cut.colour, []))[1]
            if cut.direct > LITTLE:
                shares.append(f"{100.0 * cut.direct:.2g} %")
        return [
            (
                colour,
                f"{round(math.degrees(angle), 1):g}°"
                + (f" ({', '.join(shares)})" if shares else ""),
            )
            for angle, (colour, shares) in found.items()
        ]


# ---- cartesian ----


def draw_before_after(
    made: ProcessedMeasurement,
    size: tuple[int, int] = (720, 480),
    dark: bool = False,
    title: str = "Before and after smoothing",
) -> Image.Image:
    """Draw a measurement in the plane of incidence, as dots, and the table that was made of it, as lines.

    Parameters
    ----------
    made : ProcessedMeasurement
    size : (int, int)    Width and height. [pixel]
    dark : bool    Light lines on a dark ground.
    title : str

    Returns
    -------
    Image    RGB.
    """
    canvas = open_chart(size, dark)
    wavelengths = made.table.wavelengths
    lines = []
    for number, cut in enumerate(made.cuts):
        colour = CURVES[dark][number % len(CURVES[dark])]
        dots = np.degrees(cut.angles), _mean_of_measured(wavelengths, cut)
        line = np.degrees(cut.table_angles), luminous_mean(wavelengths, cut.table)
        lines.append((cut, colour, dots, line))
    values = np.concatenate([each for _, _, dots, line in lines for each in (dots[1], line[1])])
    values = values[np.isfinite(values) & (values > 0.0)]
    scale = _choose_scale(values)
    low = scale.low if scale.is_log else 0.0
    axes = Axes(canvas, (-90.0, 90.0), (low, scale.high), scale.is_log)
    levels = [low, *scale.rings] if scale.is_log else [0.0, *scale.rings]
    axes.draw(range(-90, 91, 30), levels, "outgoing angle, mirror directions on the right", _level)
    for cut, colour, _, _ in lines:
        at = axes.place(math.degrees(cut.incidence) * np.ones(2), np.array([low, scale.high]))
        canvas.dashed(at, colour, 0.8, (3, 4))
    for _, colour, _, (angle, value) in lines:
        canvas.curve(axes.place(angle, value), colour, 1.8)
    for _, colour, (angle, value), _ in lines:
        for degrees, found in zip(angle, value, strict=True):
            if np.isfinite(found) and found > 0.0:
                canvas.dot(axes.place(degrees, found), colour, 2.4)
    axes.title(
        title,
        f"1/sr, luminous mean; left out by smoothing {100.0 * made.residual:.2g} %, error by noise "
        f"{100.0 * made.statistical_error:.2g} %, filled {100.0 * made.missing:.2g} % of the values",
    )
    entries = [
        (colour, f"{round(math.degrees(cut.incidence), 1):g}°") for cut, colour, _, _ in lines
    ]
    canvas.legend(entries, HEAD)
    return canvas.finish()


def _mean_of_measured(wavelengths, cut) -> np.ndarray:
    """Luminous mean of measured values; bands with holes stand in the ratio that the others have to the table. (n,)"""
    table = np.stack(
        [np.interp(cut.angles, cut.table_angles, band) for band in cut.table.T], axis=1
    )
    known = np.isfinite(cut.measured)
    mean = luminous_mean(wavelengths, np.where(known, cut.measured, 0.0))
    expected = luminous_mean(wavelengths, np.where(known, table, 0.0))
    ratio = mean / np.where(expected > 0.0, expected, np.nan)
    return ratio * luminous_mean(wavelengths, table)


def _level(value: float) -> str:
    return "0" if value == 0.0 else _number(value)


def draw_albedo_chart(
    source: ScatteringFile | dict[str, Scatter] | Scatter,
    side: str = "front",
    size: tuple[int, int] = (640, 480),
    dark: bool = False,
    title: str = "",
) -> Image.Image:
    """Draw what share of light is reflected and transmitted in all, by the angle of incidence; direct parts included.

    Totals that the file states are dots.

    Parameters
    ----------
    source : ScatteringFile, dict of str to Scatter by the names of `SIDES`, or Scatter
    side, size, dark, title    As of `draw_polar_cuts`.

    Returns
    -------
    Image    RGB.
    """
    shown = _shown_sides(source, side)
    canvas = open_chart(size, dark)
    curves = [
        (name, CURVES[dark][0 if "reflection" in name else 4], _totals(scatter))
        for name, scatter in shown.items()
    ]
    summed = sum((values for _, _, values in curves), np.zeros(len(ANGLES_OF_TOTALS)))
    top = max(1.0, math.ceil(float(summed.max()) * 10.0 - 1e-3) / 10.0)
    axes = Axes(canvas, (0.0, 90.0), (0.0, top), False)
    step = 0.2 if top <= 1.4 else round_step(top, MOST_RINGS)
    levels = np.arange(0.0, top + 1e-6, step)
    axes.draw(
        range(0, 91, 15), levels, "angle of incidence", lambda level: f"{100.0 * level:.0f} %"
    )
    canvas.line(axes.place(np.array([0.0, 90.0]), np.ones(2)), canvas.colours.axis, 1.5)
    degrees = np.degrees(ANGLES_OF_TOTALS)
    entries = [(colour, NAMES[name]) for name, colour, _ in curves]
    if len(curves) > 1:
        canvas.dashed(axes.place(degrees, summed), canvas.colours.text, 1.6, (7, 5))
        entries.append((canvas.colours.text, "sum"))
    for _, colour, values in curves:
        canvas.curve(axes.place(degrees, values), colour, 2.2)
    if isinstance(source, ScatteringFile):
        for name, colour, _ in curves:
            stated = np.asarray(source.stated.get(name, np.zeros(0)))
            for angle, value in zip(np.degrees(source.incidences), stated, strict=False):
                if np.isfinite(value):
                    canvas.dot(axes.place(angle, value), colour, 3.2)
    name = title or (source.name if isinstance(source, ScatteringFile) else "")
    worst = f"at most {100.0 * float(summed.max()):.3g} % of the light leaves the surface"
    axes.title(name or _title(shown), f"luminous mean; {worst}")
    canvas.legend(entries)
    return canvas.finish()


def _totals(scatter: Scatter) -> np.ndarray:
    """Luminous share of light that is sent away, at `ANGLES_OF_TOTALS`."""
    found = np.stack([total(scatter, angle) for angle in ANGLES_OF_TOTALS])
    return luminous_mean(scatter.wavelengths, found)
