"""The first hour: scenes to begin with, and the panel that says what is left to do."""

import time
import types

import bpy
import pytest
from mathutils import Vector
from panels import context, draw, interface

from lumenray.blender_addon import feedback, first_steps, light_list
from lumenray.blender_addon.first_steps import Step
from lumenray.blender_addon.foundation import preferences
from lumenray.blender_addon.preferences import LumenrayPreferences
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.engine.scene.light import Luminaire
from lumenray.engine.scene.scene import Scene
from lumenray.engine.transport.backend import BackendStatus
from lumenray.libraries.scenes import scene_path
from lumenray.operators import show_baked


@pytest.fixture(scope="module", autouse=True)
def _interface(registered):
    with interface():
        yield


def new_room(**sizes):
    assert bpy.ops.lumenray.new_lit_room(**sizes) == {"FINISHED"}
    bpy.context.view_layer.update()
    return bpy.data.collections["Lit Room"].objects


def extent(thing):
    corners = [thing.matrix_world @ Vector(corner) for corner in thing.bound_box]
    return [(min(values), max(values)) for values in zip(*corners, strict=True)]


def convert():
    return convert_scene(bpy.context.evaluated_depsgraph_get())


def lights_of(converted):
    """Return the lights that the engine gets."""
    held = Scene()
    held.apply(converted.delta)
    return held.lights.values()


def open_steps():
    """Look at the scene anew; return the steps that are left to do."""
    first_steps.refresh(bpy.context.scene)
    return [step for step, is_done in first_steps.done(bpy.context.scene).items() if not is_done]


# ---- the room ----


def test_a_room_is_ready_to_be_baked():
    room = new_room(width=6.0, depth=4.0, height=3.0, columns=3, rows=2)
    scene = bpy.context.scene
    assert scene.render.engine == "LUMENRAY"
    assert scene.unit_settings.system == "METRIC"
    assert scene.camera.name in room
    assert {thing.name for thing in bpy.context.selected_objects} == {
        "Floor",
        "Walls",
        "Ceiling",
        "Work Plane",
    }
    assert extent(room["Walls"]) == [(-3.0, 3.0), (-2.0, 2.0), (0.0, 3.0)]
    assert extent(room["Work Plane"]) == [(-2.5, 2.5), (-1.5, 1.5), (0.75, 0.75)]
    assert open_steps() == [Step.BAKE, Step.LUX]


def test_the_engine_gets_the_surfaces_with_their_reflectances_and_the_luminaires_below_the_ceiling():
    new_room(columns=3, rows=2)
    converted = convert()
    assert [row for row, _ in converted.report.rows if row.severity.name != "INFO"] == []
    lights = [light for light in lights_of(converted) if isinstance(light, Luminaire)]
    assert len(lights) == 6
    places = sorted(tuple(round(float(x), 3) for x in light.frame[:2, 3]) for light in lights)
    assert places == [(x, y) for x in (-1.667, 0.0, 1.667) for y in (-1.0, 1.0)]
    assert all(2.79 < light.frame[2, 3] < 2.8 for light in lights)
    for name, reflectance in (("Floor", 0.2), ("Walls", 0.5), ("Ceiling", 0.7)):
        settings = bpy.data.objects[name].active_material.lumenray
        assert settings.use_override
        assert settings.reflectance == pytest.approx(reflectance)


def test_all_surfaces_face_the_room():
    room = new_room()
    middle = Vector((0.0, 0.0, 1.4))
    for name in ("Floor", "Walls", "Ceiling"):
        for face in room[name].data.polygons:
            assert face.normal.dot(middle - face.center) > 0.0, name


