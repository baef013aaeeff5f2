"""What Blender's process does for the benchmark of pictures: render with Cycles.

It imports nothing of ours, see `cycles_server`. A request with a ``camera`` builds its scene and answers with the seconds
that took; others, of ``samples``, ``seed`` and ``by_processor``, whether the processors' time counts, answer ``(picture
(h, w, 3) in linear Rec. 709 [cd/m2], seconds)``.
"""

import tempfile
import time
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

LENS = 50.0
"""Focal length; what is seen follows from the sensor's size. [mm]"""


def answer(request: dict, builder):
    """Do what is asked for."""
    return build(request, builder) if "camera" in request else render(request)


def build(request: dict, builder) -> float:
    """Build a scene, and render once so that it is in Cycles' memory."""
    begin = time.perf_counter()
    bpy.ops.wm.read_factory_settings(use_empty=True)
    builder.settle(request | {"samples": 1, "seed": 0})
    scene = bpy.context.scene
    scene.cycles.use_light_tree = True
    scene.cycles.use_guiding = False
    scene.cycles.pixel_filter_type = "BOX"
    scene.render.use_persistent_data = True
    scene.render.use_compositing = scene.render.use_sequencer = False
    for entry in request["meshes"]:
        builder.add_mesh(entry)
    for entry in request["textured"]:
        add_mesh(entry, builder)
    for entry in request["lights"]:
        builder.add_light(entry)
        if "tint" in entry:
            finish_light(entry)
    builder.add_world(request["world"])
    if request["world"] is not None:
        paint_world(request["world"]["tint"])
    add_camera(request["camera"], builder)
    bpy.ops.render.render()
    return time.perf_counter() - begin


def render(request: dict) -> tuple[np.ndarray, float]:
    """Render what was built."""
    scene = bpy.context.scene
    scene.cycles.samples, scene.cycles.seed = request["samples"], request["seed"]
    read_clock = time.process_time if request["by_processor"] else time.perf_counter
    begin = read_clock()
    bpy.ops.render.render()
    seconds = read_clock() - begin
    return read_result(scene), seconds


