"""Verdicts on sensors that stand in the scene: by area, with observers of glare, and in the panel."""

import json
from dataclasses import replace
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from blender_bakes import add_lamp

from lumenray.blender_addon.rendering import light_mix, lighting_scenes
from lumenray.blender_addon.sensors import asked, drawing, files, judging, results, verdicts, words
from lumenray.blender_addon.sensors import job as sensor_job
from lumenray.blender_addon.sensors.places import place_sensors, signature_of
from lumenray.blender_addon.sensors.readings import read_readings, readings_of, write_readings
from lumenray.blender_addon.sensors.settings import find_sensors
from lumenray.engine.errors import SceneError
from lumenray.engine.judgement.requirement import Requirement
from lumenray.engine.judgement.verdict import State
from lumenray.engine.light_mix import Level, LightMix
from lumenray.engine.scene.provenance import Provenance

pytestmark = pytest.mark.usefixtures("extension")

OFFICE = Requirement(
    "office.ours",
    "Our office",
    "ours",
    "",
    {"task": {"mean": 500.0, "uniformity": 0.6}, "walls": {"mean": 75.0}},
    {"ugr": 19.0, "ra": 80.0},
)


class Fake:
    """Session that measures 600 lx on what lies, 80 lx on what stands, exactly but for 1 %."""

    def apply(self, delta):
        pass

    def measure(self, positions, normals, rule, seed, transport, progress, **_):
        values = np.where(np.abs(normals[:, 2]) > 0.5, 600.0, 80.0)
        origin = Provenance("0", "mono", "", seed, 16, 2.0)
        return SimpleNamespace(
            illuminance=values,
            standard_error=0.01 * values,
            provenance=origin,
            method="fake",
            has_common_errors=False,
        )


def new_sensor(name, quantity="PLANAR", **settings):
    empty = bpy.data.objects.new(name, None)
    own = empty.lumenray.sensor
    own.is_sensor, own.quantity = True, quantity
    for key, value in settings.items():
        setattr(own, key, value)
    bpy.context.scene.collection.objects.link(empty)
    return empty


@pytest.fixture
def measured(monkeypatch):
    """A task area, a wall, and three observers, of whom one sees nothing that dazzles."""

    def rate(session, positions, directions, groups, mixes, **_):
        assert np.allclose(directions, [1.0, 0.0, 0.0])
        table = np.array([[18.0, 0.02], [np.nan, np.nan], [18.5, 0.02]])[: len(positions)]
        # A mix of half the light: any rating but that of all light.
        return [{"ugr": table - number} for number in range(len(mixes))], ("seen",)

    monkeypatch.setattr(sensor_job, "rate_mixes", rate)
    add_lamp("Lamp").data.shadow_soft_size = 0.1
    new_sensor("Task", layout="GRID")
    wall = new_sensor("Wall", layout="GRID", area="WALLS")
    wall.rotation_euler.x = 0.5 * np.pi
    new_sensor("Eyes", "GLARE", layout="LINE", length=3.0, use_spacing=True, spacing=1.0)
    bpy.context.view_layer.update()
    job, _ = asked.prepare(bpy.context.evaluated_depsgraph_get())
    job.run(Fake())
    results.store(job)
    return job


def named(**areas):
    return [
        (
            empty.name,
            readings_of(empty),
            judging.area_of(readings_of(empty), empty.lumenray.sensor.area),
        )
        for empty in find_sensors(bpy.context.scene)
    ]


def test_areas_and_observers_are_judged_together(measured):
    judged = judging.judge_sensors(named(), OFFICE)
    assert judged.state is State.MET
    assert judged.areas["Task"].area == "task"
    assert judged.areas["Wall"].state is State.MET
    assert [each.state for each in judged.observers["Eyes"]] == [State.MET] * 3
    assert judged.missing == ["Ra"]
    text = "\n".join(judging.tell(judged))
    assert "office.ours (ours: Our office): met (without Ra, not measured)" in text
    assert "Task, task: met" in text
    assert "observer 2: met, no glare source" in text
    # Six limits share what one had: wider ranges, so that 600 lx and 80 lx have farther ends.
    alone = judging.judge_sensors([row for row in named() if row[0] == "Wall"], OFFICE)
    (one,), (shared,) = alone.areas["Wall"].verdicts, judged.areas["Wall"].verdicts
    assert shared.found.low < one.found.low


