"""Skies by formula as Mitsuba's emitter: evaluated by the pattern that all have, sampled by a table of cells."""

import drjit as dr
import mitsuba as mi
import numpy as np

from ..arrays import upload
from ..scene.light import FormulaSky
from . import picture_plugin, projection_plugin
from .far_light import far_light_class
from .skies import find_luminances, ground_luminance, luminance_scale, pattern_of

ROWS, COLUMNS = 32, 64
"""Cells of the sky's sampling table: rows of equal height in the sine of the elevation, columns in azimuth."""

EVEN_SHARE = 0.1
"""Part of the samples that is spread evenly, so that no direction that shines is seldom found."""

POINTS = 4
"""Directions per cell and axis from which its mean luminance is taken."""


def register() -> None:
    """Register the plug-ins of skies, pictures and grounds with the active Mitsuba variant. Doing it again is harmless."""
    picture_plugin.register()
    projection_plugin.register()
    made = _sky_class()
    mi.register_emitter("lumenray_sky", lambda props, made=made: made(props))


def make_sky(sky: FormulaSky, radiance: dict) -> object:
    """Return the emitter of a sky. ``radiance``: texture of a luminance of 1 cd/m2 with the sky's spectrum."""
    emitter = mi.load_dict({"type": "lumenray_sky", "radiance": radiance})
    emitter.set_sky(sky)
    return emitter


def sampling_shares(sky: FormulaSky) -> np.ndarray:
    """Probability of every cell: those of the sky row by row from the horizon up, then that of the ground. Sum 1."""
    sine = (np.arange(ROWS * POINTS) + 0.5) / (ROWS * POINTS)
    azimuth = 2.0 * np.pi * (np.arange(COLUMNS * POINTS) + 0.5) / (COLUMNS * POINTS)
    plan = np.sqrt(1.0 - sine**2)[:, None]
    directions = np.stack(
        np.broadcast_arrays(plan * np.cos(azimuth), plan * np.sin(azimuth), sine[:, None]), axis=-1
    )
    value = find_luminances(sky, directions)
    value = value.reshape(ROWS, POINTS, COLUMNS, POINTS).mean(axis=(1, 3))
    # In units of a cell's solid angle, of which the ground has as many as the whole sky.
    cells = np.append(value.ravel(), ground_luminance(sky) * ROWS * COLUMNS)
    total = cells.sum()
    shares = cells / total if total > 0.0 else np.zeros_like(cells)
    even = np.append(np.full(ROWS * COLUMNS, 1.0 / (ROWS * COLUMNS)), 0.0)
    return EVEN_SHARE * even + (1.0 - EVEN_SHARE) * (shares if total > 0.0 else even)


def _sky_class():
    class Sky(far_light_class()):
        def set_sky(self, sky: FormulaSky) -> None:
            """Take over pattern, level and the place of the sun."""
            pattern, scale = pattern_of(sky), luminance_scale(sky)
            sun = np.array(pattern.sun)
            a, b, c, d, e, edge, level, base, rise, floor = pattern.numbers
            numbers = [a, b, c, d, e, edge, level * scale, base * scale, rise * scale, floor]
            self.numbers = [mi.Float(float(x)) for x in numbers]
            self.ground = mi.Float(ground_luminance(sky))
            self.sun = mi.Vector3f(*map(float, sun))
            shares = sampling_shares(sky)
            cdf = np.cumsum(shares)
            cdf[-1] = 2.0
            self.shares, self.cdf = upload(mi.Float, shares), upload(mi.Float, cdf)
            self.starts = upload(mi.Float, np.cumsum(shares) - shares)
            dr.make_opaque(self.numbers, self.ground, self.sun)
            dr.eval(self.shares, self.cdf, self.starts)

        def _luminance(self, direction):
            a, b, c, d, e, edge, level, base, rise, floor = self.numbers
            sine = dr.maximum(direction.z, 0.0)
            gradation = 1.0 + a * dr.exp(b / dr.maximum(sine, floor))
            # By the chord: an arc cosine loses half of its digits next to the sun.
            half = dr.minimum(0.5 * dr.norm(direction - self.sun), 1.0)
            angle = 2.0 * dr.asin(half)
            cosine = 1.0 - 2.0 * dr.square(half)
            scattering = 1.0 + c * (dr.exp(d * angle) - edge) + e * dr.square(cosine)
            value = level * gradation * scattering + base + rise * sine
            return dr.select(direction.z >= 0.0, dr.maximum(value, 0.0), self.ground)

        def eval(self, si, active=True):
            value = self.radiance.eval(si, active) * self._luminance(-si.wi)
            return mi.Spectrum(value & active)

        def sample_direction(self, it, sample, active=True):
            last = ROWS * COLUMNS
            cell = dr.binary_search(0, last, lambda i: dr.gather(mi.Float, self.cdf, i) <= sample.x)
            share = dr.gather(mi.Float, self.shares, cell)
            start = dr.gather(mi.Float, self.starts, cell)
            rest = dr.clip((sample.x - start) / dr.maximum(share, 1e-20), 0.0, 0.9999999)
            is_ground = cell == last
            row, column = cell // COLUMNS, cell % COLUMNS
            azimuth = dr.select(is_ground, rest, (mi.Float(column) + rest) / COLUMNS) * dr.two_pi
            z = dr.select(is_ground, sample.y - 1.0, (mi.Float(row) + sample.y) / ROWS)
            plan = dr.safe_sqrt(1.0 - z * z)
            sine, cosine = dr.sincos(azimuth)
            ds = dr.zeros(mi.DirectionSample3f)
            ds.d = mi.Vector3f(plan * cosine, plan * sine, z)
            ds.pdf = self.pdf_direction(it, ds, active)
            return ds, mi.Spectrum(0.0)

        def pdf_direction(self, it, ds, active=True):
            z = ds.d.z
            azimuth = dr.atan2(ds.d.y, ds.d.x) * dr.inv_two_pi
            azimuth = dr.select(azimuth < 0.0, azimuth + 1.0, azimuth)
            row = dr.minimum(mi.UInt32(dr.maximum(z, 0.0) * ROWS), ROWS - 1)
            column = dr.minimum(mi.UInt32(azimuth * COLUMNS), COLUMNS - 1)
            cell = dr.select(z >= 0.0, row * COLUMNS + column, ROWS * COLUMNS)
            density = dr.gather(mi.Float, self.shares, cell, active)
            cells = dr.select(z >= 0.0, float(ROWS * COLUMNS), 1.0)
            return dr.select(active, density * cells * dr.inv_two_pi, 0.0)

    return Sky
