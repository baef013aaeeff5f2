"""What becomes of bakes in Blender: no unasked repetition, tables that last and go out of date, ends that keep what is done,
folders in which nothing is lost."""

import signal
import threading
import time
import types
from dataclasses import replace
from pathlib import Path

import bpy
import lumenray
import numpy as np
import pytest
from fake_bakes import FakeSession, Interrupted
from lumenray.blender_addon.bake import folders as bake_folders
from lumenray.blender_addon.bake import job as bake
from lumenray.blender_addon.bake import look as baked_look
from lumenray.blender_addon.bake import results as baked_results
from lumenray.blender_addon.bake import running as running_bake
from lumenray.blender_addon.foundation import engine_process
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.command_line import main as command_line
from lumenray.engine.accuracy.stopping import Progress
from lumenray.engine.errors import Cancelled
from lumenray.engine.scene.scene import Scene
from lumenray.engine.session import Session
from lumenray.libraries.scenes import tiny
from lumenray.operators import bake_illuminance
from panels import Drawn, context, draw, interface


@pytest.fixture(autouse=True)
def _operators(registered):
    lumenray.register()


@pytest.fixture
def fake(monkeypatch):
    """Let a fake engine bake that tells the scene's true hash, and return it."""
    session = FakeSession()
    real = session.bake_objects

    def bake_objects(order, progress=None):
        made = real(order, progress)
        own = replace(made.maps[0].provenance, scene_hash=session.scene.hash())
        return replace(made, maps=tuple(replace(each, provenance=own) for each in made.maps))

    session.bake_objects = bake_objects
    monkeypatch.setattr(engine_process, "open_session", lambda _: session)
    return session


def add_quad(name, x=0.0):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
    item = bpy.data.objects.new(name, mesh)
    item.location.x = x
    bpy.context.scene.collection.objects.link(item)
    bpy.context.view_layer.update()
    return item


def add_light(name):
    item = bpy.data.objects.new(name, bpy.data.lights.new(name, "POINT"))
    item.location.z = 2.0
    bpy.context.scene.collection.objects.link(item)
    bpy.context.view_layer.update()
    return item


def bake_all(folder="", **options):
    names = ",".join(item.name for item in bpy.context.scene.objects if item.type == "MESH")
    done = bpy.ops.lumenray.bake_illuminance(objects=names, folder=str(folder), **options)
    assert done == {"FINISHED"}


def scene_hash():
    scene = Scene()
    scene.apply(convert_scene(bpy.context.evaluated_depsgraph_get()).delta)
    return scene.hash()


def baked():
    bpy.context.view_layer.update()
    return bpy.context.scene.lumenray.baked


# ---- no repetition ----


def test_a_bake_is_not_redone_by_the_redo_panel_and_its_settings_do_not_linger(fake, tmp_path):
    add_quad("Floor")
    bake_all(tmp_path, samples=7, density=3.0, gltf=str(tmp_path / "room.glb"))
    last = bpy.context.window_manager.operator_properties_last("lumenray.bake_illuminance")
    assert (last.samples, last.density, last.folder, last.gltf, last.objects) == (
        0,
        0.0,
        "",
        "",
        "",
    )
    # Blender shows the redo panel, and repeats, what is registered.
    assert "REGISTER" not in bpy.types.LUMENRAY_OT_bake_illuminance.bl_options
    assert all(
        "SKIP_SAVE" in str(kind.keywords.get("options", ()))
        for kind in bpy.types.LUMENRAY_OT_bake_illuminance.__annotations__.values()
    )


# ---- tables ----


