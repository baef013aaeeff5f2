"""Meshes that materials displace: vertices and normals by closed forms, and edits of what displaces them."""

import bpy
import numpy as np
import pytest
from kept_scenes import KeptScene
from material_trees import add_image, new_tree

from lumenray.blender_addon.sync.scene_sync import SceneSync
from lumenray.engine.scene.mesh import Geometry, Placement

pytestmark = pytest.mark.blender

COUNT = 8


def grid(material, name="Grid", is_smooth=True, side=2.0):
    """A square in the plane z = 0 of 8 by 8 faces with a UV map that goes along x and y."""
    step = np.linspace(-0.5 * side, 0.5 * side, COUNT + 1)
    corners = [(x, y, 0.0) for y in step for x in step]
    first = [row * (COUNT + 1) + column for row in range(COUNT) for column in range(COUNT)]
    faces = [(n, n + 1, n + COUNT + 2, n + COUNT + 1) for n in first]
    data = bpy.data.meshes.new(name)
    data.from_pydata(corners, [], faces)
    layer = data.uv_layers.new(name="UVMap")
    places = np.array([corners[n][:2] for face in faces for n in face]) / side + 0.5
    layer.data.foreach_set("uv", places.ravel())
    data.polygons.foreach_set("use_smooth", [is_smooth] * len(faces))
    data.materials.append(material)
    item = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(item)
    return item


def displaced(height, method="DISPLACEMENT", kind="Displacement", **more):
    """A material that displaces by the output of a node. ``height``: from a tree to that."""
    tree = new_tree()
    material = tree.surface(tree.add("BsdfDiffuse"))
    name = "Height" if kind == "Displacement" else "Vector"
    values = {"Midlevel": 0.0, "Scale": 1.0} | more
    attributes = {"space": values.pop("space", "OBJECT")}
    node = tree.add(kind, attributes=attributes, **{name: height(tree)}, **values)
    output = material.node_tree.get_output_node("CYCLES")
    material.node_tree.links.new(node.outputs[0], output.inputs["Displacement"])
    material.displacement_method = method
    return material, node


def along_u(tree):
    """U of the UV map."""
    split = tree.add("SeparateXYZ", Vector=tree.add("UVMap").outputs[0])
    return split.outputs["X"]


def read():
    """Geometries and placements of the scene as it is, and what is told."""
    made = SceneSync().walk(bpy.context.evaluated_depsgraph_get())
    items = made.delta.changed
    geometries = {item.id: item for item in items if isinstance(item, Geometry)}
    placements = {item.name: item for item in items if isinstance(item, Placement)}
    return geometries, placements, [row.text() for row, _ in made.report.rows]


def shape_of(name="Grid"):
    geometries, placements, _ = read()
    return geometries[placements[name].geometry]


def test_vertices_rise_by_height_less_midlevel_times_scale():
    material, _ = displaced(along_u, Midlevel=0.5, Scale=0.4)
    grid(material)
    made = shape_of()
    u = 0.5 * made.vertices[:, 0] + 0.5
    assert made.vertices[:, 2] == pytest.approx(0.4 * (u - 0.5), abs=1e-6)


def test_a_picture_displaces_by_its_values_between_the_pixels():
    pixels = np.array([[[0.2], [0.8], [0.4], [0.6]]]).repeat(3, 2)

    def height(tree):
        image = add_image("Heights", pixels)
        return tree.add("TexImage", attributes={"image": image, "extension": "EXTEND"}).outputs[
            "Color"
        ]

    material, _ = displaced(height)
    grid(material)
    made = shape_of()
    u = 0.5 * made.vertices[:, 0] + 0.5
    expected = np.interp(u, (np.arange(4) + 0.5) / 4, pixels[0, :, 0])
    assert made.vertices[:, 2] == pytest.approx(expected, abs=1e-5)


@pytest.mark.parametrize(("method", "slope"), [("DISPLACEMENT", 0.2), ("BOTH", 0.0)])
def test_normals_turn_with_the_faces_unless_a_bump_turns_them(method, slope):
    material, _ = displaced(along_u, method=method, Scale=0.4)
    grid(material)
    made = shape_of()
    normal = np.array([-slope, 0.0, 1.0]) / np.hypot(slope, 1.0)
    assert made.corner_normals.reshape(-1, 3) == pytest.approx(
        np.broadcast_to(normal, (6 * COUNT**2, 3)), abs=1e-5
    )


def test_flat_faces_stay_flat():
    material, _ = displaced(along_u)
    grid(material, is_smooth=False)
    made = shape_of()
    assert made.corner_normals is None
    assert np.ptp(made.vertices[:, 2]) == pytest.approx(1.0, abs=1e-6)


@pytest.mark.parametrize(("space", "rise"), [("OBJECT", 0.4), ("WORLD", 0.1)])
def test_heights_of_the_world_do_not_grow_with_the_object(space, rise):
    material, _ = displaced(along_u, Scale=0.4, space=space)
    item = grid(material)
    item.scale = (4.0, 4.0, 4.0)
    bpy.context.view_layer.update()
    assert np.ptp(shape_of().vertices[:, 2]) == pytest.approx(rise, abs=1e-6)


