"""Weights of directions that are drawn."""

import numpy as np

from ...engine.scattering.data.evaluation import albedo
from .kernels import make_plugin, start_backend, weigh_by_eye
from .models import MATERIALS, table_of
from .storage import ANGLES

DRAWN = 1 << 18
"""Directions that are drawn at each incidence."""


def measure_sampling(told) -> list[dict]:
    """Weights of directions that are drawn: their mean against the albedo, their spread, the largest."""
    start_backend(spectral=False)
    import drjit as dr
    import mitsuba as mi

    rows = []
    for name in MATERIALS:
        table = table_of(name, 0.02)
        bsdf = make_plugin(table)
        for angle in ANGLES:
            si = dr.zeros(mi.SurfaceInteraction3f, DRAWN)
            si.wi = mi.Vector3f(
                float(np.sin(np.radians(angle))), 0.0, float(np.cos(np.radians(angle)))
            )
            stream = mi.PCG32(DRAWN, 11)
            numbers = mi.Point2f(stream.next_float32(), stream.next_float32())
            _, weight = bsdf.sample(mi.BSDFContext(), si, stream.next_float32(), numbers)
            weight = np.array(weight[0], dtype=float)
            rows.append(
                {
                    "material": name,
                    "incidence": angle,
                    "mean": float(weight.mean()),
                    "error": float(weight.std() / np.sqrt(DRAWN)),
                    "albedo": float(
                        weigh_by_eye(albedo(table, np.radians(angle)), table.wavelengths)
                    ),
                    "spread": float(weight.std() / weight.mean()),
                    "largest": float(weight.max() / weight.mean()),
                }
            )
        told(f"sampling, {name}")
    return rows
