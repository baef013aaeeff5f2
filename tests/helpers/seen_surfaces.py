"""What materials of a scene show to a camera far away: by what the engine is sent, and by Cycles."""

import bpy
import numpy as np
from blender_objects import pixels_of
from kept_scenes import KeptScene
from mathutils import Matrix, Vector
from mathutils.bvhtree import BVHTree

from lumenray.engine.scene.mesh import find_uv_map
from lumenray.engine.scene.texture import ImageTexture

PIXELS, SPAN = 40, 3.4
"""Side of the picture, and what it shows across. [pixel], [Blender unit]"""

FRAME = Matrix.LocRotScale(
    Vector((3.0, -4.0, 3.5)), Vector((3.0, -4.0, 3.5)).to_track_quat("Z", "Y"), None
)
"""The camera's, which looks at the origin."""


def see():
    """Look at the scene that is open; colours of emission by the engine's materials, bottom row first.

    Returns
    -------
    (PIXELS, PIXELS, 3) array, and bool array    Colours, and where there is a surface.
    """
    kept = KeptScene(final=True)
    kept.step()
    efficacy = bpy.context.scene.lumenray.efficacy
    meshes = [kept.scene.mesh(key) for key in kept.scene.meshes]
    trees = [BVHTree.FromPolygons(m.vertices.tolist(), m.triangles.tolist()) for m in meshes]
    seen = np.zeros((PIXELS, PIXELS, 3))
    is_met = np.zeros((PIXELS, PIXELS), bool)
    across, up, back = (np.array(FRAME.col[k])[:3] for k in range(3))
    for row, column in np.ndindex(PIXELS, PIXELS):
        x, y = (((each + 0.5) / PIXELS - 0.5) * SPAN for each in (column, row))
        start = np.array(FRAME.translation) + x * across + y * up
        hits = [tree.ray_cast(Vector(start), Vector(-back)) for tree in trees]
        near = [(hit[3], k) for k, hit in enumerate(hits) if hit[0] is not None]
        if not near:
            continue
        mesh, hit = meshes[min(near)[1]], hits[min(near)[1]]
        is_met[row, column] = True
        seen[row, column] = _colour(kept.scene, mesh, hit[2], np.array(hit[0])) / efficacy
    return seen, is_met


def _colour(scene, mesh, triangle, point):
    material = scene.materials[mesh.materials[mesh.material_index[triangle]]]
    glow = (material.seen or material).emission
    if glow is None:
        return np.zeros(3)
    if glow.pattern is None:
        return np.full(3, glow.luminance)
    uv = find_uv_map(mesh.uv_maps, glow.pattern.uv_map)
    a, b, c = mesh.vertices[mesh.triangles[triangle]]
    parts = np.linalg.lstsq(np.stack([b - a, c - a], 1), point - a, rcond=None)[0]
    place = uv[triangle].T @ np.array([1.0 - parts.sum(), *parts])
    return glow.luminance * np.broadcast_to(_look_up(glow.pattern, place), 3)


def _look_up(picture: ImageTexture, place):
    u, v, _ = picture.transform @ np.array([*place, 1.0])
    height, width = picture.pixels.shape[:2]
    x, y = u * width - 0.5, v * height - 0.5
    column, row = int(np.floor(x)), int(np.floor(y))
    total = 0.0
    for dx, dy in np.ndindex(2, 2):
        weight = abs(1 - dx - (x - column)) * abs(1 - dy - (y - row))
        inner = (np.clip(row + dy, 0, height - 1), np.clip(column + dx, 0, width - 1))
        if picture.extension == "repeat":
            inner = ((row + dy) % height, (column + dx) % width)
        total = total + weight * picture.pixels[inner]
    return total


def see_by_cycles(path):
    """Look at the scene that is open by Cycles; bottom row first. (PIXELS, PIXELS, 3)"""
    scene = bpy.context.scene
    data = bpy.data.cameras.new("Camera")
    data.type, data.ortho_scale = "ORTHO", SPAN
    scene.camera = bpy.data.objects.new("Camera", data)
    scene.camera.matrix_world = FRAME
    scene.collection.objects.link(scene.camera)
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = scene.render.resolution_y = PIXELS
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    scene.cycles.samples, scene.cycles.filter_width = 1, 0.01
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.render.filepath = str(path)
    bpy.ops.render.render(write_still=True)
    return pixels_of(bpy.data.images.load(str(path)))[..., :3]
