"""The operator that bakes: what it leaves, what it refuses, and how its button ends."""

import json
import time
import types

import bpy
import numpy as np
import pytest
from blender_bakes import bake_all, baked, wait_for
from blender_objects import add_quad
from fake_bakes import SlowSession
from panels import Drawn, context

import lumenray
from lumenray.blender_addon.bake import running as running_bake
from lumenray.blender_addon.foundation import engine_process
from lumenray.operators import bake_illuminance
from lumenray.tools.libraries.scenes import tiny

pytestmark = pytest.mark.usefixtures("extension")


def test_a_bake_is_not_redone_by_the_redo_panel_and_its_settings_do_not_linger(
    fake_engine, tmp_path
):
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
        monkeypatch.setattr(engine_process, "open_session", lambda *_: session)
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
        end = time.monotonic() + 120.0
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


pytestmark = pytest.mark.usefixtures("extension")


def test_the_bake_operator_writes_uv_map_image_and_files(tmp_path):
    tiny.build_closed_box()
    floor = bpy.data.objects["Floor"]
    users_own = floor.data.uv_layers.new(name="Mine")
    kept = np.array([d.vector[:] for d in users_own.uv])
    done = bpy.ops.lumenray.bake_illuminance(
        objects="Floor", density=16.0, samples=64, folder=str(tmp_path)
    )
    assert done == {"FINISHED"}
    assert {"Mine", "Lumenray"} <= {layer.name for layer in floor.data.uv_layers}
    assert np.array_equal(kept, np.array([d.vector[:] for d in floor.data.uv_layers["Mine"].uv]))
    image = floor.lumenray.baked_image
    assert image.name == "Lux atlas"
    assert image.is_float
    report = json.loads((tmp_path / "report.json").read_text())
    row = report["quantities"][0]
    # Mean over all walls is 83.33 lx (balance of flux); by symmetry the cube's floor has it too.
    assert abs(row["mean"] - 1000.0 / (24.0 * 0.5)) < 3 * row["mean_standard_error"] + 0.2
    values = np.array(image.pixels[:]).reshape(*reversed(image.size), 4)[..., 0]
    # Gutters hold what lumels hold, and nothing above them.
    low, high = row["maximum_range"]
    assert low < values.max() < high
    layer = np.array([d.vector[:] for d in floor.data.uv_layers["Lumenray"].uv])
    assert layer.min() >= 0.0
    assert layer.max() <= 1.0
    names = {path.name for path in tmp_path.iterdir()}
    assert {"report.json", "error.png"} <= names
    assert any(name.endswith(".exr") for name in names)
    assert any(name.endswith(".png") and name != "error.png" for name in names)


@pytest.mark.slow
def test_modifiers_that_change_faces_leave_the_map_on_disk_and_are_reported(tmp_path):
    tiny.build_closed_box()
    floor = bpy.data.objects["Floor"]
    floor.modifiers.new("Subdivision", "SUBSURF").subdivision_type = "SIMPLE"
    bpy.ops.lumenray.bake_illuminance(objects="Floor", density=4.0, samples=4, folder=str(tmp_path))
    assert "Lumenray" not in floor.data.uv_layers
    assert any(tmp_path.glob("*.exr"))
    rows = bpy.context.window_manager.lumenray.rows
    assert any("modifiers" in row.message for row in rows)


def test_the_bake_operator_refuses_unknown_objects_in_words(tmp_path):
    with pytest.raises(RuntimeError, match="no object named Ghost"):
        bpy.ops.lumenray.bake_illuminance(objects="Ghost", folder=str(tmp_path))
