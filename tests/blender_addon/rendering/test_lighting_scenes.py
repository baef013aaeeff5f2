"""Lighting scenes: kept levels of light groups, by which readings are added up and judged without measuring again."""

import bpy
import numpy as np
import pytest
from kept_readings import LUX, NOISE, measure, new_room, set_sliders

from lumenray.blender_addon.rendering import lighting_scenes
from lumenray.blender_addon.sensors import scene_verdicts
from lumenray.blender_addon.sensors.readings import readings_of
from lumenray.engine.errors import SceneError
from lumenray.engine.judgement.verdict import State

pytestmark = pytest.mark.usefixtures("extension")


@pytest.fixture
def room():
    """A room that was measured, with a scene that meets 500 lx and one that does not."""
    empty = new_room()
    measure()
    scene = bpy.context.scene
    lighting_scenes.add(scene)
    set_sliders(Ceiling=0.5, Desk=0.0)
    lighting_scenes.add(scene)
    return empty


def judged(empty, chosen):
    return scene_verdicts.judge_all(bpy.context.scene, chosen).areas.get(empty.name)


def test_scenes_are_sums_of_groups_and_judged_each(room):
    day, evening = lighting_scenes.choose_all(bpy.context.scene)
    assert (day.name, evening.name) == ("Day", "Evening")
    for chosen, exact, state in ((day, 600.0, State.MET), (evening, 200.0, State.NOT_MET)):
        values, _ = readings_of(room).mixed(chosen.levels)
        assert values.mean() == pytest.approx(exact, rel=0.01)
        made = judged(room, chosen)
        assert made.state is state
        assert made.verdicts[0].found.low < exact < made.verdicts[0].found.high
    made = scene_verdicts.judge_all(bpy.context.scene, evening)
    assert scene_verdicts.tell(made) == [("Desk A", "not met")]
    # The light mix as its sliders stand is judged like the scene that they show.
    assert judged(room, lighting_scenes.Chosen("", evening.levels)).state is State.NOT_MET


def test_errors_of_sums_are_those_of_what_is_added(room):
    """At 4000 sensors the readings scatter about the truth as far as the stated errors say."""
    own = room.lumenray.sensor
    own.use_spacing, own.spacing, own.length, own.width = True, 0.02, 2.0, 0.8
    measure()
    set_sliders(Ceiling=0.3, Desk=2.0)
    lighting_scenes.add(bpy.context.scene)
    chosen = lighting_scenes.choose_all(bpy.context.scene)[-1]
    values, errors = readings_of(room).mixed(chosen.levels)
    exact = 0.3 * LUX["Ceiling"] + 2.0 * LUX["Desk"]
    parts = NOISE * np.array([0.3 * LUX["Ceiling"], 2.0 * LUX["Desk"]])
    np.testing.assert_allclose(errors, np.hypot(*parts), rtol=1e-5)
    assert len(values) > 3900
    assert ((values - exact) / errors).std() == pytest.approx(1.0, abs=0.05)


def test_a_scene_sets_the_sliders_and_is_changed_by_them(room):
    scene = bpy.context.scene
    settings = scene.lumenray.light_mix
    day, evening = settings.scenes
    assert lighting_scenes.is_applied(scene, evening)
    assert bpy.ops.lumenray.apply_lighting_scene(index=0) == {"FINISHED"}
    assert [row.factor for row in settings.rows] == [1.0, 1.0]
    assert settings.rows["Desk"].is_on
    assert lighting_scenes.is_applied(scene, day)
    set_sliders(Ceiling=0.25)
    assert not lighting_scenes.is_applied(scene, day)
    assert bpy.ops.lumenray.store_lighting_scene() == {"FINISHED"}
    assert lighting_scenes.choose(day).levels.level("Ceiling").flux == 0.25
    assert bpy.ops.lumenray.remove_lighting_scene(index=0) == {"FINISHED"}
    assert [row.name for row in settings.scenes] == ["Evening"]
    assert bpy.ops.lumenray.add_lighting_scene(name="Evening") == {"FINISHED"}
    assert [row.name for row in settings.scenes] == ["Evening", "Evening 2"]


def test_scenes_are_kept_in_the_file(room, tmp_path):
    before = lighting_scenes.choose_all(bpy.context.scene)
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "room.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "room.blend"))
    assert lighting_scenes.choose_all(bpy.context.scene) == before


def test_what_a_scene_says_nothing_of_is_said(room):
    from lumenray.blender_addon.rendering import light_mix

    chosen = lighting_scenes.choose_all(bpy.context.scene)[1]
    (remark,) = lighting_scenes.remarks_of(chosen, ("Ceiling", "Desk", "Spots"))
    assert "'Evening' says nothing of the light group 'Spots'" in remark
    light_mix.list_rows(bpy.context.scene, [*LUX, "Spots"])
    assert lighting_scenes.apply(bpy.context.scene, bpy.context.scene.lumenray.light_mix.scenes[1]) == ["Spots"]  # fmt: skip
    with pytest.raises(SceneError, match="no lighting scene 'Night'; there are 'Day', 'Evening'"):
        lighting_scenes.find(bpy.context.scene, "Night")


def test_a_requirement_may_hold_in_some_scenes_alone(room):
    day, evening = lighting_scenes.choose_all(bpy.context.scene)
    room.lumenray.sensor.lighting_scenes = "Day, Night"
    assert judged(room, day) is not None
    assert judged(room, evening) is None


def test_emergency_lighting_is_judged_by_what_was_not_reflected():
    """EN 1838 counts direct light alone; half of the made-up light is."""
    empty = new_room(requirement="emergency.open_area")
    job = measure()
    assert job.wants_direct
    set_sliders(Ceiling=0.003, Desk=0.0)
    lighting_scenes.add(bpy.context.scene, "Emergency")
    (chosen,) = lighting_scenes.choose_all(bpy.context.scene)
    assert readings_of(empty).mixed(chosen.levels)[0].mean() == pytest.approx(1.2, rel=0.01)
    made = judged(empty, chosen)
    assert made.verdicts[0].found.value == pytest.approx(0.6, rel=0.05)
    empty.lumenray.sensor.requirement = "office.writing"
    assert not measure().wants_direct
    empty.lumenray.sensor.requirement = "emergency.open_area"
    told = scene_verdicts.judge_all(bpy.context.scene, chosen).problems[empty.name]
    assert "counts light that was not reflected; measure again" in told


def test_glare_is_judged_where_all_light_is_as_it_was_rated(room):
    """Ratings do not add up, so that they are not those of another light mix."""
    from dataclasses import replace

    from lumenray.blender_addon.sensors.readings import write_readings

    eyes = bpy.data.objects.new("Eyes", None)
    bpy.context.scene.collection.objects.link(eyes)
    own = eyes.lumenray.sensor
    own.is_sensor, own.quantity, own.requirement = True, "GLARE", "office.writing"
    rated = replace(
        readings_of(room),
        quantity="GLARE",
        groups=("",),
        shape=(1, 1),
        **{name: getattr(readings_of(room), name)[:1] for name in ("positions", "normals", "plane", "cells")},
        values=np.array([[16.0]], np.float32),
        errors=np.array([[0.1]], np.float32),
    )  # fmt: skip
    own.kept = write_readings(rated)
    day, evening = lighting_scenes.choose_all(bpy.context.scene)
    made = scene_verdicts.judge_all(bpy.context.scene, day)
    assert [each.state for each in made.observers["Eyes"]] == [State.MET]
    made = scene_verdicts.judge_all(bpy.context.scene, evening)
    assert "Eyes" not in made.observers
    assert "do not add up" in made.problems["Eyes"]
