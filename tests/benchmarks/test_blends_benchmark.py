"""The benchmark of whole files: what it renders of them, how it judges, and what its page tells."""

from pathlib import Path

import bpy
import numpy as np
import pytest

from lumenray.benchmarks.blends import pair
from lumenray.benchmarks.blends import run as blends
from lumenray.engine.errors import LumenrayError

pytestmark = pytest.mark.usefixtures("extension")


@pytest.fixture
def folder(tmp_path):
    """A file with a world of one luminance and no camera."""
    scene = bpy.context.scene
    world = scene.world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.5, 0.5, 0.5, 1.0)
    bpy.ops.mesh.primitive_cube_add()
    scene.render.resolution_x, scene.render.resolution_y = 1920, 1080
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "plain.blend"))
    return tmp_path


def test_a_file_is_rendered_small_by_both_programs_and_judged(folder, monkeypatch):
    monkeypatch.setattr(pair, "SAMPLES", dict.fromkeys(pair.SAMPLES, 16))
    monkeypatch.setattr(pair, "WIDTH", 32)
    result, pictures = blends.run(folder)
    row = result["files"]["plain"]
    assert pictures["plain"].shape == (2, 18, 32, 3)
    assert not row["has_camera"]
    # Background of 0.5 around a cube that reflects 0.8 of it.
    efficacy = bpy.context.scene.lumenray.efficacy
    assert all(0.3 * efficacy < mean < 0.5 * efficacy for mean in row["means"])
    assert abs(row["mean"]) < 0.03
    with pytest.raises(LumenrayError, match=r"holds no file other\.blend"):
        blends.run(folder, ["other"])
    with pytest.raises(LumenrayError, match=r"holds no \.blend files"):
        blends.run(folder / "nothing")


def test_noise_is_no_difference_and_a_shift_is_one():
    random = np.random.default_rng(3)
    shape = (2, 64, 96, 3)
    noisy = [1.0 + 0.3 * random.standard_normal(shape) for _ in range(2)]
    made = pair.judge(*noisy, 2.0, True, ())
    assert blends.agrees(made)
    assert made.block < 0.02
    assert made.means == pytest.approx((2.0, 2.0), rel=0.01)
    noisy[1][..., :48, :] *= 1.2
    made = pair.judge(*noisy, 2.0, True, ())
    assert not blends.agrees(made)
    assert made.mean == pytest.approx(0.1, abs=0.02)
    assert made.block == pytest.approx(0.2 / 2**0.5, rel=0.1)


def test_two_black_pictures_are_alike_and_one_is_not():
    black, lit = np.zeros((2, 16, 16, 3)), np.ones((2, 16, 16, 3))
    assert blends.agrees(pair.judge(black, black, 1.0, True, ()))
    assert pair.judge(black, lit, 1.0, True, ()).mean == 1.0
    assert pair.judge(lit, black, 1.0, True, ()).mean == -1.0


def test_the_page_tells_reasons_and_what_lacks_one(tmp_path, monkeypatch):
    def row(mean, agrees, said=()):
        return {
            "means": [100.0, 100.0 * (1.0 + mean)],
            "mean": mean,
            "mean_error": 0.0,
            "block": abs(mean),
            "agrees": agrees,
            "has_camera": agrees,
            "said": list(said),
        }

    said = [f"error: Lamp: row {number}" for number in range(9)]
    result = {
        "blender": "5.0.1",
        "files": {
            "room": row(0.001, True),
            "fog": row(-0.2, False, said),
            "hall": row(0.1, False),
        },
    }
    reasons = {"fog": "the fog is left out"}
    monkeypatch.setattr(blends, "REASONS", reasons)
    for function in (blends.tell_reasons, blends.check_bars):
        monkeypatch.setattr(function, "__defaults__", (reasons,))
    picture = np.full((2, 16, 24, 3), 0.5, np.float32)
    blends.write_results(result, dict.fromkeys(result["files"], picture), tmp_path, None)
    text = Path(tmp_path, "blends.md").read_text(encoding="utf-8")
    assert "| room | 100 | 100.1 | +0.1% | 0.1% |  |" in text
    assert "- **fog**: the fog is left out." in text
    assert "- **hall**: not looked into yet." in text
    assert "Not met: differences without a reason: hall." in text
    assert "and 3 more rows" in text
    assert Path(tmp_path, blends.SHEET).stat().st_size > 100