@pytest.mark.parametrize("size", [{}, {"width": 1.0, "depth": 1.0, "height": 2.0}])
def test_camera_and_work_plane_are_inside_the_room(size):
    room = new_room(**size)
    box = extent(room["Walls"])
    for thing in (room["Work Plane"], room["Room Camera"]):
        for (low, high), (least, largest) in zip(extent(thing), box, strict=True):
            assert least < low <= high < largest
    towards = room["Room Camera"].matrix_world.to_3x3() @ Vector((0.0, 0.0, -1.0))
    assert towards.x > 0.3
    assert towards.y > 0.3


def test_a_room_is_in_metres_whatever_the_scale_of_the_scene():
    bpy.context.scene.unit_settings.scale_length = 0.001
    room = new_room(width=5.0)
    assert extent(room["Walls"])[0] == pytest.approx((-2500.0, 2500.0))
    assert all(2.79 < light.frame[2, 3] < 2.8 for light in lights_of(convert()))
    # All of it is seen.
    assert room["Room Camera"].data.clip_end > 10_000.0


def test_without_units_a_unit_stays_a_metre():
    units = bpy.context.scene.unit_settings
    units.system, units.scale_length = "NONE", 0.01
    room = new_room(width=5.0)
    assert units.scale_length == 1.0
    assert extent(room["Walls"])[0] == (-2.5, 2.5)


def test_a_room_stands_clear_of_what_is_there_and_a_second_one_beside_the_first():
    bpy.ops.mesh.primitive_cube_add()
    new_room()
    assert extent(bpy.data.objects["Walls"])[0][0] >= 2.0
    bpy.ops.lumenray.new_lit_room()
    bpy.context.view_layer.update()
    assert extent(bpy.data.objects["Walls.001"])[0][0] > extent(bpy.data.objects["Walls"])[0][1]
    assert bpy.context.collection.name == "Lit Room.001"
    # What nothing is in the way of stands on the cursor.
    bpy.context.scene.cursor.location = (0.0, 40.0, 1.0)
    bpy.ops.lumenray.new_lit_room()
    bpy.context.view_layer.update()
    assert bpy.data.objects["Floor.002"].location == Vector((0.0, 40.0, 1.0))


def test_a_room_is_not_added_in_edit_mode():
    bpy.ops.mesh.primitive_cube_add()
    bpy.ops.object.mode_set(mode="EDIT")
    try:
        assert not bpy.ops.lumenray.new_lit_room.poll()
    finally:
        bpy.ops.object.mode_set(mode="OBJECT")


def test_undo_takes_all_of_a_room_away_again():
    bpy.ops.wm.read_factory_settings()
    bpy.context.preferences.edit.use_global_undo = True
    bpy.ops.ed.undo_push(message="before")
    # As a button calls it.
    bpy.ops.lumenray.new_lit_room("EXEC_DEFAULT", True)
    assert bpy.ops.ed.undo() == {"FINISHED"}
    scene = bpy.context.scene
    assert {thing.name for thing in bpy.data.objects} == {"Cube", "Light", "Camera"}
    assert scene.camera.name == "Camera"
    assert scene.render.engine != "LUMENRAY"
    assert "Lit Room" not in bpy.data.collections


@pytest.mark.slow
@pytest.mark.mitsuba
def test_a_room_as_it_comes_has_the_illuminance_that_its_tooltip_states(tmp_path):
    new_room()
    done = bpy.ops.lumenray.bake_illuminance(objects="Work Plane", error=0.02, folder=str(tmp_path))
    assert done == {"FINISHED"}
    (row,) = bpy.context.scene.lumenray.baked.rows
    assert row.mean == pytest.approx(550.0, rel=0.02)
    tooltip = bpy.ops.lumenray.new_lit_room.get_rna_type().properties["columns"].description
    assert "550 lx" in tooltip


# ---- the office ----


def test_the_office_opens_as_a_new_file_and_the_one_that_ships_stays():
    path = scene_path("office")
    before = path.read_bytes()
    assert bpy.ops.lumenray.open_office() == {"FINISHED"}
    assert bpy.data.filepath == ""
    assert "Desk Top A" in bpy.context.scene.objects
    assert path.read_bytes() == before
    # So Blender asks where to save.
    with pytest.raises(RuntimeError):
        bpy.ops.wm.save_mainfile()