def test_tables_are_there_after_saving_and_opening(fake, tmp_path):
    add_quad("Floor")
    add_quad("Desk", 2.0)
    bake_all(tmp_path / "lux")
    before = [(row.name, row.mean, row.minimum_low, row.maximum_high) for row in baked().rows]
    assert len(before) == 2
    path = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.wm.open_mainfile(filepath=str(path))
    after = [(row.name, row.mean, row.minimum_low, row.maximum_high) for row in baked().rows]
    assert after == before
    assert baked().changed == ""
    assert baked().folder == str(tmp_path / "lux")
    with interface():
        assert "Floor" in [row.name for row in bpy.context.scene.lumenray.baked.rows]
        assert draw("LUMENRAY_PT_results", context()) is not None
        assert "2 %" in draw("LUMENRAY_PT_results_whole", context())
    # Edits of the opened file are noticed too.
    bpy.data.objects["Desk"].location.x = 3.0
    assert baked().changed == "Desk"
    bpy.data.objects["Floor"].visible_shadow = False
    assert baked().changed == "Desk, Floor"


def move_camera():
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    bpy.context.scene.collection.objects.link(camera)
    return lambda: setattr(camera.location, "x", 5.0)


def swap_slot():
    bpy.data.objects["Floor"].material_slots[0].material = bpy.data.materials["Varnish"]


def own_slot():
    """Give the object a material of its own, which its mesh does not have."""
    slot = bpy.data.objects["Floor"].material_slots[0]
    slot.link = "OBJECT"
    slot.material = bpy.data.materials["Varnish"]


def set_shelf(name, value=True):
    shelf = bpy.context.view_layer.layer_collection.children["Shelf"]
    return setattr(shelf, name, value)


def set_ray(name, thing="Floor", value=False):
    return lambda: setattr(bpy.data.objects[thing], f"visible_{name}", value)


RAYS = ("camera", "diffuse", "glossy", "transmission", "shadow")

EDITS = {
    "move": (lambda: setattr(bpy.data.objects["Floor"].location, "x", 0.5), "Floor"),
    "mesh": (lambda: bpy.data.meshes["Floor"].transform(np.eye(4) * 2.0), "Floor"),
    "light": (lambda: setattr(bpy.data.lights["Lamp"], "energy", 77.0), "Lamp"),
    "physical": (lambda: setattr(bpy.data.lights["Lamp"].lumenray, "use_physical", True), "Lamp"),
    "efficacy": (lambda: setattr(bpy.context.scene.lumenray, "efficacy", 100.0), "Scene"),
    "unit": (lambda: setattr(bpy.context.scene.unit_settings, "scale_length", 0.5), "Scene"),
    "remove": (lambda: bpy.data.objects.remove(bpy.data.objects["Lamp"]), "Collection"),
    "hide": (lambda: setattr(bpy.data.objects["Lamp"], "hide_render", True), "Collection"),
    "slot": (swap_slot, "Floor"),
    "own slot": (own_slot, "Floor"),
    "world": (lambda: setattr(bpy.context.scene, "world", bpy.data.worlds["Night"]), "Scene"),
    "no world": (lambda: setattr(bpy.context.scene, "world", None), "Scene"),
    "exclude": (lambda: set_shelf("exclude"), "Board"),
    "indirect": (lambda: set_shelf("indirect_only"), "Board"),
    "eye": (lambda: bpy.data.objects["Board"].hide_set(True), "Board"),
    "shown again": (lambda: bpy.data.objects["Box"].hide_set(False), "Box"),
    **{f"{ray} rays": (set_ray(ray), "Floor") for ray in RAYS},
    "rays of a light": (set_ray("diffuse", "Lamp"), "Lamp"),
    "rays of instances": (set_ray("shadow", "Maker"), "Maker"),
    "rays of what is instanced": (set_ray("shadow", "Chair"), "Chair"),
    "instanced": (lambda: setattr(bpy.data.objects["Chair"].location, "x", 0.5), "Chair"),
}


def furnish():
    """Add what can be edited: a collection, another world and material, an object that is hidden, and instances."""
    scene = bpy.context.scene
    floor = add_quad("Floor")
    floor.data.materials.append(bpy.data.materials.new("Paint"))
    bpy.data.materials.new("Varnish")
    scene.world = bpy.data.worlds.new("Day")
    bpy.data.worlds.new("Night")
    add_light("Lamp")
    shelf, chairs = (bpy.data.collections.new(name) for name in ("Shelf", "Chairs"))
    scene.collection.children.link(shelf)
    for name, group in (("Board", shelf), ("Chair", chairs)):
        item = add_quad(name, 3.0)
        scene.collection.objects.unlink(item)
        group.objects.link(item)
    add_quad("Box", 6.0).hide_set(True)
    maker = bpy.data.objects.new("Maker", None)
    maker.instance_type, maker.instance_collection = "COLLECTION", chairs
    scene.collection.objects.link(maker)
    bpy.context.view_layer.update()


