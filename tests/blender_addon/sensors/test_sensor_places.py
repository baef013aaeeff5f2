"""Where the sensors of an empty stand, by its settings and its place."""

import bpy
import numpy as np
import pytest
from blender_objects import add_cube, add_quad
from mathutils import Matrix

from lumenray.blender_addon.foundation.identity import identity_of
from lumenray.blender_addon.sensors import adding
from lumenray.blender_addon.sensors.places import place_sensors, signature_of
from lumenray.blender_addon.sensors.settings import find_sensors
from lumenray.engine.errors import SceneError

pytestmark = pytest.mark.usefixtures("extension")


def new_sensor(layout="POINT", quantity="PLANAR", matrix=None, **settings):
    empty = bpy.data.objects.new("Sensors", None)
    empty.matrix_world = Matrix() if matrix is None else matrix
    own = empty.lumenray.sensor
    own.is_sensor, own.layout, own.quantity = True, layout, quantity
    for name, value in settings.items():
        setattr(own, name, value)
    bpy.context.scene.collection.objects.link(empty)
    bpy.context.view_layer.update()
    return empty


def placed(empty):
    bpy.context.view_layer.update()
    return place_sensors(empty, bpy.context.evaluated_depsgraph_get())


def new_floor(width=4.0, depth=3.0):
    floor = add_quad("Floor")
    floor.scale = (width, depth, 1.0)
    bpy.context.view_layer.update()
    return floor


def test_a_grid_over_a_floor_leaves_the_border_out_and_stands_at_its_height():
    found = placed(new_sensor("FLOOR", surface=new_floor(), height=0.75))
    # 3 m by 2 m: p(3 m) = 0.43 m, 7 points along 3 m, and 5 along 2 m.
    assert found.shape == (5, 7)
    np.testing.assert_allclose(found.positions[:, 2], 0.75)
    np.testing.assert_allclose(
        found.positions.min(axis=0)[:2], [0.5 + 1.5 / 7, 0.5 + 0.2], atol=1e-6
    )
    np.testing.assert_allclose(
        found.positions.max(axis=0)[:2], [3.5 - 1.5 / 7, 2.5 - 0.2], atol=1e-6
    )
    np.testing.assert_allclose(found.normals, [[0.0, 0.0, 1.0]] * 35)


def test_lengths_are_metres_whatever_the_units_of_the_scene():
    bpy.context.scene.unit_settings.scale_length = 0.01
    empty = new_sensor(
        "LINE", length=2.0, use_spacing=True, spacing=0.5, matrix=Matrix.Translation((100, 0, 0))
    )
    np.testing.assert_allclose(placed(empty).positions[:, 0], [0.25, 0.75, 1.25, 1.75], atol=1e-6)


def test_what_looks_level_looks_along_x():
    turn = Matrix.Rotation(np.radians(90.0), 4, "Z") @ Matrix.Rotation(np.radians(20.0), 4, "Y")
    for quantity in ("VERTICAL", "SEMICYLINDRICAL"):
        found = placed(new_sensor(quantity=quantity, matrix=turn))
        np.testing.assert_allclose(found.normals, [[0.0, 1.0, 0.0]], atol=1e-6)
    upright = Matrix.Rotation(np.radians(-90.0), 4, "Y")
    with pytest.raises(SceneError, match=r"sensors 'Sensors.*X axis"):
        placed(new_sensor(quantity="VERTICAL", matrix=upright))


def test_sensors_on_a_face_lie_on_it_and_go_with_its_mesh():
    wall = new_floor()
    wall.rotation_euler.x = np.radians(90.0)
    bpy.context.view_layer.update()
    bpy.context.view_layer.objects.active = wall
    empty = adding.add_sensors(bpy.context, "FACE")
    found = placed(empty)
    assert found.shape == (5, 7)
    np.testing.assert_allclose(found.normals, [[0.0, -1.0, 0.0]] * 35, atol=1e-6)
    np.testing.assert_allclose(found.positions[:, 1], 0.0, atol=1e-6)
    wall.location.y = 2.0
    np.testing.assert_allclose(placed(empty).positions[:, 1], 2.0, atol=1e-6)


