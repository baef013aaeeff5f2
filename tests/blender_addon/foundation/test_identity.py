"""Identities of data-blocks outlive renaming, undo, saving, copying and libraries."""

import bpy
import pytest

from lumenray.blender_addon.foundation import identity
from lumenray.blender_addon.sync.scene_sync import SceneSync


def link(block):
    bpy.context.scene.collection.objects.link(block)
    bpy.context.view_layer.update()
    return block


def triangle(name="Triangle"):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (0, 1, 0)], [], [(0, 1, 2)])
    return link(bpy.data.objects.new(name, mesh))


def lamp(name="Lamp"):
    return link(bpy.data.objects.new(name, bpy.data.lights.new(name, "POINT")))


def paint(name="Paint"):
    made = bpy.data.materials.new(name)
    bpy.data.objects["Triangle"].data.materials.append(made)
    bpy.context.view_layer.update()
    return made


def push():
    bpy.context.view_layer.update()
    bpy.ops.ed.undo_push(message="step")


def placements():
    step = SceneSync().walk(bpy.context.evaluated_depsgraph_get())
    return [item for item in step.delta.changed if item.id.startswith("object:")]


def test_identities_are_written_as_data_blocks_come():
    source, light = triangle(), lamp()
    material = paint()
    world = bpy.context.scene.world = bpy.data.worlds.new("Sky")
    camera = link(bpy.data.objects.new("Eye", bpy.data.cameras.new("Eye")))
    bpy.context.view_layer.update()
    identity.ensure_ids()
    blocks = [source, light, light.data, material, world, camera, camera.data]
    uids = [block.lumenray.uid for block in blocks]
    assert all(len(uid) == 32 for uid in uids)
    assert len(set(uids)) == len(uids)
    assert [identity.identity_of(block) for block in blocks] == uids


def test_evaluated_copies_have_the_same_identity():
    source = triangle()
    evaluated = source.evaluated_get(bpy.context.evaluated_depsgraph_get())
    assert identity.identity_of(evaluated) == source.lumenray.uid


def test_identities_survive_renaming():
    source = triangle()
    before = source.lumenray.uid
    source.name = source.data.name = "Another"
    bpy.context.view_layer.update()
    identity.ensure_ids()
    assert source.lumenray.uid == before


def test_identities_survive_undo_and_redo():
    push()
    triangle()
    push()
    uid = bpy.data.objects["Triangle"].lumenray.uid
    bpy.data.objects["Triangle"].location.x = 1
    push()
    bpy.ops.ed.undo()
    assert bpy.data.objects["Triangle"].location.x == 0
    assert bpy.data.objects["Triangle"].lumenray.uid == uid
    bpy.ops.ed.undo()
    assert "Triangle" not in bpy.data.objects
    bpy.ops.ed.redo()
    assert bpy.data.objects["Triangle"].lumenray.uid == uid


def test_an_undo_step_from_before_the_assignment_loses_nothing():
    mesh = bpy.data.meshes.new("Early")
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Early", mesh))
    bpy.ops.ed.undo_push(message="without identity")
    bpy.context.view_layer.update()
    identity.ensure_ids()
    uid = bpy.data.objects["Early"].lumenray.uid
    bpy.data.objects["Early"].location.x = 1
    push()
    bpy.ops.ed.undo()
    assert bpy.data.objects["Early"].lumenray.uid == uid


def test_identities_survive_saving_and_reopening(tmp_path):
    triangle(), lamp()
    uids = {block.name: block.lumenray.uid for block in bpy.data.objects}
    path = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.open_mainfile(filepath=path)
    identity.ensure_ids()
    assert {block.name: block.lumenray.uid for block in bpy.data.objects} == uids


def test_saving_writes_identities_that_no_update_has_brought(tmp_path):
    bpy.data.materials.new("Unused").use_fake_user = True
    path = str(tmp_path / "scene.blend")
    bpy.ops.wm.save_as_mainfile(filepath=path)
    assert bpy.data.materials["Unused"].lumenray.uid


def test_a_copy_gets_its_own_identity_and_keeps_its_optical_data():
    light = lamp()
    light.data.lumenray.use_physical = True
    light.data.lumenray.value = 123.0
    count = len(identity.copies_since(0))
    copy = light.copy()
    copy.data = light.data.copy()
    link(copy)
    assert copy.lumenray.uid != light.lumenray.uid
    assert copy.data.lumenray.uid != light.data.lumenray.uid
    assert copy.data.lumenray.value == 123.0
    assert identity.copies_since(count) == [
        (f"light:{copy.lumenray.uid}", f"light:{light.lumenray.uid}")
    ]


def test_copies_of_materials_are_told_to_the_engine():
    source, material = triangle(), None
    material = paint()
    sync = SceneSync()
    sync.walk(bpy.context.evaluated_depsgraph_get())
    copy = material.copy()
    source.data.materials[0] = copy
    bpy.context.view_layer.update()
    step = sync.walk(bpy.context.evaluated_depsgraph_get())
    pair = (identity.engine_id(copy), identity.engine_id(material))
    assert pair in step.delta.copies
    source.location.x = 1
    bpy.context.view_layer.update()
    assert not sync.walk(bpy.context.evaluated_depsgraph_get()).delta.copies


def test_the_original_keeps_its_identity_whichever_is_seen_first():
    source = triangle("Z")
    uid = source.lumenray.uid
    copy = source.copy()
    copy.name = "A"
    bpy.context.scene.collection.objects.link(copy)
    identity.ensure_ids()
    assert source.lumenray.uid == uid
    assert copy.lumenray.uid != uid


