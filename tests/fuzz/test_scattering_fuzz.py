"""Damaged scattering files: whatever stands in them, they are read or refused in one sentence, with little memory."""

import numpy as np
import pytest
from memory import peak_memory
from mutations import NUMBER, NUMBERS, mutate
from scattering_files import (
    alike,
    anisotropic,
    anisotropic_binary,
    brdf_text,
    bsdf180,
    coated,
    lighttools,
    mdl,
    scattering,
    simple,
    zemax,
)
from scattering_models import towards

from lumenray.engine.errors import FileFormatError
from lumenray.engine.scattering.data.table import check_table
from lumenray.engine.scattering.readers import mixtures, slices
from lumenray.engine.scattering.readers.lighttools import is_lighttools, read_lighttools
from lumenray.engine.scattering.readers.mdl import is_mdl, read_mdl
from lumenray.engine.scattering.readers.speos import is_speos, read_speos
from lumenray.engine.scattering.readers.zemax import is_zemax, read_zemax
from lumenray.engine.scene.scattering import ScatterTable

ROUNDS = 400
"""Damages of every kind of file."""

SOME = {
    "incidences": (0, 40),
    "azimuths": (0, 60, 120, 180, 240, 300, 360),
    "radials": (0, 30, 60, 90),
}

GRID = {"incidences": (0, 40), "thetas": (0, 30, 60, 90), "phis": (0, 60, 120, 180, 240, 300, 360)}

MIXED = ((0, 4, 20, 30, 10, 0), (60, 10, 20, 30, 10, 0))

FILES = {
    "zemax": (is_zemax, read_zemax, zemax(**SOME)),
    "zemax_colours": (is_zemax, read_zemax, zemax(**SOME, content="XYZ")),
    "zemax_rotations": (is_zemax, read_zemax, zemax(**SOME, rotations=(0, 120, 240))),
    "lighttools": (is_lighttools, read_lighttools, lighttools(**SOME, bands=(450, 600))),
    "anisotropic": (is_speos, read_speos, anisotropic(**GRID, turns=(0, 90), factors=(1, 2))),
    "anisotropic_binary": (is_speos, read_speos, anisotropic_binary(**GRID)),
    "brdf": (is_speos, read_speos, brdf_text(incidences=(0, 40))),
    "scattering": (is_speos, read_speos, scattering(MIXED)),
    "simple": (is_speos, read_speos, simple()),
    "coated": (is_speos, read_speos, coated()),
    "bsdf180": (is_speos, read_speos, bsdf180()),
    "mdl": (is_mdl, read_mdl, mdl(alike, 3, 4, marks=("_REFLECTION", "_TRANSMISSION"))),
    "mdl_colours": (is_mdl, read_mdl, mdl(alike, 3, 4, colour=(1.0, 0.5, 0.2))),
}

MOST_MEMORY = 64 << 20
"""That damaged files of some kilobytes may make the process grow. [byte]"""


def damage(data: bytes, rng) -> bytes:
    """Damage of one number, of several places of a text, or of four bytes that are a number."""
    kind = rng.random()
    if kind < 0.3:
        found = list(NUMBER.finditer(data))
        if found:
            match = found[rng.integers(len(found))]
            new = NUMBERS[rng.integers(len(NUMBERS))]
            return data[: match.start()] + new + data[match.end() :]
    if kind < 0.7:
        return mutate(data, rng)
    changed = bytearray(data)
    size = len(changed) if rng.random() < 0.6 else min(300, len(changed))
    at = int(rng.integers(max(size - 4, 1)))
    values = (0, 1, -1, 2, 7, 0x7FFFFFFF, -0x80000000, 1 << 20, 0x7FC00000, 0x7F800000, 0x3F000000)
    changed[at : at + 4] = values[rng.integers(len(values))].to_bytes(4, "little", signed=True)
    return bytes(changed)


def coarse(evaluate, wavelengths, *, incidences, rotations=(0.0,), **_):
    """A table of one value for each direction of incidence, so that time goes into reading; many are asked for."""
    wavelengths = np.asarray(wavelengths, dtype=np.float64)
    grid = np.meshgrid(rotations, incidences, indexing="ij")
    wi = towards(np.degrees(grid[1].ravel()), np.degrees(grid[0].ravel()))
    values = np.zeros((len(wi), len(wavelengths)))
    for wo in towards(
        np.repeat((0.0, 20.0, 50.0, 85.0, 89.0), 8), np.tile(np.arange(0, 360, 45), 5)
    ):
        values = np.maximum(values, evaluate(wi, np.broadcast_to(wo, wi.shape)))
    assert np.isfinite(values).all()
    shape = len(rotations), len(incidences), 2, 2, len(wavelengths)
    ends = np.array([0.0, np.pi])
    spread = np.broadcast_to(values.reshape(*shape[:2], 1, 1, -1), shape).astype(np.float32)
    return ScatterTable(
        np.asarray(rotations), np.asarray(incidences), ends, ends, wavelengths, spread
    )


@pytest.mark.parametrize("name", FILES)
@pytest.mark.slow
def test_damaged_files_are_read_or_refused(name, monkeypatch):
    monkeypatch.setattr(slices, "resample", coarse)
    monkeypatch.setattr(mixtures, "resample", coarse)
    rng = np.random.default_rng(list(FILES).index(name))
    is_mine, reader, data = FILES[name]
    assert is_mine(data)
    # Once before memory is counted: what is imported and cached does not count.
    assert reader(data, "surface").sides
    done, before = 0, peak_memory()
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        for _ in range(ROUNDS):
            damaged = damage(data, rng)
            is_mine(damaged)
            try:
                file = reader(damaged, "surface")
            except FileFormatError as error:
                assert "\n" not in str(error)
                continue
            done += 1
            assert file.sides
            for table in file.sides.values():
                check_table(table)
            for remark in file.remarks:
                assert "\n" not in str(remark)
    assert peak_memory() - before < MOST_MEMORY
    # Both happen, or the damage is of the wrong size.
    assert 0 < done < ROUNDS


@pytest.mark.parametrize("name", FILES)
def test_damaged_files_make_tables(name):
    """A few with all that is done to make a table."""
    rng = np.random.default_rng(100 + list(FILES).index(name))
    _, reader, data = FILES[name]
    for _ in range(4):
        try:
            file = reader(damage(data, rng), "surface")
        except FileFormatError:
            continue
        for table in file.sides.values():
            check_table(table)
