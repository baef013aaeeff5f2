"""All luminous rectangles of lamps as one emitter of Mitsuba, so that a thousand of them cost no more to trace than one.

As with luminaires (see `palette`), the row of one travels as the time of what the emitter is asked about.
"""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from .rectangles import find_rectangle_density, sample_rectangle
from .row_spectra import RowSpectra
from .spread import narrow

VECTORS = 3
"""Vectors of a row: centre, and halves of both sides."""


@dataclass(frozen=True, eq=False)
class RectangleRow:
    """A luminous rectangle as the table holds it.

    Parameters
    ----------
    centre, half_x, half_y : (3,) arrays    In the scene's frame; it shines along ``half_x`` x ``half_y``. [m]
    amount : float    Luminance along the normal [cd/m2], 0 in photometric variants for light without a visible part.
    density : (471,) array    Spectral density per unit of it. [1/nm]
    tan_spread : float    Tangent of half of Blender's spread; 0: Lambertian.
    """

    centre: np.ndarray
    half_x: np.ndarray
    half_y: np.ndarray
    amount: float
    density: np.ndarray
    tan_spread: float = 0.0

    def order(self) -> tuple:
        """Key that tells apart rectangles of equal flux at one place."""
        return (*self.half_x, *self.half_y, self.tan_spread, self.density.tobytes())


class RectangleTable:
    """The rows. The plug-in that stands for all of them holds it."""

    def __init__(self):
        self.commit([])

    def commit(self, rows: list[RectangleRow]) -> None:
        """Take these rectangles, in this order."""
        vectors = [(row.centre, row.half_x, row.half_y) for row in rows]
        self._vectors = upload(mi.Float, np.array(vectors or np.zeros((1, VECTORS, 3))))
        self._spreads = upload(mi.Float, [row.tan_spread for row in rows] or [0.0])
        self._spectra = RowSpectra([row.amount for row in rows], [row.density for row in rows])

    # ---- inside kernels ----

    def rectangle(self, row, active):
        """Centre, and halves of both sides. Vector3f each [m]"""
        return tuple(
            dr.gather(mi.Vector3f, self._vectors, row * VECTORS + k, active) for k in range(VECTORS)
        )

    def sample_place(self, row, sample, active):
        """Draw a place, evenly over the area. PositionSample3f"""
        centre, x, y = self.rectangle(row, active)
        across = dr.cross(x, y)
        made = dr.zeros(mi.PositionSample3f)
        made.p = centre + x * (2.0 * sample.x - 1.0) + y * (2.0 * sample.y - 1.0)
        made.n = dr.normalize(across)
        made.pdf = dr.rcp(4.0 * dr.norm(across))
        return made

    def radiance(self, row, cosine, wavelengths, active):
        """Radiance under an angle to the normal; 0 behind. Spectrum"""
        spread = dr.gather(mi.Float, self._spreads, row, active)
        profile = dr.select(spread > 0.0, narrow(cosine, spread), 1.0)
        value = self._spectra.eval(row, wavelengths, active) * profile
        return mi.Spectrum(value & (active & (cosine > 0.0)))


def make_rectangles():
    """Make an emitter with an empty table; it holds the table and not the other way round, see `make_emitter`."""
    emitter = mi.load_dict({"type": "lumenray_rectangles"})
    emitter.table = RectangleTable()
    return emitter


def rectangles_class():
    """Make the emitter's class for the active variant."""

    class LuminousRectangles(mi.Emitter):
        """Every rectangle of a `RectangleTable`, told apart by the time of what it is asked with."""

        table: RectangleTable

        def __init__(self, props):
            mi.Emitter.__init__(self, props)
            self.m_flags = +mi.EmitterFlags.Surface

        def traverse(self, callback):
            """Nothing here is a parameter of Mitsuba's."""

        def eval(self, si, active=True):
            cosine = mi.Frame3f.cos_theta(si.wi)
            return self.table.radiance(mi.UInt32(si.time), cosine, si.wavelengths, mi.Bool(active))

        def sample_direction(self, it, sample, active=True):
            row, active = mi.UInt32(it.time), mi.Bool(active)
            ds = sample_rectangle(self.table.rectangle(row, active), it.p, sample)
            ds.emitter = mi.EmitterPtr(self)
            active &= ds.pdf > 0.0
            value = self.eval_direction(it, ds, active) / dr.maximum(ds.pdf, 1e-20)
            return ds, mi.Spectrum(value & active)

        def pdf_direction(self, it, ds, active=True):
            rectangle = self.table.rectangle(mi.UInt32(it.time), mi.Bool(active))
            cosine = dr.dot(ds.d, ds.n)
            density = find_rectangle_density(rectangle, it.p, ds.dist, cosine)
            return dr.select(active & (cosine < 0.0), density, 0.0)

        def eval_direction(self, it, ds, active=True):
            row, cosine = mi.UInt32(it.time), -dr.dot(ds.d, ds.n)
            return self.table.radiance(row, cosine, it.wavelengths, mi.Bool(active))

        def bbox(self):
            return mi.BoundingBox3f()

        def to_string(self):
            return "LuminousRectangles[]"

    return LuminousRectangles