def read_result(scene) -> np.ndarray:
    """Return the last picture, by way of a file: Blender gives its pixels no other way."""
    settings = scene.render.image_settings
    settings.file_format, settings.color_mode, settings.color_depth = "OPEN_EXR", "RGB", "32"
    with tempfile.TemporaryDirectory() as folder:
        path = str(Path(folder) / "picture.exr")
        bpy.data.images["Render Result"].save_render(path, scene=scene)
        image = bpy.data.images.load(path)
        width, height = image.size
        pixels = np.empty(4 * width * height, dtype=np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    return pixels.reshape(height, width, 4)[..., :3]


def add_mesh(entry: dict, builder) -> None:
    """Add triangles of one material with their normals and texture coordinates."""
    mesh = bpy.data.meshes.new("mesh")
    triangles = entry["triangles"]
    mesh.vertices.add(len(entry["vertices"]))
    mesh.vertices.foreach_set("co", entry["vertices"].astype(np.float32).ravel())
    mesh.loops.add(triangles.size)
    mesh.loops.foreach_set("vertex_index", triangles.astype(np.int32).ravel())
    mesh.polygons.add(len(triangles))
    mesh.polygons.foreach_set("loop_start", np.arange(0, triangles.size, 3, dtype=np.int32))
    if entry["uv"] is not None:
        layer = mesh.uv_layers.new(name="uv")
        layer.data.foreach_set("uv", entry["uv"].astype(np.float32).ravel())
    mesh.update(calc_edges=True)
    if entry["normals"] is None:
        mesh.shade_flat()
    else:
        mesh.normals_split_custom_set(entry["normals"].reshape(-1, 3).astype(np.float32))
    mesh.materials.append(make_material(entry["material"]))
    item = bpy.data.objects.new("mesh", mesh)
    item.visible_camera = entry["is_seen"]
    builder.add_object(item)


def make_material(entry: dict):
    """Make a material of one closure, and of what it emits."""
    material = bpy.data.materials.new("material")
    material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    closure = make_closure(tree, entry)
    if "image" in entry:
        texture = tree.nodes.new("ShaderNodeTexImage")
        texture.image = make_image(entry["image"]["pixels"])
        texture.interpolation = entry["image"]["interpolation"]
        socket = "Base Color" if entry["kind"] == "coated" else "Color"
        tree.links.new(texture.outputs["Color"], closure.inputs[socket])
    total = closure.outputs[0]
    material.cycles.emission_sampling = "NONE"
    if any(entry["emitted"]):
        both = tree.nodes.new("ShaderNodeAddShader")
        tree.links.new(total, both.inputs[0])
        tree.links.new(make_glow(tree, entry), both.inputs[1])
        total = both.outputs[0]
        material.cycles.emission_sampling = "FRONT_BACK" if entry["two_sided"] else "FRONT"
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(total, output.inputs["Surface"])
    return material


def make_closure(tree, entry: dict):
    """Make the node of a surface."""
    colour = (*entry["colour"], 1.0)
    match entry["kind"]:
        case "diffuse":
            values = {"Color": colour, "Roughness": 0.0}
            return make_node(tree, "ShaderNodeBsdfDiffuse", values)
        case "coated":
            values = {
                "Base Color": colour,
                "Roughness": entry["roughness"],
                "IOR": entry["ior"],
                "Specular IOR Level": 0.5 * entry["specular"],
            }
            return make_node(tree, "ShaderNodeBsdfPrincipled", values)
        case "glossy":
            values = {"Color": colour, "Roughness": entry["roughness"]}
            return make_node(tree, "ShaderNodeBsdfAnisotropic", values)
        case "dielectric":
            return make_glass(tree, entry)
    raise ValueError(entry["kind"])


def make_glass(tree, entry: dict):
    """Make the boundary of a solid: only what passes is tinted."""
    rough, ior = {"Roughness": entry["roughness"]}, {"IOR": entry["ior"]}
    parts = [
        make_node(tree, "ShaderNodeBsdfRefraction", {"Color": (*entry["tint"], 1.0)} | rough | ior),
        make_node(tree, "ShaderNodeBsdfAnisotropic", {"Color": (1.0, 1.0, 1.0, 1.0)} | rough),
    ]
    share = make_node(tree, "ShaderNodeFresnel", ior)
    mixed = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(share.outputs[0], mixed.inputs[0])
    for part, socket in zip(parts, list(mixed.inputs)[1:], strict=True):
        tree.links.new(part.outputs[0], socket)
    return mixed


def make_glow(tree, entry: dict):
    """Make the emission of a front, or of both sides."""
    peak = max(entry["emitted"])
    colour = (*(part / peak for part in entry["emitted"]), 1.0)
    glow = make_node(tree, "ShaderNodeEmission", {"Color": colour, "Strength": peak})
    if entry["two_sided"]:
        return glow.outputs[0]
    geometry, dark = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("NewGeometry", "MixShader"))
    tree.links.new(geometry.outputs["Backfacing"], dark.inputs[0])
    tree.links.new(glow.outputs[0], dark.inputs[1])
    return dark.outputs[0]


def make_node(tree, kind: str, values: dict):
    """Make a node with values of its inputs."""
    node = tree.nodes.new(kind)
    for name, value in values.items():
        node.inputs[name].default_value = value
    return node


def make_image(pixels: np.ndarray):
    """Make an image of linear Rec. 709 (h, w, 3), row 0 at the bottom."""
    height, width = pixels.shape[:2]
    values = np.ones((height, width, 4), dtype=np.float32)
    values[..., :3] = pixels
    image = bpy.data.images.new("image", width, height, float_buffer=True, is_data=True)
    image.pixels.foreach_set(values.ravel())
    image.pack()
    return image


def finish_light(entry: dict) -> None:
    """Give the lamp that was added last a colour of luminance 1, and let the camera see it if it may."""
    lamp = bpy.context.scene.collection.objects[-1]
    peak = max(entry["tint"])
    lamp.data.color = [part / peak for part in entry["tint"]]
    lamp.data.energy *= peak
    lamp.visible_camera = entry["is_seen"]


def paint_world(tint) -> None:
    """Give the surroundings a colour of luminance 1."""
    for node in bpy.context.scene.world.node_tree.nodes:
        if node.type == "BACKGROUND":
            node.inputs["Color"].default_value = (*tint, 1.0)


def add_camera(entry: dict, builder) -> None:
    """Look as the camera of the engine does."""
    data = bpy.data.cameras.new("camera")
    data.lens, data.sensor_fit = LENS, "HORIZONTAL"
    data.sensor_width = LENS * entry["extent"]
    data.shift_x, data.shift_y = entry["shift"]
    data.clip_start, data.clip_end = entry["clip"], 1e4
    item = bpy.data.objects.new("camera", data)
    # A bare list would be taken by columns.
    item.matrix_world = Matrix(entry["frame"].tolist())
    builder.add_object(item)
    scene = bpy.context.scene
    scene.camera = item
    scene.render.resolution_x, scene.render.resolution_y = entry["size"]
    scene.render.resolution_percentage = 100
