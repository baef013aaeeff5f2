"""What happens to the engine's process must not happen to Blender: renders and bakes between kills, stops and limits."""

import os
import random
import signal
import subprocess
import sys
import threading
import time
from contextlib import contextmanager

import bpy
import numpy as np
import pytest
from workers import is_running, shared_memory, wait_for

from lumenray import operators
from lumenray.blender_addon import registry as registry_module
from lumenray.blender_addon.foundation import engine_process
from lumenray.tools.libraries.scenes import tiny

pytestmark = [
    pytest.mark.blender,
    pytest.mark.mitsuba,
    pytest.mark.skipif(sys.platform == "win32", reason="signals"),
]

PATIENCE = 60.0
"""How long an orphan may live. [s]"""


@pytest.fixture(autouse=True)
def _operators(registered):
    registry_module.register(operators.CLASSES)
    # That of a test before.
    engine_process.close()
    before = shared_memory()
    yield
    engine_process.close()
    assert shared_memory() == before


@pytest.fixture
def room():
    """Closed box with a lamp and a camera inside."""
    tiny.build_closed_box()
    scene = bpy.context.scene
    scene.render.engine = "LUMENRAY"
    scene.render.resolution_x = scene.render.resolution_y = 48
    scene.lumenray.render.stop, scene.lumenray.render.samples = "SAMPLES", 8
    if scene.camera is None:
        eye = bpy.data.objects.new("Eye", bpy.data.cameras.new("Eye"))
        scene.collection.objects.link(eye)
        scene.camera = eye
    return scene


def render(scene, path, samples=8):
    """Render to a file and return its pixels."""
    scene.lumenray.render.samples = samples
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path), check_existing=False)
    pixels = np.array(image.pixels[:])
    bpy.data.images.remove(image)
    return pixels


def bake(folder, samples=64, density=8.0):
    """Bake the floor and return the map's mean."""
    bpy.ops.lumenray.bake_illuminance(
        objects="Floor", density=density, samples=samples, folder=str(folder)
    )
    return baked_mean()


def baked_mean():
    """Mean illuminance that the last bake left in the file."""
    return float(bpy.data.objects["Floor"].lumenray.baked_image["lumenray"]["mean"])


@contextmanager
def signal_later(number, seconds):
    """Send the worker a signal while the body runs."""
    done = threading.Event()

    def act():
        deadline = time.monotonic() + seconds
        while not done.is_set() and (time.monotonic() < deadline or engine_process.pid() is None):
            time.sleep(0.005)
        if not done.is_set():
            os.kill(engine_process.pid(), number)

    thread = threading.Thread(target=act)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()


@pytest.mark.slow
def test_kills_during_renders_and_bakes_cost_a_message(room, tmp_path):
    before = render(room, tmp_path / "before.exr")
    first = bake(tmp_path)
    moments = random.Random(3)  # noqa: S311 - nothing secret
    for number in range(6):
        with signal_later(signal.SIGKILL, moments.uniform(0.05, 0.8)):
            if number % 2:
                with pytest.raises(RuntimeError, match="nothing is lost"):
                    bake(tmp_path / "killed", samples=1 << 22)
            else:
                with pytest.raises(RuntimeError, match="nothing is lost"):
                    render(room, tmp_path / "killed.exr", samples=1 << 16)
        assert baked_mean() == first
    np.testing.assert_array_equal(render(room, tmp_path / "after.exr"), before)
    assert bake(tmp_path) == first


@pytest.mark.slow
def test_a_stopped_engine_is_told_apart_from_a_busy_one(room, tmp_path):
    before = render(room, tmp_path / "before.exr")
    start = time.monotonic()
    with (
        signal_later(signal.SIGSTOP, 0.3),
        pytest.raises(RuntimeError, match="nothing is lost"),
    ):
        render(room, tmp_path / "stopped.exr", samples=1 << 16)
    assert time.monotonic() - start < 60.0
    np.testing.assert_array_equal(render(room, tmp_path / "after.exr"), before)


@pytest.mark.slow
def test_a_bake_beyond_the_memory_ends_in_words(room, tmp_path, monkeypatch):
    before = bake(tmp_path)
    engine_process.close()
    monkeypatch.setattr(engine_process, "memory_limit", lambda: 3 << 28)
    room.lumenray.bake.largest = 8192
    with pytest.raises(RuntimeError, match="memory"):
        bake(tmp_path / "large", density=2000.0)
    monkeypatch.undo()
    engine_process.close()
    room.lumenray.bake.largest = 2048
    assert bake(tmp_path) == before