# ---- steps ----


def add_light(**physical):
    light = bpy.data.lights.new("Lamp", "POINT")
    for name, value in physical.items():
        setattr(light.lumenray, name, value)
    lamp = bpy.data.objects.new("Lamp", light)
    bpy.context.scene.collection.objects.link(lamp)
    return lamp


def test_a_light_counts_once_it_states_its_amount_and_renders_show_it():
    lamp = add_light()
    assert Step.LIGHT in open_steps()
    lamp.data.lumenray.use_physical = True
    assert Step.LIGHT not in open_steps()
    lamp.hide_render = True
    assert Step.LIGHT in open_steps()


@pytest.mark.parametrize("settings", [{"source": "CIE"}, {"unit": "ILLUMINANCE"}])
def test_a_sky_of_stated_illuminance_counts_as_a_light(settings):
    bpy.context.scene.world = bpy.data.worlds.new("World")
    assert Step.LIGHT in open_steps()
    for name, value in settings.items():
        setattr(bpy.context.scene.world.lumenray, name, value)
    assert Step.LIGHT not in open_steps()


def test_a_luminaire_in_a_collection_that_is_instanced_counts():
    lamp = add_light(use_physical=True)
    held = bpy.data.collections.new("Held")
    held.objects.link(lamp)
    bpy.context.scene.collection.objects.unlink(lamp)
    assert Step.LIGHT in open_steps()
    bpy.ops.object.collection_instance_add(collection="Held")
    assert Step.LIGHT not in open_steps()


def test_a_glowing_surface_states_no_reflectance():
    bpy.ops.mesh.primitive_plane_add()
    material = bpy.data.materials.new("Paint")
    bpy.context.object.data.materials.append(material)
    assert Step.SURFACE in open_steps()
    material.lumenray.use_override, material.lumenray.model = True, "EMITTER"
    assert Step.SURFACE in open_steps()
    material.lumenray.model = "DIFFUSE"
    assert Step.SURFACE not in open_steps()


def test_steps_after_the_bake():
    own = bpy.context.scene.lumenray
    own.viewport.display = "FALSE_ILLUMINANCE"
    assert open_steps()[-2:] == [Step.BAKE, Step.LUX]
    own.viewport.display = "PICTURE"
    own.baked.rows.add()
    assert open_steps()[-1] is Step.LUX
    own.look.is_shown, own.look.kind = True, "FALSE"
    assert Step.LUX not in open_steps()


# ---- the panel ----


@pytest.fixture
def own(monkeypatch):
    """Preferences of an extension that is switched on."""
    made = types.SimpleNamespace(show_steps=True, bl_rna=LumenrayPreferences.bl_rna)
    monkeypatch.setattr(preferences, "own", lambda: made)
    return made


def start(**attributes):
    first_steps.refresh(bpy.context.scene)
    return draw("LUMENRAY_PT_start", context(**attributes))


def test_the_panel_leads_from_the_engine_to_lux(own):
    feedback.note_status(bpy.context.window_manager, BackendStatus(True, "all there"))
    seen = start()
    assert seen[0] == "Engine ready"
    assert "lumenray.new_lit_room" in seen
    assert "lumenray.open_office" in seen
    assert [text for text in seen if text in {step.value for step in Step}] == [
        step.value for step in Step
    ]
    for wanted in ("engine=LUMENRAY", "lumenray.add_luminaire", "lumenray.bake_illuminance"):
        assert wanted in seen
    assert "lumenray.show_baked" in seen
    assert "show_steps" in seen
    new_room()
    seen = start(selected_objects=bpy.context.selected_objects)
    assert "engine=LUMENRAY" not in seen
    assert "lumenray.add_luminaire" not in seen
    assert "4 objects selected" in seen


