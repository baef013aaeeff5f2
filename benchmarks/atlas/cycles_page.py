"""What Blender's process does for the benchmark of the atlas: bake pages with Cycles.

It imports nothing of ours, see `cycles_server`. Answers are ``(illuminance (h, w) [lx], seconds)``.
"""

import time

import bpy
import numpy as np


def answer(request: dict, builder) -> tuple[np.ndarray, float]:
    """Build the scene anew and bake its page."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    builder.settle(request)
    for entry in request["meshes"]:
        builder.add_mesh(entry)
    for entry in request["lights"]:
        builder.add_light(entry)
    builder.add_world(request["world"])
    height, width = request["size"]
    image = bpy.data.images.new("page", width, height, float_buffer=True, is_data=True, alpha=True)
    target = add_target(request["target"], image, builder)
    bpy.context.view_layer.objects.active = target
    target.select_set(True)
    begin = time.perf_counter()
    bpy.ops.object.bake(
        type="DIFFUSE", pass_filter={"DIRECT", "INDIRECT"}, margin=0, use_clear=True
    )
    seconds = time.perf_counter() - begin
    pixels = np.empty(4 * width * height, dtype=np.float32)
    image.pixels.foreach_get(pixels)
    # A bake without colour is the illuminance over pi.
    return np.pi * pixels.reshape(height, width, 4)[..., 1], seconds


def add_target(entry: dict, image, builder):
    """Add what is baked as one object, with texture coordinates by corner and a material slot for each material."""
    mesh = bpy.data.meshes.new("target")
    corners = entry["corners"].reshape(-1, 3)
    count = len(corners) // 3
    mesh.vertices.add(len(corners))
    mesh.vertices.foreach_set("co", corners.astype(np.float32).ravel())
    mesh.loops.add(len(corners))
    mesh.loops.foreach_set("vertex_index", np.arange(len(corners), dtype=np.int32))
    mesh.polygons.add(count)
    mesh.polygons.foreach_set("loop_start", np.arange(0, len(corners), 3, dtype=np.int32))
    mesh.polygons.foreach_set("material_index", entry["slot"].astype(np.int32))
    mesh.uv_layers.new(name="uv").data.foreach_set("uv", entry["uv"].astype(np.float32).ravel())
    mesh.update(calc_edges=True)
    mesh.shade_flat()
    for description in entry["materials"]:
        material = builder.make_material(description)
        tree = material.node_tree
        page = tree.nodes.new("ShaderNodeTexImage")
        page.image = image
        tree.nodes.active = page
        mesh.materials.append(material)
    target = bpy.data.objects.new("target", mesh)
    builder.add_object(target)
    return target