@pytest.mark.parametrize(("space", "axis"), [("OBJECT", 0), ("WORLD", 1)])
def test_vectors_move_vertices_in_their_space(space, axis):
    def vector(tree):
        return tree.add("CombineXYZ", X=along_u(tree)).outputs[0]

    material, _ = displaced(vector, kind="VectorDisplacement", space=space, Scale=0.1)
    item = grid(material)
    item.rotation_euler[2] = -0.5 * np.pi
    bpy.context.view_layer.update()
    plain = np.array([(v.co.x, v.co.y, v.co.z) for v in item.data.vertices])
    moved = shape_of().vertices - plain
    expected = np.zeros_like(moved)
    # x of the world is y of what is turned by -90 degrees.
    expected[:, axis] = 0.1 * (0.5 * plain[:, 0] + 0.5)
    assert moved == pytest.approx(expected, abs=1e-6)


def test_a_vector_of_tangents_is_told_and_left_out():
    material, _ = displaced(
        lambda tree: tree.add("UVMap").outputs[0], kind="VectorDisplacement", space="TANGENT"
    )
    grid(material)
    geometries, placements, rows = read()
    assert np.ptp(geometries[placements["Grid"].geometry].vertices[:, 2]) == 0.0
    assert any("tangent space" in row and "not displaced" in row for row in rows)


def test_what_is_not_known_at_vertices_is_told_and_left_out():
    material, _ = displaced(lambda tree: tree.add("ObjectInfo").outputs["Random"])
    grid(material)
    geometries, placements, rows = read()
    assert np.ptp(geometries[placements["Grid"].geometry].vertices[:, 2]) == 0.0
    assert any("not known at vertices" in row for row in rows)


def test_a_texture_of_the_object_displaces_by_the_places_of_vertices():
    def height(tree):
        place = tree.add("TexCoord").outputs["Object"]
        return tree.add("TexGradient", Vector=place).outputs["Fac"]

    material, _ = displaced(height)
    grid(material, side=1.0)
    made = shape_of()
    # A linear gradient is x, held within 0 and 1.
    assert made.vertices[:, 2] == pytest.approx(np.clip(made.vertices[:, 0], 0.0, 1.0), abs=1e-5)


def test_only_triangles_of_the_material_are_displaced():
    material, _ = displaced(lambda tree: tree.add("Value").outputs[0], Scale=1.0)
    material.node_tree.nodes["Value"].outputs[0].default_value = 0.3
    item = grid(bpy.data.materials.new("Plain"))
    item.data.materials.append(material)
    slots = np.zeros(COUNT**2, np.int32)
    slots[: COUNT**2 // 2] = 1
    item.data.polygons.foreach_set("material_index", slots)
    item.data.update()
    z = shape_of().vertices[:, 2].reshape(COUNT + 1, COUNT + 1)
    assert z[: COUNT // 2 + 1] == pytest.approx(0.3, abs=1e-6)
    assert z[COUNT // 2 + 1 :] == pytest.approx(0.0, abs=1e-6)


# ---- edits ----


class Stage(KeptScene):
    """Two squares that share a mesh which is displaced."""

    def __init__(self):
        super().__init__()
        self.material, self.node = displaced(along_u, Scale=0.4)
        self.first = grid(self.material, "First")
        self.second = bpy.data.objects.new("Second", self.first.data)
        bpy.context.scene.collection.objects.link(self.second)
        self.step()

    def rise(self, name="First"):
        mesh = next(
            self.scene.mesh(key) for key in self.scene.meshes if self.scene.mesh(key).name == name
        )
        return np.ptp(mesh.vertices[:, 2])


def test_objects_share_a_displaced_mesh():
    geometries, placements, _ = read() if Stage() else None
    assert len(geometries) == 1
    assert placements["First"].geometry == placements["Second"].geometry


def test_an_edit_of_the_material_displaces_anew():
    stage = Stage()
    assert stage.rise() == pytest.approx(0.4, abs=1e-6)
    stage.node.inputs["Scale"].default_value = 0.7
    assert "Geometry" in stage.sent()[0]
    assert stage.rise("Second") == pytest.approx(0.7, abs=1e-6)


def test_methods_change_the_mesh():
    stage = Stage()
    stage.material.displacement_method = "BUMP"
    stage.changes()
    assert stage.rise() == 0.0
    stage.material.displacement_method = "BOTH"
    stage.changes()
    assert stage.rise() == pytest.approx(0.4, abs=1e-6)


def test_another_colour_sends_no_mesh():
    stage = Stage()
    shader = next(
        n for n in stage.material.node_tree.nodes if n.bl_idname == "ShaderNodeBsdfDiffuse"
    )
    shader.inputs["Color"].default_value = (0.1, 0.2, 0.3, 1.0)
    assert stage.sent() == (["Material"], 0)


def test_moving_sends_no_mesh_unless_heights_are_of_the_world():
    stage = Stage()
    stage.first.scale.z = 2.0
    assert stage.sent() == (["Placement"], 0)
    stage.node.space = "WORLD"
    stage.changes()
    stage.first.scale.z = 4.0
    kinds, _ = stage.sent()
    assert "Geometry" in kinds
    assert stage.rise() == pytest.approx(0.4, abs=1e-6)
    assert stage.rise("Second") == pytest.approx(0.4, abs=1e-6)


def test_an_edit_of_the_mesh_is_displaced_too():
    stage = Stage()
    for vertex in stage.first.data.vertices:
        vertex.co.z += 1.0
    stage.first.data.update()
    stage.changes()
    assert stage.rise() == pytest.approx(0.4, abs=1e-6)
