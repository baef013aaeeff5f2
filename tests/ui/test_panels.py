"""Panels of lights, materials, worlds and renders are drawn onto a layout that checks what is put on it."""

import types

import bpy
import pytest
from material_trees import new_tree
from panels import context, draw, labels_of, new_light

from lumenray import operators, ui
from lumenray.blender_addon.surface_models import MODELS
from lumenray.ui import bake, cloth, compatibility, ink, luminaire, paint, rayset, scattering


def all_panels():
    return [kind.__name__ for kind in ui.CLASSES if issubclass(kind, bpy.types.Panel)]


def test_all_classes_are_registered():
    for kind in (*ui.CLASSES, *operators.CLASSES):
        assert kind.is_registered
        assert hasattr(bpy.types, kind.__name__)


def test_every_panel_of_the_properties_editor_is_only_there_for_our_engine():
    light = new_light("POINT")
    world = bpy.data.worlds.new("World")
    for engine, expected in (("LUMENRAY", True), ("CYCLES", False)):
        where = context(
            engine=engine,
            light=light.light,
            world=world,
            material=bpy.data.materials.new("Paint"),
        )
        for kind in ui.CLASSES:
            # Those that need a file or a composition are looked at in the tests of these.
            files = (
                luminaire.LuminaireChild
                | rayset.RaysetChild
                | scattering.MeasuredPanel
                | paint.PaintPanel
                | ink.InkPanel
                | cloth.ClothPanel
            )
            if issubclass(kind, files | bake.LUMENRAY_PT_luminaire_group):
                continue
            if getattr(kind, "bl_space_type", "") == "PROPERTIES":
                assert bool(kind.poll(where)) is expected, kind.__name__


def test_panels_of_data_that_is_not_there_are_not_drawn():
    for name in all_panels():
        kind = getattr(bpy.types, name)
        if getattr(kind, "bl_context", "") in {"data", "material", "world"}:
            assert not kind.poll(context())


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "SUN", "AREA"])
@pytest.mark.parametrize("physical", [False, True])
def test_light_panels_draw_for_every_kind(kind, physical):
    where = new_light(kind)
    where.light.lumenray.use_physical = physical
    assert {"POINT": "shadow_soft_size", "SPOT": "spot_size", "SUN": "angle", "AREA": "spread"}[
        kind
    ] in draw("LUMENRAY_PT_light", where)
    seen = draw("LUMENRAY_PT_light_photometry", where)
    assert ("value" in seen) is physical
    assert ("energy" in seen) is not physical
    assert draw("LUMENRAY_PT_light_readout", where)
    assert "use_physical" in draw("LUMENRAY_PT_active_light", where)


@pytest.mark.parametrize(
    "spectrum", ["RGB", "ILLUMINANT", "BLACKBODY", "DAYLIGHT", "FILE", "SUNLIGHT"]
)
def test_spectrum_shows_what_belongs_to_it(spectrum):
    where = new_light("AREA")
    where.light.lumenray.use_physical = True
    where.light.lumenray.spectrum = spectrum
    shown = {
        "RGB": "color",
        "ILLUMINANT": "illuminant",
        "BLACKBODY": "colour_temperature",
        "DAYLIGHT": "colour_temperature",
        "FILE": "spectrum_file",
        "SUNLIGHT": "turbidity",
    }
    seen = draw("LUMENRAY_PT_light_photometry", where)
    assert set(shown.values()) & set(seen) == {shown[spectrum]}


@pytest.mark.parametrize("quantity", ["LUMINOUS_FLUX", "LUMINANCE", "RADIANT_FLUX"])
@pytest.mark.parametrize("kind", ["POINT", "SPOT", "SUN", "AREA"])
def test_readout_draws_for_every_quantity(kind, quantity):
    where = new_light(kind)
    where.light.lumenray.use_physical = True
    where.light.lumenray.quantity = quantity
    assert draw("LUMENRAY_PT_light_readout", where)


@pytest.mark.parametrize("model", list(MODELS))
def test_material_override_draws_every_model(model):
    paint = bpy.data.materials.new("Paint")
    settings = paint.lumenray
    settings.use_override = True
    settings.model = model
    for source in ("VALUE", "COLOR", "FILE"):
        settings.reflectance_source = source
        for index in ("CONSTANT", "CAUCHY", "FILE"):
            settings.ior_source = index
            assert "model" in draw("LUMENRAY_PT_material_override", context(material=paint))
    assert draw("LUMENRAY_PT_material_surface", context(material=paint)) is None


def test_saved_files_keep_their_models():
    """A file holds the number of a model: numbers are never given anew."""
    items = bpy.data.materials.new("Paint").lumenray.bl_rna.properties["model"].enum_items
    names = (
        "DIFFUSE",
        "COATED",
        "CONDUCTOR",
        "DIELECTRIC",
        "THIN_GLASS",
        "EMITTER",
        "MEASURED",
        "FABRIC",
        "PAINT",
        "INK",
        "CLOTH",
    )
    assert {item.identifier: item.value for item in items} == {
        name: number for number, name in enumerate(names)
    }


