"""What the benchmark of pictures makes of its runs: summary, bars, document, and going on with an earlier run."""

import json

import numpy as np
import pytest

pytestmark = pytest.mark.mitsuba


def row_of(scale: float, stated=None) -> dict:
    """Program whose error is 0.5 / sqrt(n), each sample ``scale`` seconds; ``stated`` over true."""
    samples = [2**k for k in range(1, 8)]
    errors = [0.5 / np.sqrt(n) for n in samples]
    return {
        "samples": samples,
        "seconds": [scale * n for n in samples],
        "errors": errors,
        "stated": [None if stated is None else stated * error for error in errors],
        "reference_error": 0.03,
        "mean": 50.0,
        "mean_error": 0.1,
    }


def made_up_scene(key: str, cycles: float, before: float, honesty: float, worst: float) -> dict:
    """Scene in which the others take ``cycles`` and ``before`` times as long as ours."""
    bias = dict.fromkeys(("mean", "noise", "spread", "largest", "interval"), 0.25)
    bias |= {"seeds": 8, "blocks": 1000, "worst": worst, "mean_interval": 0.1}
    return {
        "key": key,
        "title": key.title(),
        "size": [640, 400],
        "budget": 240.0,
        "programs": {
            "Lumenray": row_of(0.1, honesty),
            "before": row_of(0.1 * before, honesty),
            "cycles": row_of(0.1 * cycles),
        },
        "bias": bias | {"samples": 8, "sharing": bias | {"worst": 7.0}},
        "stand_ins": [],
        "pair": [5.0, 5.1],
        "seconds": 99.0,
        "other_load": 0.5,
    }


def made_up_result(scenes=None) -> dict:
    """Whole result."""
    from lumenray.benchmarks.pictures.summary import summarise

    if scenes is None:
        scenes = [
            made_up_scene("office", 40.0, 9.0, 1.0, 0.1),
            made_up_scene("product", 10.0, 4.5, 1.2, 0.3),
        ]
    names = ("cpu", "cores", "memory_gib", "system", "python", "mitsuba", "lumenray")
    return {
        **summarise(scenes),
        "machine": dict.fromkeys(names, "-"),
        "size": [640, 400],
        "budget": 240.0,
        "has_methods": True,
        "scenes": scenes,
    }


def test_the_summary_is_of_all_scenes():
    result = made_up_result()
    assert result["speedup"]["cycles"] == pytest.approx(20.0)
    assert result["speedup"]["before"] == pytest.approx(np.sqrt(9.0 * 4.5))
    assert result["speedup"]["scenes"]["product"]["cycles"] == pytest.approx(10.0)
    assert result["bias_percent"] == 0.3
    assert result["calibration"] == pytest.approx(1.1)


def test_what_was_not_measured_is_not_summed_up():
    scene = made_up_scene("office", 40.0, 9.0, 1.0, 0.1) | {"bias": None}
    scene["programs"] = {
        "Lumenray": scene["programs"]["Lumenray"],
        "cycles": {"refusal": "no Blender"},
    }
    result = made_up_result([scene])
    assert result["speedup"] == {
        "cycles": None,
        "before": None,
        "scenes": {"office": {"cycles": None, "before": None}},
    }
    assert result["bias_percent"] is None


def test_the_bars_tell_what_is_met_and_what_is_not():
    from lumenray.benchmarks.pictures.bars import check_bars

    bars = {bar.demand: bar for bar in check_bars(made_up_result())}
    assert bars["time of Cycles over ours"].passed is False
    assert bars["time of plain paths of ours over ours"].passed is True
    assert bars["the same in the worst scene"].measured == "x 10 (product)"
    assert bars["bias of the worst block beyond noise"].passed is True
    assert bars["stated over true error, every scene"].measured == "1.20 at worst (product)"
    assert bars["stated over true error, every scene"].passed is False


def test_the_document_and_its_pictures_are_written(tmp_path):
    from lumenray.benchmarks.pictures import run as pictures
    from lumenray.benchmarks.pictures.programs import Made

    result = made_up_result()
    grey = np.full((40, 64, 3), 30.0)
    pictures.write_pair(
        [Made(grey, grey[..., 0], 5.0), Made(grey, grey[..., 0], 5.1)], "office", tmp_path
    )
    pictures.write_results(result, tmp_path, tmp_path / "all.json")
    text = (tmp_path / "pictures.md").read_text(encoding="utf-8")
    # 0.5 / sqrt(25) is 10 %; Cycles takes 40 times as long, and 2 % lies beyond its runs.
    assert "| Office (`office`) | 10 % | 2.5 |" in text
    assert "x 40" in text
    assert "2.5e+03\\*" in text or "2500\\*" in text
    for name in ("pictures_races.png", "pictures_office.png"):
        assert f"({name})" in text
        assert (tmp_path / name).stat().st_size > 100
    assert "Times are not to be relied on" in text
    assert "This was a short run" not in text
    # What sharing moves is told, and is none of what cells change.
    assert text.count("| 7.000 |") == 2
    read = pictures.read_results(tmp_path / "all.json")
    assert read["speedup"] == json.loads(json.dumps(result["speedup"]))


