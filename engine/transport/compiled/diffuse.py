"""Which shapes are matt, and how much light passes their coats: what is read at a hit without asking the surface model.

A matt surface is a smooth diffuse base with or without a clear coat (see `materials.coated`). The light that its base sends
out is separable: f = rho / pi * (1 - C(cos_i)) (1 - C(cos_o)) / (1 - C_mean), with the coat's directional reflectance C. So
the base sends rho / pi * (1 - C(cos_o)) / (1 - C_mean) * M in every direction, where M is the irradiance that passes the
coat.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...materials.facets import COSINES, MINIMUM_ALPHA, coat_reflectance, mean_reflectance
from .surfaces import PALETTE_STEPS, alpha
from .textures import TextureMaker


class DiffuseTable:
    """Looks up coats by the number of a shape.

    Parameters
    ----------
    scene : CompiledScene
    """

    def __init__(self, scene):
        rows: dict[tuple, int] = {}
        make = TextureMaker(scene.mean_light)
        numbers = np.zeros(scene.shape_count, dtype=np.uint32)
        self.shapes: list[int] = []
        for _, part, material in scene.parts():
            coated = material.surface.as_coated
            if coated is None or coated.base_roughness > 0.0 or part.is_transparent:
                continue
            self.shapes.append(part.number)
            key = _coat(coated, make)
            numbers[part.number] = rows.setdefault(key, len(rows)) + 1
        tables = [_table(*key) for key in rows] or [np.zeros(COSINES)]
        self.has_coat = any(table.any() for table in tables)
        self._host = numbers, np.stack(tables)
        self._rows = upload(mi.UInt32, numbers)
        self._tables = upload(mi.Float, np.concatenate(tables))
        self._scale = upload(mi.Float, [1.0 / max(1.0 - mean_reflectance(t), 1e-6) for t in tables])
        dr.eval(self._rows, self._tables, self._scale)

    def row(self, shape, active):
        """Row of a shape plus 1; 0 where it is not matt."""
        return dr.gather(mi.UInt32, self._rows, dr.reinterpret_array(mi.UInt32, shape), active)

    def coat(self, row, cosine, active):
        """Directional reflectance of the coat. ``row``: as `row` gives it, at least 1. [-]"""
        if not self.has_coat:
            return mi.Float(0.0)
        place = dr.sqrt(dr.clip(dr.abs(cosine), 0.0, 1.0)) * (COSINES - 1)
        below = dr.minimum(mi.UInt32(place), COSINES - 2)
        index = (row - 1) * COSINES + below
        low = dr.gather(mi.Float, self._tables, index, active)
        high = dr.gather(mi.Float, self._tables, index + 1, active)
        return dr.lerp(low, high, place - mi.Float(below))

    def passing(self, shape: np.ndarray, cosine: np.ndarray) -> np.ndarray:
        """Share of light that passes the coats of shapes, on the host; 0 where they are not matt. (n,), (n,) -> (n,)"""
        numbers, tables = self._host
        row = numbers[shape].astype(np.int64)
        place = np.sqrt(np.clip(cosine, 0.0, 1.0)) * (COSINES - 1)
        below = np.minimum(place.astype(np.int64), COSINES - 2)
        table = tables[np.maximum(row - 1, 0)]
        low, high = (np.take_along_axis(table, (below + k)[:, None], axis=1)[:, 0] for k in (0, 1))
        return np.where(row > 0, 1.0 - (low + (high - low) * (place - below)), 0.0)

    def scale(self, row, active):
        """1 / (1 - mean reflectance of the coat). [-]"""
        if not self.has_coat:
            return mi.Float(1.0)
        return dr.gather(mi.Float, self._scale, row - 1, active)


def _coat(coated, make) -> tuple:
    if coated.ior <= 1.001 or coated.specular <= 0.0:
        return (0.0, 1.0, 0.0, 1.0)
    width = round(float(max(alpha(coated.roughness), MINIMUM_ALPHA)), 4)
    tint = 1.0 if coated.tint is None else float(make.spectrum(coated.tint, PALETTE_STEPS).max())
    eta = round(float(max(coated.ior, 1.0001)), 4)
    return (width, eta, min(float(coated.specular), 1.0), tint)


def _table(width: float, eta: float, specular: float, tint: float) -> np.ndarray:
    if specular <= 0.0:
        return np.zeros(COSINES)
    return coat_reflectance(width, eta, specular, tint)
