"""Blender and the user's cluster: who computes, what is shown of it, and what is said where it cannot be reached."""

from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from panels import context, draw

from lumenray import operators, ui
from lumenray.blender_addon import feedback
from lumenray.blender_addon import registry as registry_module
from lumenray.blender_addon.foundation import cluster_place, engine_process
from lumenray.blender_addon.foundation import preferences as kept
from lumenray.blender_addon.preferences import LumenrayPreferences
from lumenray.engine.errors import LumenrayError
from lumenray.tools.libraries.scenes import tiny

pytestmark = pytest.mark.blender

PANEL = "LUMENRAY_PT_cluster"

NOBODY = r"no scheduler answers|does not answer"


@pytest.fixture(autouse=True)
def _registered(registered):
    registry_module.register(operators.CLASSES)
    registry_module.register(ui.CLASSES)
    yield
    engine_process.close()


@pytest.fixture
def own(monkeypatch):
    """The extension's preferences, which Blender has none of where it is a module."""
    made = SimpleNamespace(
        bl_rna=LumenrayPreferences.bl_rna, cluster_address="", cluster_authority="", cluster_certificate="", cluster_key="",
        device="AUTO", memory_limit=0.0,
    )  # fmt: skip
    monkeypatch.setattr(kept, "own", lambda: made)
    return made


@pytest.fixture
def scene():
    bpy.context.scene.lumenray.use_cluster = True
    return bpy.context.scene


def test_nothing_leaves_the_computer_unasked(own):
    own.cluster_address = "tcp://127.0.0.1:8786"
    assert cluster_place.place_of(bpy.context.scene) is None


def test_a_cluster_without_a_name_is_told(own, scene):
    with pytest.raises(LumenrayError, match="no cluster is named: give its address"):
        cluster_place.place_of(scene)


def test_other_computers_need_online_access(own, scene, monkeypatch):
    own.cluster_address = "tls://render.office:8786"
    monkeypatch.setattr(cluster_place.bpy, "app", SimpleNamespace(online_access=False))
    with pytest.raises(LumenrayError, match="allow online access"):
        cluster_place.place_of(scene)
    own.cluster_address = "tcp://localhost:8786"
    assert cluster_place.place_of(scene) == ("tcp://localhost:8786", "", "", "")


def test_an_address_that_is_none_is_told(own, scene):
    own.cluster_address = "render office"
    with pytest.raises(LumenrayError, match="no address of a cluster"):
        cluster_place.place_of(scene)


def test_a_worker_is_shown_as_silent_once_it_is_not_counted_on():
    from lumenray.engine.cluster.dispatch import SILENCE

    assert ui.cluster.QUIET == SILENCE
    found = bpy.context.window_manager.lumenray.cluster
    feedback.show_workers(
        bpy.context.window_manager, "tcp://here:1", [("tcp://a", 0.5), ("tcp://b", SILENCE + 5.0)]
    )
    assert [row.name for row in found.workers] == ["tcp://a", "tcp://b"]


@pytest.mark.slow
@pytest.mark.mitsuba
def test_workers_render_and_are_shown(own, scene, tmp_path):
    pytest.importorskip("distributed")
    from lumenray.engine.cluster.hosts import LocalCluster

    tiny.build_closed_box()
    scene = bpy.context.scene
    scene.render.engine = "LUMENRAY"
    scene.render.resolution_x = scene.render.resolution_y = 32
    scene.lumenray.render.stop, scene.lumenray.render.samples = "SAMPLES", 64
    eye = bpy.data.objects.new("Eye", bpy.data.cameras.new("Eye"))
    scene.collection.objects.link(eye)
    # It looks down from beside the lamp.
    eye.location = (0.5, 0.5, 1.5)
    scene.camera = eye
    scene.render.image_settings.file_format = "OPEN_EXR"

    def render(name):
        scene.render.filepath = str(tmp_path / f"{name}.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath, check_existing=False)
        return np.array(image.pixels[:]).reshape(-1, 4)[:, :3]

    scene.lumenray.use_cluster = False
    here = render("here")
    scene.lumenray.use_cluster = True
    with LocalCluster(1, threads=1) as local:
        own.cluster_address = str(local.address)
        there = render("there")
        again = render("again")
        assert bpy.ops.lumenray.find_workers() == {"FINISHED"}
        assert "1 worker" in " ".join(draw(PANEL, context()))
        shown = bpy.context.window_manager.lumenray.cluster.workers
        assert [row.name for row in shown] == [local.workers[0].address]
    # The same chunks by whoever there is; other samples than those of this computer.
    np.testing.assert_array_equal(there, again)
    assert not np.array_equal(there, here)
    assert there.mean() == pytest.approx(here.mean(), rel=0.02)
    with pytest.raises(RuntimeError, match=NOBODY):
        render("lost")
    with pytest.raises(RuntimeError, match=NOBODY):
        bpy.ops.lumenray.find_workers()
    assert "1 worker" not in " ".join(draw(PANEL, context()))
    scene.lumenray.use_cluster = False
    np.testing.assert_array_equal(render("back"), here)
