"""What is told of a file, and changes of it by name, as lights and materials have them afterwards."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from blender_luminaires import add_luminaire
from blender_objects import add_light, add_quad, new_paint

from lumenray.blender_addon import scene_edits
from lumenray.blender_addon.light_list import find_lights
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.engine.errors import SceneError
from lumenray.engine.scene.spectrum import Blackbody, Illuminant
from lumenray.libraries import luminaires

pytestmark = pytest.mark.usefixtures("registered")

NOWHERE = Path("never.blend")
"""Where files are saved beside which nothing is written."""

LIBRARY = {"wall_white_matt": "White wall paint, matt"}


def amounts():
    """What each light of the open file gives, by its name."""
    bpy.context.view_layer.update()
    found = find_lights(bpy.context.evaluated_depsgraph_get())
    assert not found.problems
    return {row.name: row.amount for row in found.rows}


def change(edits, saved=NOWHERE):
    """Check edits against the open file, and make them."""
    checked = scene_edits.check_edits(edits, scene_edits.describe(bpy), LIBRARY)
    scene_edits.apply_edits(bpy, checked, saved)


def spectrum_of(name):
    """What the engine gets as the spectrum of the only light."""
    delta = convert_scene(bpy.context.evaluated_depsgraph_get()).delta
    (light,) = [each for each in delta.changed if hasattr(each, "output") and each.name == name]
    return light.output.spectrum


def test_what_is_told_of_a_file():
    add_quad("Floor", material=new_paint())
    add_light("POINT", energy=10.0, name="Bulb")
    told = scene_edits.describe(bpy)
    (light,) = [each for each in told["lights"] if each["name"] == "Bulb"]
    assert (light["unit"], light["count"]) == ("lm", 1)
    assert light["amount"] == pytest.approx(amounts()["Bulb"])
    assert {"Floor", "Bulb"} <= set(told["objects"])
    assert "Floor" in told["surfaces"]
    assert "Paint" in told["materials"]


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "AREA"])
def test_flux_and_dimming_of_lights(kind):
    add_light(kind, energy=10.0, name="Lamp")
    before = amounts()["Lamp"]
    change({"lights": {"Lamp": {"dimming": 0.25}}})
    assert amounts()["Lamp"] == pytest.approx(0.25 * before, rel=1e-5)
    change({"lights": {"Lamp": {"flux": 900, "dimming": 0.5}}})
    assert amounts()["Lamp"] == pytest.approx(450.0, rel=1e-5)
    change({"lights": {"Lamp": {"is_on": False}}})
    assert "Lamp" not in amounts()
    assert scene_edits.describe(bpy)["lights"][-1]["is_on"] is False
    change({"lights": {"Lamp": {"is_on": True}}})
    assert amounts()["Lamp"] == pytest.approx(450.0, rel=1e-5)


def test_a_sun_is_dimmed_but_has_no_flux():
    add_light("SUN", energy=3.0, name="Sun")
    before = amounts()["Sun"]
    change({"lights": {"Sun": {"dimming": 0.5}}})
    assert amounts()["Sun"] == pytest.approx(0.5 * before, rel=1e-5)
    with pytest.raises(SceneError, match="stated in lx and has no flux"):
        change({"lights": {"Sun": {"flux": 900}}})


@pytest.mark.parametrize("kind", ["AREA", "EMPTY"])
def test_flux_and_dimming_of_photometric_files(kind):
    path = next(luminaires.FOLDER.rglob("*.ldt"))
    add_luminaire(kind, str(path), "Downlight")
    change({"lights": {"Downlight": {"flux": 1200, "dimming": 0.5, "temperature": 3000}}})
    assert amounts()["Downlight"] == pytest.approx(600.0, rel=1e-4)


def test_the_temperature_of_a_light_is_the_one_that_the_engine_gets():
    add_light("POINT", energy=10.0, name="Lamp")
    before = amounts()["Lamp"]
    change({"lights": {"Lamp": {"temperature": 3000}}})
    assert spectrum_of("Lamp") == Blackbody(3000.0)
    assert amounts()["Lamp"] == pytest.approx(before, rel=1e-5)


@pytest.mark.parametrize("kind", ["POINT", "EMPTY"])
def test_an_illuminant_is_the_spectrum_of_a_light_which_keeps_its_lumens(kind):
    if kind == "EMPTY":
        add_luminaire(kind, str(next(luminaires.FOLDER.rglob("*.ldt"))), "Lamp")
    else:
        add_light(kind, energy=10.0, name="Lamp")
    before = amounts()["Lamp"]
    change({"lights": {"Lamp": {"spectrum": "LED-B3"}}})
    assert spectrum_of("Lamp") == Illuminant("LED-B3")
    assert amounts()["Lamp"] == pytest.approx(before, rel=1e-4)


def test_a_spectrum_that_comes_with_the_edits_lies_beside_the_file_that_is_saved(tmp_path):
    """Two files of one name that differ, one of them with a name that some systems refuse and the second column chosen."""
    add_light("POINT", energy=10.0, name="Lamp")
    first = {"file": "a?/b.csv", "text": "nm,no,yes\n400,9,1\n500,9,2\n600,9,3\n", "column": 2}
    second = {"file": "a?/b.csv", "text": "400 3\n600 1\n"}
    saved = tmp_path / "out.blend"
    change({"lights": {"Lamp": {"spectrum": second}}}, saved)
    change({"lights": {"Lamp": {"spectrum": first}}}, saved)
    bpy.ops.wm.save_as_mainfile(filepath=str(saved))
    moved = tmp_path / "elsewhere"
    moved.mkdir()
    for each in (saved, tmp_path / "out.spectra"):
        each.rename(moved / each.name)
    bpy.ops.wm.open_mainfile(filepath=str(moved / "out.blend"))
    table = spectrum_of("Lamp")
    np.testing.assert_array_equal(table.wavelengths, [400.0, 500.0, 600.0])
    np.testing.assert_array_equal(table.values, [1.0, 2.0, 3.0])
    assert len(list((moved / "out.spectra").iterdir())) == 2


def test_materials_of_the_file_change_places_all_at_once():
    """What is asked for is what the file had, also where it gives its own place to another."""
    paints = [new_paint() for _ in range(3)]
    floors = [add_quad(each.name, material=each) for each in paints]
    red, green, blue = (each.name for each in paints)
    for each, reflectance in zip(paints, (0.1, 0.2, 0.3), strict=True):
        each.lumenray.use_override, each.lumenray.reflectance = True, reflectance
    change({"materials": {red: {"scene": green}, green: {"scene": red}, blue: {"scene": green}}})
    found = [floor.data.materials[0].lumenray.reflectance for floor in floors]
    assert found == pytest.approx([0.2, 0.1, 0.2])


def test_lights_that_share_settings_are_changed_one_by_one():
    first = add_light("POINT", energy=10.0, name="A")
    second = bpy.data.objects.new("B", first.data)
    bpy.context.scene.collection.objects.link(second)
    before = amounts()
    change({"lights": {"A": {"dimming": 0.5}}})
    after = amounts()
    assert after["A"] == pytest.approx(0.5 * before["A"], rel=1e-5)
    assert after["B"] == pytest.approx(before["B"], rel=1e-5)


def test_hidden_objects_and_materials_of_the_library():
    floor = add_quad("Floor", material=new_paint())
    chair = add_quad("Chair")
    change({"hidden": ["Chair"], "materials": {"Paint": "wall_white_matt"}})
    assert chair.hide_render
    assert not floor.hide_render
    (material,) = floor.data.materials
    assert material.name.startswith(LIBRARY["wall_white_matt"])
    assert material.lumenray.use_override


@pytest.mark.parametrize(
    ("edits", "told"),
    [
        ([], "expected an object"),
        ({"light": {}}, "expected an object with lights"),
        ({"lights": []}, "'lights' is expected to be an object"),
        ({"lights": {"Nobody": {}}}, "no light 'Nobody'"),
        ({"lights": {"Lamp": {"power": 1}}}, "expected flux"),
        ({"lights": {"Lamp": {"flux": "9"}}}, "expected a number"),
        ({"lights": {"Lamp": {"flux": True}}}, "expected a number"),
        ({"lights": {"Lamp": {"flux": float("nan")}}}, "expected a number"),
        ({"lights": {"Lamp": {"dimming": 1.5}}}, "from 0 to 1"),
        ({"lights": {"Lamp": {"is_on": 1}}}, "expected true or false"),
        ({"lights": {"Lamp": {"spectrum": "LED"}}}, "no illuminant 'LED'; there are A, D50"),
        ({"lights": {"Lamp": {"spectrum": 4000}}}, "expected the name of an illuminant"),
        ({"lights": {"Lamp": {"spectrum": {"file": "a.csv"}}}}, "an object with file, text"),
        ({"lights": {"Lamp": {"spectrum": {"file": "", "text": "1 1"}}}}, "'file' is expected"),
        ({"lights": {"Lamp": {"spectrum": {"file": "a", "text": 5}}}}, "'text' is expected"),
        ({"lights": {"Lamp": {"spectrum": {"file": "a", "text": "\ud800"}}}}, "no text can have"),
        (
            {"lights": {"Lamp": {"spectrum": {"file": "a", "text": "1" * 300_000}}}},
            "at most 262144",
        ),
        ({"lights": {"Lamp": {"spectrum": {"file": "a", "text": "400 1\n500 x"}}}}, "line 2"),
        (
            {"lights": {"Lamp": {"spectrum": {"file": "a", "text": "400 0\n500 0"}}}},
            "no visible light",
        ),
        (
            {
                "lights": {
                    "Lamp": {"spectrum": {"file": "a.csv", "text": "400 1\n500 2", "column": 2}}
                }
            },
            "a.csv",
        ),
        ({"lights": {"Lamp": {"spectrum": "A", "temperature": 3000}}}, "not both"),
        ({"materials": {"Paint": {"scene": "Gold"}}}, "no material 'Gold'"),
        ({"materials": {"Paint": {"of": "Paint"}}}, "an object with 'scene'"),
        ({"hidden": {}}, "expected to be a list"),
        ({"hidden": [["Lamp"]]}, "no object"),
        ({"materials": {"Lamp": "wall_white_matt"}}, "no material 'Lamp'"),
        ({"materials": {"Paint": "gold"}}, "no material of the library 'gold'"),
    ],
)
def test_edits_that_are_not_understood(edits, told):
    content = {
        "lights": [{"name": "Lamp", "unit": "lm"}],
        "objects": ["Lamp"],
        "materials": ["Paint"],
    }
    with pytest.raises(SceneError, match=told):
        scene_edits.check_edits(edits, content, LIBRARY)