def test_material_without_override_shows_its_nodes():
    tree = new_tree()
    tree.surface(tree.add("BsdfDiffuse"))
    where = context(material=tree.material)
    assert "nodes" in draw("LUMENRAY_PT_material_surface", where)
    tree.material.node_tree.nodes.clear()
    assert "No output node" in draw("LUMENRAY_PT_material_surface", where)


@pytest.mark.parametrize("unit", ["BLENDER", "LUMINANCE", "ILLUMINANCE"])
def test_world_panels_draw(unit):
    world = bpy.data.worlds.new("World")
    world.lumenray.unit = unit
    where = context(world=world)
    assert "unit" in draw("LUMENRAY_PT_world_unit", where)
    assert draw("LUMENRAY_PT_world_surface", where)
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    world.node_tree.nodes.clear()
    assert draw("LUMENRAY_PT_world_surface", where)


@pytest.mark.parametrize("stop", ["SAMPLES", "ERROR", "TIME"])
def test_render_panels_draw_what_their_choice_needs(stop):
    bpy.context.scene.lumenray.render.stop = stop
    drawn = {"SAMPLES": "samples", "ERROR": "error_percent", "TIME": "time"}[stop]
    assert {drawn, "method", "use_unbiased"} <= set(draw("LUMENRAY_PT_sampling", context()))
    for name in ("LUMENRAY_PT_passes", "LUMENRAY_PT_advanced"):
        assert draw(name, context())


@pytest.mark.parametrize("quantity", ["PICTURE", "FALSE_LUMINANCE", "FALSE_ILLUMINANCE"])
def test_the_scale_of_false_colours_tells_its_unit(quantity):
    settings = bpy.context.scene.lumenray
    settings.viewport.display, settings.viewport.automatic = quantity, False
    solid = types.SimpleNamespace(type="RENDERED")
    shown = context(space_data=types.SimpleNamespace(shading=solid))
    texts = labels_of("LUMENRAY_PT_view", shown)
    unit = {"FALSE_LUMINANCE": "cd/m²", "FALSE_ILLUMINANCE": "lx"}.get(quantity)
    assert texts.get("low") == (unit and f"From [{unit}]")
    assert texts.get("high") == (unit and f"To [{unit}]")
    # Pictures have neither lines nor values.
    assert ({"isolux_lines", "use_values"} <= texts.keys()) == (unit is not None)
    settings.viewport.automatic = True
    assert "low" not in labels_of("LUMENRAY_PT_view", shown)


def test_the_film_panel_says_so_where_the_denoiser_is_not_installed(monkeypatch):
    settings = bpy.context.scene.lumenray.render
    settings.use_denoising = True
    monkeypatch.setattr("lumenray.engine.analysis.denoiser.find_denoiser", lambda: "somewhere")

    def is_told():
        return any("Not installed" in text for text in draw("LUMENRAY_PT_film", context()))

    assert not is_told()
    monkeypatch.setattr("lumenray.engine.analysis.denoiser.find_denoiser", lambda: None)
    assert is_told()
    settings.use_denoising = False
    assert not is_told()


def test_film_says_what_becomes_white():
    for exposure in ("LUMINANCE", "EV100", "AUTO"):
        bpy.context.scene.lumenray.exposure = exposure
        assert "exposure" in draw("LUMENRAY_PT_film", context())


def test_the_world_has_a_preview_as_materials_and_lights_have():
    world = bpy.data.worlds.new("World")
    assert "preview" in draw("LUMENRAY_PT_world_preview", context(world=world))


def test_blenders_own_panels_take_our_engine_and_let_it_go():
    for name in (
        "DATA_PT_lens",
        "WORLD_PT_context_world",
        "RENDER_PT_format",
        "VIEWLAYER_PT_layer",
        "DATA_PT_preview",
        "MATERIAL_PT_preview",
    ):
        assert "LUMENRAY" in getattr(bpy.types, name).COMPAT_ENGINES
    assert "LUMENRAY" not in bpy.types.DATA_PT_light.COMPAT_ENGINES
    assert "LUMENRAY" not in bpy.types.DATA_PT_EEVEE_light.COMPAT_ENGINES
    for name in compatibility.TAKEN_TOO:
        assert "LUMENRAY" in getattr(bpy.types, name).COMPAT_ENGINES
    ui.detach()
    for panel in bpy.types.Panel.__subclasses__():
        if panel.__module__.startswith("bl_ui."):
            assert "LUMENRAY" not in getattr(panel, "COMPAT_ENGINES", ())
    ui.attach()