@pytest.mark.parametrize("name", list(EDITS))
def test_an_edit_of_what_is_lit_or_gives_light_is_said(fake, tmp_path, name):
    furnish()
    bake_all(tmp_path)
    assert baked().changed == ""
    edit, said = EDITS[name]
    edit()
    bpy.context.scene.update_tag()
    assert said in baked().changed
    with interface():
        seen = draw("LUMENRAY_PT_results", context())
    assert any(text.startswith("Out of date") for text in seen)
    assert "lumenray.check_baked" in seen


def test_what_does_not_concern_the_light_leaves_tables_current(fake, tmp_path):
    floor = add_quad("Floor")
    material = bpy.data.materials.new("Paint")
    if material.node_tree is None:
        material.use_nodes = True
    floor.data.materials.append(material)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    bpy.context.scene.collection.objects.link(camera)
    bake_all(tmp_path)
    settings = bpy.context.scene.lumenray
    camera.location.x = 5.0
    floor.select_set(True)
    floor.name = "Ground"
    settings.bake_density, settings.white_luminance = 99.0, 20.0
    floor.color, camera.visible_diffuse = (1.0, 0.0, 0.0, 1.0), False
    floor.vertex_groups.new(name="Group")
    bpy.context.scene.camera = camera
    assert baked().changed == ""
    # Nor does our own look.
    assert bpy.ops.lumenray.show_baked() == {"FINISHED"}
    settings.baked_high = 750.0
    settings.baked_look = "FALSE"
    assert baked().changed == ""
    material.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 1.0
    assert baked().changed == "Paint"
    material.node_tree.nodes["Principled BSDF"].inputs["Metallic"].default_value = 0.0
    bpy.ops.lumenray.check_baked()
    assert baked().changed == ""
    assert bpy.ops.lumenray.hide_baked() == {"FINISHED"}
    assert baked().changed == ""


def test_sliders_of_shown_layers_leave_tables_current(fake, tmp_path):
    floor = add_quad("Floor")
    floor.data.materials.append(bpy.data.materials.new("Paint"))
    add_light("Lamp").data.lumenray.light_group = "Ceiling"
    settings = bpy.context.scene.lumenray
    settings.bake_layers = "GROUPS"
    bake_all(tmp_path)
    bpy.ops.lumenray.show_baked()
    settings.baked_layers["Ceiling"].strength = 0.3
    assert baked().changed == ""


def test_what_was_set_back_is_current_again_after_a_check(fake, tmp_path):
    floor = add_quad("Floor")
    bake_all(tmp_path)
    floor.location.x = 0.5
    assert baked().changed == "Floor"
    bpy.ops.lumenray.check_baked()
    assert baked().changed == "Floor"
    floor.location.x = 0.0
    assert baked().changed == "Floor"
    bpy.ops.lumenray.check_baked()
    assert baked().changed == ""


def test_undo_does_not_make_tables_current_that_are_not(fake, tmp_path):
    floor = add_quad("Floor")
    bpy.context.preferences.edit.use_global_undo = True
    bake_all(tmp_path)
    bpy.ops.ed.undo_push(message="baked")
    floor.location.x = 0.5
    # Blender pushes its undo step before handlers hear of the edit.
    bpy.ops.ed.undo_push(message="moved")
    assert baked().changed == "Floor"
    bpy.context.scene.frame_end = 77
    bpy.ops.ed.undo_push(message="something else")
    bpy.ops.ed.undo()
    assert bpy.data.objects["Floor"].location.x == 0.5
    assert baked().changed == "Floor"


