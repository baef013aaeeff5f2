"""Textures in coordinates of objects: what their pictures show beside Cycles, and what edits send."""

import bpy
import numpy as np
import pytest
from kept_scenes import KeptScene
from material_trees import new_tree, output_of
from seen_surfaces import see, see_by_cycles

from lumenray.blender_addon.sync.nodes.fields import LUMINANCE
from lumenray.blender_addon.sync.tables import materials
from lumenray.engine.scene.material import Raised
from lumenray.engine.scene.mesh import CHART_MAP
from lumenray.engine.scene.relief import Axes

pytestmark = pytest.mark.usefixtures("extension")

SMOOTH, SHARP = 0.01, 0.06
"""Share of pixels that may differ: at silhouettes, and at edges of a texture as well. [-]"""


def add_ball(material, **settings):
    """A smooth ball, stretched and turned, with a UV map that goes beyond its first tile and a loose triangle."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=16, ring_count=8)
    made = bpy.context.object
    made.data.polygons.foreach_set("use_smooth", [True] * len(made.data.polygons))
    made.data.materials.append(material)
    return _placed(made, **settings)


def add_box(material, **settings):
    """A box with faces of its own."""
    bpy.ops.mesh.primitive_cube_add(size=1.6)
    made = bpy.context.object
    made.data.materials.append(material)
    return _placed(made, **settings)


def _placed(made, location=(0.1, 0.2, -0.1), turn=(0.2, 0.1, 0.5), scale=(1.0, 0.8, 1.1)):
    made.location, made.rotation_euler, made.scale = location, turn, scale
    return made


def shown(tree, socket):
    """The tree's material, which glows in the colour of an output."""
    return tree.surface(tree.add("Emission", Color=socket))


def coordinates(tree, name, **attributes):
    return output_of(tree.add("TexCoord", attributes=attributes), name)


def geometry(tree, name):
    return output_of(tree.add("NewGeometry"), name)


def shifted(tree, socket):
    """Coordinates as a colour that is above 0."""
    node = tree.add("VectorMath", attributes={"operation": "MULTIPLY_ADD"})
    tree.material.node_tree.links.new(socket, node.inputs[0])
    node.inputs[1].default_value, node.inputs[2].default_value = (0.25,) * 3, (0.5,) * 3
    return node.outputs[0]


def texture(tree, kind, where, output=0, attributes=None, **inputs):
    node = tree.add(kind, attributes=attributes or {}, Vector=where, **inputs)
    return node.outputs[output]


def picture(tree, where, **attributes):
    image = bpy.data.images.new("Picture", 8, 8, float_buffer=True)
    u, v = np.meshgrid(np.arange(8), np.arange(8))
    values = np.ones((8, 8, 4), np.float32)
    values[..., 0], values[..., 1] = 0.5 + 0.4 * np.sin(0.8 * u), v / 8
    image.pixels.foreach_set(values.ravel())
    image.update()
    return texture(tree, "TexImage", where, attributes={"image": image, **attributes})


def other_object(tree):
    other = bpy.data.objects.new("Other", None)
    other.location, other.rotation_euler, other.scale = (0.4, -0.3, 0.2), (0.3, 0.6, 0.1), (2, 1, 1)
    bpy.context.scene.collection.objects.link(other)
    return shifted(tree, coordinates(tree, "Object", object=other))


def far_uv(tree):
    where = tree.add("Mapping", Vector=coordinates(tree, "UV"))
    where.inputs["Scale"].default_value = (1.0, 1.0, 1.0)
    return texture(tree, "TexNoise", where.outputs[0], Scale=3.0)


def transformed(tree, socket, kind, spaces):
    node = tree.add("VectorTransform", attributes={"vector_type": kind, "convert_from": spaces[0]})
    node.convert_to = spaces[1]
    tree.material.node_tree.links.new(socket, node.inputs[0])
    return shifted(tree, node.outputs[0])


