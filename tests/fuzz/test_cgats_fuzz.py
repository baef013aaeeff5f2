"""Damaged CGATS text: whatever stands in it, it is read or refused in one sentence, soon, and with little memory."""

import time

import numpy as np
import pytest
from cgats_files import NM, argyll, grey, pairs, samples, table
from memory import peak_memory
from mutations import mutate

from lumenray.engine.errors import FileFormatError
from lumenray.engine.formats.cgats import is_cgats, read_cgats
from lumenray.engine.formats.spd import read_spectrum

ROUNDS = 300
"""Damages of every kind of file."""

MOST_MEMORY = 64 << 20
"""That damaged files of some kilobytes may make the process grow. [byte]"""

FILES = {
    "chart": samples(),
    "per cent": samples("SPECTRAL_PCT_{}", 100.0),
    "argyll": argyll(100.0 * grey(0.5), norm=100.0, spectra=2),
    "pairs": pairs(),
    "upright": table(["SPECTRAL_NM", "SPECTRAL_DEC"], list(zip(NM, grey(0.5), strict=True))),
}


@pytest.mark.parametrize("name", FILES)
def test_damaged_texts_are_read_or_refused(name, tmp_path):
    rng = np.random.default_rng(list(FILES).index(name))
    path, count, before = tmp_path / "spectrum.txt", 0, peak_memory()
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        for k in range(ROUNDS):
            path.write_bytes(mutate(FILES[name].encode(), rng))
            try:
                file = read_spectrum(path, (None, 1, 2)[k % 3])
            except FileFormatError as error:
                assert "\n" not in str(error)
                continue
            count += 1
            assert (np.diff(file.table.wavelengths) > 0.0).all()
            assert file.table.values.min() >= 0.0
    assert peak_memory() - before < MOST_MEMORY
    # Both happen, or the damage is of the wrong size.
    assert 0 < count < ROUNDS


HEAD = "CGATS.17\nBEGIN_DATA_FORMAT\n"

HOSTILE = {
    "fields without end": HEAD + "NM380\n" * 1_000_000,
    "one endless line": HEAD + "NM380 " * 1_000_000,
    "samples without end": f"{HEAD}NM380\nEND_DATA_FORMAT\nBEGIN_DATA\n" + "1\n" * 1_000_000,
    "quotes without end": f"{HEAD}NM380\nEND_DATA_FORMAT\nBEGIN_DATA\n" + '"' * 100_001,
    "quotes that do not match": f'{HEAD}{"NM380 " * 9}\nEND_DATA_FORMAT\nBEGIN_DATA\n{"a" + chr(34)}' * 9,
    "bands by the million": argyll(grey(0.5)).replace('BANDS "36"', 'BANDS "999999999999"'),
    "wavelengths beyond measure": argyll(grey(0.5)).replace('"730.000000"', '"1e308"'),
    "a norm of next to nothing": argyll(grey(0.5)).replace('NORM "1.000000"', 'NORM "1e-320"'),
    "empty tables without end": "BEGIN_DATA\nEND_DATA\n" * 100_000,
    "keywords without end": "".join(f"K{k} 1\n" for k in range(100_000)) + "BEGIN_DATA\n",
}  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_texts_are_refused_soon(name):
    data, start = HOSTILE[name].encode(), time.monotonic()
    assert is_cgats(data)
    with pytest.raises(FileFormatError) as caught:
        read_cgats("spectrum.txt", data)
    assert len(str(caught.value)) < 400
    assert "\n" not in str(caught.value)
    assert time.monotonic() - start < 10.0
