"""What a bake asks the engine for: by the settings, by a script, and what it goes on from."""

import bpy
import pytest
from blender_bakes import bake_all
from blender_objects import add_quad

from lumenray.blender_addon.bake import folders as bake_folders

pytestmark = pytest.mark.usefixtures("extension")


def test_settings_reach_the_engine(fake_engine, tmp_path):
    settings = bpy.context.scene.lumenray
    floor = add_quad("Floor")
    floor.lumenray.density, floor.lumenray.two_sided = 3.0, True
    for name, value in {
        "density": 7.0, "from_textures": True, "largest": 512, "pages": 3, "margin": 6, "cone": 0.5, "detail": 0.1,
        "exitance": True, "denoise": True, "isolux": True, "method": "PATHS", "caustics": "OFF", "use_error": True,
        "error": 0.01, "use_absolute": True, "absolute": 4.0, "use_time": True, "time": 9.0,
    }.items():  # fmt: skip
        setattr(settings.bake, name, value)
    settings.seed = 5
    bake_all(tmp_path)
    order = fake_engine.order
    (key,) = order.objects
    assert order.densities == {key: 3.0}
    assert order.two_sided == (key,)
    wanted = (
        7.0,
        True,
        512,
        3,
        6,
        pytest.approx(0.5),
        pytest.approx(0.1),
        True,
        True,
        True,
        "paths",
        "off",
        5,
    )
    found = (order.density, order.from_textures, order.largest, order.pages, order.margin, order.cone, order.detail,
             order.exitance, order.denoise, order.isolux, order.method, order.caustics, order.seed)  # fmt: skip
    assert found == wanted
    rule = order.rule
    assert (rule.samples, rule.error, rule.seconds, rule.absolute) == (
        None, pytest.approx(0.01), pytest.approx(9.0), 4.0,
    )  # fmt: skip
    assert order.checkpoint == str(tmp_path / bake_folders.CHECKPOINT)


def test_a_rule_of_a_script_stands_alone(fake_engine, tmp_path):
    add_quad("Floor")
    bake_all(tmp_path, absolute=2.0, density=5.0)
    rule = fake_engine.order.rule
    assert (rule.samples, rule.error, rule.seconds, rule.absolute) == (None, None, None, 2.0)
    assert fake_engine.order.density == 5.0


def test_a_rule_with_nothing_on_is_refused_in_words(fake_engine, tmp_path):
    add_quad("Floor")
    bpy.context.scene.lumenray.bake.use_error = False
    with pytest.raises(RuntimeError, match="no stopping rule"):
        bake_all(tmp_path)


def test_only_a_bake_that_is_there_is_resumed(fake_engine, tmp_path):
    add_quad("Floor")
    with pytest.raises(RuntimeError, match="no interrupted bake"):
        bake_all(tmp_path, resume=True)
    kept = tmp_path / bake_folders.CHECKPOINT
    kept.write_bytes(b"state")
    bpy.context.scene.lumenray.bake.use_checkpoint = False
    bake_all(tmp_path, resume=True)
    assert kept.read_bytes() == b"state"
    assert fake_engine.order.checkpoint == str(kept)


def test_a_new_bake_forgets_the_interrupted_one(fake_engine, tmp_path, monkeypatch):
    add_quad("Floor")
    bake_all(tmp_path)
    kept = tmp_path / bake_folders.CHECKPOINT
    kept.write_bytes(b"state")
    seen = []
    real = fake_engine.bake_objects
    monkeypatch.setattr(
        fake_engine, "bake_objects", lambda *a: (seen.append(kept.exists()), real(*a))[1]
    )
    bake_all(tmp_path)
    assert seen == [False]