CASES = {
    "point to world": (
        lambda t: transformed(t, coordinates(t, "Object"), "POINT", ("OBJECT", "WORLD")),
        SMOOTH,
    ),
    "vector to object": (
        lambda t: transformed(t, geometry(t, "Position"), "VECTOR", ("WORLD", "OBJECT")),
        SMOOTH,
    ),
    "normal to object": (
        lambda t: transformed(t, geometry(t, "Normal"), "NORMAL", ("WORLD", "OBJECT")),
        SMOOTH,
    ),
    "generated": (lambda t: coordinates(t, "Generated"), SMOOTH),
    "object": (lambda t: shifted(t, coordinates(t, "Object")), SMOOTH),
    "other object": (other_object, SMOOTH),
    "normal": (lambda t: shifted(t, coordinates(t, "Normal")), SMOOTH),
    "uv": (lambda t: coordinates(t, "UV"), 2 * SMOOTH),
    "position": (lambda t: shifted(t, geometry(t, "Position")), SMOOTH),
    "world normal": (lambda t: shifted(t, geometry(t, "Normal")), SMOOTH),
    "true normal": (lambda t: shifted(t, geometry(t, "True Normal")), SHARP),
    "pointiness": (lambda t: geometry(t, "Pointiness"), SMOOTH),
    "noise on uv": (far_uv, SHARP),
    "noise": (lambda t: texture(t, "TexNoise", coordinates(t, "Object"), Scale=2.0), SMOOTH),
    "noise by default": (lambda t: t.add("TexNoise", Scale=2.0).outputs[0], SMOOTH),
    "checker": (lambda t: texture(t, "TexChecker", coordinates(t, "Object"), Scale=2.3), SHARP),
    "brick": (lambda t: texture(t, "TexBrick", coordinates(t, "Generated"), Scale=2.0), SHARP),
    "gradient": (lambda t: texture(t, "TexGradient", coordinates(t, "Generated")), SMOOTH),
    "picture": (lambda t: picture(t, coordinates(t, "Generated")), SHARP),
    "clipped": (
        lambda t: picture(t, shifted(t, coordinates(t, "Object")), extension="CLIP"),
        SHARP,
    ),
    "box": (
        lambda t: picture(t, coordinates(t, "Object"), projection="BOX", projection_blend=0.3),
        SHARP,
    ),
    "hard box": (lambda t: picture(t, coordinates(t, "Object"), projection="BOX"), SHARP),
    "sphere": (lambda t: picture(t, coordinates(t, "Generated"), projection="SPHERE"), SHARP),
    "tube": (lambda t: picture(t, coordinates(t, "Generated"), projection="TUBE"), SHARP),
    "wire": (lambda t: t.add("Wireframe", Size=0.05).outputs[0], 2 * SHARP),
}


def mirrored(material):
    return add_ball(material, scale=(-1.0, 0.8, 1.1))


def lettered(material):
    data = bpy.data.curves.new("Sign", "FONT")
    data.body, data.size, data.extrude = "B", 2.0, 0.2
    data.materials.append(material)
    made = bpy.data.objects.new("Sign", data)
    bpy.context.scene.collection.objects.link(made)
    return _placed(made, location=(-0.8, -0.5, 0.0), turn=(0.9, 0.0, 0.6))


def subdivided(material):
    made = add_box(material)
    made.modifiers.new("Smooth", "SUBSURF").levels = 2
    made.modifiers["Smooth"].render_levels = 2
    return made


def two_materials(material):
    made = add_box(material)
    other = new_tree()
    made.data.materials.append(shown(other, coordinates(other, "Generated")))
    made.data.polygons.foreach_set("material_index", [0, 1, 0, 1, 0, 7])
    return made


def own_slot(material):
    made = add_ball(None)
    made.material_slots[0].link = "OBJECT"
    made.material_slots[0].material = material
    return made


@pytest.mark.parametrize(
    "shape", [mirrored, lettered, subdivided, two_materials, own_slot], ids=lambda f: f.__name__
)
def test_objects_of_all_kinds_show_what_cycles_shows(shape, tmp_path):
    tree = new_tree()
    where = coordinates(tree, "Generated")
    shape(shown(tree, texture(tree, "TexNoise", where, output=1, Scale=2.0)))
    compare(tmp_path, 2 * SMOOTH)


