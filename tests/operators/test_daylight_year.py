"""The operator that computes a year of daylight, in this process, on a floor in the open."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from blender_objects import add_quad, new_paint
from weather_files import sunny_year

from lumenray.blender_addon.daylight_year import asked, results
from lumenray.engine.daylight.blinds import FixedTimes, PlaneBound, SensorBound, SunBound
from lumenray.engine.errors import SceneError
from lumenray.engine.sky.clock_range import ClockRange

pytestmark = pytest.mark.usefixtures("extension")


@pytest.fixture
def floor(tmp_path):
    """A floor of 4 m, a weather file of the world's place, and a year to be asked for."""
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("World")
    item = add_quad("Floor", material=new_paint())
    item.scale = (4.0, 4.0, 1.0)
    bpy.context.view_layer.update()
    weather = tmp_path / "year.epw"
    weather.write_text(sunny_year(), encoding="latin-1")
    settings = scene.lumenray.year
    settings.weather_file, settings.floor = str(weather), item
    settings.spacing, settings.samples = 2.0, 600
    return item


def test_clocks_are_those_of_the_place_where_it_is_near_the_weather(floor):
    place = bpy.context.scene.world.lumenray.place
    place.latitude, place.longitude, place.zone = np.radians(49.0), np.radians(8.0), "Europe/Paris"
    job, _, notes = asked.prepare(bpy.context)
    assert job.question.zone == "Europe/Paris"
    assert not any("standard" in note or "daylight saving" in note for note in notes)
    place.latitude = np.radians(-30.0)
    job, _, notes = asked.prepare(bpy.context)
    assert job.question.zone is None
    assert any("daylight saving" in note for note in notes)


def test_every_collection_in_the_blinds_is_a_group(floor):
    blinds = bpy.data.collections.new("Blinds")
    bpy.context.scene.collection.children.link(blinds)
    for name in ("South", "West"):
        group = bpy.data.collections.new(name)
        blinds.children.link(group)
        plate = add_quad(f"Blind {name}", material=floor.data.materials[0])
        bpy.context.scene.collection.objects.unlink(plate)
        group.objects.link(plate)
    bpy.context.scene.lumenray.year.blinds = blinds
    bpy.context.view_layer.update()
    job, _, _ = asked.prepare(bpy.context)
    assert [len(keys) for keys in job.blinds] == [1, 1]
    assert job.states == 3


@pytest.fixture
def blinds(floor):
    """A plate high above the floor as the blinds of one group."""
    group = bpy.data.collections.new("Blinds")
    bpy.context.scene.collection.children.link(group)
    plate = add_quad("Plate", material=floor.data.materials[0])
    bpy.context.scene.collection.objects.unlink(plate)
    group.objects.link(plate)
    settings = bpy.context.scene.lumenray.year
    settings.blinds = group
    bpy.context.view_layer.update()
    return settings


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        ("STANDARD", ()),
        ("TIMES", (FixedTimes(ClockRange((4, 9), (9.0, 17.0))),)),
        ("SUN", (SunBound(200.0),)),
        ("HORIZONTAL", (PlaneBound(200.0),)),
        ("SENSORS", (SensorBound(3000.0),)),
    ],
)
def test_what_closes_blinds_is_asked_for(blinds, rule, expected):
    blinds.blinds_rule = rule
    assert asked.prepare(bpy.context)[0].question.blinds == expected


def test_a_facade_is_turned_with_the_building(blinds):
    blinds.blinds_rule = "FACADE"
    bpy.context.scene.world.lumenray.place.north = np.radians(90.0)
    (rule,) = asked.prepare(bpy.context)[0].question.blinds
    # +Y is east, so that south is +X.
    np.testing.assert_allclose(rule.facing, (1.0, 0.0, 0.0), atol=1e-6)


def test_states_come_from_a_file(blinds, tmp_path):
    blinds.blinds_rule = "TABLE"
    with pytest.raises(SceneError, match="no file with the states"):
        asked.prepare(bpy.context)
    path = tmp_path / "states.csv"
    path.write_text("1\n0\n")
    blinds.blinds_file = str(path)
    job, _, _ = asked.prepare(bpy.context)
    assert job.question.blinds[0].is_closed.tolist() == [True, False]
    with pytest.raises(SceneError, match="has 2 states"):
        job.run(None)


@pytest.mark.mitsuba
def test_a_year_becomes_images_and_a_text(floor):
    from lumenray.engine.session import Session

    job, report, notes = asked.prepare(bpy.context)
    assert not any(row.message == "the scene has no light" for row, _ in report.rows)
    job.run(Session())
    images = results.store(job, notes)
    assert [image.name for image in images] == list(results.IMAGES.values())
    assert all(image.packed_file for image in images)
    values = np.empty(len(images[0].pixels), dtype=np.float32)
    images[0].pixels.foreach_get(values)
    assert values.std() > 0.1
    figures = dict(results.read_figures(bpy.data.texts[results.TEXT]))
    assert figures["sDA 300/50 %"].startswith("100 %")
    assert "paths each" in figures["sensors"]
    # Again: in the place of the first.
    assert [image.name for image in results.store(job, notes)] == [image.name for image in images]


