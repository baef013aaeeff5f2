"""Damaged ray files: whatever stands in them, they are read or refused in one sentence, soon, and with little memory."""

import numpy as np
import pytest
from memory import peak_memory
from mutations import mutate
from ray_files import (
    asap,
    lambert_rays,
    lighttools,
    lighttools_text,
    speos,
    tm25,
    tracepro_text,
    zemax,
    zemax_text,
)

from lumenray.engine.errors import FileFormatError
from lumenray.engine.raysets.reader import read_rayset
from lumenray.engine.raysets.survey import survey_rays

ROUNDS = 550
"""Damages of every kind of file; with ten kinds more than 5000."""

RAYS = lambert_rays(60)
COLOURED = np.concatenate([RAYS, np.full((60, 1), 0.55, dtype="<f4")], axis=1)
SPECTRUM = [(400.0, 0.5), (500.0, 1.0), (600.0, 0.0)]

FILES = {
    "tm25": tm25(RAYS, lumens=30.0),
    "tm25_tables": tm25(
        np.concatenate([RAYS, RAYS[:, 6:]], axis=1),
        kind=3,
        spectra=(SPECTRUM,),
        more=("a",),
        text="b",
    ),
    "zemax": zemax(RAYS),
    "zemax_coloured": zemax(COLOURED, kind=2, quantity=0),
    "lighttools": lighttools(RAYS),
    "speos": speos(np.concatenate([RAYS[:, :6], np.full((60, 1), 555.0), RAYS[:, 6:]], axis=1)),
    "asap": asap(RAYS),
    "zemax_text": zemax_text(RAYS),
    "lighttools_text": lighttools_text(RAYS),
    "tracepro_text": tracepro_text(RAYS),
}

MOST_MEMORY = 64 << 20
"""That damaged files of some kilobytes may make the process grow. [byte]"""


def damage(data: bytes, rng) -> bytes:
    """Damage of numbers as text, of bytes in the head, or of four bytes that are a number."""
    if rng.random() < 0.5:
        return mutate(data, rng)
    changed = bytearray(data)
    for _ in range(rng.integers(1, 4)):
        # Heads are short, so most damage goes there; that of TM-25 has its numbers in the first 300 bytes.
        size = len(changed) if rng.random() < 0.3 else min(300, len(changed))
        at = int(rng.integers(max(size - 4, 1)))
        values = (
            0,
            1,
            -1,
            2,
            7,
            0x7FFFFFFF,
            -0x80000000,
            1 << 20,
            0x7FC00000,
            0x7F800000,
            int(rng.integers(1 << 31)),
        )
        value = values[rng.integers(len(values))]
        changed[at & ~3 : (at & ~3) + 4] = int(value).to_bytes(4, "little", signed=True)
    return bytes(changed)


@pytest.mark.parametrize("name", FILES)
def test_damaged_files_are_read_or_refused(tmp_path, name):
    rng = np.random.default_rng(list(FILES).index(name))
    path = tmp_path / "lamp.ray"
    read, before = 0, peak_memory()
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        for _ in range(ROUNDS):
            path.write_bytes(damage(FILES[name], rng))
            try:
                made = survey_rays(read_rayset(path))
            except FileFormatError as error:
                assert "\n" not in str(error)
                continue
            read += 1
            assert made.rays > 0
            assert np.isfinite(made.bounds).all()
            assert np.isfinite([made.weight, made.factor, *made.centroid, *made.axis]).all()
            assert made.weight > 0.0
            assert np.abs(np.linalg.norm(made.axis)) <= 1.0 + 1e-6
            for flux in (made.luminous_flux, made.radiant_flux):
                assert flux is None or (np.isfinite(flux) and flux >= 0.0)
    assert peak_memory() - before < MOST_MEMORY
    # Both happen, or the damage is of the wrong size.
    assert 0 < read < ROUNDS
