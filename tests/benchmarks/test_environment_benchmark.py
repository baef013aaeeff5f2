"""The benchmark of pictures of the surroundings: its maps, its closed form of a shadow, verdicts and the document."""

import json

import numpy as np
import pytest

from lumenray.benchmarks.environment import run as environment
from lumenray.benchmarks.environment.drawn_maps import Spot, make_map
from lumenray.benchmarks.environment.suns import LIMB, _part_below
from lumenray.engine.errors import LumenrayError


def test_disks_in_maps_have_the_light_that_they_are_said_to_have():
    """By a plain sum over cells, which is what the disks are drawn for."""
    height = 512
    spot = Spot(33.0, 200.0, 2.0, 5.0, (1.2, 0.9, 1.4))
    added = make_map(height, [spot], sky=0.0, ground=0.0).astype(np.float64)
    edges = -np.cos(np.pi * np.arange(height + 1) / height)
    solid = np.repeat(np.diff(edges) * np.pi / height, 2 * height).reshape(height, -1)
    polar = np.pi * (np.arange(height)[:, None] + 0.5) / height
    turn = 2.0 * np.pi * (0.5 - (np.arange(2 * height)[None, :] + 0.5) / (2 * height))
    seen = np.sin(polar) * (np.cos(turn) * spot.towards[0] + np.sin(turn) * spot.towards[1])
    seen = seen - np.cos(polar) * spot.towards[2]
    light = (added * (solid * np.maximum(seen, 0.0))[..., None]).sum(axis=(0, 1))
    assert light == pytest.approx(5.0 * np.array(spot.colour), rel=2e-3)


def test_the_shadow_of_an_edge_is_the_part_of_a_darkened_disk():
    """Against random places on the disk."""
    rng = np.random.default_rng(4)
    x, y = rng.uniform(-1.0, 1.0, (2, 400_000))
    inside = x**2 + y**2 <= 1.0
    weight = np.where(inside, 1.0 - LIMB * (1.0 - np.sqrt(np.maximum(1.0 - x**2 - y**2, 0.0))), 0.0)
    for t in (-0.8, -0.2, 0.0, 0.5, 0.9):
        part = weight[x < t].sum() / weight.sum()
        assert _part_below(t) == pytest.approx(part, abs=4e-3)
    assert (_part_below(-2.0), _part_below(2.0)) == pytest.approx((0.0, 1.0), abs=1e-4)


def test_parts_that_are_none_are_refused():
    with pytest.raises(LumenrayError, match="choose from maps"):
        environment.run(("suns",))


def test_results_are_gone_on_with(tmp_path, monkeypatch):
    monkeypatch.setattr(environment, "measure_maps", lambda say: [])
    monkeypatch.setattr(environment, "measure_noise", lambda say: {"gain": 2.0})
    path = tmp_path / "numbers.json"
    environment.write_numbers(environment.run(("noise",)), path)
    made = environment.run(("maps",), earlier=environment.read_results(path))
    assert set(made["parts"]) == {"maps", "noise"}
    assert made["variance_gain"] == 2.0
    path.write_text("{}")
    with pytest.raises(LumenrayError, match="holds no results"):
        environment.read_results(path)


@pytest.mark.slow
@pytest.mark.mitsuba
def test_a_part_is_measured_judged_and_told(tmp_path):
    result = environment.run(("shadow", "noise"))
    # A sun that is taken out must not cost: its samples are shared by its light.
    assert result["variance_gain"] > 1.0
    assert result["illuminance_error_percent"] is None
    judged = {bar.demand: bar.passed for bar in environment.check_bars(result)}
    assert judged["shadow of an edge, share of the sun's light"] is True
    assert judged["directions of sources"] is None
    environment.write_results(result, tmp_path, tmp_path / "numbers.json")
    assert json.loads((tmp_path / "numbers.json").read_text())["variance_gain"] > 0.1
    assert "## Noise" in (tmp_path / "environment.md").read_text(encoding="utf-8")