def test_what_takes_the_place_of_a_deleted_object_keeps_the_identity(tmp_path):
    path = str(tmp_path / "copy.blend")
    source = triangle()
    uid = source.lumenray.uid
    bpy.ops.wm.save_as_mainfile(filepath=path, copy=True)
    bpy.data.objects.remove(source)
    with bpy.data.libraries.load(path, link=False) as (_, wanted):
        wanted.objects = ["Triangle"]
    assert link(wanted.objects[0]).lumenray.uid == uid


def library(tmp_path):
    """Save a triangle in a file of its own and start an empty one."""
    path = str(tmp_path / "library.blend")
    uid = triangle().lumenray.uid
    bpy.ops.wm.save_as_mainfile(filepath=path)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    return path, uid


def test_appended_objects_keep_their_identity_unless_it_is_taken(tmp_path):
    path, uid = library(tmp_path)
    found = []
    for _ in range(2):
        with bpy.data.libraries.load(path, link=False) as (_, wanted):
            wanted.objects = ["Triangle"]
        found.append(link(wanted.objects[0]).lumenray.uid)
    assert found[0] == uid
    assert found[1] != uid


def test_linked_objects_and_overrides_have_identities_from_their_names(tmp_path):
    path, uid = library(tmp_path)
    found = []
    for _ in range(2):
        with bpy.data.libraries.load(path, link=True) as (_, wanted):
            wanted.objects = ["Triangle"]
        linked = link(wanted.objects[0])
        override = linked.override_create()
        link(override)
        identity.ensure_ids()
        found.append((identity.identity_of(linked), identity.identity_of(override)))
        assert linked.lumenray.uid == uid
        bpy.ops.wm.read_factory_settings(use_empty=True)
    assert found[0] == found[1]
    assert len({*found[0], uid}) == 3


def test_collection_instances_are_told_apart():
    group = bpy.data.collections.new("Group")
    for name in ("A", "B"):
        source = triangle(name)
        group.objects.link(source)
        bpy.context.scene.collection.objects.unlink(source)
    for i in range(2):
        empty = bpy.data.objects.new(f"Empty {i}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", group
        link(empty)
    made = placements()
    assert len({item.id for item in made}) == 4
    assert len({item.geometry for item in made}) == 2
    uids = {bpy.data.objects[f"Empty {i}"].lumenray.uid for i in range(2)}
    assert {item.id.removeprefix("object:").split("/")[0] for item in made} == uids


def test_instances_on_faces_are_told_apart_and_follow_their_parent():
    parent, child = triangle("Parent"), triangle("Child")
    mesh = bpy.data.meshes.new("Two")
    corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]
    mesh.from_pydata(corners, [], [(0, 1, 2), (1, 3, 2)])
    parent.data = mesh
    child.parent, parent.instance_type = parent, "FACES"
    bpy.context.view_layer.update()
    found = [item for item in placements() if "/" in item.id]
    assert len({item.id for item in found}) == 2
    assert {item.geometry for item in found} == {f"geometry:data/{child.data.session_uid}"}


def scatter(source, other):
    """Geometry nodes with a cube and another object on each vertex, beside the mesh itself."""
    group = bpy.data.node_groups.new("Scatter", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    nodes, links = group.nodes, group.links
    begin, end = nodes.new("NodeGroupInput"), nodes.new("NodeGroupOutput")
    join, cube = nodes.new("GeometryNodeJoinGeometry"), nodes.new("GeometryNodeMeshCube")
    info = nodes.new("GeometryNodeObjectInfo")
    info.inputs["Object"].default_value = other
    info.inputs["As Instance"].default_value = True
    for socket in (cube.outputs[0], info.outputs["Geometry"]):
        points = nodes.new("GeometryNodeInstanceOnPoints")
        links.new(begin.outputs[0], points.inputs["Points"])
        links.new(socket, points.inputs["Instance"])
        links.new(points.outputs[0], join.inputs[0])
    links.new(begin.outputs[0], join.inputs[0])
    links.new(join.outputs[0], end.inputs[0])
    source.modifiers.new("Scatter", "NODES").node_group = group
    bpy.context.view_layer.update()


def test_instances_of_geometry_nodes_are_told_from_their_parent():
    source, other = triangle("Source"), triangle("Other")
    scatter(source, other)
    made = {item.id: item for item in placements()}
    own, uid = made[f"object:{source.lumenray.uid}"], source.lumenray.uid
    instances = [item for key, item in made.items() if key.startswith(f"object:{uid}/")]
    of_other = [item for item in instances if item.id.endswith(other.lumenray.uid)]
    raw = [item for item in instances if item.id.endswith(uid)]
    assert len(made) == 2 + 3 + 3
    assert len(of_other) == len(raw) == 3
    assert {item.geometry for item in of_other} == {f"geometry:data/{other.data.session_uid}"}
    assert len({item.geometry for item in raw}) == 1
    assert raw[0].geometry != own.geometry


@pytest.mark.parametrize("kind", ["FONT", "CURVE"])
def test_text_and_curves_come_once_under_their_own_identity(kind):
    data = bpy.data.curves.new("Data", kind)
    if kind == "FONT":
        data.body = "a"
    else:
        data.bevel_depth = 0.1
        spline = data.splines.new("POLY")
        spline.points.add(1)
        spline.points[1].co = (1, 0, 0, 1)
    source = link(bpy.data.objects.new("Item", data))
    (item,) = placements()
    assert item.id == f"object:{source.lumenray.uid}"


def test_a_disabled_extension_listens_no_longer():
    identity.detach()
    try:
        source = triangle()
        assert not source.lumenray.uid
    finally:
        identity.attach()
    identity.ensure_ids()
    assert source.lumenray.uid
