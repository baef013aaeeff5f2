"""Picture of an intensity distribution as data sheets show it: polar, or cartesian for narrow beams."""

import math
from dataclasses import dataclass, replace

import numpy as np
from PIL import Image, ImageDraw

from ..luminaires.coordinates import angles, directions
from ..luminaires.distribution import flux, peak
from ..luminaires.formats.record import LUMINOUS, UNITS, LuminaireFile
from ..luminaires.sections import section, spread
from ..scene.distribution import IntensityDistribution
from .canvas import DARK, LIGHT, SCALE, Canvas, to_pixels

NARROW = math.radians(30.0)
"""Widest field for which the kind ``auto`` is cartesian. [rad]"""

BASE = 512
"""Shorter side of a picture whose lines and letters have their nominal size. [pixel]"""

ALIKE = 0.005
"""Difference, of the peak, under which the curves of both planes are drawn as one."""

OUTSHINES = 1.02
"""Ratio of the peak to the largest intensity of both planes from which the plane of the peak is drawn as well."""

MOST_LINES = 6
"""Most lines of round intensities up to the peak."""

FILL = 28
"""Opacity of the inside of a curve, of 255."""

FAINT = 0.01
"""Share of the peak under which the tails of a beam are left out of a cartesian diagram."""


@dataclass(frozen=True, eq=False)
class Curve:
    """Intensity in a plane.

    Parameters
    ----------
    name : str
    angle : (n,) array    From the luminaire's -z, ascending from -pi to pi, positive to the right. [rad]
    values : (n,) array    [cd] or [cd/klm]
    colour : str
    is_dashed : bool
    """

    name: str
    angle: np.ndarray
    values: np.ndarray
    colour: str
    is_dashed: bool = False


@dataclass(frozen=True)
class PolarAxes:
    """Where intensities lie in a polar diagram: gamma 0 down. ``pole`` [pixel], ``scale`` [pixel per unit]."""

    pole: tuple[float, float]
    scale: float

    def place(self, angle, value):
        """Pixel (x, y) of an angle [rad] and an intensity."""
        reach = self.scale * value
        return self.pole[0] + reach * np.sin(angle), self.pole[1] + reach * np.cos(angle)


@dataclass(frozen=True)
class CartesianAxes:
    """Where intensities lie in a cartesian diagram: angles ``low`` to ``high`` [rad] across, 0 to ``top`` upwards.

    ``centre`` is 0, or pi for a luminaire that shines upwards; angles count from it. ``window`` is in pixels.
    """

    window: tuple[float, float, float, float]
    low: float
    high: float
    top: float
    centre: float

    def place(self, angle, value):
        """Pixel (x, y) of an angle [rad] from the luminaire's -z and an intensity."""
        left, top, right, bottom = self.window
        across = (_from_centre(angle, self.centre) - self.low) / (self.high - self.low)
        return left + across * (right - left), bottom - value / self.top * (bottom - top)


def draw_polar_diagram(
    source: LuminaireFile | IntensityDistribution,
    size: tuple[int, int] = (512, 512),
    dark: bool = False,
    kind: str = "auto",
    per_klm: bool = False,
) -> Image.Image:
    """Draw the planes C0-C180 (solid) and C90-C270 (dashed); that of the peak as well, where it lies in neither.

    Parameters
    ----------
    source : LuminaireFile or IntensityDistribution
    size : (int, int)    Width and height. [pixel]
    dark : bool    Light lines on a dark ground.
    kind : str    ``polar``, ``cartesian`` or ``auto``: cartesian for fields narrower than `NARROW`, else polar.
    per_klm : bool    Intensities for 1000 lm of the lamps, or of the luminaire in absolute photometry.

    Returns
    -------
    Image    RGB.
    """
    return _Diagram(source, size, DARK if dark else LIGHT, kind, per_klm).draw()


def diagram_pixels(source, **options) -> np.ndarray:
    """Picture of `draw_polar_diagram`, whose options it takes, as Blender keeps images.

    Returns
    -------
    (h, w, 4) float32 array    Display-encoded RGBA 0..1, the bottom row first.
    """
    return to_pixels(draw_polar_diagram(source, **options))


