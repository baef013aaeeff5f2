"""Measure the sheen of Blender's microfibres: what Cycles sends on of a single sun, solved for the transforms of its lobes.

Run as ``python -m lumenray.tools.libraries.materials.microfibre``; it needs ``bpy`` and writes
`libraries/materials/microfibre.csv`. A sun is a single direction and is not sampled, so a picture of 32 x 32 faces, one
pixel for each roughness and angle, is exact. With the direction (x, y, z) in the frame of the normal and the eye, a lobe is

    R z / pi * (a / l)^2,    l = (a x + b z)^2 + (a y)^2 + z^2,

so that sqrt(z / (pi value)) is linear in a / sqrt(R), b / sqrt(R) and (b^2 + 1) / (a sqrt(R)), by x^2 + y^2, 2 x z and z^2.
"""

import tempfile
from pathlib import Path

import bpy
import mathutils
import numpy as np

COUNT = 32
"""Nodes of Cycles' table along each side."""

NEAR = 0.25
"""Place between the first two nodes that stands for the first, at which nothing is seen."""

TILTS, AZIMUTHS = np.radians([15.0, 30.0, 45.0, 60.0, 75.0, 85.0]), (0.0, 0.5, 1.0, -0.7, 2.0)
"""Of suns, to the eye. [rad]"""

LEAST = 6
"""Suns that a face has to show."""

OUTPUT = Path(__file__).parents[3] / "libraries" / "materials" / "microfibre.csv"


def nodes() -> np.ndarray:
    """Return the cosines and roughnesses at which Cycles' table is asked. (32,) [-]"""
    values = np.arange(COUNT) / (COUNT - 1)
    values[0] = NEAR * values[1]
    return values