def test_a_band_around_a_task_has_none_of_it_and_ends_with_the_floor():
    floor = new_floor(4.0, 4.0)
    empty = new_sensor(
        "BAND", length=2.0, width=1.0, band=1.0, surface=floor, border=0.0,
        matrix=Matrix.Translation((2.0, 0.5, 0.75)), use_spacing=True, spacing=0.25,
    )  # fmt: skip
    found = placed(empty)
    x, y = np.abs(found.positions[:, :2] - [2.0, 0.5]).T
    assert ((x > 1.0) | (y > 0.5)).all()
    assert found.positions[:, 1].min() > 0.0
    # 4 m by 3 m without the task's 2 m by 1 m and without the 1 m beyond the floor.
    assert len(found.positions) * 0.25**2 == pytest.approx(4.0 * 2.0 - 2.0, abs=0.01)


def test_a_room_gets_sensors_on_floor_walls_and_ceiling_and_about_its_task():
    room = add_cube((4.0, 4.0, 1.5), (4.0, 4.0, 1.5))
    room.data.flip_normals()
    task = new_sensor("GRID", length=1.0, width=1.0, matrix=Matrix.Translation((4.0, 4.0, 0.75)))
    bpy.context.view_layer.update()
    room.select_set(True)
    bpy.context.view_layer.objects.active = task
    assert bpy.ops.lumenray.add_room_sensors() == {"FINISHED"}
    names = sorted(empty.name for empty in find_sensors(bpy.context.scene) if empty != task)
    assert names == [
        "Background",
        "Ceiling",
        "Floor",
        "Surroundings",
        "Wall",
        "Wall.001",
        "Wall.002",
        "Wall.003",
    ]
    for empty in find_sensors(bpy.context.scene):
        found = placed(empty)
        # Everything lies in the room and looks into it.
        inwards = np.array([4.0, 4.0, 1.5]) - found.positions
        assert (found.positions >= -1e-6).all()
        assert (found.positions <= [8.0 + 1e-6, 8.0 + 1e-6, 3.0 + 1e-6]).all()
        if empty.name not in {"Background", "Surroundings", task.name}:
            assert ((inwards * found.normals).sum(axis=1) > 0.0).all()


def test_what_says_where_sensors_stand_is_in_their_signature():
    floor = new_floor()
    empty = new_sensor("FLOOR", surface=floor)
    seen = {signature_of(empty)}
    for name, value in (
        ("height", 1.2), ("border", 0.2), ("use_spacing", True), ("spacing", 0.3), ("quantity", "CYLINDRICAL"),
        ("layout", "LINE"), ("length", 3.0), ("width", 3.0), ("band", 2.0),
    ):  # fmt: skip
        setattr(empty.lumenray.sensor, name, value)
        seen.add(signature_of(empty))
    empty.location.x = 1.0
    bpy.context.view_layer.update()
    seen.add(signature_of(empty))
    assert len(seen) == 11


def test_sensors_have_stable_ids_and_copies_their_own():
    empty = new_sensor()
    uid = identity_of(empty)
    empty.name = "Else"
    assert identity_of(empty) == uid
    copy = empty.copy()
    bpy.context.scene.collection.objects.link(copy)
    assert identity_of(copy) != uid


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"layout": "FLOOR"}, "no surface is chosen"),
        ({"layout": "FACE"}, "no surface is chosen"),
        ({"layout": "GRID", "use_spacing": True, "spacing": 0.001}, "at most 200000"),
    ],
)
def test_sensors_that_stand_nowhere_are_told(settings, words):
    with pytest.raises(SceneError, match=f"sensors 'Sensors': .*{words}"):
        placed(new_sensor(**settings))


def test_a_face_needs_to_be_there():
    empty = new_sensor("FACE", surface=new_floor(), matrix=Matrix.Translation((0.0, 0.0, 0.5)))
    with pytest.raises(SceneError, match="no face of 'Floor'"):
        placed(empty)
