"""Damaged pictures under the command ``lumenray environment``: an answer, or one line and the exit code 1."""

import json
from functools import partial

import numpy as np
import pytest
from commands import run_command
from mutations import damage
from radiance_files import write_picture

from lumenray.benchmarks.environment.drawn_maps import Spot, make_map
from lumenray.engine.environment.map_file import write_map

run = partial(run_command, "environment")

ROUNDS = 25

PIXELS = make_map(16, [Spot(40.0, 120.0, 12.0, 3.0)])


@pytest.mark.mitsuba
@pytest.mark.parametrize("kind", ["packed.hdr", "plain.hdr", "whole.exr"])
def test_damaged_pictures_are_analysed_or_refused(kind, tmp_path, capsys):
    if kind.endswith(".exr"):
        whole = write_map(tmp_path / kind, PIXELS).read_bytes()
    else:
        whole = write_picture(PIXELS, ["EXPOSURE=0.5"], packed=kind == "packed.hdr")
    rng = np.random.default_rng([41, len(kind)])
    path, answers = tmp_path / "map", 0
    for _ in range(ROUNDS):
        path.write_bytes(damage(whole, rng))
        code, out, err = run(capsys, "analyse", path, "--json")
        assert code in {0, 1}
        assert bool(err) == (code == 1)
        if code == 0:
            answers += 1
            assert json.loads(out)["horizontal_lx"] >= 0.0
        else:
            assert err.startswith("lumenray: ")
            assert err.count("\n") == 1
    assert answers < ROUNDS
