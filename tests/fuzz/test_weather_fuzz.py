"""Damaged weather files: they are read with sensible numbers or refused in one sentence, soon, and with little memory."""

import time

import numpy as np
import pytest
from memory import peak_memory
from mutations import damage
from weather_files import epw, epw_record, wea

from lumenray.engine.errors import FileFormatError, SceneError
from lumenray.engine.sky.weather import find_hours
from lumenray.engine.sky.weather_file import read_weather

ROUNDS = 400
"""Damages of every kind of file."""

MOST_MEMORY = 64 << 20
"""That damaged files of some kilobytes may make the process grow. [byte]"""

FILES = {
    "epw": epw(
        [epw_record(2005, 7, 3, h, dni=500, dhi=90, ghi=400, dew=12.5) for h in range(1, 25)]
    ),
    "by the quarter": epw(
        [epw_record(2005, 7, 3, 9, 15 * k, dni=500, dhi=90, ghi=400) for k in range(1, 5)],
        per_hour=4,
    ),
    "wea": wea([(7, 3, h + 0.5, 500, 90) for h in range(24)]),
    "wea, horizontal": wea([(7, 3, h + 0.5, 300, 90) for h in range(24)], unit=2),
}


@pytest.mark.parametrize("name", FILES)
def test_damaged_files_are_read_or_refused(name, tmp_path):
    rng = np.random.default_rng([28, list(FILES).index(name)])
    path, count, before = tmp_path / "weather", 0, peak_memory()
    with np.errstate(over="raise", divide="raise", invalid="raise"):
        for _ in range(ROUNDS):
            path.write_bytes(damage(FILES[name].encode(), rng))
            try:
                weather = read_weather(path)
                hours = find_hours(weather, 2024)
            except (FileFormatError, SceneError) as error:
                assert "\n" not in str(error)
                assert len(str(error)) > 20
                continue
            count += 1
            for values in (hours.direct_normal, hours.diffuse_horizontal):
                known = values[~np.isnan(values)]
                assert ((known >= 0.0) & (known < 1e6)).all()
            assert np.isfinite(hours.sun.elevation).all()
            assert np.isfinite(hours.times).all()
    assert peak_memory() - before < MOST_MEMORY
    # Both happen, or the damage is of the wrong size.
    assert 0 < count < ROUNDS


HEAD = epw([])

HOSTILE = {
    "records without end": HEAD + (epw_record(2005, 1, 1, 1) + "\n") * 110_000,
    "one endless line": HEAD + "1," * 2_000_000,
    "quotes without end": HEAD + '"' * 1_000_000,
    "an endless heading": "LOCATION," + "a," * 2_000_000,
    "blank lines without end": HEAD + "\n" * 4_000_000,
    "wea: records without end": wea([]) + "1 1 1 1 1\n" * 110_000,
    "wea: one endless line": wea([]) + "1 " * 4_000_000,
}  # fmt: skip


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_files_are_refused_soon(name, tmp_path):
    path = tmp_path / "weather"
    path.write_text(HOSTILE[name])
    start = time.process_time()
    with pytest.raises(FileFormatError) as caught:
        read_weather(path)
    assert len(str(caught.value)) < 400
    assert time.process_time() - start < 10.0
