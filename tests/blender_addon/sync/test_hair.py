"""Hair, curves and points of Blender: what stands where, of what material, in renders, instances and edits."""

import bpy
import numpy as np
import pytest
from blender_objects import add_quad, new_paint
from conversion import converted_scene
from rendered_frames import note_frames

from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.scene.mesh import Geometry, Placement

pytestmark = pytest.mark.blender


def items(made, kind):
    return [item for item in made.delta.changed if isinstance(item, kind)]


def errors(made):
    rows = [row for row, _ in made.report.rows if row.severity.value != "info"]
    return [row for row in rows if row.message != "the scene has no light"]


def add_curves(name="Hair", radius=0.02, materials=2):
    """Two strands of unit length, of two materials."""
    data = bpy.data.hair_curves.new(name)
    data.add_curves([3, 3])
    points = [(x, 0.0, z) for x in (0.0, 1.0) for z in (0.0, 0.5, 1.0)]
    data.attributes["position"].data.foreach_set("vector", np.array(points, np.float32).ravel())
    if radius:
        data.attributes.new("radius", "FLOAT", "POINT").data.foreach_set("value", [radius] * 6)
    data.attributes.new("material_index", "INT", "CURVE").data.foreach_set("value", [0, 1])
    for _ in range(materials):
        data.materials.append(new_paint())
    item = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(item)
    return item


def add_fur(count=6, **settings):
    """A square with strands of particles, of unit length upwards."""
    item = add_quad("Field", material=new_paint())
    item.data.materials.append(new_paint())
    item.modifiers.new("Fur", "PARTICLE_SYSTEM")
    made = item.particle_systems[0].settings
    made.type, made.count, made.hair_length, made.material = "HAIR", count, 1.0, 2
    for key, value in settings.items():
        setattr(made, key, value)
    return item


def lateral(geometry):
    """Surface of triangles. [square of Blender's unit]"""
    a, b, c = geometry.vertices[geometry.triangles].astype(float).transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)


@pytest.mark.parametrize(("radius", "expected"), [(0.02, 0.02), (0.0, 0.005)])
def test_curves_are_tubes_of_their_radii_and_materials(radius, expected):
    add_curves(radius=radius)
    made = converted_scene()
    (geometry,), (placement,) = items(made, Geometry), items(made, Placement)
    assert errors(made) == []
    areas = lateral(geometry)
    for slot in (0, 1):
        own = areas[geometry.material_index == slot].sum()
        assert own == pytest.approx(2.0 * np.pi * expected, rel=1e-4)
    assert len(placement.materials) == 2
    assert made.objects == {}


def test_hair_of_particles_stands_beside_its_mesh():
    add_fur()
    made = converted_scene()
    assert errors(made) == []
    names = {placement.name: placement for placement in items(made, Placement)}
    assert set(names) == {"Field", "Field (hair)"}
    assert set(made.objects) == {"Field"}
    hair = next(g for g in items(made, Geometry) if g.id == names["Field (hair)"].geometry)
    assert np.unique(hair.material_index).tolist() == [1]
    assert hair.vertices[:, 2].max() == pytest.approx(1.0, abs=0.01)
    # Pointed strands: cones of half the root's diameter, times the scale of radii.
    settings = bpy.data.particles[0]
    radius = 0.5 * settings.root_radius * settings.radius_scale
    assert lateral(hair).sum() == pytest.approx(6 * np.pi * radius, rel=0.02)


def test_children_stand_for_their_parents():
    def surface():
        made = converted_scene()
        return max(lateral(g).sum() for g in items(made, Geometry) if len(g.triangles) > 2)

    item = add_fur(count=5, child_type="SIMPLE", child_percent=4, rendered_child_count=9)
    settings = item.particle_systems[0].settings
    of_children = surface()
    settings.child_type = "NONE"
    assert of_children == pytest.approx(4 * surface(), rel=0.1)


def test_renders_have_the_children_of_renders(tmp_path):
    add_fur(count=5, child_type="SIMPLE", child_percent=1, rendered_child_count=3)

    def note(depsgraph):
        delta = SceneSync(final=True).walk(depsgraph).delta
        return max(len(item.triangles) for item in delta.changed if isinstance(item, Geometry))

    (in_render,) = note_frames(note, (1, 1, 1), tmp_path)
    shown = max(len(each.triangles) for each in items(converted_scene(), Geometry))
    # Three for one, of twice as many steps.
    assert in_render >= 5 * shown


