"""Every panel is drawn onto a layout that checks what is put on it."""

import ast
import re
import types
from pathlib import Path

import bpy
import numpy as np
import pytest
from fake_bakes import make_page, make_result
from lumenray import operators, ui
from lumenray.blender_addon import feedback, preferences, properties, readout
from lumenray.blender_addon.bake import results as baked_results
from lumenray.blender_addon.foundation import probe
from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.foundation.units import format_lengths
from lumenray.engine.accuracy.extremes import Extreme
from lumenray.engine.accuracy.stopping import Progress
from lumenray.engine.baking.order import Layout as MapLayout
from lumenray.engine.baking.order import LuxMap
from lumenray.engine.scene.provenance import Provenance
from lumenray.engine.transport.backend import BackendStatus
from lumenray.ui import bake, compatibility, luminaire, material, rayset, scattering, sidebar
from panels import Drawn, Layout, context, draw, interface, new_light


@pytest.fixture(scope="module", autouse=True)
def _interface(registered):
    with interface():
        yield


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
            # Those that need a file are looked at in test_luminaire_ui, test_raysets and test_scattering.
            files = luminaire.LuminaireChild | rayset.RaysetChild | scattering.MeasuredPanel
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


@pytest.mark.parametrize("spectrum", ["RGB", "ILLUMINANT", "BLACKBODY", "DAYLIGHT", "FILE"])
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


@pytest.mark.parametrize("model", list(material.DRAWN))
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


def test_every_model_of_the_properties_can_be_drawn():
    items = bpy.data.materials.new("Paint").lumenray.bl_rna.properties["model"].enum_items
    assert set(items.keys()) == set(material.DRAWN)


def test_material_without_override_shows_its_nodes(tree):
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
    settings = bpy.context.scene.lumenray
    settings.stop = stop
    drawn = {"SAMPLES": "samples", "ERROR": "error_percent", "TIME": "time"}[stop]
    assert drawn in draw("LUMENRAY_PT_sampling", context())
    for name in ("LUMENRAY_PT_passes", "LUMENRAY_PT_advanced"):
        assert draw(name, context())


def test_the_bake_panel_says_so_where_a_bake_would_never_end():
    settings = bpy.context.scene.lumenray
    seen = draw("LUMENRAY_PT_lux_bake", context())
    for name, amount in (
        ("error", "error_percent"),
        ("absolute", "absolute"),
        ("time", "time"),
        ("samples", "samples"),
    ):
        assert {f"bake_use_{name}", f"bake_{amount}"} <= set(seen)
    assert not any("never end" in text for text in seen)
    settings.bake_use_error = False
    assert any("never end" in text for text in draw("LUMENRAY_PT_lux_bake", context()))


def test_errors_are_shown_in_per_cent_and_kept_as_shares():
    settings = bpy.context.scene.lumenray
    for name in ("error", "bake_error"):
        setattr(settings, name, 0.02)
        assert getattr(settings, f"{name}_percent") == pytest.approx(2.0)
        setattr(settings, f"{name}_percent", 0.5)
        assert getattr(settings, name) == pytest.approx(0.005)
        assert settings.bl_rna.properties[f"{name}_percent"].subtype == "PERCENTAGE"


def test_an_object_without_a_density_of_its_own_shows_the_scenes():
    mesh = bpy.data.objects.new("Floor", bpy.data.meshes.new("Floor"))
    where = context(selected_objects=[mesh], object=mesh)
    settings = mesh.lumenray
    bpy.context.scene.lumenray.bake_density = 12.0
    seen = draw("LUMENRAY_PT_bake", where)
    assert "use_density" in seen
    assert "density" not in seen
    settings.use_density = True
    assert settings.density == 12.0
    assert "density" in draw("LUMENRAY_PT_bake", where)
    settings.use_density = False
    assert settings.density == 0.0


def test_designers_are_not_shown_what_an_edit_cost_the_engine():
    status = types.SimpleNamespace(
        changed="Cube moved", sent=1, action="moved", walk=0.01, transfer=0.01, commit=0.01,
        first_sample=0.01, error=0.012, samples=64, is_error=False, message="",
    )  # fmt: skip
    told = " ".join(f"{label} {value}" for label, value in readout.describe_edit(status))
    assert "Picture error 1.2 %" in told
    assert "ms" not in told
    assert any("ms" in value for _, value in readout.describe_timing(status))


