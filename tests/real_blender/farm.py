"""Do the tasks of Flamenco's jobs in a real Blender, one after the other; see `run_farm.sh`."""

import csv
import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent

sys.path.insert(0, str(HERE.parent / "helpers"))

from flamenco import BAKE, RENDER, command_line, compile_job  # noqa: E402

OUT = Path(os.environ["LUMENRAY_OUT"])

INSIDE = Path("/out/farm a'b ö")
"""Folder of the job as Blender sees it."""

BLEND = str(INSIDE / "box.blend")

MAKE = """
import bpy, sys
from importlib import import_module
name = next(n for n in sys.modules if n.endswith("lumenray.blender_addon")).rpartition(".")[0]
scenes = import_module(name + ".libraries.scenes")
bpy.ops.wm.open_mainfile(filepath=str(scenes.scene_path("closed_box")))
scene = bpy.context.scene
scene.render.resolution_x = scene.render.resolution_y = 16
collection = bpy.data.collections.new("Ground; 'floor'")
scene.collection.children.link(collection)
collection.objects.link(bpy.data.objects["Floor"])
bpy.ops.wm.save_as_mainfile(filepath=sys.argv[-1])
sys.stdout.write("scene=" + scene.name + "\\n")
"""


class FarmError(Exception):
    """Something that is not as it has to be."""


def require(condition, message):
    """Raise :class:`FarmError` unless the condition holds."""
    if not condition:
        raise FarmError(message)


def blender(*arguments) -> subprocess.CompletedProcess:
    """Run a program in the real Blender's system, without a shell."""
    line = [str(HERE / "blender.sh"), "run", *map(str, arguments)]
    done = subprocess.run(
        line, check=False, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    sys.stdout.write(done.stdout)
    return done


def do(task, exit_code: int = 0) -> str:
    """Do a task, and return what Blender said."""
    sys.stdout.write(f"\n-- {task['name']}\n")
    done = blender(*command_line(task["commands"][0]))
    require(done.returncode == exit_code, f"{task['name']} ended with {done.returncode}")
    return done.stdout


def table(path: Path) -> list[dict]:
    """Rows of a table."""
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def main() -> None:
    """Do it all."""
    folder = OUT / INSIDE.name
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    said = blender("blender", "-b", "--python-exit-code", "1", "--python-expr", MAKE, "--", BLEND)
    (scene,) = [
        line.partition("=")[2] for line in said.stdout.splitlines() if line.startswith("scene=")
    ]
    common = {"blendfile": BLEND, "scene": scene}

    order = RENDER | common | {"render_output_path": str(INSIDE / "frames" / "######")}
    *renders, collect = compile_job("render", order)["tasks"]
    do(renders[0])
    require("frames are missing" in do(collect, 1), "a missing frame is not missed")
    do(renders[1])
    do(collect)
    rows = table(folder / "frames" / "lumenray_frames.csv")
    require([row["frame"] for row in rows] == ["1", "2", "3"], f"frames of the table: {rows}")
    require(
        all((folder / "frames" / row["file"]).is_file() for row in rows), "a frame is not there"
    )

    order = BAKE | common | {
        "collections": "Ground; 'floor'", "stop": "samples", "samples": 16, "density": 4.0,
        "bake_output_path": str(INSIDE / "maps"),
    }  # fmt: skip
    for task in compile_job("bake", order)["tasks"]:
        do(task)
    rows = table(folder / "maps" / "lumenray_maps.csv")
    require([row["name"] for row in rows] == ["Floor"], f"maps of the table: {rows}")

    missing = compile_job("bake", order | {"collections": "Nowhere"})["tasks"][0]
    require("no collection named Nowhere" in do(missing, 1), "it is not said what is missing")
    for task, told in ((renders[0], "engine not found"), (missing, "Lumenray is not enabled")):
        given = task["commands"][0]["parameters"]
        given["argsBefore"] = ["--factory-startup", *given["argsBefore"]]
        require(told in do(task, 1), "a Blender without Lumenray goes on")
    sys.stdout.write("the farm's tasks do what they have to\n")


if __name__ == "__main__":
    main()