def round_step(largest: float, most: int) -> float:
    """Round distance (1, 2, 2.5 or 5 times a power of ten) of at most so many lines up to the largest value."""
    power = 10.0 ** math.floor(math.log10(largest / most))
    return next(
        f * power for f in (1.0, 2.0, 2.5, 5.0, 10.0) if f * power * most >= largest * 0.999
    )


def _from_centre(angle, centre: float):
    """Angle in -pi..pi counted from a centre; half a turn keeps its sign about a centre of 0."""
    return np.asarray(angle) if centre == 0.0 else np.mod(angle, 2.0 * np.pi) - centre


def _number(value: float) -> str:
    """Four digits or more, thousands set off by blanks."""
    if value >= 1000.0:
        return f"{value:,.0f}".replace(",", " ")
    return f"{value:.3g}"


def _degrees(angle: float) -> str:
    return f"{round(math.degrees(angle), 1):g}°"


class _Diagram(Canvas):
    """The picture under way."""

    def __init__(self, source, size, colours, kind, per_klm):
        super().__init__(size, colours, max(min(size) / BASE, 0.6))
        is_file = isinstance(source, LuminaireFile)
        self.distribution = source.distribution if is_file else source
        self.flux = flux(self.distribution)
        units = source.units if is_file else UNITS[LUMINOUS]
        rated = source.stated_flux if is_file and source.stated_flux else self.flux
        self.factor = 1000.0 / rated if per_klm and rated > 0.0 else 1.0
        self.unit = f"{units.intensity}/k{units.flux}" if per_klm else units.intensity
        self.flux_unit = units.flux
        self.largest, azimuth, polar = peak(self.distribution)
        self.towards = angles(directions(azimuth, polar, self.distribution.frame))
        planes = [self._curve(azimuth, i) for i, azimuth in enumerate((0.0, 0.5 * math.pi))]
        self.beams = [spread(curve.angle, curve.values, 0.5) for curve in planes]
        self.fields = [spread(curve.angle, curve.values, 0.1) for curve in planes]
        self.curves = self._shown(planes)
        if kind == "auto":
            widest = max((field for field in self.fields if field is not None), default=math.pi)
            kind = "cartesian" if widest < NARROW else "polar"
        self.kind = kind

    def _curve(self, azimuth: float, number: int) -> Curve:
        """Plane whose half at an azimuth of 0 to 180 degrees lies on the right."""
        angle, values = section(self.distribution, azimuth)
        name = f"C{_degrees(azimuth)[:-1]}-C{_degrees(azimuth + math.pi)[:-1]}"
        return Curve(name, angle, values * self.factor, self.colours.curves[number], number == 1)

    def _shown(self, planes) -> list[Curve]:
        """Both planes, or one curve for both if they are alike; and that of the peak, if it lies in neither."""
        first, second = planes
        top = max(first.values.max(), second.values.max())
        other = np.interp(first.angle, second.angle, second.values)
        curves = planes
        if np.abs(other - first.values).max() <= ALIKE * top:
            curves = [replace(first, name=f"{first.name}, {second.name}")]
        if self.largest * self.factor > OUTSHINES * top:
            curves = [*curves, self._curve(float(np.mod(self.towards[0], math.pi)), 2)]
        return curves

    def draw(self) -> Image.Image:
        """Draw everything and return the picture in its size."""
        if self.kind == "polar":
            self._draw_polar()
        else:
            self._draw_cartesian()
        self._write_title()
        self._write_legend()
        return self.finish()

    # ---- polar ----

    def _draw_polar(self) -> None:
        left, top, right, bottom = self.window
        axes, largest = self._polar_axes()
        x, y = axes.pole
        corner = max(math.hypot(a - x, b - y) for a in (left, right) for b in (top, bottom))
        step = round_step(largest, MOST_LINES)
        circles = np.arange(1, int(corner / axes.scale / step) + 1) * step
        for value in circles:
            self._circle(axes.pole, axes.scale * value, self.colours.grid)
        for angle in np.deg2rad(np.arange(0.0, 360.0, 15.0)):
            far = (x + corner * math.sin(angle), y + corner * math.cos(angle))
            self.line([axes.pole, far], self.colours.grid)
        for far in ((x - corner, y), (x + corner, y), (x, y - corner), (x, y + corner)):
            self.line([axes.pole, far], self.colours.axis)
        self._draw_curves(axes, lambda _: np.array(axes.pole)[:, None])
        self._clear_margins()
        self._label_rays(axes)
        self._label_circles(axes, circles)
        self._write_sides()

    def _polar_axes(self) -> tuple[PolarAxes, float]:
        """Axes in which all curves fit into the window with some room around, and the largest intensity."""
        left, top, right, bottom = self.window
        largest = max(float(c.values.max()) for c in self.curves) or 1.0
        down = max(float((c.values * np.cos(c.angle)).max()) for c in self.curves)
        up = max(float((-c.values * np.cos(c.angle)).max()) for c in self.curves)
        side = max(float(np.abs(c.values * np.sin(c.angle)).max()) for c in self.curves)
        # Room for the pole's surroundings, also where nothing shines.
        down, up = max(down, 0.15 * largest), max(up, 0.15 * largest)
        room = 1.12
        scale = min(
            (bottom - top) / (room * (up + down)), (right - left) / (room * 2.0 * side or 1.0)
        )
        middle = 0.5 * (top + bottom) + 0.5 * scale * (up - down)
        return PolarAxes((0.5 * (left + right), middle), scale), largest

    def _label_circles(self, axes, circles) -> None:
        """Write the values beside the vertical, on the outside of beams that are narrower than the words."""
        unit = self.zoom
        paths = np.concatenate([self._path(axes, curve) for curve in self.curves])
        for value in circles:
            radius = axes.scale * value
            aside = paths[:, 0] - axes.pole[0]
            near = np.abs(paths[:, 1] - axes.pole[1] - radius) < 7 * unit
            flank = aside[near & (aside > 0.0) & (aside < 40 * unit)].max(initial=0.0)
            if flank > 34 * unit or flank > radius:
                flank = 0.0
            place = (axes.pole[0] + flank, axes.pole[1] + math.sqrt(radius**2 - flank**2))
            if place[1] < self.window[3] - 4 * unit:
                self.write((place[0] + 4 * unit, place[1]), _number(value), 11, "lm", has_halo=True)

    def _label_rays(self, axes) -> None:
        """Write the angle of each ray where it leaves the window, the rounder first if there is no room for all."""
        left, top, right, bottom = self.window
        x, y = axes.pole
        gap = 5 * self.zoom
        taken: list[tuple[float, float]] = []
        rays = range(-165, 181, 15)
        for degrees in sorted(rays, key=lambda d: (d % 90 != 0, d % 30 != 0)):
            sine, cosine = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
            across = ((right - x) if sine > 0 else (x - left)) / max(abs(sine), 1e-12)
            along = ((bottom - y) if cosine > 0 else (y - top)) / max(abs(cosine), 1e-12)
            reach = min(across, along)
            place = (x + reach * sine, y + reach * cosine)
            if any(math.dist(place, other) < 30 * self.zoom for other in taken):
                continue
            taken.append(place)
            if across < along:
                anchor, shift = ("lm", (gap, 0.0)) if sine > 0 else ("rm", (-gap, 0.0))
            else:
                anchor, shift = ("mt", (0.0, gap)) if cosine > 0 else ("mb", (0.0, -gap))
            text = f"{abs(degrees)}°"
            self.write((place[0] + shift[0], place[1] + shift[1]), text, 11, anchor)

    # ---- cartesian ----

    def _draw_cartesian(self) -> None:
        left, top, right, bottom = self.window
        axes, largest = self._cartesian_axes()
        step = round_step(largest, MOST_LINES)
        levels = [
            (value, float(axes.place(axes.centre, value)[1]))
            for value in np.arange(0.0, axes.top + 1e-9 * step, step)
        ]
        for _, y in levels:
            self.line([(left, y), (right, y)], self.colours.grid)
        step = math.radians(max(round_step(math.degrees(axes.high - axes.low), 12), 0.1))
        ticks = np.arange(
            math.ceil(axes.low / step - 1e-9), math.floor(axes.high / step + 1e-9) + 1
        )
        for tick in ticks * step:
            x = left + (tick - axes.low) / (axes.high - axes.low) * (right - left)
            colour = self.colours.axis if abs(tick) < 1e-9 else self.colours.grid
            self.line([(x, top), (x, bottom)], colour)
        for share in (0.5, 0.1):
            y = float(axes.place(axes.centre, share * largest)[1])
            self.dashed(np.array([[left, y], [right, y]]), self.colours.caption, 0.8, (2, 3))
        self._draw_curves(axes, lambda angle: axes.place(angle, 0.0))
        self._clear_margins()
        gap = 4 * self.zoom
        for tick in ticks * step:
            x = left + (tick - axes.low) / (axes.high - axes.low) * (right - left)
            gamma = tick if axes.centre == 0.0 else math.pi - abs(tick)
            self.write((x, bottom + gap), _degrees(gamma), 11, "mt")
        for value, y in levels[1:]:
            if y > top + 2 * gap:
                self.write((left + gap, y), _number(value), 11, "lm", has_halo=True)
        for share in (0.5, 0.1):
            y = float(axes.place(axes.centre, share * largest)[1])
            self.write(
                (right - gap, y), f"{100 * share:.0f} %", 11, "rm", is_caption=True, has_halo=True
            )
        self._write_sides()

    def _cartesian_axes(self) -> tuple[CartesianAxes, float]:
        """Axes that show all angles with more than a faint intensity, and the largest intensity."""
        largest = max(float(c.values.max()) for c in self.curves) or 1.0
        brightest = max(self.curves, key=lambda c: c.values.max())
        top = brightest.angle[np.argmax(brightest.values)]
        centre = 0.0 if abs(top) <= 0.5 * math.pi else math.pi
        seen = [_from_centre(c.angle[c.values > FAINT * largest], centre) for c in self.curves]
        seen = np.concatenate(seen)
        low, high = (float(seen.min()), float(seen.max())) if len(seen) else (-1.0, 1.0)
        # A beam along the axis is shown with its axis in the middle.
        if low * high < 0.0 and min(-low, high) > 0.5 * max(-low, high):
            low, high = min(low, -high), max(high, -low)
        room = 0.04 * (high - low) + math.radians(0.2)
        step = round_step(largest, MOST_LINES)
        top = step * math.ceil(1.04 * largest / step)
        return CartesianAxes(self.window, low - room, high + room, top, centre), largest

    # ---- both ----

    @property
    def window(self) -> tuple[float, float, float, float]:
        """Left, top, right and bottom of the part in which curves are drawn."""
        unit = self.zoom
        return 40 * unit, 64 * unit, self.size[0] - 40 * unit, self.size[1] - 56 * unit

    def _draw_curves(self, axes, ground) -> None:
        """Fill the curves lightly, draw them, and mark the peak. ``ground(angle)``: pixel of an intensity of 0."""
        for curve in self.curves:
            self._fill(self._path(axes, curve, ground), curve.colour)
        for curve in reversed(self.curves):
            path = self._path(axes, curve)
            if curve.is_dashed:
                self.dashed(path, curve.colour, 2.0, (7, 5))
            else:
                self.line(path, curve.colour, 2.0)
        brightest = max(self.curves, key=lambda curve: curve.values.max())
        if self.largest > 0.0:
            # Of several alike the one nearest to the nadir, and of two sides the right one.
            alike = np.flatnonzero(brightest.values >= brightest.values.max() * (1.0 - 1e-6))
            at = brightest.angle[alike]
            i = alike[np.lexsort((at < 0.0, np.round(np.abs(at), 9)))[0]]
            place = axes.place(brightest.angle[i], brightest.values[i])
            self.dot(place, brightest.colour, 4.5, self.colours.background)

    @staticmethod
    def _path(axes, curve, ground=None) -> np.ndarray:
        """Pixels of a curve (n, 2), closed by its ground if that is given."""
        angle, values = curve.angle, curve.values
        if isinstance(axes, CartesianAxes) and axes.centre:
            order = np.argsort(_from_centre(angle, axes.centre), kind="stable")
            angle, values = angle[order], values[order]
        path = np.stack(np.broadcast_arrays(*axes.place(angle, values)), axis=1)
        if ground is None:
            return path
        return np.concatenate([path, np.stack(np.broadcast_arrays(*ground(angle[::-1])), axis=1)])

    def _write_title(self) -> None:
        """Flux, peak, and the angles of the beam in both planes."""
        left, _, right, _ = self.window
        unit = self.zoom
        end = self.write((left, 16 * unit), f"{_number(self.flux)} {self.flux_unit}", 18, "lm")
        around, gamma = self.towards
        where = f"gamma {_degrees(gamma)}"
        if 1e-6 < gamma < math.pi - 1e-6:
            where = f"C {_degrees(around)}  {where}"
        peak_text = f"{_number(self.largest * self.factor)} {self.unit}"
        text = f"peak {peak_text} at {where}"
        if end + self.measure(text, 13) > right - 4 * unit:
            # Letters have a least size, so in a small picture both would meet.
            text = f"peak {peak_text}"
        self.write((right, 17 * unit), text, 13, "rm")
        for name, spreads, place, anchor in (
            ("beam", self.beams, left, "lm"),
            ("field", self.fields, right, "rm"),
        ):
            words = ["none" if angle is None else _degrees(angle) for angle in spreads]
            text = " x ".join(words[:1] if words[0] == words[1] else words)
            self.write((place, 35 * unit), f"{name} {text}", 12, anchor, is_caption=True)

    def _write_legend(self) -> None:
        """A piece of each curve and its name below the window, the unit on the right."""
        left, _, right, _ = self.window
        unit = self.zoom
        x, y = left, self.size[1] - 18 * unit
        for curve in self.curves:
            stroke = np.array([[x, y], [x + 24 * unit, y]])
            if curve.is_dashed:
                self.dashed(stroke, curve.colour, 2.5, (7, 5))
            else:
                self.line(stroke, curve.colour, 2.5)
            x = self.write((x + 30 * unit, y), curve.name, 12, "lm") + 18 * unit
        self.write((right, y), self.unit, 12, "rm", is_caption=True)

    def _write_sides(self) -> None:
        """Say which half-planes lie on which side."""
        left, top, right, _ = self.window
        gap = 6 * self.zoom
        self.write((left + gap, top + gap), "C180, C270", 11, "lt", is_caption=True, has_halo=True)
        self.write((right - gap, top + gap), "C0, C90", 11, "rt", is_caption=True, has_halo=True)

    # ---- more of the pen ----

    def _circle(self, centre, radius: float, colour: str) -> None:
        (x, y), r = (SCALE * c for c in centre), SCALE * radius
        self.pen.ellipse(
            [x - r, y - r, x + r, y + r], outline=colour, width=round(self.zoom * SCALE)
        )

    def _fill(self, path: np.ndarray, colour: str) -> None:
        mask = Image.new("L", self.image.size)
        ImageDraw.Draw(mask).polygon([(x * SCALE, y * SCALE) for x, y in path], fill=FILL)
        self.image.paste(colour, (0, 0), mask)

    def _clear_margins(self) -> None:
        """Wipe what was drawn outside the window, and frame it."""
        left, top, right, bottom = (round(edge * SCALE) for edge in self.window)
        width, height = self.image.size
        for box in (
            (0, 0, width, top),
            (0, bottom, width, height),
            (0, 0, left, height),
            (right, 0, width, height),
        ):
            self.pen.rectangle(box, self.colours.background)
        line = round(self.zoom * SCALE)
        self.pen.rectangle((left, top, right, bottom), outline=self.colours.axis, width=line)
