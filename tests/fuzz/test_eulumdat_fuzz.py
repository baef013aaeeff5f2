"""EULUMDAT under damage: a luminaire with a sensible flux, or a refusal; never a crash, a hang or nonsense."""

import os
import time

import numpy as np
import pytest
from mutations import damage

from lumenray.engine.errors import FileFormatError
from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.luminaires.formats.eulumdat.reader import parse_eulumdat
from lumenray.engine.luminaires.formats.eulumdat.writer import write_eulumdat
from lumenray.engine.luminaires.formats.reader import parse_luminaire

CHUNKS = 16
MUTATIONS = (8000 if os.environ.get("LUMENRAY_ALL_SEEDS") else 1200) // CHUNKS
"""Damaged files in each of the chunks; set LUMENRAY_ALL_SEEDS for the full number."""

LONGEST = 1.0
"""No file takes longer. [s]"""

DIRECTIONS = np.random.default_rng(0).normal(size=(200, 3))


def text(isym, planes, stored, polars, sets=((1, "LED", 1000.0, "4000 K", "80", 12.5),)):
    rng = np.random.default_rng(isym)
    lines = [
        *("Example", 2, isym, len(planes), 0, len(polars), 0),
        *("EX-REP", "Lüster 54°", "EX-1", "ex.ldt", "2024-01-01/x"),
        *(1200, 300, 60.5, 1150, 250, 10, 10, 10, 10, 75.5, 80, 1.0, 0, len(sets)),
        *(item for lamp in sets for item in lamp),
        *(0.22, 0.3, 0.38, 0.46, 0.52, 0.62, 0.69, 0.74, 0.81, 0.85),
        *planes,
        *polars,
        *np.round(400.0 * rng.random(stored * len(polars)), 2),
    ]
    return "".join(f"{line}\r\n" for line in lines).encode("latin-1")


PLANES = [15 * i for i in range(24)]
POLARS = [0, 5, 12.5, 20, 30, 45, 60, 75, 90]
TWO = ((1, "T5", 500.0, "830", "1B", 15), (2, "T5 HO", 1200.5, "840", "1B", 31.5))
TEXTS = [
    text(0, PLANES[::4], 6, POLARS),
    text(1, PLANES, 1, [*POLARS, 120, 180]),
    text(2, PLANES, 13, POLARS, TWO),
    text(3, [0, 5, 30, 90, 150, 175, 180, 200, 230, 270, 310, 340], 7, POLARS),
    text(4, PLANES, 7, POLARS, ((-1, "LED", 2500, "nw/4000", "90", 0),)),
    text(1, [0], 1, [90, 120, 150, 180]),
]


@pytest.mark.parametrize("data", TEXTS)
def test_the_undamaged_files_are_read(data):
    assert flux(parse_luminaire(data, "a.ldt").distribution) > 0.0


@pytest.mark.parametrize("chunk", range(CHUNKS))
def test_damaged_files_are_read_sensibly_or_refused(chunk):
    rng = np.random.default_rng([20, chunk])
    for i in range(MUTATIONS):
        damaged = damage(TEXTS[i % len(TEXTS)], rng)
        # The door must do as well as the room.
        parse = (parse_eulumdat, parse_luminaire)[i % 3 == 0]
        start = time.process_time()
        try:
            file = parse(damaged, "damaged.ldt")
        except FileFormatError as error:
            assert len(str(error)) > 20
            continue
        finally:
            assert time.process_time() - start < LONGEST
        total = flux(file.distribution)
        assert np.isfinite(total)
        assert total > 0.0
        assert np.all(np.isfinite(file.distribution.intensity))
        assert np.all(np.diff(file.distribution.azimuth) > 0.0)
        assert np.all(np.diff(file.distribution.polar) > 0.0)
        assert all(0.0 <= side <= 1000.0 for side in file.opening.size)
        if i % 25 == 0:
            back = parse_eulumdat(write_eulumdat(file)[0], "back.ldt")
            before, after = (intensity(f.distribution, DIRECTIONS) for f in (file, back))
            assert np.abs(after - before).max() <= 1e-4 * file.distribution.intensity.max()