@pytest.mark.parametrize("name", ["move", "shadow rays", "eye"])
def test_what_is_edited_while_a_bake_runs_makes_its_tables_out_of_date(
    fake, tmp_path, monkeypatch, name
):
    furnish()
    edit, said = EDITS[name]
    real = fake.bake_objects

    def bake_objects(*arguments):
        edit()
        bpy.context.view_layer.update()
        return real(*arguments)

    monkeypatch.setattr(fake, "bake_objects", bake_objects)
    bake_all(tmp_path)
    assert baked().changed == said


def test_a_bake_leaves_the_scene_as_it_was_for_the_engine(fake, tmp_path):
    """The UV map of the lux map must not become the one that pictures lie by."""
    floor = add_quad("Floor")
    before = scene_hash()
    bake_all(tmp_path)
    assert floor.data.uv_layers[0].name == "Lumenray"
    assert scene_hash() == before
    bpy.ops.lumenray.show_baked()
    with baked_look.hidden(bpy.context.scene):
        assert scene_hash() == before
    bpy.ops.lumenray.hide_baked()
    # Somebody asks for it.
    material = bpy.data.materials.new("Paint")
    if material.node_tree is None:
        material.use_nodes = True
    material.node_tree.nodes.new("ShaderNodeUVMap").uv_map = "Lumenray"
    floor.data.materials.append(material)
    converted = convert_scene(bpy.context.evaluated_depsgraph_get())
    assert any("Lumenray" in getattr(item, "uv_maps", ()) for item in converted.delta.changed)


# ---- ends ----


class SlowSession(FakeSession):
    """Bakes until it is asked to end; a stop gives a result, a cancel none."""

    def __init__(self):
        super().__init__()
        self.is_working = threading.Event()

    def bake_objects(self, order, progress=None):
        while not (self.cancelled or self.stopped):
            self.is_working.set()
            progress(Progress(0.3, 64, 0.0016, 5.0, 20.0, "illuminance"))
            time.sleep(0.005)
        made = super().bake_objects(order, progress)
        return replace(made, shortfall="stopped at an error of 0.16 %; asked for: 0.1 %")


def begin(session, folder):
    """Start a bake as the button does, without a window."""
    settings = bpy.context.scene.lumenray
    objects = [item for item in bpy.context.scene.objects if item.type == "MESH"]
    made = bake.read_settings(settings, objects, bake.rule_of(settings), folder)
    job = bake.prepare(bpy.context.evaluated_depsgraph_get(), objects, made)
    running = running_bake.start(job, session, bpy.context.window_manager)
    assert session.is_working.wait(20.0)
    return running


def wait_for(running):
    end = time.monotonic() + 20.0
    while running.is_alive:
        assert time.monotonic() < end
        time.sleep(0.01)


def test_stop_and_keep_gives_the_results_so_far(tmp_path):
    add_quad("Floor")
    manager = bpy.context.window_manager
    running = begin(SlowSession(), tmp_path)
    running.show(manager)
    with interface():
        seen = draw("LUMENRAY_PT_bake", context())
        assert {"lumenray.stop_bake", "lumenray.cancel_bake"} <= set(seen)
        assert bpy.ops.lumenray.stop_bake() == {"FINISHED"}
        assert "Ends with the results so far" in draw("LUMENRAY_PT_bake", context())
    wait_for(running)
    running.end(manager)
    assert running.error is None
    bake.store(running.job, bpy.context.scene)
    assert "0.16 %" in baked().shortfall
    assert not manager.lumenray.job.running
    with interface():
        assert any("0.16 %" in text for text in draw("LUMENRAY_PT_results", context()))


def test_cancel_gives_nothing(tmp_path):
    add_quad("Floor")
    running = begin(SlowSession(), tmp_path)
    assert bpy.ops.lumenray.cancel_bake() == {"FINISHED"}
    wait_for(running)
    running.end(bpy.context.window_manager)
    assert isinstance(running.error, Cancelled)
    assert not bpy.ops.lumenray.stop_bake.poll()