def test_a_maintenance_factor_and_a_strict_limit_are_not_met(measured):
    judged = judging.judge_sensors(named(), OFFICE, maintenance=0.7)
    assert judged.areas["Task"].state is State.NOT_MET
    assert judged.state is State.NOT_MET
    strict = Requirement("a", "a", "a", "", {}, {"ugr": 16.0})
    judged = judging.judge_sensors(named(), strict)
    states = [each.state for each in judged.observers["Eyes"]]
    assert states == [State.NOT_MET, State.MET, State.NOT_MET]
    assert set(judged.skipped) == {"Task", "Wall"}


def test_ratings_are_of_all_light_and_told_as_such(measured):
    (eyes,) = [each for each in find_sensors(bpy.context.scene) if each.name == "Eyes"]
    readings = readings_of(eyes)
    assert readings.groups == ("",) and readings.unit == "UGR"
    dimmed = LightMix((Level("Ceiling", 0.1),))
    np.testing.assert_array_equal(readings.mixed(dimmed)[0], readings.mixed()[0])
    lines = dict(words.describe(eyes, dimmed))
    assert lines["UGR"] == "18.0 to 18.5"
    assert lines["no glare source"] == "1 of 3"
    assert "measure again for these levels" in lines["light mix"]
    judged = judging.judge_sensors([("Eyes", readings, None)], OFFICE, dimmed)
    assert "do not add up" in judged.skipped["Eyes"]
    again = read_readings(write_readings(readings))
    assert np.isnan(again.values[0, 1]) and not again.has_common


def test_ratings_of_lighting_scenes_are_kept_beside_that_of_all_light(measured):
    scene = bpy.context.scene
    scene.objects["Lamp"].data.lumenray.light_group = "Ceiling"
    scene.lumenray.light_mix.groups = "GROUPS"
    light_mix.list_rows(scene, ["Ceiling"])
    lighting_scenes.add(scene, "Day")
    scene.lumenray.light_mix.rows["Ceiling"].factor = 0.5
    lighting_scenes.add(scene, "Evening")
    job, _ = asked.prepare(bpy.context.evaluated_depsgraph_get())
    job.run(Fake())
    results.store(job)
    readings = readings_of(scene.objects["Eyes"])
    day, evening = (chosen.levels for chosen in lighting_scenes.choose_all(scene))
    assert readings.mixed(day)[0][0] == pytest.approx(18.0)
    assert readings.mixed(evening)[0][0] == pytest.approx(17.0)
    assert not readings.is_told(LightMix((Level("Ceiling", 0.4),)))
    again = read_readings(write_readings(readings))
    np.testing.assert_array_equal(again.mixed(evening)[0], readings.mixed(evening)[0])
    strict = Requirement("a", "a", "a", "", {}, {"ugr": 17.8})

    def judge(kept, levels):
        return judging.judge_sensors([("Eyes", kept, None)], strict, levels)

    assert judge(readings, day).observers["Eyes"][0].state is State.NOT_MET
    assert judge(readings, evening).observers["Eyes"][0].state is State.MET
    # To older versions lamps that are dimmed were sources no longer, so that less glare was found than there is.
    old = judge(replace(readings, keeps_sources=False), evening)
    assert old.observers["Eyes"][0].state is State.UNKNOWN
    assert "measure again" in old.skipped["Eyes"]
    off = LightMix((Level("Ceiling", is_on=False),))
    assert not off.is_dimmed and evening.is_dimmed


def test_verdicts_stand_in_the_documents(measured, tmp_path):
    judged = judging.judge_sensors(named(), OFFICE)
    rows = [(name, readings) for name, readings, _ in named()]
    path = files.write_document(
        tmp_path / "a.json", "a.blend", rows, LightMix(), requirement=judging.describe(judged)
    )
    # Strict readers know no NaN.
    content = json.loads(path.read_text(), parse_constant=pytest.fail)
    assert content["requirement"]["state"] == "met"
    assert content["requirement"]["not_measured"] == ["Ra"]
    (eyes,) = [each for each in content["sensors"] if each["name"] == "Eyes"]
    assert eyes["values"] == [18.0, None, 18.5] and eyes["unit"] == "UGR"
    lines = files.write_rows(tmp_path / "a.csv", rows, LightMix()).read_text().splitlines()
    assert "Eyes,glare" in lines[1] and ",18,0.02,UGR" in lines[1]
    assert ",,,UGR" in lines[2]


