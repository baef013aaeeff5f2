"""Pigment layers of few words, and grids that are random."""

import numpy as np

from lumenray.engine.ink.reader import parse_ink

BINDER = 1.558
"""Index of the reference's binder."""

WAVELENGTH = 0.55
"""[um]"""


def make_ink(
    share=0.0, median=0.0, index=1.4, absorption=0.0, *, spread=0.0, reflectance=0.9, **more
):
    """Ink of one pigment in the reference's binder, a micrometre thick."""
    pigment = {
        "index": {"wavelengths_nm": [400, 700], "n": [index] * 2, "k": [absorption] * 2},
        "volume_fraction": share,
        "median_um": median,
    }
    return parse_ink(
        {
            "lumenray_ink": 1,
            "name": "Test",
            "thickness_um": 1.0,
            "thickness_spread": spread,
            "binder": {"index": BINDER},
            "pigments": [pigment] if share else [],
            "substrate": {"reflectance": reflectance},
        }
        | more
    )


def random_grid(seed=0, layers=16, columns=24, index=1.4):
    """Permittivity of cells that are pigment or binder by chance."""
    chance = np.random.default_rng(seed).random((layers, columns, columns))
    return np.where(chance < 0.3, complex(index) ** 2, BINDER**2 + 0j)
