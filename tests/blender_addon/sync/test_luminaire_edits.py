"""Luminaires in a scene that is kept current: what each edit sends, and what the scene is then."""

import bpy
import numpy as np
import pytest
from blender_luminaires import add_luminaire
from kept_scenes import KeptScene
from photometric_files import EVEN, FOUR, FULL_FLUX

from lumenray.blender_addon.luminaires.files import photometric_files
from lumenray.blender_addon.luminaires.settings import settings_of
from lumenray.engine.scene.light import Luminaire
from lumenray.engine.scene.mesh import Placement
from lumenray.engine.scene.scene import content_digest

pytestmark = pytest.mark.usefixtures("extension")


def test_an_empty_is_a_light_of_the_scene_and_goes_with_its_file(write_photometry):
    empty, stage = add_luminaire("EMPTY", write_photometry()), KeptScene()
    ((light,), removed) = stage.changes()
    assert isinstance(light, Luminaire)
    assert light.id == f"object:{empty.lumenray.uid}"
    assert removed == []
    settings_of(empty).use_file = False
    assert stage.changes() == ([], [light.id])
    settings_of(empty).use_file = True
    ((back,), _) = stage.changes()
    assert content_digest(back) == content_digest(light)
    bpy.data.objects.remove(empty)
    assert stage.changes() == ([], [light.id])


@pytest.mark.parametrize("kind", ["POINT", "EMPTY"])
@pytest.mark.parametrize("edit", ["dimming", "rotation", "emission", "text", "move"])
def test_an_edit_sends_that_light_alone(kind, edit, write_photometry):
    lamp, other = (
        add_luminaire(kind, write_photometry()),
        add_luminaire(kind, write_photometry(), "Other"),
    )
    add_luminaire("EMPTY", name="plain")
    stage = KeptScene()
    stage.changes()
    settings = settings_of(lamp)
    match edit:
        case "dimming":
            settings.dimming = 0.5
        case "rotation":
            settings.rotation = 0.5
        case "emission":
            settings.emission = "POINT"
        case "text":
            photometric_files.load(settings, write_photometry(FOUR, "four.ies"))
        case "move":
            lamp.location.z = 1.0
    changed, removed = stage.changes()
    assert [item.name for item in changed] == [lamp.name]
    assert removed == []
    assert settings_of(other).dimming == 1.0
    settings.show_solid = False
    assert stage.changes() == ([], [])


def test_a_hidden_luminaire_is_dark_and_comes_back(write_photometry):
    empty, stage = add_luminaire("EMPTY", write_photometry()), KeptScene()
    stage.changes()
    empty.hide_set(True)
    ((dark,), _) = stage.changes()
    assert dark.output.value == 0.0
    empty.hide_set(False)
    ((bright,), _) = stage.changes()
    assert bright.id == dark.id
    assert bright.output.value == pytest.approx(FULL_FLUX)


def test_instances_of_luminaires_are_lights(write_photometry):
    group = bpy.data.collections.new("Group")
    empty, lamp = (
        add_luminaire("EMPTY", write_photometry()),
        add_luminaire("SPOT", write_photometry()),
    )
    for thing in (empty, lamp):
        group.objects.link(thing)
        bpy.context.scene.collection.objects.unlink(thing)
    stage, places = KeptScene(), [(1, 0, 0), (0, 5, 0)]
    for place in places:
        instance = add_luminaire("EMPTY", name="Instance")
        instance.instance_type, instance.instance_collection = "COLLECTION", group
        instance.location = place
    lights, _ = stage.changes()
    assert len(lights) == len({light.id for light in lights}) == 4
    found = sorted(tuple(light.frame[:3, 3]) for light in lights)
    assert found == sorted(place for place in places for _ in range(2))
    instance.location.x = 9.0
    changed, removed = stage.changes()
    assert [light.frame[0, 3] for light in changed] == [9.0, 9.0]
    assert removed == []
    settings_of(empty).dimming = 0.5
    changed, _ = stage.changes()
    assert len(changed) == 2
    assert all(light.output.value == pytest.approx(0.5 * FULL_FLUX) for light in changed)