def test_the_panel_says_what_the_engine_lacks(own):
    feedback.note_status(
        bpy.context.window_manager, BackendStatus(False, "LLVM was not found", "install it")
    )
    said = " ".join(start())
    assert "LLVM was not found" in said
    assert "install it" in said
    assert "lumenray.check_engine" in said


def test_the_panel_is_one_line_once_all_is_done_or_the_user_has_seen_enough(own):
    own.show_steps = False
    seen = start()
    assert seen[0] == "0 of 5 steps done"
    # It can be had back.
    assert "show_steps" in seen
    assert not {step.value for step in Step} & set(seen)
    own.show_steps = True
    new_room()
    scene = bpy.context.scene.lumenray
    scene.baked.rows.add()
    scene.look.is_shown, scene.look.kind = True, "FALSE"
    assert start() == ["5 of 5 steps done", "lumenray.new_lit_room", "lumenray.open_office"]


def test_the_engine_is_told_of_in_one_panel_at_a_time(own):
    for own.show_steps in (True, False):
        told = "lumenray.check_engine"
        feedback.note_status(bpy.context.window_manager, BackendStatus(False, "no LLVM", "none"))
        panels = [start(), draw("LUMENRAY_PT_engine", context())]
        assert sum(told in (seen or ()) for seen in panels) == 1


@pytest.mark.parametrize(("asked", "shown"), [("FALSE", "FALSE"), (None, "EXITANCE")])
def test_the_last_button_shows_false_colours_and_others_keep_the_look(asked, shown):
    bpy.context.scene.lumenray.look.kind = "EXITANCE"
    # Without a window Blender never calls it.
    pressed = types.SimpleNamespace(
        look=asked or "LIGHT",
        properties=types.SimpleNamespace(is_property_set=lambda name: asked is not None),
        execute=lambda _: {"FINISHED"},
    )
    show_baked.LUMENRAY_OT_show_baked.invoke(pressed, context(), None)
    assert pressed.look == shown


def test_a_job_takes_the_place_of_the_button(own):
    bpy.context.window_manager.lumenray.job.running = True
    assert "lumenray.bake_illuminance" not in start()


def test_drawing_looks_at_no_object(own, monkeypatch):
    for _ in range(2000):
        add_light()
    first_steps.refresh(bpy.context.scene)

    def fail(*_, **__):
        raise AssertionError("a panel that is drawn looks for something")

    monkeypatch.setattr(first_steps, "find", fail)
    monkeypatch.setattr(light_list, "convert_light", fail)
    begin = time.perf_counter()
    for _ in range(20):
        draw("LUMENRAY_PT_start", context())
    assert (time.perf_counter() - begin) / 20 < 0.1


def test_a_change_is_seen_soon_and_looking_takes_a_small_share_of_the_time(own, monkeypatch):
    waiting = []
    timers = types.SimpleNamespace(
        register=lambda function, first_interval: waiting.append((function, first_interval)),
        is_registered=lambda function: any(function == each for each, _ in waiting),
    )
    app = types.SimpleNamespace(background=False, timers=timers)
    monkeypatch.setattr(first_steps, "bpy", types.SimpleNamespace(app=app, data=bpy.data))
    lamp = add_light()
    first_steps.refresh(bpy.context.scene)
    for _ in range(3):
        draw("LUMENRAY_PT_start", context())
    ((look, interval),) = waiting
    assert interval >= first_steps.QUIET
    lamp.data.lumenray.use_physical = True
    assert not first_steps.done(bpy.context.scene)[Step.LIGHT]
    assert look() is None
    assert first_steps.done(bpy.context.scene)[Step.LIGHT]
    waiting.clear()
    monkeypatch.setattr(first_steps._state, "seconds", 1.0)
    draw("LUMENRAY_PT_start", context())
    assert waiting[0][1] == pytest.approx(1.0 / first_steps.SHARE)