def test_pictures_on_two_maps_are_both_seen(tmp_path):
    tree = new_tree()
    first = picture(tree, coordinates(tree, "UV"))
    second = picture(tree, tree.add("UVMap", attributes={"uv_map": "Other"}).outputs[0])
    mixed = tree.add("MixRGB", Fac=0.4, Color1=first, Color2=second)
    item = add_box(shown(tree, mixed.outputs[0]))
    layer = item.data.uv_layers.new(name="Other")
    layer.data.foreach_set("uv", 1.7 * _uv_of(item.data).ravel())
    compare(tmp_path, SHARP)


def test_a_fine_picture_has_its_mean_on_coarse_texels(monkeypatch):
    monkeypatch.setattr(materials, "TEXELS", 1 << 12)
    tree = new_tree()
    image = bpy.data.images.new("Dots", 512, 512, float_buffer=True)
    values = np.random.default_rng(2).random((512, 512, 4)).astype(np.float32) ** 8
    image.pixels.foreach_set(values.ravel())
    image.update()
    where = coordinates(tree, "Object")
    add_box(shown(tree, texture(tree, "TexImage", where, attributes={"image": image})))
    seen, is_met = see()
    assert seen[is_met].mean() == pytest.approx(values[..., :3].mean(), rel=0.03)


def test_a_fine_picture_that_repeats_keeps_its_pixels_beside_a_texture_that_does_not(tmp_path):
    tree = new_tree()
    image = bpy.data.images.new("Dots", 256, 256, float_buffer=True)
    values = np.random.default_rng(2).random((256, 256, 4)).astype(np.float32)
    image.pixels.foreach_set(values.ravel())
    image.update()
    where = tree.add("Mapping", Vector=coordinates(tree, "UV"))
    where.inputs["Scale"].default_value = (40.0, 40.0, 40.0)
    dots = texture(tree, "TexImage", where.outputs[0], attributes={"image": image})
    cloud = texture(tree, "TexNoise", coordinates(tree, "UV"), Scale=2.0)
    glow = tree.add("BsdfDiffuse", Color=dots)
    gloss = tree.add("BsdfDiffuse", Color=cloud)
    item = add_box(tree.surface(tree.add("MixShader", Fac=0.5)))
    mix = next(n for n in tree.nodes if n.bl_idname == "ShaderNodeMixShader")
    tree.material.node_tree.links.new(glow.outputs[0], mix.inputs[1])
    tree.material.node_tree.links.new(gloss.outputs[0], mix.inputs[2])
    item.data.uv_layers[0].data.foreach_set("uv", _uv_of(item.data).ravel())
    kept = KeptScene.started()
    (made,) = (m for m in kept.scene.materials.values() if m.name == "Paint")
    assert {picture.uv_map for picture in made.surface.pictures} == {""}
    assert max(picture.pixels.shape[0] for picture in made.surface.pictures) >= 256


SHAPES = [
    pytest.param(add_ball, id="ball"),
    pytest.param(add_box, id="box", marks=pytest.mark.slow),
]


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("name", CASES)
def test_objects_show_what_cycles_shows(name, shape, tmp_path):
    make, share = CASES[name]
    tree = new_tree()
    item = shape(shown(tree, make(tree)))
    if name == "noise on uv":
        item.data.uv_layers[0].data.foreach_set("uv", _uv_of(item.data).ravel())
    compare(tmp_path, share)


def _uv_of(mesh):
    uv = np.empty((len(mesh.loops), 2), np.float32)
    mesh.uv_layers[0].data.foreach_get("uv", uv.ravel())
    return 3.0 * uv - 0.7


def compare(tmp_path, share, tolerance=0.02, is_grey=False):
    """Compare what both see; ``is_grey``: its luminance alone, where constant light has a spectrum."""
    ours, is_met = see()
    theirs = see_by_cycles(tmp_path / "cycles.exr")
    if is_grey:
        ours, theirs = (np.repeat(each @ LUMINANCE[:, None], 3, axis=-1) for each in (ours, theirs))
    assert is_met.mean() > 0.05
    is_wrong = (np.abs(ours - theirs).max(-1) > tolerance) & is_met
    assert is_wrong.sum() <= share * is_met.sum(), (
        f"{is_wrong.sum()} of {is_met.sum()} pixels differ, ours {ours[is_wrong][:3]}, "
        f"Cycles {theirs[is_wrong][:3]}"
    )


