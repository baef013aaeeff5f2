"""The command that takes the guide's pictures of the service's page: an office, baked, changed and compared.

python tests/viewer/take_pictures.py docs/pictures
"""

import sys
import tempfile
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[1] / "helpers"))

import bpy
import page_visits

from lumenray.blender_addon import registry
from lumenray.blender_addon.lit_room import Plan, add_lit_room
from lumenray.blender_addon.luminaires.settings import is_luminaire

DESKS = {"Desk A": (-1.2, -0.6), "Desk B": (1.2, 0.6)}


def main() -> None:
    """Take them into the folder that the command line names."""
    if not page_visits.CAN_VISIT:
        sys.exit(f"take_pictures: {page_visits.HOW}")
    # Other than a test it may wait for maps that are worth a look.
    page_visits.LIMIT = 1200
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "office.blend"
        lights = save_office(file)
        request = {
            "file": str(file),
            "error": 1,
            "time": 180,
            "density": 6,
            "interval": 100,
            "requirement": "office.writing",
            "surfaces": ["Floor", "Walls", "Ceiling", *DESKS],
            "lights": lights,
            "spectrum": "LED-B4",
            "dimmed": lights[:2],
            "material": ["Walls 50 %", "White wall paint, matt"],
            "points": [[0.33, 0.88]],
            "pictures": str(Path(sys.argv[1]).resolve()),
        }
        page_visits.visit("pictures.mjs", Path(folder), request)


def save_office(path: Path) -> list[str]:
    """Save the room that the extension begins with, with two desks; return the names of its lights."""
    registry.register()
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    floor, *_ = add_lit_room(bpy.context, Plan(5.4, 4.2, 2.8, 2, 2))
    for name, (x, y) in DESKS.items():
        place = floor.location
        bpy.ops.mesh.primitive_cube_add(size=1.0, location=(place.x + x, place.y + y, 0.71))
        desk = bpy.context.object
        desk.name, desk.scale = name, (1.6, 0.8, 0.04)
        desk.data.materials.append(bpy.data.materials["Ceiling 70 %"])
    lights = sorted(
        filter(is_luminaire, bpy.context.scene.objects),
        key=lambda each: each.location.x,
    )
    for number, each in enumerate(lights):
        each.name = f"Panel {number + 1}"
        each.lumenray.light_group = "Window side" if number < 2 else "Door side"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    return [each.name for each in lights]


if __name__ == "__main__":
    main()