@pytest.mark.mitsuba
def test_the_operator_computes_in_the_engines_process(floor):
    shown = bpy.data.collections.new("Shown")
    bpy.context.scene.collection.children.link(shown)
    shown.objects.link(floor)
    settings = bpy.context.scene.lumenray.year
    settings.maps, settings.map_density = shown, 1.0
    assert bpy.ops.lumenray.daylight_year() == {"FINISHED"}
    figures = dict(results.read_figures(bpy.data.texts[results.TEXT]))
    assert figures["sDA 300/50 %"].startswith("100 %")
    assert "16 lumels" in figures["Floor"]
    assert len(results.find_images()) > len(results.IMAGES)


@pytest.mark.mitsuba
def test_maps_lie_on_the_objects_of_a_collection(floor):
    """Half of a table under a plate: its map is dark there."""
    shown = bpy.data.collections.new("Shown")
    bpy.context.scene.collection.children.link(shown)
    table = add_quad("Table", material=floor.data.materials[0])
    table.scale, table.location = (4.0, 4.0, 1.0), (6.0, 0.0, 0.0)
    shown.objects.link(table)
    plate = add_quad("Plate", material=floor.data.materials[0])
    plate.scale, plate.location = (2.0, 40.0, 1.0), (6.0, -18.0, 0.1)
    settings = bpy.context.scene.lumenray.year
    settings.maps, settings.map_density = shown, 2.0
    bpy.context.view_layer.update()
    from lumenray.engine.session import Session

    job, _, notes = asked.prepare(bpy.context)
    assert job.names == {job.maps.objects[0]: "Table"}
    job.run(Session())
    results.store(job, notes)
    image = bpy.data.images["Daylight Map Daylight autonomy"]
    assert image.packed_file
    width, height = image.size
    values = np.empty(len(image.pixels), dtype=np.float32)
    image.pixels.foreach_get(values)
    values = values.reshape(height, width, 4)[..., 0]
    # By the UV map, the autonomy in the middles of the two halves.
    uv = np.empty(2 * len(table.data.loops), dtype=np.float32)
    table.data.uv_layers["Lumenray Year"].uv.foreach_get("vector", uv)
    corner = np.array([table.data.vertices[loop.vertex_index].co[:2] for loop in table.data.loops])
    affine = np.linalg.lstsq(
        np.column_stack([corner, np.ones(len(corner))]), uv.reshape(-1, 2), rcond=None
    )[0]
    for place, expected in (((0.25, 0.5), (0.0, 10.0)), ((0.75, 0.5), (80.0, 100.0))):
        u, v = np.array([*place, 1.0]) @ affine
        found = values[int(v * height), int(u * width)]
        assert expected[0] <= found <= expected[1], place
    figures = dict(results.read_figures(bpy.data.texts[results.TEXT]))
    assert "64 lumels" in figures["Table"]
    names = [image.name for image in results.find_images()]
    assert "Daylight Map Daylight autonomy, Colours 1" in names
    # It can be shown on the object in false colours, and taken away again.
    look = bpy.context.scene.lumenray.look
    nodes = [node.name for node in table.active_material.node_tree.nodes]
    look.low, look.high = 5.0, 700.0
    assert bpy.ops.lumenray.show_year_map(figure="mean_lx") == {"FINISHED"}
    assert (look.kind, look.unit, look.low) == ("FALSE", "lx", 0.0)
    assert bpy.ops.lumenray.show_year_map(figure="daylight_autonomy") == {"FINISHED"}
    assert (look.unit, look.high) == ("%", 100.0)
    used = {
        node.image
        for tree in bpy.data.node_groups
        for node in tree.nodes
        if node.bl_idname == "ShaderNodeTexImage"
    }
    assert used == {image}
    assert bpy.ops.lumenray.hide_baked() == {"FINISHED"}
    assert [node.name for node in table.active_material.node_tree.nodes] == nodes
    # Baked light has its own scale again.
    assert (look.figure, look.unit, look.low, look.high) == ("", "lx", 5.0, 700.0)
    assert bpy.ops.lumenray.show_year_map(figure="sda_coverage") == {"FINISHED"}
    # Again none is there twice, and a year without maps has none.
    results.store(job, notes)
    assert sorted(image.name for image in results.find_images()) == sorted(names)
    assert not look.is_shown
    job.answer = replace(job.answer, maps=None)
    results.store(job, notes)
    assert "Lumenray Year" not in table.data.uv_layers
    with pytest.raises(RuntimeError, match="a year with maps"):
        bpy.ops.lumenray.show_year_map(figure="mean_lx")
    assert len(results.find_images()) == len(results.IMAGES)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda settings: setattr(settings, "weather_file", ""), "no weather file"),
        (lambda settings: setattr(settings, "floor", None), "no floor"),
        (lambda settings: setattr(settings, "spacing", 50.0), "smaller"),
    ],
)
def test_what_is_missing_is_said(floor, change, words):
    change(bpy.context.scene.lumenray.year)
    with pytest.raises(SceneError, match=words):
        asked.prepare(bpy.context)
    with pytest.raises(RuntimeError, match=words):
        bpy.ops.lumenray.daylight_year()