def test_a_body_is_no_part_of_the_scene(write_photometry):
    bpy.ops.lumenray.add_luminaire(filepath=write_photometry())
    empty, stage = bpy.context.object, KeptScene()
    ((light,), _) = stage.changes()
    assert isinstance(light, Luminaire)
    shown = [i.object.name for i in bpy.context.evaluated_depsgraph_get().object_instances]
    assert len(shown) == 2
    shape = empty.instance_collection.objects[0]
    shape.lumenray.is_luminaire_body = False
    changed, _ = stage.changes()
    assert Placement in {type(item) for item in changed}
    shape.lumenray.is_luminaire_body = True
    assert any(key.startswith("object:") for key in stage.changes()[1])


def test_undo_brings_a_luminaire_back(write_photometry):
    bpy.context.preferences.edit.use_global_undo = True
    lamp, stage = add_luminaire("POINT", write_photometry()), KeptScene()
    lamp.name = "Lamp"
    bpy.ops.ed.undo_push(message="before")
    stage.changes()
    settings_of(lamp).dimming = 0.25
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="dimmed")
    stage.changes()
    bpy.ops.ed.undo()
    ((light,), _) = stage.changes()
    assert light.output.value == pytest.approx(FULL_FLUX)


@pytest.mark.parametrize("seed", [0, 1])
def test_random_edits_leave_the_scene_of_a_fresh_export(seed, write_photometry):  # noqa: PLR0912 - one for each edit
    """`KeptScene.changes` compares after every edit."""
    draw = np.random.default_rng(seed)
    paths = [
        write_photometry(),
        write_photometry(FOUR, "four.ies"),
        write_photometry(EVEN.replace("100 100", "7 7"), "dim.ies"),
    ]
    for number, kind in enumerate(("POINT", "SPOT", "AREA", "EMPTY", "EMPTY", "SUN")):
        add_luminaire(kind, "" if kind == "SUN" else paths[number % 3], f"{kind} {number}")
    group = bpy.data.collections.new("Group")
    group.objects.link(bpy.data.objects["EMPTY 3"])
    instance = add_luminaire("EMPTY", name="Instance")
    instance.instance_type, instance.instance_collection = "COLLECTION", group
    stage = KeptScene()
    stage.changes()
    for _ in range(120):
        lamp = bpy.data.objects[int(draw.integers(len(bpy.data.objects)))]
        settings, edit = settings_of(lamp), int(draw.integers(12))
        if edit == 0:
            lamp.location = draw.normal(size=3)
        elif edit == 1:
            lamp.hide_set(not lamp.hide_get())
        elif edit == 2:
            lamp.scale.x *= -1.0
        elif edit == 3:
            copied = lamp.copy()
            copied.data = lamp.data.copy() if lamp.data and draw.random() < 0.5 else lamp.data
            bpy.context.scene.collection.objects.link(copied)
        elif edit == 4 and len(bpy.data.objects) > 6:
            bpy.data.objects.remove(lamp)
        elif edit == 5 and lamp.data is not None:
            lamp.data.type = str(draw.choice(["POINT", "SPOT", "SUN", "AREA"]))
        elif settings is not None and edit == 6:
            settings.use_file = not settings.use_file
        elif settings is not None and edit == 7:
            photometric_files.load(settings, str(draw.choice(paths)), bool(draw.random() < 0.5))
        elif settings is not None and edit == 8:
            settings.dimming = float(draw.choice([0.0, 0.5, 1.0]))
        elif settings is not None and edit == 9:
            settings.emission = str(draw.choice(["OPENING", "LIGHT", "POINT"]))
        elif settings is not None and edit == 10:
            settings.rotation, settings.mirror = float(draw.random()), not settings.mirror
        elif settings is not None:
            settings.filepath = "//nowhere.ies"
        stage.changes()
