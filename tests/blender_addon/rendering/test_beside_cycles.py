"""Pictures of the engine beside those of Cycles."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from blender_objects import add_camera, add_cube, add_light, needs_cycles, new_world

pytestmark = pytest.mark.usefixtures("extension")


def directional_world():
    """An environment that is bright around one direction only, turned about z."""
    world, node = new_world((0, 0, 0))
    image = bpy.data.images.new("Sky", 64, 32, float_buffer=True)
    pixels = np.zeros((32, 64, 4), np.float32)
    pixels[..., 3] = 1.0
    pixels[20:24, 40:46, :3] = 50.0
    pixels[18:20, 10:14, :3] = (30.0, 5.0, 5.0)
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    texture = world.node_tree.nodes.new("ShaderNodeTexEnvironment")
    texture.image = image
    mapping = world.node_tree.nodes.new("ShaderNodeMapping")
    mapping.inputs["Rotation"].default_value[2] = 0.7
    where = world.node_tree.nodes.new("ShaderNodeTexCoord")
    links = world.node_tree.links
    links.new(where.outputs["Generated"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], node.inputs["Color"])
    return world


def render_with(engine, samples=128):
    """Render 48 x 32 pixels and return linear luminance, row 0 at the bottom.

    ``samples``: of a pixel; Cycles takes twice as many.
    """
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.render.resolution_x, scene.render.resolution_y = 48, 32
    scene.render.resolution_percentage = 100
    if hasattr(scene.render.image_settings, "media_type"):
        scene.render.image_settings.media_type = "IMAGE"
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    path = Path(bpy.app.tempdir) / f"{engine}.exr"
    scene.render.filepath = str(path)
    if engine == "CYCLES":
        scene.cycles.samples = 2 * samples
        scene.cycles.use_denoising = False
        scene.cycles.use_adaptive_sampling = False
        scene.cycles.device = "CPU"
    else:
        scene.lumenray.render.samples = samples
        scene.lumenray.white_luminance = scene.lumenray.efficacy
    bpy.ops.render.render(write_still=True)
    image = bpy.data.images.load(str(path), check_existing=False)
    pixels = np.array(image.pixels[:], np.float32).reshape(32, 48, -1)
    bpy.data.images.remove(image)
    return pixels[..., :3]


PANORAMA = {"type": "PANO", "clip_start": 0.5}
FISHEYE = PANORAMA | {"shift_x": 0.05, "shift_y": -0.1, "lens": 200.0}

VIEWS = {
    "perspective": {"lens": 30.0},
    "shifted": {"lens": 40.0, "shift_x": 0.15, "shift_y": -0.1},
    "orthographic": {"type": "ORTHO", "ortho_scale": 7.0},
    "clipped": {"lens": 30.0, "clip_start": 7.0, "clip_end": 9.0},
    "clipped orthographic": {"type": "ORTHO", "ortho_scale": 7.0, "clip_end": 9.0},
    "out of focus": {
        "lens": 35.0,
        "dof.use_dof": True,
        "dof.focus_distance": 4.0,
        "dof.aperture_fstop": 0.05,
        "dof.aperture_blades": 3,
        "dof.aperture_rotation": 0.4,
        "dof.aperture_ratio": 2.0,
    },
    "orthographic lens": {
        "type": "ORTHO",
        "ortho_scale": 7.0,
        "dof.use_dof": True,
        "dof.focus_distance": 5.0,
        "dof.aperture_fstop": 0.5,
        "dof.aperture_blades": 5,
    },
    "panorama": PANORAMA | {"panorama_type": "EQUIRECTANGULAR"},
    "part of a panorama": PANORAMA
    | {
        "panorama_type": "EQUIRECTANGULAR",
        "longitude_min": -1.0,
        "longitude_max": 0.5,
        "latitude_max": 0.4,
        "shift_x": 0.1,
        "shift_y": 0.05,
        "clip_end": 9.0,
    },
    "equidistant": FISHEYE | {"panorama_type": "FISHEYE_EQUIDISTANT", "fisheye_fov": 2.0},
    "equisolid": FISHEYE
    | {"panorama_type": "FISHEYE_EQUISOLID", "fisheye_fov": 2.0, "fisheye_lens": 20.0},
    "tall sensor": FISHEYE
    | {
        "panorama_type": "FISHEYE_EQUISOLID",
        "fisheye_lens": 20.0,
        "sensor_fit": "VERTICAL",
        "sensor_height": 30.0,
        "dof.use_dof": True,
        "dof.focus_distance": 4.0,
        "dof.aperture_fstop": 0.1,
        "dof.aperture_blades": 3,
    },
    "polynomial": FISHEYE | {"panorama_type": "FISHEYE_LENS_POLYNOMIAL", "fisheye_fov": 1.5},
    "mirror ball": FISHEYE
    | {
        "panorama_type": "MIRRORBALL",
        "dof.use_dof": True,
        "dof.focus_distance": 4.0,
        "dof.aperture_fstop": 0.1,
        "dof.aperture_blades": 3,
        "dof.aperture_rotation": 0.5,
    },
    "cube face": PANORAMA | {"panorama_type": "EQUIANGULAR_CUBEMAP_FACE"},
    "cylinder": PANORAMA
    | {
        "panorama_type": "CENTRAL_CYLINDRICAL",
        "central_cylindrical_range_u_min": -1.0,
        "central_cylindrical_range_u_max": 1.5,
        "central_cylindrical_range_v_min": -1.5,
        "central_cylindrical_radius": 1.2,
    },
}
"""Settings of cameras by what they show, of depth of field by dots."""


def set_up_camera(settings, place=(5, -6, 4), turn=(1.1, 0, 0.7)):
    """Add the scene's camera; panoramas are set where the version of Blender has them."""
    data = add_camera(place, turn).data
    for path, value in settings.items():
        *steps, name = path.split(".")
        holder = data.dof if steps else data
        if not hasattr(holder, name):
            holder = data.cycles
        setattr(holder, name, value)