def test_lengths_follow_the_units_of_the_scene():
    units = bpy.context.scene.unit_settings
    light = new_light("POINT").light
    settings = light.lumenray.rayset
    settings.width_position = 2.0
    assert settings.position_spread == pytest.approx(0.002)
    units.scale_length = 0.01
    assert settings.position_spread == pytest.approx(0.2)
    settings.position_spread = 0.1
    assert settings.width_position == pytest.approx(1.0)
    assert settings.bl_rna.properties["position_spread"].subtype == "DISTANCE"
    assert format_lengths([0.0254, 0.508]) == "25.4 × 508 mm"
    units.system = "IMPERIAL"
    assert format_lengths([0.0254, 0.508]) == "1 × 20 in"
    assert format_lengths([3.048]) == "10 ft"


def test_settings_that_do_not_follow_the_units_of_the_scene_say_so():
    """Preferences are of no scene, and densities are compared between scenes, in files and on the command line."""
    scene, item = properties.LumenraySceneSettings, properties.LumenrayObjectSettings
    own = preferences.LumenrayPreferences
    for group, name in ((own, "solid_radius"), (scene, "bake_density"), (item, "density")):
        setting = group.bl_rna.properties[name]
        assert "metre" in setting.description
        assert "whatever the units of the scene" in setting.description
        # Blender shows lengths by the units and the scale of the open scene.
        assert setting.subtype == "NONE"


@pytest.mark.parametrize("quantity", ["PICTURE", "FALSE_LUMINANCE", "FALSE_ILLUMINANCE"])
def test_the_scale_of_false_colours_tells_its_unit(quantity):
    settings = bpy.context.scene.lumenray
    settings.viewport_display, settings.viewport_automatic = quantity, False
    solid = types.SimpleNamespace(type="RENDERED")
    shown = context(space_data=types.SimpleNamespace(shading=solid))
    texts = labels("LUMENRAY_PT_view", shown)
    unit = {"FALSE_LUMINANCE": "cd/m²", "FALSE_ILLUMINANCE": "lx"}.get(quantity)
    assert texts.get("viewport_low") == (unit and f"From [{unit}]")
    assert texts.get("viewport_high") == (unit and f"To [{unit}]")
    settings.viewport_automatic = True
    assert "viewport_low" not in labels("LUMENRAY_PT_view", shown)


def labels(name, where):
    """Draw a panel and return the texts that its settings are given."""
    found = {}

    class Labelled(Layout):
        def _part(self, **_):
            return self

        row = column = box = split = _part

        def prop(self, data, name, text=None, **options):
            super().prop(data, name, text, **options)
            found[name] = text

    kind = getattr(bpy.types, name)
    assert kind.poll(where)
    kind.draw(Drawn(kind, Labelled()), where)
    return found


GROUPS = (*properties.CLASSES, *preferences.CLASSES, *feedback.CLASSES)
OPERATORS = [kind for kind in operators.CLASSES if issubclass(kind, bpy.types.Operator)]
SMALL = {"cm", "for"}
"""What is small in names beside what labels of figures have."""


def check_title(name, where):
    words = " ".join(word for word in name.split(" ") if word not in SMALL)
    assert readout.title_case(words) == words, f"{where}: '{name}'"


def check_titles(entries):
    """Check the names of settings, and of what they can be chosen to be."""
    for entry in entries:
        is_group = entry.type in {"POINTER", "COLLECTION"}
        # Blender calls what has no name by its identifier: files of operators, which its browser shows.
        if entry.name == entry.identifier or is_group or entry.is_hidden:
            continue
        check_title(entry.name, entry.identifier)
        for item in entry.enum_items if entry.type == "ENUM" else ():
            check_title(item.name, entry.identifier)


@pytest.mark.parametrize("group", GROUPS, ids=lambda group: group.__name__)
def test_names_of_settings_are_written_as_blender_writes_its_own(group):
    check_titles(entry for entry in group.bl_rna.properties if entry.identifier != "name")


