"""A picture of the surroundings as Mitsuba's emitter: evaluated as `picture` defines it, sampled in proportion to it."""

from dataclasses import replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ..arrays import upload
from ..photometry.spectra import GRID, illuminant, luminous_efficiency
from .far_light import far_light_class
from .picture import ROWS_AT_ONCE, WHITE, Grid, clean, find_luminances, find_mean, grid_of

COARSE = 2
"""Step of the sums that find the luminance of a pixel's smooth spectrum. [nm]"""

LEAST_PLAN = 1e-12
"""Directions nearer to the axis than this are taken as that near. [-]"""


def register() -> None:
    """Register the plug-in with the active Mitsuba variant. Doing it again is harmless."""
    made = _picture_class()
    mi.register_emitter("lumenray_picture", lambda props, made=made: made(props))


def make_picture(image, radiance: dict) -> tuple[object, float] | None:
    """Return the emitter of a picture and its mean luminance, with values as luminances in cd/m2; None if it is black.

    Parameters
    ----------
    image : ImageTexture
    radiance : dict    Texture of a luminance of 1 cd/m2 with the spectrum of `WHITE`.
    """
    grid = grid_of(image)
    pixels = clean(image.pixels)
    if grid.height == 1:
        # A band from pole to pole would have no cosine.
        pixels = np.repeat(pixels, 2, axis=0)
        grid = replace(grid, height=2)
    luminances = find_luminances(pixels)
    if luminances.max(initial=0.0) <= 0.0:
        return None
    emitter = mi.load_dict({"type": "lumenray_picture", "radiance": radiance})
    emitter.set_picture(luminances, grid, make_colours(pixels, luminances))
    return emitter, find_mean(luminances, grid)


# ---- tables ----


def share_bands(luminances: np.ndarray, grid: Grid) -> tuple[np.ndarray, np.ndarray, float]:
    """Sampling of the bands.

    Returns
    -------
    rows : (height,) float64 array    Mean luminance of each row.
    shares : (bands,) float64 array    Probability of each band. Sum 1.
    total : float    Integral of luminance times cosine of elevation, linear within bands, over u [-] and v [row].
    """
    rows = luminances.mean(axis=1, dtype=np.float64)
    low, high = rows[grid.lower], rows[grid.upper]
    narrow, wide = (np.sin(np.pi * each / grid.height) for each in (grid.start, grid.end))
    mass = low * (2.0 * narrow + wide) + high * (narrow + 2.0 * wide)
    mass *= (grid.end - grid.start) / 6.0
    return rows, mass / mass.sum(), float(mass.sum())


def accumulate_columns(luminances: np.ndarray, grid: Grid) -> np.ndarray:
    """Cumulative share of each step from column to column in its row. (height, width) float32, the last ones 1"""
    made = np.empty(luminances.shape, dtype=np.float32)
    for i in range(0, len(luminances), ROWS_AT_ONCE):
        part = luminances[i : i + ROWS_AT_ONCE].astype(np.float64)
        part += np.roll(part, -grid.step, axis=1)
        part[part.sum(axis=1) <= 0.0] = 1.0
        sums = np.cumsum(part, axis=1)
        made[i : i + ROWS_AT_ONCE] = sums / sums[:, -1:]
    made[:, -1] = 1.0
    return made