class Button(Drawn):
    """Stands for the operator that bakes in the background, which Blender makes where there is a window alone."""

    objects, density, gltf, resume = "Floor", 0.0, "", False
    samples = error = absolute = time = 0

    def __init__(self, folder):
        super().__init__(bake_illuminance.LUMENRAY_OT_bake_illuminance, None)
        self.folder, self.said = str(folder), []

    def report(self, levels, text):
        self.said.append((*levels, text))

    def hear(self, kind, value="NOTHING"):
        """Hand it an event and return its answer."""
        event = types.SimpleNamespace(type=kind, value=value)
        screen = types.SimpleNamespace(areas=[])
        return self.modal(context(screen=screen), event)


class Manager:
    """Blender's window manager, which takes operators that wait for events though no event can come."""

    def __init__(self):
        self.waiting = []

    def __getattr__(self, name):
        return getattr(bpy.context.window_manager, name)

    def modal_handler_add(self, operator):
        self.waiting.append(operator)


@pytest.fixture
def press(monkeypatch, tmp_path):
    """Return a function that presses the button, and gives it with the session when some progress is shown."""

    def press(session):
        add_quad("Floor")
        monkeypatch.setattr(engine_process, "open_session", lambda _: session)
        app = types.SimpleNamespace(background=False)
        blender = types.SimpleNamespace(app=app, data=bpy.data, path=bpy.path)
        monkeypatch.setattr(bake_illuminance, "bpy", blender)
        button, manager = Button(tmp_path), Manager()
        where = bpy.context
        shown = context(
            window_manager=manager,
            window=where.window,
            evaluated_depsgraph_get=where.evaluated_depsgraph_get,
        )
        assert button.invoke(shown, None) == {"RUNNING_MODAL"}
        assert manager.waiting == [button]
        end = time.monotonic() + 20.0
        while bpy.context.window_manager.lumenray.job.progress == 0.0:
            assert time.monotonic() < end
            assert button.hear("TIMER") == {"PASS_THROUGH"}
        return button, running_bake.current()

    yield press
    running_bake.end()


def test_esc_ends_a_bake_with_what_it_has_and_no_other_key_does(press):
    session = SlowSession()
    button, running = press(session)
    for kind, value in (("ESC", "RELEASE"), ("RET", "PRESS"), ("MOUSEMOVE", "NOTHING")):
        assert button.hear(kind, value) == {"PASS_THROUGH"}
        assert not (session.stopped or session.cancelled)
    assert button.hear("ESC", "PRESS") == {"PASS_THROUGH"}
    assert bpy.context.window_manager.lumenray.job.is_stopping
    wait_for(running)
    assert session.stopped
    assert not session.cancelled
    assert button.hear("TIMER") == {"FINISHED"}
    assert [row.name for row in baked().rows] == ["Floor"]
    assert "0.16 %" in baked().shortfall
    ((level, text),) = button.said
    assert level == "WARNING"
    assert "0.16 %" in text
    assert not bpy.context.window_manager.lumenray.job.running
    assert running_bake.current() is None


def test_cancel_gives_nothing_and_says_so(press):
    button, running = press(SlowSession())
    assert bpy.ops.lumenray.cancel_bake() == {"FINISHED"}
    wait_for(running)
    assert button.hear("TIMER") == {"CANCELLED"}
    assert button.said == [("WARNING", "Bake cancelled")]
    assert len(baked().rows) == 0


@pytest.mark.parametrize("is_done", [False, True], ids=["working", "done"])
def test_the_button_ends_quietly_when_the_extension_is_disabled_under_it(press, is_done):
    """Blender drops operators of classes that go; one that hears of an event all the same finds nothing to write to."""
    button, running = press(SlowSession())
    if is_done:
        running_bake.stop(bpy.context.window_manager)
        wait_for(running)
    lumenray.unregister()
    try:
        assert not hasattr(bpy.types.WindowManager, "lumenray")
        assert not running.is_alive
        assert button.hear("MOUSEMOVE") == {"PASS_THROUGH"}
        assert button.hear("ESC", "PRESS") == {"PASS_THROUGH"}
        assert button.hear("TIMER") == {"CANCELLED"}
        button.cancel(context())
    finally:
        lumenray.register()
    assert button.said == [("WARNING", "Bake cancelled")]
    assert len(baked().rows) == 0
    assert not bpy.context.window_manager.lumenray.job.running