@pytest.mark.parametrize("kind", OPERATORS, ids=lambda kind: kind.bl_idname)
def test_names_of_operators_and_their_settings_are_written_as_blender_writes_its_own(kind):
    check_title(kind.bl_label, kind.bl_idname)
    made = getattr(bpy.ops.lumenray, kind.bl_idname.partition(".")[2])
    entries = made.get_rna_type().properties
    assert {entry.identifier for entry in entries} >= set(kind.__annotations__)
    check_titles(entries)


ROOT = Path(__file__).parents[2]
LABELS = {"prop": "text", "operator": "text", "row": "heading", "column": "heading"}


def test_labels_in_panels_are_written_as_blender_writes_its_own():
    """Texts that panels and preferences put in place of the names of settings and operators."""
    count = 0
    for path in (*(ROOT / "ui").glob("*.py"), ROOT / "blender_addon" / "preferences.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute)):
                continue
            for word in node.keywords:
                if word.arg == LABELS.get(node.func.attr) and isinstance(word.value, ast.Constant):
                    check_title(word.value.value, f"{path.name}:{node.lineno}")
                    count += 1
    assert count > 50
    for kind in ui.CLASSES:
        check_title(getattr(kind, "bl_label", ""), kind.__name__)


BLENDERS = {
    "Add",
    "Camera",
    "Developer Extras",
    "Environment Texture",
    "Extensions",
    "IES Texture",
    "Interface",
    "Mapping",
    "Preferences",
    "Ray Visibility",
    "Render",
    "Rendered",
    "Sidebar",
}
"""Names in the guide that are Blender's own."""

EMPHASIS = {
    "Lux maps",
    "The same at all",
    "Uneven sides",
    "information error",
    "isotropic",
    "orthotropic",
    "pictures and sensors",
    "second witness",
}
"""What the guide stresses, and what panels say of a file."""


def test_names_in_the_guide_are_those_of_the_interface():
    guide = (ROOT / "docs" / "guide.md").read_text(encoding="utf-8")
    plain = re.sub(r"```.*?```|`[^`]*`|\*\*|\\\*", "", guide, flags=re.DOTALL)
    starred = [" ".join(name.split()) for name in re.findall(r"\*([^*]+)\*", plain)]
    assert len(starred) > 100
    names = {name for path in starred for name in path.split(" > ")}
    known = {
        node.value
        for folder in ("ui", "operators", "blender_addon")
        for path in (ROOT / folder).rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and isinstance(node.value, str)
    }
    assert names - known - BLENDERS - EMPHASIS == set()
    # The lists are short: what the guide does not say, or the source does, is not on them.
    assert (BLENDERS | EMPHASIS) - names == set()


def test_film_says_what_becomes_white():
    for exposure in ("LUMINANCE", "EV100", "AUTO"):
        bpy.context.scene.lumenray.exposure = exposure
        assert "exposure" in draw("LUMENRAY_PT_film", context())


def test_engine_panel_names_cause_and_remedy(monkeypatch):
    manager = bpy.context.window_manager
    feedback.note_status(manager, BackendStatus(False, "LLVM was not found", "install it"))
    said = " ".join(draw("LUMENRAY_PT_engine", context()))
    assert "LLVM was not found" in said
    assert "install it" in said
    assert "lumenray.check_engine" in said
    feedback.note_status(manager, BackendStatus(True, "all there"))
    monkeypatch.setattr(sidebar.engine_process, "why_lost", lambda: None)
    assert draw("LUMENRAY_PT_engine", context()) == ["Ready"]
    monkeypatch.setattr(sidebar.engine_process, "why_lost", lambda: "out of memory")
    assert draw("LUMENRAY_PT_engine", context()) == ["Ended; the next action starts it"]


def test_engine_panel_offers_our_engine_where_another_is_chosen():
    assert "engine=LUMENRAY" in draw("LUMENRAY_PT_engine", context(engine="CYCLES"))


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
        smoothed=True,
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
    assert "Smoothed" in said
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


def report():
    made = ConversionReport()
    made.info("Glass", "Thin walls are not told apart", "solid glass is used")
    made.warn("Wood", "Noise has no equal", "its mean is used", node="Noise Texture")
    made.warn("Wood", "Noise has no equal", "its mean is used", node="Noise Texture")
    made.error("Smoke", "A volume is not supported", "it is left out")
    return made


def test_report_lists_the_worst_first_and_details_the_active_row():
    manager = bpy.context.window_manager
    assert "Filled when" in draw("LUMENRAY_PT_report", context())[0]
    feedback.show_report(manager, ConversionReport())
    assert draw("LUMENRAY_PT_report", context()) == ["All of it was taken over"]
    feedback.show_report(manager, report())
    rows = manager.lumenray.rows
    assert [row.severity for row in rows] == ["ERROR", "WARNING", "INFO"]
    assert rows[1].count == 2
    manager.lumenray.row_index = 1
    said = draw("LUMENRAY_PT_report", context())
    assert "1 error, 1 warning, 1 note" in said
    assert "Wood / Noise Texture" in said
    assert "Noise has no equal" in said
    assert "Instead: its mean is used" in said
    layout = Layout()
    list_ = Drawn(sidebar.LUMENRAY_UL_report, layout)
    for row in rows:
        sidebar.LUMENRAY_UL_report.draw_item(
            list_, context(), layout, manager.lumenray, row, 0, None, ""
        )
    assert "Noise has no equal (×2)" in layout.seen


def test_report_can_be_searched():
    manager = bpy.context.window_manager
    feedback.show_report(manager, report())
    list_ = Drawn(sidebar.LUMENRAY_UL_report, Layout())
    find = sidebar.LUMENRAY_UL_report.filter_items
    assert find(list_, context(), manager.lumenray, "rows") == ([], [])
    list_.filter_name = "noise"
    flags, _ = find(list_, context(), manager.lumenray, "rows")
    assert [bool(flag) for flag in flags] == [False, True, False]


def test_report_is_copied_as_text():
    manager = bpy.context.window_manager
    feedback.show_report(manager, report())
    lines = feedback.report_text(manager).splitlines()
    assert lines[0] == "ERROR: Smoke: A volume is not supported; it is left out"
    assert lines[1].endswith("(2 times)")
    assert bpy.ops.lumenray.copy_report() == {"FINISHED"}
    manager.lumenray.rows.clear()
    assert not bpy.ops.lumenray.copy_report.poll()


def test_feedback_of_another_file_is_forgotten():
    feedback.show_report(bpy.context.window_manager, report())
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert len(bpy.context.window_manager.lumenray.rows) == 0


def test_operator_asks_for_the_engine(monkeypatch):
    class Answer:
        def wait(self):
            return BackendStatus(False, "LLVM was not found", "install it")

    monkeypatch.setattr(feedback, "Probe", Answer)
    assert bpy.ops.lumenray.check_engine() == {"FINISHED"}
    engine = bpy.context.window_manager.lumenray.engine
    assert engine.checked
    assert not engine.usable
    assert engine.remedy == "install it"


def test_probe_answers_from_a_process_of_its_own():
    asked = probe.Probe()
    status = asked.wait()
    assert status.cause
    assert asked.poll() == status
    assert status.usable or status.remedy


@pytest.mark.parametrize(
    ("code", "answer", "complaint", "expected"),
    [
        (0, 'noise\nstatus={"usable": true, "cause": "c", "remedy": ""}\n', "", "c"),
        (-11, "", "LLVM ERROR: bad\n", "LLVM ERROR: bad"),
        (1, "", "Traceback\nImportError: no numpy\n", "ImportError: no numpy"),
        (0, "", "", "without a word"),
    ],
)
def test_probe_understands_what_a_process_leaves(code, answer, complaint, expected):
    status = probe.read_answer(code, answer, complaint)
    assert expected in status.cause
    assert status.usable or status.remedy


def test_blenders_own_panels_take_our_engine_and_let_it_go():
    for name in (
        "DATA_PT_lens",
        "WORLD_PT_context_world",
        "RENDER_PT_format",
        "VIEWLAYER_PT_layer",
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
