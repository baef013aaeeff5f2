"""The bundled office as the engine's data. Blender reads it in a process of its own, which leaves Mitsuba alone.

That process is ``python -m lumenray.benchmarks.common.office OUT``.
"""

import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from ...engine.errors import LumenrayError
from ...engine.scene.camera import Camera
from ...engine.worker import codec

PATIENCE = 120.0
"""Longest that Blender may take. [s]"""


@dataclass(frozen=True, eq=False)
class Office:
    """Items of the scene, ids of the objects of its collection `Bake`, and its camera."""

    items: tuple
    baked: tuple[str, ...]
    camera: Camera


def load_office() -> Office:
    """Read the office.

    Raises
    ------
    LumenrayError    Blender's Python module is missing, or does not read it.
    """
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "office"
        try:
            made = subprocess.run(
                [sys.executable, "-m", __spec__.name, str(path)],
                capture_output=True,
                timeout=PATIENCE,
                check=False,
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            raise LumenrayError(f"Blender cannot read the office ({error})") from None
        if made.returncode:
            said = made.stderr.decode(errors="replace").strip().splitlines() or ["no message"]
            raise LumenrayError(f"Blender cannot read the office ({said[-1]})")
        text, _, block = path.read_bytes().partition(b"\n")
    return Office(*codec.decode(codec.from_text(text), bytearray(block)))


def write_office(path: Path) -> None:
    """Convert the office with Blender and write it."""
    import bpy

    from ...blender_addon import registry
    from ...blender_addon.sync.scene import convert_scene
    from ...libraries import scenes

    registry.register()
    bpy.ops.wm.open_mainfile(filepath=str(scenes.scene_path("office")), load_ui=False)
    made = convert_scene(bpy.context.evaluated_depsgraph_get())
    baked = bpy.data.collections["Bake"].all_objects
    objects = tuple(made.objects[item.name] for item in baked)
    tree, parts, size = codec.encode((made.delta.changed, objects, made.camera))
    block = bytearray(size)
    for offset, array in parts:
        block[offset : offset + array.nbytes] = array.tobytes()
    path.write_bytes(codec.to_text(tree) + b"\n" + block)


if __name__ == "__main__":
    write_office(Path(sys.argv[1]))