@pytest.mark.slow
def test_a_render_goes_before_a_bake_and_both_come_right(room, tmp_path):
    from lumenray.blender_addon.bake import job as bake_module
    from lumenray.engine.accuracy.stopping import StopRule
    from lumenray.engine.baking.order import BakeOrder

    before = render(room, tmp_path / "before.exr")
    order = BakeOrder((), StopRule(samples=1 << 13), density=16.0, largest=1024)
    settings = bake_module.BakeSettings(order, tmp_path)
    graph = bpy.context.evaluated_depsgraph_get()
    alone = bake_module.prepare(graph, [bpy.data.objects["Floor"]], settings)
    alone.run(engine_process.open_session("alone"))
    job = bake_module.prepare(graph, [bpy.data.objects["Floor"]], settings)
    session = engine_process.open_session("bake")
    thread = threading.Thread(target=job.run, args=(session,))
    thread.start()
    during = render(room, tmp_path / "during.exr")
    assert thread.is_alive()
    thread.join()
    np.testing.assert_array_equal(during, before)
    np.testing.assert_array_equal(
        job.result.pages[0].illuminance, alone.result.pages[0].illuminance
    )


@pytest.mark.slow
def test_the_engine_ends_with_the_file_and_the_extension(room, tmp_path):
    render(room, tmp_path / "a.exr")
    first = engine_process.pid()
    assert is_running(first)
    path = tmp_path / "kept.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    assert engine_process.pid() == first
    bpy.ops.wm.open_mainfile(filepath=str(path))
    assert wait_for(lambda: not is_running(first))
    render(bpy.context.scene, tmp_path / "b.exr")
    second = engine_process.pid()
    registry_module.unregister(operators.CLASSES)
    try:
        assert wait_for(lambda: not is_running(second))
    finally:
        registry_module.register(operators.CLASSES)


def test_an_animation_shares_one_scene_and_lets_it_go(room, tmp_path):
    bpy.data.objects["Floor"].keyframe_insert("location", frame=1)
    room.frame_start, room.frame_end = 1, 3
    room.render.image_settings.file_format = "OPEN_EXR"
    room.render.filepath = str(tmp_path / "frame_")
    bpy.ops.render.render(animation=True)
    assert len(list(tmp_path.glob("frame_*.exr"))) == 3
    from lumenray.blender_addon.rendering import render_engine

    assert render_engine._final is None


CHILD = """
import sys, threading
import bpy
sys.path[:0] = {path!r}
import lumenray
from lumenray.blender_addon import registry
from lumenray.blender_addon.foundation import engine_process
from lumenray.tools.libraries.scenes import tiny
from lumenray import operators
registry.register(operators.CLASSES)
tiny.build_closed_box()
scene = bpy.context.scene
scene.render.engine = "LUMENRAY"
if scene.camera is None:
    eye = bpy.data.objects.new("Eye", bpy.data.cameras.new("Eye"))
    scene.collection.objects.link(eye)
    scene.camera = eye
scene.render.resolution_x = scene.render.resolution_y = 64
scene.lumenray.render.samples = 1 << 18
def tell():
    while engine_process.pid() is None:
        pass
    print("pid", engine_process.pid(), flush=True)
threading.Thread(target=tell, daemon=True).start()
{action}
"""

ACTIONS = {
    "render": "bpy.ops.render.render()",
    "bake": "bpy.ops.lumenray.bake_illuminance(objects='Floor', samples=1 << 24, folder='.')",
    "exit": (
        "threading.Timer(2.0, lambda: __import__('os')._exit(3)).start(); bpy.ops.render.render()"
    ),
    "end": "engine_process.open_session('x'); __import__('time').sleep(0.5)",
}


@pytest.mark.parametrize("action", ACTIONS)
@pytest.mark.slow
def test_no_process_is_left_when_blender_is_gone(action, tmp_path):
    text = CHILD.format(path=sys.path, action=ACTIONS[action])
    host = subprocess.Popen(
        [sys.executable, "-c", text], stdout=subprocess.PIPE, text=True, cwd=tmp_path
    )
    try:
        line = next(line for line in host.stdout if line.startswith("pid"))
        worker = int(line.split()[1])
        if action in {"render", "bake"}:
            assert is_running(worker)
            time.sleep(1.5)
            host.kill()
        assert wait_for(lambda: host.poll() is not None, PATIENCE)
        assert wait_for(lambda: not is_running(worker), PATIENCE)
    finally:
        host.kill()
        host.wait()
        host.stdout.close()
