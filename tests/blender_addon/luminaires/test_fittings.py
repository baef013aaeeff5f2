"""Schedule of a scene: what renders show is counted, what is not known is told."""

import json

import bpy
import pytest
from blender_luminaires import add_luminaire
from photometric_files import FULL_FLUX

from lumenray.blender_addon.luminaires.fittings import find_fittings
from lumenray.blender_addon.luminaires.settings import settings_of
from lumenray.command_line import main as command_line

pytestmark = pytest.mark.usefixtures("extension")

WATTS = 10.0
"""That the file of these tests states. [W]"""


def fittings():
    """Return what the open scene's schedule is made of."""
    return find_fittings(bpy.context.evaluated_depsgraph_get())


def test_what_renders_show_is_counted_with_its_factors(write_photometry):
    path = write_photometry()
    add_luminaire("POINT", path)
    settings_of(add_luminaire("EMPTY", path, "Dimmed")).dimming = 0.5
    add_luminaire("AREA", path, "Off").hide_render = True
    add_luminaire("SPOT", name="Own")
    add_luminaire("SUN", name="Sun")
    made, problems, others = fittings()
    assert sorted(each.luminous_flux for each in made) == pytest.approx([FULL_FLUX / 2, FULL_FLUX])
    assert [each.watts for each in made] == [WATTS, WATTS]
    assert (problems, others) == ([], 1)


def test_instances_count(write_photometry):
    lamp = add_luminaire("POINT", write_photometry())
    group = bpy.data.collections.new("Group")
    group.objects.link(lamp)
    bpy.context.scene.collection.objects.unlink(lamp)
    for number in range(3):
        place = bpy.data.objects.new(f"Place {number}", None)
        place.instance_type, place.instance_collection = "COLLECTION", group
        bpy.context.scene.collection.objects.link(place)
    assert len(fittings()[0]) == 3


def test_a_missing_file_is_a_problem_not_a_zero():
    lamp = add_luminaire()
    settings_of(lamp).use_file = True
    settings_of(lamp).filepath = "/nowhere/none.ies"
    made, problems, _ = fittings()
    assert made == []
    assert "Lamp" in problems[0]


def test_the_command_tells_watts_per_area(write_photometry, tmp_path, capsys):
    path = write_photometry()
    for number in range(4):
        add_luminaire("POINT", path, f"Lamp {number}")
    blend = str(tmp_path / "room.blend")
    bpy.ops.wm.save_as_mainfile(filepath=blend)
    capsys.readouterr()
    tell = ["luminaire", "schedule", blend, "--area", "20"]
    assert command_line.main([*tell, "--lux", "400", "--json"]) == 0
    row = json.loads(capsys.readouterr().out)
    assert row["count"] == 4
    assert row["luminaires"][0]["count"] == 4
    assert row["watts_per_m2"] == pytest.approx(4 * WATTS / 20.0)
    assert row["watts_per_m2_per_100_lx"] == pytest.approx(0.5)
    assert command_line.main(tell) == 0
    assert "2 W/m2" in capsys.readouterr().out
    assert command_line.main(["luminaire", "schedule", blend, "--lux", "400"]) == 1
    assert "--area" in capsys.readouterr().err