def add_room():
    """A cube on a slab, two lamps and an even world."""
    add_cube(location=(0, 0, 0))
    floor = add_cube(location=(0, 0, -1.5), scale=(6, 6, 0.4))
    paint = bpy.data.materials.new("Paint")
    paint.use_nodes = True
    nodes = paint.node_tree.nodes
    diffuse = nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (0.7, 0.4, 0.2, 1.0)
    paint.node_tree.links.new(diffuse.outputs[0], nodes.get("Material Output").inputs["Surface"])
    for item in (bpy.data.objects["Cube"], floor):
        item.data.materials.append(paint)
    add_light("POINT", location=(2, -3, 3), energy=300.0, shadow_soft_size=0.3)
    add_light("AREA", location=(-3, -1, 3), energy=200.0, size=1.5)
    new_world((0.2, 0.3, 0.5), 0.5)


QUICK = {"perspective", "panorama"}


@needs_cycles
@pytest.mark.parametrize(
    "view",
    [pytest.param(view, marks=[] if view in QUICK else [pytest.mark.slow]) for view in VIEWS],
)
def test_pictures_agree_with_cycles(view):
    add_room()
    set_up_camera(VIEWS[view])
    ours, theirs = render_with("LUMENRAY"), render_with("CYCLES")

    # Blocks of 8 x 8 pixels even out noise; upsampled spectra and RGB differ a little in colour.
    def blocks(picture):
        return picture.reshape(4, 8, 6, 8, 3).mean(axis=(1, 3))

    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.03)
    assert np.abs(blocks(ours) - blocks(theirs)).max() < 0.08 * blocks(theirs).max()


def add_relief(kind):
    """A square whose normals, or whose vertices, follow a picture."""
    side = 24
    step = np.linspace(-2.0, 2.0, side + 1)
    corners = [(x, y, 0.0) for y in step for x in step]
    first = [row * (side + 1) + column for row in range(side) for column in range(side)]
    faces = [(n, n + 1, n + side + 2, n + side + 1) for n in first]
    mesh = bpy.data.meshes.new("Square")
    mesh.from_pydata(corners, [], faces)
    places = np.array([corners[n][:2] for face in faces for n in face])
    mesh.uv_layers.new(name="UVMap").data.foreach_set("uv", (0.25 * places + 0.5).ravel())
    mesh.polygons.foreach_set("use_smooth", [True] * len(faces))
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Square", mesh))

    x, y = np.meshgrid(np.arange(16) / 16, np.arange(16) / 16)
    pixels = np.ones((16, 16, 4), np.float32)
    pixels[..., 0] = 0.5 + 0.3 * np.sin(2 * np.pi * x)
    pixels[..., 1] = 0.5 + 0.3 * np.cos(2 * np.pi * y)
    image = bpy.data.images.new("Relief", 16, 16, float_buffer=True)
    image.colorspace_settings.name = "Non-Color"
    image.pixels.foreach_set(pixels.ravel())
    image.update()

    material = bpy.data.materials.new("Relief")
    material.use_nodes = True
    mesh.materials.append(material)
    nodes, links = material.node_tree.nodes, material.node_tree.links
    nodes.clear()
    shaders = "OutputMaterial", "BsdfAnisotropic" if kind == "metal" else "BsdfDiffuse"
    output, shader = (nodes.new(f"ShaderNode{name}") for name in shaders)
    shader.inputs["Color"].default_value = (0.6, 0.6, 0.6, 1.0)
    links.new(shader.outputs[0], output.inputs["Surface"])
    picture = nodes.new("ShaderNodeTexImage")
    picture.image = image
    if kind in {"normal map", "metal"}:
        if kind == "metal":
            shader.inputs["Roughness"].default_value = 0.5
        node = nodes.new("ShaderNodeNormalMap")
        links.new(picture.outputs["Color"], node.inputs["Color"])
        links.new(node.outputs[0], shader.inputs["Normal"])
    elif kind == "bump":
        node = nodes.new("ShaderNodeBump")
        node.inputs["Distance"].default_value = 0.5
        links.new(picture.outputs["Color"], node.inputs["Height"])
        links.new(node.outputs[0], shader.inputs["Normal"])
    else:
        node = nodes.new("ShaderNodeDisplacement")
        node.inputs["Scale"].default_value = 0.6
        links.new(picture.outputs["Color"], node.inputs["Height"])
        links.new(node.outputs[0], output.inputs["Displacement"])
        material.displacement_method = kind
    add_light("SUN", location=(0, 0, 3), energy=3.0).rotation_euler = (0.7, 0.2, 0.0)
    new_world((1.0, 1.0, 1.0), 0.2)
    add_camera((0, 0, 3), (0, 0, 0), type="ORTHO", ortho_scale=3.6)