def make_colours(pixels: np.ndarray, luminances: np.ndarray):
    """Smooth spectra of coloured pixels, in variants with wavelengths.

    Returns
    -------
    (4 height width,) Float or None
        Three coefficients of a sigmoid and the luminance over that of the spectrum that they give under `WHITE`, so that no
        luminance is lost in the fit. None where only luminances count.
    """
    if not mi.is_spectral or pixels.shape[2] == 1:
        return None
    height, width = luminances.shape
    largest = pixels.max(axis=2, keepdims=True)
    # At half of the gamut's height the spectra are smooth.
    colours = 0.5 * pixels / np.maximum(largest, 1e-38)
    texture = mi.load_dict({"type": "bitmap", "bitmap": mi.Bitmap(colours), "format": "variant"})
    # Mitsuba makes pictures of a single row or column larger.
    found = mi.traverse(texture)["data"]
    index = dr.arange(mi.UInt32, height * width)
    start = ((index // width) * found.shape[1] + index % width) * 3
    c0, c1, c2 = (dr.gather(mi.Float, found.array, start + i) for i in range(3))
    given = _white_luminance(c0, c1, c2)
    level = dr.select(given > 0.0, upload(mi.Float, luminances) / given, 0.0)
    made = dr.zeros(mi.Float, 4 * height * width)
    for i, values in enumerate((c0, c1, c2, level)):
        dr.scatter(made, values, index * 4 + i)
    return made


def _white_luminance(c0, c1, c2):
    """Luminance of spectra under `WHITE`, relative to its own."""
    middles, shares = _coarse_weights()
    middles, weights = upload(mi.Float, middles), upload(mi.Float, shares)

    def add(i, total):
        nm, weight = dr.gather(mi.Float, middles, i), dr.gather(mi.Float, weights, i)
        return i + 1, total + weight * sigmoid(c0, c1, c2, nm)

    state = (mi.UInt32(0), dr.zeros(mi.Float, dr.width(c0)))
    return dr.while_loop(state, lambda i, _: i < len(shares), add)[1]


def _coarse_weights() -> tuple[np.ndarray, np.ndarray]:
    """Middles of bands [nm] and the share of the luminance of `WHITE` in them."""
    weight = illuminant(GRID, WHITE) * luminous_efficiency()
    band = ((GRID - GRID[0]) // COARSE).astype(int)
    shares = np.bincount(band, weight)
    middles = np.bincount(band, weight * GRID) / np.maximum(shares, 1e-300)
    used = shares > 1e-9 * shares.sum()
    return middles[used], (shares / shares.sum())[used]


def sigmoid(c0, c1, c2, wavelength):
    """Return the smooth spectrum of three coefficients of `make_colours` at wavelengths. [nm -> -]"""
    x = dr.fma(dr.fma(c0, wavelength, c1), wavelength, c2)
    return dr.fma(0.5 * x, dr.rsqrt(dr.fma(x, x, 1.0)), 0.5)


# ---- sampling in kernels ----


def _find_first(count, levels: int, is_above):
    """First of ``count`` entries for which a rising predicate holds; the last one if none does."""
    low, high = mi.UInt32(0), count - 1
    for _ in range(levels):
        middle = (low + high) >> 1
        above = is_above(middle)
        high = dr.select(above, middle, high)
        low = dr.select(above, low, dr.minimum(middle + 1, high))
    return low


def _draw_linear(start, end, sample):
    """Place in 0..1 with a density that goes straight from ``start`` to ``end``, not below 0."""
    largest = dr.maximum(dr.maximum(start, end), 1e-30)
    start, end = start / largest, end / largest
    root = dr.sqrt(dr.lerp(dr.square(start), dr.square(end), sample))
    place = sample * (start + end) / dr.maximum(start + root, 1e-30)
    return dr.clip(place, 0.0, 1.0)


def _draw_product(low, high, narrow, wide, sample):
    """Place in 0..1 with a density that is the product of two straight lines, from low narrow to high wide."""
    place = _draw_linear(low * narrow, high * wide, sample)
    rise, widen = high - low, wide - narrow
    linear, square = 0.5 * (low * widen + rise * narrow), rise * widen / 3.0
    level = low * narrow
    wanted = sample * (level + linear + square)
    # Newton's method; the density is not below 0, so the distribution rises.
    for _ in range(5):
        excess = place * (level + place * (linear + place * square)) - wanted
        density = (low + place * rise) * (narrow + place * widen)
        place = dr.clip(place - excess / dr.maximum(density, 1e-30), 0.0, 1.0)
    return place


def _picture_class():
    class Picture(far_light_class()):
        def set_picture(self, luminances, grid: Grid, colours) -> None:
            """Take over a picture: (height, width) float32 luminances, and its colours of `make_colours`."""
            self.largest = float(luminances.max())
            rows, shares, total = share_bands(luminances / np.float32(self.largest), grid)
            self.height, self.width = mi.UInt32(grid.height), mi.UInt32(grid.width)
            self.shift, self.step = mi.Float(grid.shift), mi.UInt32(grid.step)
            self.levels = (grid.bands.bit_length(), grid.width.bit_length())
            self.luminances = upload(mi.Float, luminances / np.float32(self.largest))
            self.columns = upload(mi.Float, accumulate_columns(luminances, grid))
            self.rows, self.shares = upload(mi.Float, rows), upload(mi.Float, shares)
            self.ends = upload(mi.Float, np.cumsum(shares))
            self.colours = colours
            # Density over solid angle of one over (u, v), the cosine aside.
            self.density = mi.Float(grid.height / (2.0 * np.pi**2 * total))
            dr.make_opaque(self.height, self.width, self.shift, self.step, self.density)
            dr.eval(self.luminances, self.columns, self.rows, self.shares, self.ends, colours)

        def lay(self, level: float, rotation) -> None:
            """Set the luminance [cd/m2] of a value of 1, and the matrix from the world's directions to the picture's."""
            self.level = mi.Float(level * self.largest)
            self.colour_level = mi.Float(level)
            self.to_map = mi.Matrix3f([[float(x) for x in row] for row in rotation])
            dr.make_opaque(self.level, self.colour_level, self.to_map)

        # ---- the picture ----

        def _wrap(self, column):
            """Column number below twice the width, round the circle."""
            # Lanes that do not ask this emitter see a width of 0, of which a remainder would end the process.
            return dr.select(column >= self.width, column - self.width, column)

        def _find(self, direction):
            """Corners (4 pixel numbers and 4 weights) around a direction of the world, and cosines there.

            The first cosine is that of the elevation, the second the one that samples follow, linear within bands.
            Elevations count from the nearer pole, so that both keep their digits there.
            """
            d = self.to_map @ direction
            plan = dr.maximum(dr.norm(mi.Vector2f(d.x, d.y)), LEAST_PLAN)
            height = mi.Float(self.height)
            x = (0.5 - dr.atan2(d.y, d.x) * dr.inv_two_pi) * mi.Float(self.width) - self.shift
            column = dr.floor(x)
            s = x - column
            number = mi.Int32(column)
            left = dr.select(number < 0, number + mi.Int32(self.width), number)
            left = self._wrap(mi.UInt32(left))
            right = self._wrap(left + self.step)
            from_pole = dr.atan2(plan, dr.abs(d.z)) * dr.inv_pi * height
            y = from_pole - self.shift
            row = dr.floor(y)
            t = y - row
            first = mi.UInt32(dr.maximum(mi.Int32(row), 0))
            last = mi.UInt32(mi.Int32(row) + mi.Int32(self.step))
            start = dr.maximum(row + self.shift, 0.0)
            end = row + 1.0 + self.shift
            narrow, wide = (dr.sin(dr.pi * each / height) for each in (start, end))
            cosine = dr.lerp(narrow, wide, (from_pole - start) / (end - start))
            is_upper = d.z >= 0.0
            top = self.height - 1
            first, last = (dr.minimum(each, top) for each in (first, last))
            first, last = (dr.select(is_upper, top - each, each) for each in (first, last))
            first, last = first * self.width, last * self.width
            corners = (first + left, first + right, last + left, last + right)
            weights = ((1.0 - t) * (1.0 - s), (1.0 - t) * s, t * (1.0 - s), t * s)
            return corners, weights, plan, cosine

        def _luminance(self, corners, weights, active):
            """Relative to the largest one."""
            value = mi.Float(0.0)
            for corner, weight in zip(corners, weights, strict=True):
                value += weight * dr.gather(mi.Float, self.luminances, corner, active)
            return value

        def _spectrum(self, corners, weights, wavelengths, active):
            value = mi.Spectrum(0.0)
            for corner, weight in zip(corners, weights, strict=True):
                c0, c1, c2, level = dr.gather(mi.Vector4f, self.colours, corner, active)
                value += weight * level * sigmoid(c0, c1, c2, wavelengths)
            return value

        def eval(self, si, active=True):
            corners, weights, _, _ = self._find(-si.wi)
            white = self.radiance.eval(si, active)
            if self.colours is None:
                value = white * (self.level * self._luminance(corners, weights, active))
            else:
                value = self._spectrum(corners, weights, si.wavelengths, active)
                value *= white * self.colour_level
            return mi.Spectrum(value & active)

        # ---- sampling ----

        def _draw_elevation(self, sample, active):
            """Rows that a band leads between, how far it goes from one to the other, and the elevation. [row]"""
            bands = self.height + self.step

            def is_above(k):
                return dr.gather(mi.Float, self.ends, k, active) > sample

            band = _find_first(bands, self.levels[0], is_above)
            share = dr.gather(mi.Float, self.shares, band, active)
            rest = (sample - (dr.gather(mi.Float, self.ends, band, active) - share)) / share
            rest = dr.clip(dr.select(share > 0.0, rest, 0.5), 0.0, 1.0)
            number, height = mi.Float(band), mi.Float(self.height)
            start = dr.maximum(number - self.shift, 0.0)
            end = dr.minimum(number + 1.0 - self.shift, height)
            lower = dr.maximum(band, self.step) - self.step
            upper = dr.minimum(band, self.height - 1)
            low, high = (dr.gather(mi.Float, self.rows, each, active) for each in (lower, upper))
            narrow, wide = (dr.maximum(dr.sin(dr.pi * each / height), 0.0) for each in (start, end))
            t = _draw_product(low, high, narrow, wide, rest)
            return lower, upper, low * (1.0 - t), high * t, t, dr.lerp(start, end, t)

        def _draw_azimuth(self, lower, upper, low, high, t, sample, active):
            """Place round the circle, u, in the row that lies between two, their parts in it being ``low`` and ``high``."""
            first, last = lower * self.width, upper * self.width
            part = dr.select(low + high > 0.0, high / (low + high), 0.5)

            def reach(j):
                before = dr.gather(mi.Float, self.columns, first + j, active)
                return dr.lerp(before, dr.gather(mi.Float, self.columns, last + j, active), part)

            left = _find_first(self.width, self.levels[1], lambda j: reach(j) > sample)
            start = dr.select(left > 0, reach(dr.maximum(left, 1) - 1), 0.0)
            rest = dr.clip((sample - start) / dr.maximum(reach(left) - start, 1e-30), 0.0, 1.0)
            right = self._wrap(left + self.step)
            value = [
                dr.lerp(
                    dr.gather(mi.Float, self.luminances, first + each, active),
                    dr.gather(mi.Float, self.luminances, last + each, active),
                    t,
                )
                for each in (left, right)
            ]
            s = _draw_linear(*value, rest)
            return (mi.Float(left) + self.shift + s) / mi.Float(self.width)

        def sample_direction(self, it, sample, active=True):
            lower, upper, low, high, t, v = self._draw_elevation(sample.x, active)
            u = self._draw_azimuth(lower, upper, low, high, t, sample.y, active)
            sine, cosine = dr.sincos((0.5 - u) * dr.two_pi)
            plan, down = dr.sincos(dr.pi * v / mi.Float(self.height))
            ds = dr.zeros(mi.DirectionSample3f)
            ds.d = dr.normalize(self.to_map.T @ mi.Vector3f(plan * cosine, plan * sine, -down))
            ds.pdf = self.pdf_direction(it, ds, active)
            return ds, mi.Spectrum(0.0)

        def pdf_direction(self, it, ds, active=True):
            corners, weights, plan, cosine = self._find(ds.d)
            value = self._luminance(corners, weights, active) * (cosine / plan) * self.density
            return dr.select(active, value, 0.0)

    return Picture