def test_disabling_the_extension_ends_a_bake_and_leaves_nothing(tmp_path):
    add_quad("Floor")
    running = begin(SlowSession(), tmp_path)
    assert bpy.context.window_manager.lumenray.job.running
    lumenray.unregister()
    try:
        assert not running.is_alive
        assert running_bake.current() is None
    finally:
        lumenray.register()
    assert not bpy.context.window_manager.lumenray.job.running
    assert bpy.ops.lumenray.bake_illuminance.poll()


def test_opening_a_file_ends_a_bake(tmp_path):
    add_quad("Floor")
    running = begin(SlowSession(), tmp_path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    assert not running.is_alive
    assert not bpy.context.window_manager.lumenray.job.running


@pytest.mark.mitsuba
@pytest.mark.slow
def test_a_bake_that_was_stopped_and_kept_goes_on_with_another_end(tmp_path, monkeypatch):
    """What the first end leaves in the file, UV maps above all, must not count as another scene."""
    tiny.build_closed_box()
    settings = bpy.context.scene.lumenray

    class Impatient(Session):
        def bake_objects(self, order, progress=None):
            def report(state):
                progress(state)
                if state.samples:
                    self.stop()

            return super().bake_objects(order, report)

        def close(self):
            pass

    monkeypatch.setattr(engine_process, "open_session", lambda _: Impatient())
    options = {"objects": "Floor,Walls", "density": 6.0, "folder": str(tmp_path)}
    bpy.ops.lumenray.bake_illuminance(**options, error=0.002)
    early = baked().relative_error
    assert "0.2 %" in baked().shortfall
    assert early > 0.002
    assert baked().changed == ""
    monkeypatch.setattr(engine_process, "open_session", lambda _: Patient())
    bpy.ops.lumenray.bake_illuminance(**options, error=0.02, resume=True)
    assert baked().relative_error <= 0.02
    assert baked().shortfall == ""
    # Mean over all walls of the closed box by the balance of flux. [lx]
    mean = 1000.0 / (24.0 * 0.5)
    assert settings.baked.mean == pytest.approx(mean, rel=0.02)
    bpy.ops.lumenray.check_baked()
    assert baked().changed == ""
    with pytest.raises(RuntimeError, match=r"no interrupted bake"):
        bpy.ops.lumenray.bake_illuminance(**options, error=0.02, resume=True)


class Patient(Session):
    """The engine's session without a process of its own."""

    def close(self):
        pass


def saved_room(tmp_path):
    add_quad("Floor")
    file = tmp_path / "room.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file))
    return file


def test_ctrl_c_keeps_what_a_bake_has_and_says_so(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("lumenray.engine.session.Session", lambda: Interrupted(1))
    before = signal.getsignal(signal.SIGINT)
    code = command_line.main(["bake", str(saved_room(tmp_path)), "-o", str(tmp_path / "lux")])
    said = capsys.readouterr()
    assert code == 3
    assert "the results so far are kept" in said.err
    assert "stopped at an error of 0.16 %" in said.err
    assert "--resume" in said.err
    assert "Floor" in said.out
    assert signal.getsignal(signal.SIGINT) is before


def test_a_second_ctrl_c_cancels_and_says_what_is_left(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("lumenray.engine.session.Session", lambda: Interrupted(2))
    code = command_line.main(["bake", str(saved_room(tmp_path)), "-o", str(tmp_path / "lux")])
    said = capsys.readouterr()
    assert code == 1
    assert "nothing was written; --resume goes on" in said.err
    assert "Floor" not in said.out


# ---- folders ----


def written(monkeypatch, fake):
    """Have the fake engine leave a page in the folder, and return where."""
    real, folders = fake.bake_objects, []

    def bake_objects(order, progress=None):
        folder = Path(order.folder)
        (folder / "illuminance.1001.exr").write_text(str(order.density))
        folders.append(folder)
        return real(order, progress)

    monkeypatch.setattr(fake, "bake_objects", bake_objects)
    return folders


def test_files_of_one_folder_have_bakes_of_their_own(fake, tmp_path, monkeypatch):
    folders = written(monkeypatch, fake)
    add_quad("Floor")
    for name in ("office", "shop"):
        bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / f"{name}.blend"))
        bake_all()
    assert folders == [tmp_path / "lux_office", tmp_path / "lux_shop"]


def test_results_of_other_settings_are_not_overwritten_unasked(fake, tmp_path, monkeypatch):
    folders = written(monkeypatch, fake)
    add_quad("Floor")
    settings = bpy.context.scene.lumenray
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "office.blend"))
    bake_all(density=5.0)
    bake_all(density=7.0)
    # The same again takes its own place.
    bake_all(density=5.0)
    # A coarser end is another setting: hours of work must not go for it.
    bake_all(density=5.0, error=0.5)
    first = tmp_path / "lux_office"
    assert folders == [first, tmp_path / "lux_office_2", first, tmp_path / "lux_office_3"]
    assert (first / "illuminance.1001.exr").read_text() == "5.0"
    settings.bake_overwrite = True
    bake_all(density=9.0)
    assert folders[-1] == first
    assert baked().folder == str(first)