def test_results_that_do_not_tell_what_sharing_moves_are_gone_on_with(tmp_path):
    from lumenray.benchmarks.pictures.document import write_document

    result = made_up_result()
    for scene in result["scenes"]:
        del scene["bias"]["sharing"]
    write_document(result, tmp_path / "pictures.md")
    text = (tmp_path / "pictures.md").read_text(encoding="utf-8")
    assert "## Bias" in text
    assert "What sharing light" not in text


def test_a_run_keeps_each_scene_and_goes_on_with_an_earlier_one(monkeypatch):
    from lumenray.benchmarks.pictures import run as pictures

    asked, kept = [], []

    def measure_scene(key, size, budget, with_peers, say, by_processor, only_races):
        asked.append(key)
        if key == "window":
            raise KeyboardInterrupt
        return made_up_scene(key, 30.0, 6.0, 1.0, 0.1) | {"size": list(size)}, None

    def keep(result, key, _pair):
        kept.append((key, [scene["key"] for scene in result["scenes"]]))

    monkeypatch.setattr(pictures, "measure_scene", measure_scene)
    small = (240, 150)
    with pytest.raises(KeyboardInterrupt):
        pictures.measure(("glass", "cabin", "window"), small, 9.0, keep)
    # In the order of the scenes, whatever that of the run.
    assert kept == [("glass", ["glass"]), ("cabin", ["cabin", "glass"])]
    earlier = {"scenes": [made_up_scene("cabin", 1.0, 1.0, 1.0, 0.0) | {"size": list(small)}]}
    asked.clear()
    result = pictures.measure(("cabin", "glass"), small, 9.0, keep, earlier=earlier)
    assert asked == ["glass"]
    assert result["speedup"]["scenes"]["cabin"]["cycles"] == pytest.approx(1.0)
    # Pictures of another size are made anew.
    asked.clear()
    pictures.measure(("cabin",), (640, 400), 9.0, keep, earlier=earlier)
    assert asked == ["cabin"]


def test_equal_time_is_the_longest_that_both_have():
    from lumenray.benchmarks.pictures.programs import Made
    from lumenray.benchmarks.pictures.race import pair_at_equal_time

    grey = np.ones((2, 2))
    made = {
        "a": [Made(grey, grey, seconds) for seconds in (1.0, 2.0, 4.0, 8.0)],
        "b": [Made(grey, grey, seconds) for seconds in (0.5, 1.5, 4.5)],
    }
    assert [each.seconds for each in pair_at_equal_time(made, ("a", "b"))] == [4.0, 4.5]


def test_the_command_refuses_what_it_cannot_measure(capsys, tmp_path):
    from lumenray.command_line.main import main

    assert main(["benchmark", "pictures", "--scenes", "palace", "-o", str(tmp_path)]) != 0
    assert "there is no scene palace; choose from office, cabin" in capsys.readouterr().err
    assert main(["benchmark", "pictures", "--resume", "-o", str(tmp_path)]) != 0
    assert "--resume needs --json" in capsys.readouterr().err


def test_a_card_is_told_beside_the_processors_of_its_machine(tmp_path):
    from lumenray.benchmarks.pictures.document import write_document

    def result_of(speed, device, mean):
        scene = made_up_scene("office", 1.0, 4.0 * speed, 1.0, 0.1)
        scene["programs"]["Lumenray"] = row_of(0.1 * speed, 1.0) | {"mean": mean}
        return made_up_result([scene]) | {"device": device}

    whole = made_up_result() | {
        "card": [result_of(1.0, "A card", 50.0), result_of(3.0, "Cores", 51.0)]
    }
    write_document(whole, tmp_path / "pictures.md")
    text = (tmp_path / "pictures.md").read_text()
    assert "A card, beside Cores, of one machine" in text
    # Three times as fast at every error; 1 cd/m2 less, of which both are known to 0.1.
    assert "| x 3 | 50 and 51, -7.1 |" in text
    assert "Lumenray: x 3; plain paths of ours: x 3." in text