def test_hair_shows_without_its_mesh_and_not_where_strands_are_off():
    item = add_fur()
    item.show_instancer_for_render = item.show_instancer_for_viewport = False
    assert [p.name for p in items(converted_scene(), Placement)] == ["Field (hair)"]
    add_curves()
    bpy.context.view_layer.use_strand = False
    assert items(converted_scene(), Placement) == []


def test_hair_goes_with_its_mesh_and_with_instances_of_it():
    item = add_fur()
    sync = SceneSync(final=True)
    sync.walk(bpy.context.evaluated_depsgraph_get())
    item.location.x = 3.0
    bpy.context.view_layer.update()
    sync.tag_scene()
    delta = sync.walk(bpy.context.evaluated_depsgraph_get()).delta
    moved = {p.name: p.frame[0, 3] for p in delta.changed if isinstance(p, Placement)}
    assert moved == {"Field": 3.0, "Field (hair)": 3.0}
    group = bpy.data.collections.new("Group")
    group.objects.link(item)
    empty = bpy.data.objects.new("Empty", None)
    empty.instance_type, empty.instance_collection, empty.location = "COLLECTION", group, (0, 5, 0)
    bpy.context.scene.collection.objects.link(empty)
    made = converted_scene()
    places = [p.frame[:3, 3].tolist() for p in items(made, Placement) if "(hair)" in p.name]
    assert sorted(places) == [[3.0, 0.0, 0.0], [3.0, 5.0, 0.0]]
    assert len({p.geometry for p in items(made, Placement)}) == 2
    bpy.data.objects.remove(item)
    assert len(items(converted_scene(), Placement)) == 0


def test_what_is_edited_is_sent_anew():
    item = add_fur()
    sync = SceneSync(final=True)
    sync.walk(bpy.context.evaluated_depsgraph_get())
    item.particle_systems[0].settings.hair_length = 2.0
    depsgraph = bpy.context.evaluated_depsgraph_get()
    sync.tag(depsgraph.updates)
    bpy.context.view_layer.update()
    delta = sync.walk(bpy.context.evaluated_depsgraph_get()).delta
    heights = [g.vertices[:, 2].max() for g in delta.changed if isinstance(g, Geometry)]
    assert max(heights) == pytest.approx(2.0, abs=0.02)


def test_points_are_balls():
    mesh = bpy.data.meshes.new("Points")
    mesh.from_pydata([(0, 0, 0), (2, 0, 0)], [], [])
    item = bpy.data.objects.new("Points", mesh)
    bpy.context.scene.collection.objects.link(item)
    tree = bpy.data.node_groups.new("Points", "GeometryNodeTree")
    tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
    tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
    kinds = ("NodeGroupInput", "GeometryNodeMeshToPoints", "NodeGroupOutput")
    first, made, last = (tree.nodes.new(kind) for kind in kinds)
    made.inputs["Radius"].default_value = 0.25
    tree.links.new(first.outputs[0], made.inputs[0])
    tree.links.new(made.outputs[0], last.inputs[0])
    item.modifiers.new("Points", "NODES").node_group = tree
    scene = converted_scene()
    (geometry,) = items(scene, Geometry)
    assert errors(scene) == []
    assert lateral(geometry).sum() == pytest.approx(2 * 4 * np.pi * 0.25**2, rel=1e-4)


def test_thinned_strands_are_told(monkeypatch):
    monkeypatch.setattr("lumenray.blender_addon.sync.strands.SIDES", ((3, 20),))
    add_fur()
    (row,) = errors(converted_scene())
    assert row.datablock == "Field (hair)"
    assert "6 strands are too many" in row.message


def test_pictures_on_strands_are_told():
    item = add_curves()
    image = bpy.data.images.new("Picture", 2, 2)
    image.pixels.foreach_set(np.array([0, 0, 0, 1, 1, 1, 1, 1] * 2, np.float32))
    image.update()
    tree = item.data.materials[1].node_tree
    texture = tree.nodes.new("ShaderNodeTexImage")
    texture.image = image
    tree.links.new(texture.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])
    (row,) = [row for row in errors(converted_scene()) if "no UV maps" in row.message]
    assert row.datablock == "Hair"


def test_empty_curves_and_clouds_show_nothing():
    for data in (bpy.data.hair_curves.new("Bald"), bpy.data.pointclouds.new("None")):
        bpy.context.scene.collection.objects.link(bpy.data.objects.new(data.name, data))
    add_fur(count=0)
    made = converted_scene()
    assert [placement.name for placement in items(made, Placement)] == ["Field"]
    assert errors(made) == []
