"""Panels of the bake: what is shown of results, looks and groups."""

from types import SimpleNamespace

import bpy
import numpy as np
from blender_bakes import add_lamp, bake_all
from blender_objects import add_quad, new_paint
from fake_bakes import make_page, make_result
from panels import Drawn, Layout, context, draw, settings_drawn

from lumenray.blender_addon import feedback
from lumenray.blender_addon.bake import folders as bake_folders
from lumenray.blender_addon.bake import look as baked_look
from lumenray.blender_addon.bake import results as baked_results
from lumenray.engine.accuracy.extremes import Extreme
from lumenray.engine.accuracy.stopping import Progress
from lumenray.engine.baking.order import Layout as MapLayout
from lumenray.engine.baking.order import LuxMap
from lumenray.engine.scene.provenance import Provenance
from lumenray.ui import bake


def test_panels_draw_what_is_there(fake_engine, tmp_path):
    add_quad("Floor", material=new_paint())
    add_lamp("A", "Ceiling")
    settings = bpy.context.scene.lumenray
    settings.bake.layers = "GROUPS"
    shading = bpy.types.View3DShading
    view = SimpleNamespace(shading=SimpleNamespace(type="MATERIAL", bl_rna=shading.bl_rna))
    assert draw("LUMENRAY_PT_baked_light", context(space_data=view)) is None
    bake_all(tmp_path)
    assert "lumenray.show_baked" in draw("LUMENRAY_PT_baked_light", context(space_data=view))
    baked_look.show(bpy.context.scene)
    seen = draw("LUMENRAY_PT_baked_light", context(space_data=view))
    assert {"lumenray.hide_baked", "kind", "LUMENRAY_UL_layers"} <= set(seen)
    settings.look.kind = "FALSE"
    assert "high" in draw("LUMENRAY_PT_baked_light", context(space_data=view))
    said = draw("LUMENRAY_PT_results_whole", context())
    assert "to 80 %" in said
    for name in ("layout", "light", "output"):
        assert draw(f"LUMENRAY_PT_lux_bake_{name}", context())


def test_a_luminaire_that_is_an_empty_has_its_group_in_a_panel():
    empty = bpy.data.objects.new("Luminaire", None)
    bpy.context.scene.collection.objects.link(empty)
    assert draw("LUMENRAY_PT_luminaire_group", context(object=empty)) is None
    empty.lumenray.luminaire.use_file = True
    assert "light_group" in draw("LUMENRAY_PT_luminaire_group", context(object=empty))
    assert draw("LUMENRAY_PT_luminaire_group", context(object=empty, engine="CYCLES")) is None


def test_resume_is_offered_where_the_folder_holds_a_state(tmp_path):
    settings = bpy.context.scene.lumenray
    settings.bake.folder = str(tmp_path)
    item = add_quad("Floor")
    where = context(selected_objects=[item], object=item)
    assert draw("LUMENRAY_PT_bake", where).count("lumenray.bake_illuminance") == 1
    (tmp_path / bake_folders.CHECKPOINT).write_bytes(b"state")
    assert draw("LUMENRAY_PT_bake", where).count("lumenray.bake_illuminance") == 2


def test_the_bake_panel_says_so_where_a_bake_would_never_end():
    settings = bpy.context.scene.lumenray
    seen = draw("LUMENRAY_PT_lux_bake", context())
    for name, amount in (
        ("error", "error_percent"),
        ("absolute", "absolute"),
        ("time", "time"),
        ("samples", "samples"),
    ):
        assert {f"use_{name}", amount} <= set(seen)
    assert not any("never end" in text for text in seen)
    settings.bake.use_error = False
    assert any("never end" in text for text in draw("LUMENRAY_PT_lux_bake", context()))


def test_an_object_without_a_density_of_its_own_shows_the_scenes():
    mesh = bpy.data.objects.new("Floor", bpy.data.meshes.new("Floor"))
    where = context(selected_objects=[mesh], object=mesh)
    settings, scenes = mesh.lumenray, bpy.context.scene.lumenray.bake
    scenes.density = 12.0

    def owners():
        drawn = settings_drawn("LUMENRAY_PT_bake", where)
        return [owner for owner, name, _ in drawn if name == "density"]

    assert "use_density" in draw("LUMENRAY_PT_bake", where)
    assert owners() == [scenes, scenes]
    settings.use_density = True
    assert settings.density == 12.0
    assert owners() == [scenes, settings]
    settings.use_density = False
    assert settings.density == 0.0


def test_bake_panel_shows_a_button_or_progress():
    mesh = bpy.data.objects.new("Floor", bpy.data.meshes.new("Floor"))
    where = context(selected_objects=[mesh], object=mesh)
    seen = draw("LUMENRAY_PT_bake", where)
    assert "1 object selected" in seen
    assert "lumenray.bake_illuminance" in seen
    assert "Select the objects to bake" in draw("LUMENRAY_PT_bake", context())
    manager = bpy.context.window_manager
    feedback.begin_job(manager)
    feedback.show_progress(manager, Progress(0.4267, 8, 0.031, 20.0, 27.4, "passes"))
    seen = draw("LUMENRAY_PT_bake", where)
    # Rounded down.
    assert "42 %" in seen
    assert {"passes", "8", "3.10 %", "27 s"} <= set(seen)
    assert any(text.startswith("Esc stops") for text in seen)
    assert "lumenray.bake_illuminance" not in seen


def lux_map(name="Floor", mean=500.0):
    uv = np.zeros((1, 3, 2), np.float32)
    corners = np.array([[0, 1, 2]], np.int32)
    return LuxMap(
        id=f"object:{name}",
        name=name,
        number=0,
        lumels=12500,
        charts=1,
        mean=mean,
        least=Extreme(0.5 * mean, 0.45 * mean, 0.55 * mean),
        largest=Extreme(1.5 * mean, 1.4 * mean, 1.7 * mean),
        relative_standard_error=0.1,
        mean_standard_error=2.0,
        bias=-0.4,
        bias_error=0.2,
        samples=64.0,
        density=8.0,
        requested_density=8.0,
        area=10.0,
        invalid=7,
        provenance=Provenance("0", "llvm_ad_mono", "hash", 0, 64, 1.5),
        layout=MapLayout(uv, np.zeros(1, np.int32), corners, None, 3),
    )


def test_results_are_shown_with_their_error():
    assert draw("LUMENRAY_PT_results", context()) is None
    scene = bpy.context.scene
    made = make_result([lux_map(), lux_map("Desk", 750.0)], [make_page(0)])
    baked_results.store_results(scene, made, "lux")
    scene.lumenray.baked.row_index = 1
    said = draw("LUMENRAY_PT_results", context())
    assert "750.0 ± 2.0 lx" in said
    assert {"0.50", "338 to 412 lx", "1\u2009050 to 1\u2009275 lx", "0.45 to 0.55"} <= set(said)
    assert "-0.40 ± 0.20 lx" in said
    assert "7 lumels, filled" in said
    whole = draw("LUMENRAY_PT_results_whole", context())
    assert "2 %" in whole
    assert "12 s" in whole
    assert "1.00 lx (noise 1.20 lx)" in whole
    layout = Layout()
    list_ = Drawn(bake.LUMENRAY_UL_results, layout)
    bake.LUMENRAY_UL_results.draw_item(
        list_, context(), layout, scene.lumenray.baked, scene.lumenray.baked.rows[0], 0, None, ""
    )
    assert layout.seen == ["Floor", "500 lx"]
