"""Damaged weather files and sky tables under the command ``lumenray sky``: an answer, or one line and the exit code 1."""

import json
from functools import partial

import numpy as np
import pytest
from commands import run_command
from mutations import damage
from weather_files import epw, epw_record, wea

run = partial(run_command, "sky")

ROUNDS = 30

FILES = {
    "epw": epw(
        [epw_record(2005, 7, 3, h, dni=500, dhi=90, ghi=400, dew=12.5) for h in range(1, 25)]
    ),
    "wea": wea([(7, 3, h + 0.5, 500, 90) for h in range(24)]),
    "wea, horizontal": wea([(7, 3, h + 0.5, 300, 90) for h in range(24)], unit=2),
    "wea, lux": wea([(7, 3, h + 0.5, 30_000, 9000) for h in range(24)], unit=3),
}


def check(code, out, err):
    assert code in {0, 1}
    assert bool(err) == (code == 1)
    if err:
        assert err.startswith("lumenray: ")
        assert err.count("\n") == 1
    else:
        assert out


@pytest.mark.parametrize("name", FILES)
def test_damaged_weather_is_told_or_refused(name, tmp_path, capsys):
    rng = np.random.default_rng([31, list(FILES).index(name)])
    path, answers = tmp_path / "weather", 0
    for number in range(ROUNDS):
        path.write_bytes(damage(FILES[name].encode(), rng))
        more = ("--time", "2026-07-03T11:30") if number % 2 else ()
        code, out, err = run(capsys, "info", "--weather", path, "--json", *more)
        check(code, out, err)
        if code == 0:
            answers += 1
            row = json.loads(out)
            assert all(value is None or value >= 0.0 for value in row["weather"]["sums"].values())
            run(capsys, "info", "--weather", path, *more)
    # Illuminances alone are not judged.
    assert (answers > 0) == (name != "wea, lux")


@pytest.mark.parametrize("name", ["epw", "wea"])
def test_damaged_weather_is_drawn_or_refused(name, tmp_path, capsys):
    rng = np.random.default_rng([32, list(FILES).index(name)])
    path = tmp_path / "weather"
    for _ in range(25):
        path.write_bytes(damage(FILES[name].encode(), rng))
        check(
            *run(
                *(capsys, "plot", "--weather", path, "--time", "2026-07-03T11:30", "--force"),
                *("-o", tmp_path / "a.png", "--size", "160x160"),
            )
        )


def test_damaged_tables_are_drawn_or_refused(tmp_path, capsys):
    rng = np.random.default_rng(33)
    patches = "\n".join(str(1000 + 7 * k) for k in range(145))
    grid = "\n".join(f"{e} {a} {100 + e}" for e in (5, 45, 85) for a in (0, 90, 180, 270))
    path = tmp_path / "scan.sky"
    for text in (patches, grid):
        for _ in range(20):
            path.write_bytes(damage(text.encode(), rng))
            check(
                *run(
                    *(capsys, "plot", "--measured", path, "--force"),
                    *("-o", tmp_path / "a.png", "--size", "160x160"),
                )
            )