def test_the_panel_judges_by_the_scenes_requirement_what_is_current(measured):
    scene = bpy.context.scene
    settings = scene.lumenray.sensors
    settings.requirement, settings.maintenance = "office.writing", 0.9
    told = verdicts.texts_of(scene, find_sensors(scene))
    assert told[0].startswith("office.writing")
    assert any(line.startswith("Eyes, UGR at most 19: met") for line in told)
    bpy.data.objects["Lamp"].location.x += 1.0
    bpy.context.view_layer.update()
    told = verdicts.texts_of(scene, find_sensors(scene))
    assert told == ("Out of date, not judged: Eyes, Task, Wall", "Measure to have verdicts")


def test_rooms_know_the_areas_of_their_sensors():
    from lumenray.blender_addon.sensors import adding

    bpy.ops.mesh.primitive_cube_add(size=4.0)
    room = bpy.context.object
    for polygon in room.data.polygons:
        polygon.flip()
    task = new_sensor("Task", layout="GRID")
    room.select_set(True)
    bpy.context.view_layer.objects.active = task
    made = adding.add_room(bpy.context)
    areas = [empty.lumenray.sensor.area for empty in made]
    assert areas.count("WALLS") == 4 and areas.count("CEILING") == 1
    assert {"SURROUNDINGS", "BACKGROUND", "NONE"} <= set(areas)


def test_a_camera_tells_the_luminances_of_its_picture_by_part():
    """A wall whose left half glows at 300 and right half at 100 cd/m2, before a camera that sees both alike."""
    from lumenray.engine.accuracy.stopping import StopRule
    from lumenray.engine.camera_luminance import measure_regions

    bpy.ops.object.camera_add(location=(0.0, 0.0, 1.0), rotation=(0.5 * np.pi, 0.0, 0.0))
    camera = bpy.context.scene.camera = bpy.context.object
    camera.data.sensor_fit = "HORIZONTAL"
    empty = new_sensor("Parts", "LUMINANCE", layout="CAMERA", columns=4, rows=2)
    bpy.context.view_layer.update()
    placed = place_sensors(empty, bpy.context.evaluated_depsgraph_get())
    assert placed.shape == (2, 4) and placed.kind == ("camera", placed.uid)
    # Row by row from the lower left: the first looks down and to the left, the last up and to the right.
    assert placed.normals[0, 0] < 0.0 and placed.normals[0, 2] < 0.0
    assert placed.normals[-1, 0] > 0.0 and placed.normals[-1, 2] > 0.0
    np.testing.assert_allclose(placed.frame[:3, 3], [0.0, 0.5, 1.0], atol=1e-6)

    class Wall:
        def render(self, seen, settings):
            assert (seen.width, seen.height) == (48, 24)
            luminance = np.where(np.arange(48) < 24, 300.0, 100.0) + np.zeros((24, 1))
            noise = np.random.default_rng(settings.seed).normal(0.0, 5.0, luminance.shape)
            picture = np.repeat((luminance + noise)[..., None], 3, axis=2)
            origin = Provenance("0", "mono", "", 0, 1, 0.1, notes=("note",))
            return SimpleNamespace(
                tristimulus=picture,
                luminance_error=np.full(luminance.shape, 5.0),
                provenance=origin,
            )

    found = measure_regions(Wall(), placed.camera, placed.shape, StopRule(each=0.01, floor=1.0))
    expected = np.array([300.0, 300.0, 100.0, 100.0] * 2)
    assert found.simplified == 0.0
    assert (found.standard_error <= 0.01 * expected * 1.01).all()
    assert (np.abs(found.luminance - expected) < 5.0 * found.standard_error).all()
    assert found.notes == ("note",)
    before = signature_of(empty)
    camera.data.lens = 20.0
    assert signature_of(empty) != before
    empty.lumenray.sensor.quantity = "PLANAR"
    with pytest.raises(SceneError, match="set the quantity to Luminance"):
        place_sensors(empty, bpy.context.evaluated_depsgraph_get())


def test_logarithmic_colours_spread_over_three_powers_of_ten(measured):
    settings = bpy.context.scene.lumenray.sensors
    settings.automatic, settings.high = False, 1000.0
    plain = drawing.make_drawing(bpy.context.scene).scale
    settings.logarithmic = True
    scale = drawing.make_drawing(bpy.context.scene).scale
    assert plain.share(100.0) == pytest.approx(0.1)
    assert scale.share(100.0) == pytest.approx(2.0 / 3.0)
    for each in (plain, scale):
        np.testing.assert_allclose(each.share(each.value([0.1, 0.5, 1.0])), [0.1, 0.5, 1.0])


