"""The benchmark of Blender's content: its scenes, and how it judges."""

import json

import bpy
import pytest

from lumenray.benchmarks.content import run as content
from lumenray.engine.errors import LumenrayError

pytestmark = pytest.mark.usefixtures("extension")


@pytest.fixture(scope="module")
def features():
    from lumenray.benchmarks.content.features import FEATURES

    return FEATURES


def test_every_scene_is_built_and_has_a_camera_and_light(features):
    from lumenray.benchmarks.content.stage import Stage

    assert len(features) > 150
    for key, feature in features.items():
        feature.build(Stage())
        scene = bpy.context.scene
        assert scene.camera is not None, key
        assert scene.world is not None or any(o.type == "LIGHT" for o in scene.objects), key


def row(mean, block, said=(), agrees=False):
    return {
        "group": "Surfaces",
        "mean": mean,
        "mean_error": 0.0,
        "block": block,
        "agrees": agrees,
        "said": list(said),
    }


def test_the_document_tells_what_is_silent(tmp_path):
    result = {
        "blender": "5.0.1",
        "scenes": {
            "Paint": row(0.001, 0.002, agrees=True),
            "Hair": row(0.2, 0.3, ["error: Hair: left out"]),
            "Secret": row(-0.1, 0.2),
            "Linked": row(-0.1, 0.2, ["error: Lamp: lights all"]) | {"left_out": "there is no lux"},
            "Hushed": row(-0.1, 0.2) | {"left_out": "nobody said so"},
        },
        "silent": ["Secret", "Hushed"],
        "over": ["Hair", "Secret", "Hushed"],
    }
    content.write_results(result, tmp_path, tmp_path / "content.json")
    text = (tmp_path / "content.md").read_text()
    assert "| Paint |  | +0.1% | 0.2% |  |" in text
    assert "| Hair | error: Hair: left out | +20.0% | 30.0% | differs |" in text
    assert "| Secret |  | -10.0% | 20.0% | **silent** |" in text
    assert "| Linked | error: Lamp: lights all | -10.0% | 20.0% | left out |" in text
    assert "Left out:\n\n- Linked: there is no lux.\n" in text
    assert "| Hushed |  | -10.0% | 20.0% | **silent** |" in text
    assert json.loads((tmp_path / "content.json").read_text())["silent"] == ["Secret", "Hushed"]
    silent, agreeing = content.check_bars(result)
    assert (silent.passed, silent.measured) == (False, "Secret, Hushed")
    assert agreeing.measured == "1, 3 differ, 1 left out"


def test_only_features_that_there_are_have_a_reason(features):
    assert set(content.REASONS) <= set(features)


def test_unknown_features_are_refused():
    with pytest.raises(LumenrayError, match="no feature 'Fog'"):
        content.run(["Fog"])


@pytest.mark.mitsuba
@pytest.mark.slow
def test_paints_agree_and_what_is_left_out_is_said():
    result = content.run(["Diffuse", "Principled, metal 0.6", "Volume, scatter"])
    assert (result["over"], result["silent"]) == ([], [])
    volume = result["scenes"].pop("Volume, scatter")
    assert content.is_left_out(volume)
    assert volume["block"] > 0.05
    assert all(row["agrees"] for row in result["scenes"].values())


def test_earlier_results_are_gone_on_with_and_only_what_is_named_is_measured_again(
    features, monkeypatch
):
    from types import SimpleNamespace

    from lumenray.benchmarks.content import compare

    measured = []

    def made(_folder):
        measured.append(len(measured))
        return SimpleNamespace(mean=0.0, mean_error=0.0, block=0.0, said=())

    monkeypatch.setattr(compare, "compare", made)
    first, *others = features
    earlier = {
        "scenes": {key: row(0.2, 0.3) for key in others} | {"A feature of before": row(0.2, 0.3)},
        "silent": [],
        "over": [],
    }
    result = content.run(earlier=earlier)
    assert len(measured) == 1
    assert list(result["scenes"]) == list(features)
    assert result["scenes"][first]["agrees"]
    assert first not in result["silent"]
    assert others[0] in result["silent"]
    again = content.run(others[:1], earlier=result)
    assert len(measured) == 2
    assert again["scenes"][others[0]]["agrees"]
    assert again["silent"] == others[1:]
