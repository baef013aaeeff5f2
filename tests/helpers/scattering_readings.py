"""What was read of a scattering file, and whether it is what the file was made of."""

from pathlib import Path

import numpy as np
from scattering_models import towards

from lumenray.engine.scattering.data.record import SIDES
from lumenray.engine.scattering.data.table import check_table, evaluate_table
from lumenray.engine.scattering.readers.lighttools import is_lighttools, read_lighttools
from lumenray.engine.scattering.readers.mdl import is_mdl, read_mdl
from lumenray.engine.scattering.readers.speos import is_speos, read_speos
from lumenray.engine.scattering.readers.zemax import is_zemax, read_zemax

READERS = (
    (is_zemax, read_zemax),
    (is_lighttools, read_lighttools),
    (is_speos, read_speos),
    (is_mdl, read_mdl),
)


def read_back(data: bytes):
    """Read by the one reader that takes the file for its own, and check what it makes."""
    mine = [reader for is_mine, reader in READERS if is_mine(data)]
    assert len(mine) == 1
    file = mine[0](data, Path("surface"))
    assert set(file.sides) <= set(SIDES)
    for table in file.sides.values():
        check_table(table)
    return file


def front_of(data: bytes):
    """Read the reflection of the front."""
    return read_back(data).sides["front_reflection"]


def told(file) -> str:
    """Return all remarks as one text."""
    return " | ".join(str(each) for each in file.remarks)


def pairs(incidences, rotations=None, count=4000):
    """Pairs of directions, light coming at angles of incidence [degree] and at any azimuth or some. [degree]"""
    rng = np.random.default_rng(5)
    theta = rng.choice(np.asarray(incidences, dtype=float), count)
    phi = rng.uniform(0.0, 360.0, count) if rotations is None else rng.choice(rotations, count)
    steep = np.degrees(np.arccos(np.sqrt(rng.uniform(np.cos(np.radians(75.0)) ** 2, 1.0, count))))
    return towards(theta, phi), towards(steep, rng.uniform(0.0, 360.0, count))


def assert_same(table, brdf, incidences, tolerance, factor=1.0, **more):
    """The values are those of a function, wherever light comes from and goes."""
    wi, wo = pairs(incidences, **more)
    wanted = factor * brdf(wi, wo)
    error = np.abs(evaluate_table(table, wi, wo)[:, 0] - wanted)
    assert error.max() < tolerance * wanted.max()
