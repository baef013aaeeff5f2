"""Jobs of Flamenco compiled by Node, with a stand-in for its manager, and their tasks done by hand."""

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPTS = Path(__file__).parents[2] / "packaging" / "flamenco"

MANAGER = Path(__file__).with_name("flamenco_manager.js")

RENDER = {
    "frames": "1-3", "chunk_size": 2, "stop": "samples", "error": 2.0, "samples": 4, "time": 60.0, "accept_errors": False,
    "video": False, "render_output_path": "/farm/out/{timestamp}/######", "blendfile": "/farm/office.flamenco.blend",
    "scene": "Scene", "format": "PNG", "image_file_extension": ".png", "fps": 24.0,
}  # fmt: skip

BAKE = {
    "collections": "", "density": 0.0, "stop": "as the scene says", "error": 2.0, "error_lx": 5.0, "samples": 64,
    "time": 600.0, "accept_errors": False, "bake_output_path": "/farm/out/{timestamp}", "blendfile": "/farm/office.blend",
    "scene": "Scene",
}  # fmt: skip


def compile_job(kind, settings):
    """What a script makes of settings: its type, tasks, settings as they are then, and its fault.

    The test is skipped where there is no Node.
    """
    node = shutil.which("node")
    if node is None:
        pytest.skip("Node.js is needed to compile jobs of Flamenco")
    done = subprocess.run(
        [node, str(MANAGER), str(SCRIPTS / f"lumenray-{kind}.js")],
        input=json.dumps(settings),
        capture_output=True,
        text=True,
        check=True,
    )
    return json.loads(done.stdout)


def command_line(command, blender="blender"):
    """What Flamenco Worker runs for a command, as a list: there is no shell."""
    given = command["parameters"]
    before = given["exeArgs"].replace("{blenderArgs}", "-b -y").split()
    exe = given["exe"].replace("{blender}", blender)
    return [exe, *before, *given["argsBefore"], given["blendfile"], *given["args"]]


def frames_of(text):
    """Frames as Blender's --render-frame has them."""
    ends = [piece.partition("..") for piece in text.split(",")]
    return [n for first, dots, last in ends for n in range(int(first), int(last or first) + 1)]


def do_in_bpy(command):
    """Do a command line in Blender's Python module, argument by argument as Blender does; the .blend file is opened."""
    import bpy

    words = command_line(command)
    bpy.ops.wm.open_mainfile(filepath=command["parameters"]["blendfile"])
    scene = bpy.context.scene
    queue = list(command["parameters"]["args"])
    kept, sys.argv = sys.argv, words
    try:
        while queue and queue[0] != "--":
            option, value = queue.pop(0), queue.pop(0)
            if option == "--scene":
                scene = bpy.context.window.scene = bpy.data.scenes[value]
            elif option == "--engine":
                scene.render.engine = value
            elif option == "--render-output":
                scene.render.filepath = value
            elif option == "--render-format":
                scene.render.image_settings.file_format = value
            elif option == "--python-expr":
                exec(value, {"__name__": "__main__"})  # noqa: S102 - what a task has Blender run
            elif option == "--render-frame":
                for frame in frames_of(value):
                    _render(scene, frame)
            else:
                raise ValueError(f"Blender is given {option}")
    finally:
        sys.argv = kept


def _render(scene, frame):
    import bpy

    scene.frame_start = scene.frame_end = frame
    try:
        bpy.ops.render.render(animation=True, scene=scene.name)
    except RuntimeError as error:
        # Blender goes on to the next argument.
        sys.stderr.write(f"{error}\n")
