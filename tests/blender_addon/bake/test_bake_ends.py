"""Bakes that end early: with what they have, with nothing, and to be gone on with."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from blender_bakes import baked, wait_for
from blender_objects import add_quad
from fake_bakes import SlowSession
from panels import context, draw, interface

import lumenray
from lumenray.blender_addon.bake import folders as bake_folders
from lumenray.blender_addon.bake import job as bake
from lumenray.blender_addon.bake import running as running_bake
from lumenray.blender_addon.foundation import engine_process
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.errors import Cancelled
from lumenray.engine.session import Session
from lumenray.tools.libraries.scenes import tiny

pytestmark = pytest.mark.usefixtures("extension")


@pytest.mark.mitsuba
@pytest.mark.slow
def test_a_cancelled_bake_goes_on_to_the_same_map(tmp_path):
    tiny.build_closed_box()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    objects = [bpy.data.objects["Floor"]]
    rule = StopRule(samples=2048)

    def prepared(folder, resume=False):
        settings = bake.read_settings(bpy.context.scene.lumenray, objects, rule, tmp_path / folder)
        return bake.prepare(depsgraph, objects, replace(settings.ask(density=8.0), resume=resume))

    whole = prepared("whole").run(Session()).pages[0]
    job = prepared("halves")

    def stop_half_way(progress):
        if progress.samples > 256:
            job.cancel()

    with pytest.raises(Cancelled):
        job.run(Session(), stop_half_way)
    assert bake_folders.checkpoint_path(tmp_path / "halves").is_file()
    page = prepared("halves", resume=True).run(Session()).pages[0]
    assert not bake_folders.checkpoint_path(tmp_path / "halves").exists()
    np.testing.assert_array_equal(page.illuminance, whole.illuminance)
    np.testing.assert_array_equal(page.standard_error, whole.standard_error)


pytestmark = pytest.mark.usefixtures("extension")


def begin(session, folder):
    """Start a bake as the button does, without a window."""
    settings = bpy.context.scene.lumenray
    objects = [item for item in bpy.context.scene.objects if item.type == "MESH"]
    made = bake.read_settings(settings, objects, bake.rule_of(settings.bake), folder)
    job = bake.prepare(bpy.context.evaluated_depsgraph_get(), objects, made)
    running = running_bake.start(job, session, bpy.context.window_manager)
    assert session.is_working.wait(120.0)
    return running


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

    monkeypatch.setattr(engine_process, "open_session", lambda *_: Impatient())
    options = {"objects": "Floor,Walls", "density": 6.0, "folder": str(tmp_path)}
    bpy.ops.lumenray.bake_illuminance(**options, error=0.002)
    early = baked().relative_error
    assert "0.2 %" in baked().shortfall
    assert early > 0.002
    assert baked().changed == ""
    monkeypatch.setattr(engine_process, "open_session", lambda *_: Patient())
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