def test_results_of_another_scene_or_of_unknown_origin_are_not_overwritten(
    fake, tmp_path, monkeypatch
):
    folders = written(monkeypatch, fake)
    floor = add_quad("Floor")
    bpy.context.scene.lumenray.bake_folder = "//lux"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "office.blend"))
    bake_all()
    other = bpy.data.scenes.new("Evening")
    other.collection.objects.link(floor)
    other.lumenray.bake_folder = "//lux"
    with bpy.context.temp_override(scene=other, view_layer=other.view_layers[0]):
        assert bpy.ops.lumenray.bake_illuminance(objects="Floor") == {"FINISHED"}
    # Left by a version that did not say whose it is.
    old = tmp_path / "lux_3"
    old.mkdir()
    (old / "illuminance.1001.exr").write_bytes(b"")
    bake_all(density=3.0)
    assert folders == [tmp_path / "lux", tmp_path / "lux_2", tmp_path / "lux_4"]


def test_an_interrupted_bake_of_other_settings_is_not_forgotten(fake, tmp_path, monkeypatch):
    folders = written(monkeypatch, fake)
    add_quad("Floor")
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "office.blend"))
    bake_all(density=5.0)
    kept = folders[0] / bake_folders.CHECKPOINT
    kept.write_bytes(b"state")
    bake_all(density=7.0)
    assert kept.exists()
    bpy.ops.lumenray.bake_illuminance(objects="Floor", density=5.0, error=0.3, resume=True)
    assert folders[-1] == folders[0]
    assert kept.exists()


def test_a_file_that_was_never_saved_writes_to_the_temporary_folder_and_says_so(
    fake, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    folders = written(monkeypatch, fake)
    add_quad("Floor")
    for text in ("", "//lux", "lux"):
        bpy.context.scene.lumenray.bake_folder = text
        bake_all()
    assert all(folder.is_relative_to(bpy.app.tempdir) for folder in folders)
    assert list(tmp_path.iterdir()) == []
    assert bake_folders.is_temporary(folders[0])
    with interface():
        seen = " ".join(draw("LUMENRAY_PT_lux_bake_output", context()))
    assert "temporary folder" in seen


def test_hostile_claims_are_read_as_none(tmp_path):
    for content in (b"", b"[" * 70000, b'{"settings": 3}', b"\xff\xfe", b"[]"):
        (tmp_path / bake_folders.CLAIM).write_bytes(content)
        assert bake_folders._read_claim(tmp_path) in (None, 3)


def test_watches_end_with_their_jobs():
    watch = baked_results.Watch()
    add_quad("Floor")
    assert "Floor" in watch.names
    del watch
    assert len(baked_results._tracker.watches) == 0
