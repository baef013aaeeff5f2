"""Presets of settings: those that ship say what they set and why, and users can keep their own."""

import ast
import re
import types

import bpy
import pytest
from panels import Drawn, Layout, context, interface

from lumenray.blender_addon import setting_presets
from lumenray.blender_addon.setting_presets import OWNER, ROOT, SUBFOLDER, VALUES
from lumenray.ui import bake, render

FOLDER = ROOT / "presets" / SUBFOLDER
SHIPPED = sorted(FOLDER.iterdir()) if FOLDER.is_dir() else []


@pytest.fixture(scope="module", autouse=True)
def _interface(registered):
    with interface():
        yield


def read(path):
    """Return what a preset sets: values by what they are assigned to, the line of its owner left out."""
    body = ast.parse(path.read_text(encoding="utf-8")).body
    lines = [node for node in body if isinstance(node, ast.Assign)]
    assert ast.unparse(lines[0]) == OWNER
    return {ast.unparse(line.targets[0]): ast.literal_eval(line.value) for line in lines[1:]}


def value_of(name):
    return eval(name, {"settings": bpy.context.scene.lumenray})  # noqa: S307 - names of our own


def apply(path):
    done = bpy.ops.script.execute_preset(filepath=str(path), menu_idname="LUMENRAY_PT_presets")
    assert done == {"FINISHED"}


def test_the_presets_that_ship():
    assert [path.stem for path in SHIPPED] == ["Exhibition", "Office", "Product", "Shop", "Street"]


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_preset_sets_all_that_presets_have_and_nothing_else(path):
    assert tuple(read(path)) == VALUES


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_applying_a_preset_gives_the_scene_its_values(path):
    apply(path)
    for name, value in read(path).items():
        # Numbers beyond their range would be cut off.
        assert value_of(name) == (pytest.approx(value) if isinstance(value, float) else value), name


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_a_preset_says_for_what_levels_it_is_and_why_its_values_are_so(path):
    text = path.read_text(encoding="utf-8")
    assert re.search(r"\d lx", ast.get_docstring(ast.parse(text)))
    for block in text.split("\n\n")[3:]:
        assert block.startswith("# "), block


@pytest.mark.parametrize("path", SHIPPED, ids=lambda path: path.stem)
def test_the_levels_that_a_preset_names_are_on_its_scale(path):
    told = ast.get_docstring(ast.parse(path.read_text(encoding="utf-8")))
    values = read(path)
    for level in map(float, re.findall(r"(\d+) lx", told)):
        assert values["settings.look.low"] <= level <= values["settings.look.high"]
        assert values["settings.viewport.low"] <= level <= values["settings.viewport.high"]


def test_blender_finds_them_while_the_extension_is_on():
    assert str(FOLDER) in bpy.utils.preset_paths(SUBFOLDER)
    setting_presets.attach()
    assert bpy.utils.preset_paths(SUBFOLDER).count(str(FOLDER)) == 1
    setting_presets.detach()
    try:
        assert str(FOLDER) not in bpy.utils.preset_paths(SUBFOLDER)
        setting_presets.detach()
    finally:
        setting_presets.attach()


def test_what_a_user_keeps_comes_back_and_can_be_removed(tmp_path, monkeypatch):
    monkeypatch.setattr(bpy.utils, "user_resource", lambda *_, path, create: str(tmp_path))
    monkeypatch.setattr(bpy.utils, "preset_paths", lambda _: [str(tmp_path)])
    settings = bpy.context.scene.lumenray
    settings.bake.density, settings.white_luminance, settings.render.stop = 3.0, 77.0, "TIME"
    settings.render.time, settings.bake.use_samples, settings.bake.samples = 5.0, True, 99
    assert bpy.ops.lumenray.add_preset(name="Church") == {"FINISHED"}
    assert tuple(read(tmp_path / "Church.py")) == VALUES
    apply(FOLDER / "Office.py")
    assert not settings.bake.use_samples
    apply(tmp_path / "Church.py")
    assert settings.bake.density == 3.0
    assert settings.white_luminance == 77.0
    assert settings.render.stop == "TIME"
    assert settings.render.time == 5.0
    assert settings.bake.use_samples
    assert settings.bake.samples == 99
    assert bpy.ops.lumenray.add_preset(name="Church", remove_name=True) == {"FINISHED"}
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("panel", [render.LUMENRAY_PT_sampling, bake.LUMENRAY_PT_bake])
@pytest.mark.parametrize("engine", ["LUMENRAY", "CYCLES"])
def test_the_button_is_in_the_headers_while_our_engine_is_chosen(panel, engine):
    shown = []
    layout = Layout()
    layout.popover = lambda panel, icon, text: shown.append(panel)
    panel.draw_header_preset(Drawn(panel, layout), context(engine=engine))
    assert shown == (["LUMENRAY_PT_presets"] if engine == "LUMENRAY" else [])


def test_the_menu_lists_the_presets_by_name():
    listed = []

    class Menu(Layout):
        def operator(self, idname, text=None, icon="NONE", translate=True):
            made = types.SimpleNamespace()
            if idname == "script.execute_preset":
                listed.append((text, made))
            return made

        def _part(self, **_):
            return self

        row = column = _part

        def separator(self):
            pass

    kind = bpy.types.LUMENRAY_PT_presets
    kind.draw(Drawn(kind, Menu()), context())
    assert [text for text, _ in listed] == ["Exhibition", "Office", "Product", "Shop", "Street"]
    assert all(made.menu_idname == "LUMENRAY_PT_presets" for _, made in listed)