def test_a_bake_rates_the_observers_that_stand_in_its_file(monkeypatch, tmp_path, capsys):
    from lumenray.command_line import bake_observers

    monkeypatch.setattr(
        sensor_job,
        "rate_mixes",
        lambda session, positions, *_, **__: (
            [{"ugr": np.array([[22.0, 0.02]] * len(positions))}],
            (),
        ),
    )
    options = SimpleNamespace(
        accept_missing=False,
        seed=3,
        transport=None,
        output=tmp_path,
        file=tmp_path / "a.blend",
        cluster=None,
        tls_ca=None,
        tls_cert=None,
        tls_key=None,
    )
    add_lamp("Lamp").data.shadow_soft_size = 0.1
    depsgraph = bpy.context.evaluated_depsgraph_get()
    bake_observers.judge_observers(options, depsgraph, OFFICE)
    assert not list(tmp_path.iterdir())
    new_sensor("Eye", "GLARE")
    new_sensor("Desk", layout="GRID")
    bpy.context.view_layer.update()
    bake_observers.judge_observers(options, bpy.context.evaluated_depsgraph_get(), OFFICE)
    assert "Eye, UGR at most 19: not met" in capsys.readouterr().out
    content = json.loads((tmp_path / bake_observers.FILE).read_text())
    assert [each["name"] for each in content["sensors"]] == ["Eye"]
    assert content["requirement"]["observers"][0]["limits"][0]["value"] == 22.0
    assert content["seed"] == 3


def test_lights_that_cannot_be_seen_leave_glare_open(measured):
    """A lamp without a size dazzles, but not in pictures: what they rate can be not met, never met."""
    eyes = bpy.data.objects["Eyes"]
    assert readings_of(eyes).lacks == ""
    bpy.data.objects["Lamp"].data.shadow_soft_size = 0.0
    bpy.context.view_layer.update()
    job, _ = asked.prepare(bpy.context.evaluated_depsgraph_get())
    job.run(Fake())
    results.store(job)
    assert "without a size are not seen" in readings_of(eyes).lacks
    assert any("without a size" in note for note in job.notes)
    judged = judging.judge_sensors(named(), OFFICE)
    assert {each.state for each in judged.observers["Eyes"]} == {State.UNKNOWN}
    assert "UGR" in judged.missing
    assert any(line.startswith("Eyes: lights without a size") for line in judging.tell(judged))
    strict = Requirement("a", "a", "a", "", {}, {"ugr": 16.0})
    states = [each.state for each in judging.judge_sensors(named(), strict).observers["Eyes"]]
    assert states == [State.NOT_MET, State.UNKNOWN, State.NOT_MET]


OWN = """standard = "House rules"
[studio.bench]
title = "Bench"
task = { mean = 700 }
"""


def test_a_scenes_own_file_of_requirements_judges_its_sensors(measured, tmp_path):
    from lumenray.blender_addon.reporting import gathering
    from lumenray.blender_addon.sensors import requirements, scene_verdicts

    scene, path = bpy.context.scene, tmp_path / "own.toml"
    settings = scene.lumenray.sensors
    settings.requirement, settings.requirements_file = "studio.bench", str(path)

    def told():
        return verdicts.texts_of(scene, find_sensors(scene))

    assert "own.toml" in told()[0] and told()[0].startswith("No verdict")
    assert "studio.bench" not in requirements.known_keys(scene)
    path.write_text(OWN)
    assert told()[0].startswith("studio.bench (House rules: Bench): not met")
    (chosen,) = lighting_scenes.choose_all(scene)
    assert scene_verdicts.judge_all(scene, chosen).areas["Task"].state is State.NOT_MET
    report = gathering.gather(bpy.context.evaluated_depsgraph_get())
    (task,) = [area for area in report.scenes[0].areas if area.name == "Task"]
    assert task.assessment.requirement.title == "Bench"
    # What is written anew counts at once, and what a command adds before both.
    path.write_text(OWN.replace("700", "70"))
    assert told()[0].startswith("studio.bench (House rules: Bench): met")
    more = tmp_path / "more.toml"
    more.write_text(OWN.replace("700", "7000"))
    report = gathering.gather(bpy.context.evaluated_depsgraph_get(), files=(more,))
    (task,) = [area for area in report.scenes[0].areas if area.name == "Task"]
    assert task.state is State.NOT_MET