def build():
    """Make the scene; returns the sun's object."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="cycles")
    scene = bpy.context.scene
    render, settings = scene.render, scene.cycles
    render.engine, settings.device, settings.samples, settings.max_bounces = "CYCLES", "CPU", 1, 0
    settings.use_denoising = settings.use_adaptive_sampling = False
    settings.light_sampling_threshold, settings.filter_width = 0.0, 0.01
    render.resolution_x = render.resolution_y = COUNT
    render.resolution_percentage = 100
    image = render.image_settings
    image.media_type, image.file_format = "IMAGE", "OPEN_EXR"
    image.color_depth, image.color_mode = "32", "RGBA"
    data = bpy.data.meshes.new("Faces")
    corners = []
    for sine, cosine in zip(np.sqrt(1.0 - nodes() ** 2), nodes(), strict=True):
        column = len(corners) // (4 * COUNT)
        for row in range(COUNT):
            middle = np.array([column + 0.5, row + 0.5, 0.0])
            x, y = np.array([0.45, 0.0, -0.45 * sine / cosine]), np.array([0.0, 0.45, 0.0])
            corners += [middle - x - y, middle + x - y, middle + x + y, middle - x + y]
    faces = np.arange(len(corners)).reshape(-1, 4)
    data.from_pydata([tuple(each) for each in corners], [], faces.tolist())
    roughness = np.tile(nodes(), COUNT).astype(np.float32)
    data.attributes.new("roughness", "FLOAT", "FACE").data.foreach_set("value", roughness)
    material = bpy.data.materials.new("Sheen")
    tree = material.node_tree
    tree.nodes.clear()
    sheen, attribute = (tree.nodes.new(f"ShaderNode{n}") for n in ("BsdfSheen", "Attribute"))
    sheen.distribution, attribute.attribute_name = "MICROFIBER", "roughness"
    sheen.inputs["Color"].default_value = (1.0, 1.0, 1.0, 1.0)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(attribute.outputs["Fac"], sheen.inputs["Roughness"])
    tree.links.new(sheen.outputs[0], output.inputs["Surface"])
    data.materials.append(material)
    camera, light = bpy.data.cameras.new("Eye"), bpy.data.lights.new("Sun", "SUN")
    camera.type, camera.ortho_scale, camera.clip_end = "ORTHO", COUNT, 1e4
    light.energy, light.angle, light.use_shadow = 1.0, 0.0, False
    items = [bpy.data.objects.new(each.name, each) for each in (data, camera, light)]
    for item in items:
        scene.collection.objects.link(item)
    scene.camera = items[1]
    scene.camera.location = (COUNT / 2, COUNT / 2, 1000.0)
    return items[2]


def render(sun, direction) -> np.ndarray:
    """Return what is seen under a sun in a direction. (32, 32) by roughness and cosine [1/sr]"""
    scene = bpy.context.scene
    sun.rotation_euler = mathutils.Vector(tuple(direction)).to_track_quat("Z", "Y").to_euler()
    with tempfile.TemporaryDirectory() as folder:
        scene.render.filepath = str(Path(folder) / "faces.exr")
        bpy.ops.render.render(write_still=True)
        image = bpy.data.images.load(scene.render.filepath)
        pixels = np.empty(COUNT * COUNT * 4, np.float32)
        image.pixels.foreach_get(pixels)
        bpy.data.images.remove(image)
    return pixels.reshape(COUNT, COUNT, 4)[..., 0].astype(np.float64)


def solve(directions, values, cosine) -> tuple[float, float, float]:
    """Return a, b and R of a face by its cosine and what is seen of it under each sun; NaN where that is nothing."""
    sine = np.sqrt(1.0 - cosine**2)
    normal, along = np.array([sine, 0.0, cosine]), np.array([-cosine, 0.0, sine])
    x, y, z = (directions @ axis for axis in (along, np.array([0.0, 1.0, 0.0]), normal))
    lit = (z > 0.02) & (values > 1e-12)
    if lit.sum() < LEAST:
        return np.nan, np.nan, np.nan
    seen = np.sqrt(z[lit] / (np.pi * values[lit]))
    rows = np.stack([x[lit] ** 2 + y[lit] ** 2, 2.0 * x[lit] * z[lit], z[lit] ** 2], axis=1)
    first, second, third = np.linalg.lstsq(rows / seen[:, None], np.ones(lit.sum()), rcond=None)[0]
    ratio = second / first
    a = 1.0 / np.sqrt(third / first - ratio**2)
    return a, ratio * a, (a / first) ** 2


def fill(table: np.ndarray) -> np.ndarray:
    """Return the table at its nodes: where nothing is reflected lobes are those beside it. (32, 32, 3)"""
    made = table.copy()
    for row in made:
        known = ~np.isnan(row[:, 2])
        for k in (0, 1):
            row[:, k] = np.interp(nodes(), nodes()[known], row[known, k])
        row[~known, 2] = 0.0
    # Along the normal no direction is preferred.
    made[:, -1, 1] = 0.0
    for first, second in ((made[:, 0], made[:, 1]), (made[0], made[1])):
        first[...] = (first - NEAR * second) / (1.0 - NEAR)
    made[..., 0] = np.maximum(made[..., 0], 1e-3)
    made[..., 2] = np.clip(made[..., 2], 0.0, 1.0)
    return made


def main() -> None:
    """Measure, and write the table."""
    sun = build()
    directions = np.array(
        [
            (np.sin(tilt) * np.cos(azimuth), np.sin(tilt) * np.sin(azimuth), np.cos(tilt))
            for tilt in TILTS
            for azimuth in AZIMUTHS
        ]
    )
    pictures = np.stack([render(sun, direction) for direction in directions])
    table = np.empty((COUNT, COUNT, 3))
    for row, column in np.ndindex(COUNT, COUNT):
        table[row, column] = solve(directions, pictures[:, row, column], nodes()[column])
    lines = [",".join(f"{value:.4g}" for value in place) for place in fill(table).reshape(-1, 3)]
    OUTPUT.write_text("\n".join(["a,b,albedo", *lines]) + "\n", encoding="ascii")


if __name__ == "__main__":
    main()
