"""Pictures by tables beside those by Mitsuba's own models."""

import tempfile
from pathlib import Path

import numpy as np

from ...engine.scattering.data.resampling import resample
from .kernels import make_plugin, start_backend
from .models import MATERIALS, RED, WAVELENGTHS, mirror, paint

PICTURE, GROUPS, SAMPLES = 96, 8, 64
"""Side of pictures in pixels, independent ones of each, samples of a pixel in each."""

BLOCK = 8
"""Pixels along the side of the blocks whose means are compared."""


def measure_pictures(told) -> list[dict]:
    """Differences of pictures by tables and by Mitsuba's own models, with those of chance."""
    start_backend(spectral=True)
    import mitsuba as mi

    rows = []
    with tempfile.TemporaryDirectory() as folder:
        exact = paint(0.2, RED)
        path = Path(folder) / "red.bsdf"
        from ...engine.scattering.readers.reader import Wish, read_scattering
        from ...engine.scattering.readers.tensor_file import write_tensor_file

        angles = np.radians(np.concatenate([np.arange(0.0, 81.0, 4.0), [83.0, 86.0, 89.0]]))
        write_tensor_file(path, exact, angles, WAVELENGTHS, 64)
        ours = read_scattering(path, Wish(0.02)).sides["front_reflection"]
        matt = resample(MATERIALS["matt"][0], [550.0])
        rough = resample(mirror(0.3, is_joint=False), [550.0], tolerance=0.01)
        cases = {
            "RGL file, Mitsuba's measured": (ours, {"type": "measured", "filename": str(path)}),
            "Lambert, Mitsuba's diffuse": (
                matt,
                {"type": "diffuse", "reflectance": {"type": "uniform", "value": 0.8}},
            ),
            "GGX metal, Mitsuba's roughconductor": (
                rough,
                {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": 0.3},
            ),
        }
        for name, (table, other) in cases.items():
            theirs = mi.load_dict({"type": "twosided", "nested": other})
            both = [
                np.stack([_render(bsdf, seed + offset) for seed in range(GROUPS)])
                for offset, bsdf in ((0, make_plugin(table)), (100, theirs))
            ]
            rows.append({"case": name, "stated": table.error} | _compare(*both))
            told(f"{name}: {100 * rows[-1]['difference']:.2f} %")
    return rows


def _compare(ours, theirs) -> dict:
    """Difference of block means relative to the mean of a block, and how much of it is chance."""

    def blocks(p):
        shape = (len(p), PICTURE // BLOCK, BLOCK, PICTURE // BLOCK, BLOCK, p.shape[-1])
        return p.reshape(shape).mean(axis=(2, 4))

    a, b = blocks(ours), blocks(theirs)
    mean = np.maximum(b.mean(axis=0), 0.02 * b.mean())
    chance = np.sqrt((a.var(axis=0, ddof=1) + b.var(axis=0, ddof=1)) / GROUPS) / mean
    apart = (a.mean(axis=0) - b.mean(axis=0)) / mean
    squared = max(float((apart**2).mean() - (chance**2).mean()), 0.0)
    return {
        "difference": float(np.sqrt((apart**2).mean())),
        "chance": float(np.sqrt((chance**2).mean())),
        "without_chance": float(np.sqrt(squared)),
        "whole": float(a.mean() / b.mean() - 1.0),
        "pictures": [a_.tolist() for a_ in (ours.mean(axis=0), theirs.mean(axis=0))],
    }


def _render(bsdf, seed: int) -> np.ndarray:
    """A ball on a floor of the same stuff, a lamp and a grey sky. (h, w, 3)"""
    import mitsuba as mi

    look = mi.ScalarTransform4f().look_at
    scene = mi.load_dict(
        {
            "type": "scene",
            "sky": {"type": "constant", "radiance": 0.3},
            "lamp": {
                "type": "rectangle",
                "to_world": look([2, -2, 3], [0, 0, 0], [0, 0, 1]),
                "emitter": {"type": "area", "radiance": 6.0},
            },
            "ball": {"type": "sphere", "bsdf": bsdf},
            "floor": {
                "type": "rectangle",
                "to_world": mi.ScalarTransform4f().translate([0, 0, -1]).scale(4.0),
                "bsdf": bsdf,
            },
            "sensor": {
                "type": "perspective",
                "fov": 40.0,
                "to_world": look([0, -6, 1.5], [0, 0, 0], [0, 0, 1]),
                "film": {
                    "type": "hdrfilm",
                    "width": PICTURE,
                    "height": PICTURE,
                    "rfilter": {"type": "box"},
                },
            },
            "integrator": {"type": "path", "max_depth": 4},
        }
    )
    return np.array(mi.render(scene, spp=SAMPLES, seed=seed))