@pytest.mark.parametrize("is_mirrored", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_normal_map_beside_a_texture_of_the_object_leans_by_its_uv_map(is_mirrored):
    """On a square in the object's own plane z = 0, U along x or against it and V along y."""
    tree = new_tree()
    normal = tree.add("NormalMap", Color=(0.7, 0.4, 0.9))
    cloud = texture(tree, "TexNoise", coordinates(tree, "Object"), output=1)
    bpy.ops.mesh.primitive_plane_add(size=2.0)
    item = _placed(bpy.context.object)
    shader = tree.add("BsdfDiffuse", Color=cloud, Normal=normal.outputs["Normal"])
    item.data.materials.append(tree.surface(shader))
    if is_mirrored:
        uv = np.empty((4, 2), np.float32)
        item.data.uv_layers[0].data.foreach_get("uv", uv.ravel())
        item.data.uv_layers[0].data.foreach_set("uv", (uv * (-1.0, 1.0)).ravel())
    kept = KeptScene.started()
    found = [m.surface for m in kept.scene.materials.values() if isinstance(m.surface, Raised)]
    relief = next(each.relief for each in found if each.relief.vectors.uv_map == CHART_MAP)
    assert relief.axes is Axes.OBJECT
    vectors = relief.vectors.pixels.reshape(-1, 3)
    shown = vectors[np.abs(vectors).max(axis=1) > 0.0]
    expected = [-0.4 if is_mirrored else 0.4, -0.2, 0.8]
    assert np.abs(shown - expected).max() < 1e-5


# ---- attributes ----


ATTRIBUTES = {
    "colour at vertices": ("FLOAT_COLOR", "POINT", "color", 4),
    "colour at corners": ("BYTE_COLOR", "CORNER", "color", 4),
    "number of faces": ("FLOAT", "FACE", "value", 1),
    "number at vertices": ("FLOAT", "POINT", "value", 1),
    "whole number": ("INT", "FACE", "value", 1),
    "switch": ("BOOLEAN", "FACE", "value", 1),
    "vector": ("FLOAT_VECTOR", "POINT", "vector", 3),
    "pair": ("FLOAT2", "CORNER", "vector", 2),
}


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("output", ["Color", "Fac", "Alpha"])
@pytest.mark.parametrize("name", ATTRIBUTES)
def test_attributes_are_those_of_cycles(name, output, tmp_path):
    kind, domain, field, channels = ATTRIBUTES[name]
    tree = new_tree()
    node = tree.add("Attribute", attributes={"attribute_name": "Own"})
    item = add_box(shown(tree, output_of(node, output)))
    made = item.data.attributes.new("Own", kind, domain)
    values = np.random.default_rng(3).random((len(made.data), channels))
    values = np.round(values) if kind in {"INT", "BOOLEAN"} else values
    dtype = {"INT": np.int32, "BOOLEAN": bool}.get(kind, np.float32)
    made.data.foreach_set(field, values.astype(dtype).ravel())
    compare(tmp_path, SHARP)


def test_the_colour_attribute_that_is_shown_is_the_default(tmp_path):
    tree = new_tree()
    item = add_box(shown(tree, tree.add("VertexColor").outputs[0]))
    for name, value in (("First", 0.2), ("Second", 0.7)):
        layer = item.data.color_attributes.new(name, "FLOAT_COLOR", "POINT")
        layer.data.foreach_set("color", [value] * 4 * len(layer.data))
    item.data.color_attributes.render_color_index = 1
    compare(tmp_path, SMOOTH)
    assert see()[0].max() == pytest.approx(0.7, rel=1e-3)


@pytest.mark.one_at_a_time
@pytest.mark.parametrize("kind", ["GEOMETRY", "OBJECT", "VIEW_LAYER"])
@pytest.mark.parametrize("output", ["Color", "Fac", "Alpha"])
def test_an_attribute_that_is_not_there_is_that_of_cycles(output, kind, tmp_path):
    tree = new_tree()
    named = {"attribute_type": kind, "attribute_name": "None such"}
    node = tree.add("Attribute", attributes=named)
    add_box(shown(tree, output_of(node, output)))
    compare(tmp_path, SMOOTH)


def test_every_island_has_the_number_of_cycles(tmp_path):
    tree = new_tree()
    item = add_box(shown(tree, geometry(tree, "Random Per Island")))
    corners = np.array([each.co for each in item.data.vertices])
    faces = [tuple(face.vertices) for face in item.data.polygons]
    mesh = bpy.data.meshes.new("Parts")
    mesh.from_pydata(
        [corners[v] for face in faces for v in face],
        [],
        [range(4 * k, 4 * k + 4) for k in range(6)],
    )
    mesh.materials.append(tree.material)
    item.data = mesh
    compare(tmp_path, SHARP)
    assert len(np.unique(np.round(see()[0], 3))) > 3


# ---- values of objects ----


VALUES = ("Color", "Alpha", "Object Index", "Material Index", "Random", "Location")


@pytest.mark.parametrize("name", VALUES)
def test_values_of_objects_are_those_of_cycles(name, tmp_path):
    tree = new_tree()
    material = shown(tree, output_of(tree.add("ObjectInfo"), name))
    items = [add_box(material, location=(x, 0.2, 0.3), scale=(0.4,) * 3) for x in (0.2, 1.0)]
    items[1].data, material.pass_index = items[0].data, 3
    for number, item in enumerate(items):
        item.color, item.pass_index = (0.3 + 0.4 * number,) * 3 + (0.5,), number + 1
    compare(tmp_path, 2 * SMOOTH, is_grey=True)


@pytest.mark.parametrize("kind", ["OBJECT", "INSTANCER", "VIEW_LAYER"])
def test_properties_are_those_of_cycles(kind, tmp_path):
    tree = new_tree()
    node = tree.add("Attribute", attributes={"attribute_type": kind, "attribute_name": "tone"})
    item = add_box(shown(tree, output_of(node, "Fac")))
    owner = bpy.context.scene if kind == "VIEW_LAYER" else item
    owner["tone"] = 0.37
    compare(tmp_path, SMOOTH)


def test_instances_have_random_numbers_of_their_own(tmp_path):
    tree = new_tree()
    item = add_box(shown(tree, output_of(tree.add("ObjectInfo"), "Random")), scale=(0.2,) * 3)
    group = bpy.data.collections.new("Group")
    group.objects.link(item)
    bpy.context.scene.collection.objects.unlink(item)
    for x in (-0.8, 0.0, 0.8):
        empty = bpy.data.objects.new("Empty", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", group
        empty.location = (x, 0.0, 0.0)
        bpy.context.scene.collection.objects.link(empty)
    ours, is_met = see()
    theirs = see_by_cycles(tmp_path / "cycles.exr")
    is_wrong = (np.abs(ours - theirs).max(-1) > 0.02) & is_met
    assert is_wrong.sum() <= SHARP * is_met.sum()
    assert len(np.unique(np.round(ours[is_met], 3))) == 3


# ---- edits ----


class Kept(KeptScene):
    """A ball with a texture, and another object, kept current."""

    def __init__(self, make):
        super().__init__()
        self.tree = new_tree()
        self.item = add_ball(shown(self.tree, make(self.tree)))
        self.other = add_box(bpy.data.materials.new("Plain"), location=(3, 0, 0))
        self.step()

    def kinds(self):
        """Walk and compare with a fresh export; kinds of what was sent, but for the pixels of pictures."""
        return sorted(kind for kind in self.sent()[0] if kind != "Pixels")


def noise(tree, where="Generated"):
    return texture(tree, "TexNoise", coordinates(tree, where), Scale=2.0)


def node_of(kept, name):
    return next(n for n in kept.tree.nodes if n.bl_idname == f"ShaderNode{name}")


def test_a_material_without_such_nodes_is_sent_as_it_was():
    kept = Kept(lambda tree: texture(tree, "TexNoise", coordinates(tree, "UV"), Scale=2.0))
    assert all(CHART_MAP not in each.uv_maps for each in kept.scene.geometries.values())
    assert len(kept.scene.materials) == 2


def test_an_edit_of_a_node_sends_the_material_alone():
    kept = Kept(noise)
    node_of(kept, "TexNoise").inputs["Scale"].default_value = 3.0
    # The material for all objects is kept for those that may come to show it.
    assert set(kept.kinds()) == {"Material"}


def test_an_edit_elsewhere_sends_nothing_of_it():
    kept = Kept(noise)
    kept.other.location.x = 4.0
    assert kept.kinds() == ["Placement"]
    kept.other.active_material.node_tree.nodes["Principled BSDF"].inputs[0].default_value = (
        1,
        0,
        0,
        1,
    )
    assert kept.kinds() == ["Material"]


def test_a_moved_object_keeps_its_picture_unless_that_lies_in_the_world():
    kept = Kept(noise)
    kept.item.location.x = 0.5
    assert kept.kinds() == ["Placement"]
    kept = Kept(lambda tree: shifted(tree, geometry(tree, "Position")))
    kept.item.location.x = 0.5
    assert kept.kinds() == ["Material", "Placement"]


def test_a_bent_mesh_and_a_painted_one_get_new_pictures():
    kept = Kept(noise)
    kept.item.data.vertices[5].co.x += 0.3
    kept.item.data.update()
    assert kept.kinds() == ["Geometry", "Material"]
    attribute = lambda tree: output_of(  # noqa: E731
        tree.add("Attribute", attributes={"attribute_name": "Own"}), "Color"
    )
    kept = Kept(attribute)
    layer = kept.item.data.color_attributes.new("Own", "FLOAT_COLOR", "POINT")
    layer.data.foreach_set("color", np.linspace(0.1, 0.9, 4 * len(layer.data)))
    kept.item.data.update()
    assert kept.kinds() == ["Material"]


def test_the_picture_comes_and_goes_with_its_nodes():
    kept = Kept(noise)
    links = kept.tree.material.node_tree.links
    link = node_of(kept, "TexNoise").inputs["Vector"].links[0]
    links.remove(link)
    uv = output_of(node_of(kept, "TexCoord"), "UV")
    links.new(uv, node_of(kept, "TexNoise").inputs["Vector"])
    assert kept.kinds() == ["Geometry", "Material", "Placement"]
    assert all(CHART_MAP not in each.uv_maps for each in kept.scene.geometries.values())
    links.new(
        output_of(node_of(kept, "TexCoord"), "Object"), node_of(kept, "TexNoise").inputs["Vector"]
    )
    assert set(kept.kinds()) == {"Geometry", "Material", "Placement"}
    assert any(CHART_MAP in each.uv_maps for each in kept.scene.geometries.values())


def test_the_picture_follows_another_object_that_it_lies_by():
    kept = Kept(other_object)
    bpy.data.objects["Other"].location.x = 1.0
    assert kept.kinds() == ["Material"]


def test_objects_of_one_mesh_share_a_picture_that_is_the_same_for_both():
    kept = Kept(noise)
    second = bpy.data.objects.new("Second", kept.item.data)
    bpy.context.scene.collection.objects.link(second)
    assert kept.kinds() == ["Placement"]
    second.location.z = 2.0
    assert kept.kinds() == ["Placement"]


def test_an_object_of_another_colour_has_a_material_of_its_own():
    kept = Kept(lambda tree: output_of(tree.add("ObjectInfo"), "Color"))
    kept.item.color = (0.2, 0.4, 0.6, 1.0)
    assert kept.kinds() == ["Material", "Placement"]


def test_a_deleted_object_takes_its_picture_with_it():
    kept = Kept(noise)
    bpy.data.objects.remove(kept.item)
    made = kept.step()
    assert kept.differences() == []
    placed = [key for key in made.delta.removed if key.startswith("material:")]
    assert placed


def test_pictures_share_what_room_there_is(monkeypatch):
    monkeypatch.setattr(materials, "LIVE_TEXELS", 1 << 15)
    kept = Kept(lambda tree: texture(tree, "TexNoise", coordinates(tree, "Object"), Scale=40.0))
    pictures = [m.emission.pattern for m in kept.scene.materials.values() if m.emission]
    sizes = [p.pixels.size // p.pixels.shape[2] for p in pictures if p is not None]
    assert max(sizes) <= 1 << 16
    rows = [row.text() for row, _ in kept.step().report.rows]
    assert any("finer than the texels" in row for row in rows)


def instancing_nodes(item, kind="FLOAT"):
    """Geometry nodes that put an object on four points, each instance with its number as an attribute."""
    group = bpy.data.node_groups.new("Instances", "GeometryNodeTree")
    for in_out in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Geometry", in_out=in_out, socket_type="NodeSocketGeometry")
    nodes, links = group.nodes, group.links
    line = nodes.new("GeometryNodeMeshLine")
    line.inputs["Count"].default_value = 4
    line.inputs["Start Location"].default_value = (-0.9, 0.0, 0.0)
    line.inputs["Offset"].default_value = (0.6, 0.0, 0.0)
    shown_by = nodes.new("GeometryNodeObjectInfo")
    shown_by.inputs["Object"].default_value = item
    shown_by.inputs["As Instance"].default_value = True
    put = nodes.new("GeometryNodeInstanceOnPoints")
    put.inputs["Scale"].default_value = (0.2, 0.2, 0.2)
    store = nodes.new("GeometryNodeStoreNamedAttribute")
    store.data_type, store.domain = kind, "INSTANCE"
    store.inputs["Name"].default_value = "tone"
    scaled = nodes.new("ShaderNodeMath")
    scaled.operation, scaled.inputs[1].default_value = "MULTIPLY", 0.25
    links.new(nodes.new("GeometryNodeInputIndex").outputs[0], scaled.inputs[0])
    links.new(line.outputs[0], put.inputs["Points"])
    links.new(shown_by.outputs["Geometry"], put.inputs["Instance"])
    links.new(put.outputs[0], store.inputs["Geometry"])
    links.new(scaled.outputs[0], store.inputs["Value"])
    links.new(store.outputs[0], nodes.new("NodeGroupOutput").inputs[0])
    host = bpy.data.objects.new("Host", bpy.data.meshes.new("Host"))
    bpy.context.scene.collection.objects.link(host)
    host.modifiers.new("Instances", "NODES").node_group = group
    return host


@pytest.mark.skipif(bpy.app.version < (5, 0, 0), reason="this Blender does not tell")
def test_attributes_of_instances_are_those_of_cycles(tmp_path):
    tree = new_tree()
    named = {"attribute_type": "INSTANCER", "attribute_name": "tone"}
    item = add_box(
        shown(tree, output_of(tree.add("Attribute", attributes=named), "Fac")),
        # Out of sight; instances of it stand where they are put.
        location=(0, 0, 50),
        scale=(0.2,) * 3,
    )
    instancing_nodes(item)
    compare(tmp_path, SMOOTH)
    assert len(np.unique(np.round(see()[0], 3))) == 4


@pytest.mark.parametrize("name", ["Generated", "UV"])
def test_coordinates_of_instancers_are_those_of_cycles(name, tmp_path):
    tree = new_tree()
    where = coordinates(tree, name, from_instancer=True)
    item = add_box(shown(tree, shifted(tree, where)), location=(0, 0, 0), scale=(0.3,) * 3)
    bpy.ops.mesh.primitive_grid_add(x_subdivisions=2, y_subdivisions=2, size=1.6)
    host = bpy.context.object
    host.instance_type = "FACES" if name == "UV" else "VERTS"
    host.show_instancer_for_render = host.show_instancer_for_viewport = False
    item.parent = host
    # The object itself is seen beside its instances here, and not in Cycles.
    compare(tmp_path, 0.15, is_grey=True)


def test_a_hidden_object_keeps_its_charts():
    kept = Kept(noise)
    kept.item.hide_viewport = True
    kept.step()
    kept.item.hide_viewport = False
    assert kept.kinds() == ["Material", "Placement"]


def test_what_is_shown_by_too_many_objects_is_told(monkeypatch):
    monkeypatch.setattr(materials, "MOST", 2)
    tree = new_tree()
    material = shown(tree, output_of(tree.add("ObjectInfo"), "Random"))
    for number in range(4):
        add_box(material, location=(number, 0, 0))
    kept = KeptScene.started()
    rows = [row.text() for row, _ in kept.step().report.rows]
    assert any("another one on each of more than 2 objects" in row for row in rows)
    assert len(kept.scene.materials) == 3