@needs_cycles
@pytest.mark.parametrize(
    "kind",
    [
        "bump",
        *(
            pytest.param(kind, marks=pytest.mark.slow)
            for kind in ("normal map", "metal", "BUMP", "DISPLACEMENT", "BOTH")
        ),
    ],
)
def test_reliefs_agree_with_cycles(kind):
    add_relief(kind)
    ours, theirs = (render_with(engine, 64)[..., 1] for engine in ("LUMENRAY", "CYCLES"))
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.01)
    blocks = [picture.reshape(4, 8, 6, 8).mean(axis=(1, 3)) for picture in (ours, theirs)]
    # Highlights that follow a normal map differ by 2.9 % without noise (4096 samples).
    bound = 0.035 if kind == "metal" else 0.03
    assert np.abs(blocks[0] - blocks[1]).max() < bound * blocks[1].max()


BLURRED = {"clip_start": 0.01} | {
    f"dof.{name}": value
    for name, value in (
        ("use_dof", True),
        ("focus_distance", 1.5),
        ("aperture_blades", 3),
        ("aperture_rotation", 0.3),
        ("aperture_ratio", 1.6),
    )
}

LENSES = {
    "perspective": BLURRED | {"lens": 20.0, "dof.aperture_fstop": 0.03},
    "orthographic": BLURRED | {"type": "ORTHO", "ortho_scale": 4.0, "dof.aperture_fstop": 1.5},
    "fisheye": BLURRED
    | PANORAMA
    | {"panorama_type": "FISHEYE_EQUIDISTANT", "fisheye_fov": 2.0, "dof.aperture_fstop": 0.1},
}


@needs_cycles
@pytest.mark.parametrize(
    "lens",
    [
        pytest.param(lens, marks=[] if lens == "perspective" else [pytest.mark.slow])
        for lens in LENSES
    ],
)
def test_small_lights_out_of_focus_have_the_shape_that_cycles_gives_them(lens):
    """The mirror image of the aperture, or one with a blade more, agrees less than 0.992."""
    glow = bpy.data.materials.new("Glow")
    glow.use_nodes = True
    nodes = glow.node_tree.nodes
    emission = nodes.new("ShaderNodeEmission")
    emission.inputs["Strength"].default_value = 50.0
    surface = nodes.get("Material Output").inputs["Surface"]
    glow.node_tree.links.new(emission.outputs[0], surface)
    for place in ((0, 0, -3), (1.2, 0.4, -3.5), (-1.0, -0.6, -2.5), (0.8, -0.7, -4)):
        lamp = add_cube(location=place, scale=(0.1, 0.1, 0.02))
        lamp.data.materials.append(glow)
    new_world((0, 0, 0))
    set_up_camera(LENSES[lens], (0, 0, 0), (0, 0, 0))
    ours, theirs = (render_with(engine, 2048).sum(axis=2) for engine in ("LUMENRAY", "CYCLES"))
    assert (ours * theirs).sum() / np.sqrt((ours**2).sum() * (theirs**2).sum()) > 0.995
    assert ours.mean() == pytest.approx(theirs.mean(), rel=0.02)


@needs_cycles
@pytest.mark.slow
def test_environments_are_turned_like_cycles_turns_them():
    directional_world()
    add_camera((0, 0, 0), (1.4, 0.0, 0.0), lens=12.0)
    compared = 0
    for angle in (0.0, 2.0, 4.0):
        bpy.context.scene.camera.rotation_euler[2] = angle
        ours, theirs = render_with("LUMENRAY"), render_with("CYCLES")
        if theirs.max() < 1.0:
            continue
        # The bright patches must fall on the same pixels.
        a, b = ours.sum(axis=2), theirs.sum(axis=2)
        assert (a * b).sum() / np.sqrt((a**2).sum() * (b**2).sum()) > 0.97
        compared += 1
    assert compared, "no view saw a bright patch"
