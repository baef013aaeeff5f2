"""Three scenes of a few faces each, whose light can be checked by hand."""

import bpy
import numpy as np

from . import staging, textures
from .assembly import Assembly
from .shapes import box, quad, sphere


def _matt(name, reflectance):
    """Return a diffuse material of a stated neutral reflectance."""
    grey = {"Base Color": (reflectance,) * 3, "Roughness": 1.0, "Specular IOR Level": 0.0}
    material = staging.new_material(name, "ShaderNodeBsdfPrincipled", grey)
    return staging.override(
        material, "DIFFUSE", reflectance_source="VALUE", reflectance=reflectance
    )


def _square(side):
    """Return a square about the origin, facing up, its side in metres."""
    return quad((-side / 2, -side / 2, 0.0), (side, 0.0, 0.0), (0.0, side, 0.0))


def build_inverse_square():
    """Build a point of 100 lm, 1 m above a square of 0.2 m.

    The middle of the receiver gets 100 / (4 pi) = 7.958 lx.
    """
    collection = staging.new_collection("Scene")
    receiver = Assembly().add(_matt("Receiver", 0.05), _square(0.2))
    receiver.build("Receiver", collection)
    # White at all wavelengths, so that the result does not depend on the observer's tables.
    light = staging.new_light(
        "Point",
        "POINT",
        collection,
        (0.0, 0.0, 1.0),
        "LUMINOUS_FLUX",
        100.0,
        "ILLUMINANT",
        illuminant="E",
    )
    light.data.shadow_soft_size = 0.0
    staging.set_sky((0.0, 0.0, 0.0), 0.0)
    staging.new_camera((0.0, -0.4, 0.6), (33.69, 0.0, 0.0), lens=50.0)
    staging.set_render(256, 256, 0.2)


def build_closed_box():
    """Build a closed white box of 2 m with reflectance 0.5 and a point of 1000 lm inside.

    The floor is an object of its own. By the balance of flux the mean illuminance over all
    24 m2 is 1000 / (24 (1 - 0.5)) = 83.33 lx.
    """
    collection = staging.new_collection("Scene")
    paint = _matt("Half", 0.5)
    shell = box((2.0, 2.0, 2.0), (0.0, 0.0, 1.0)).flipped()
    # The lower face is left out: the floor takes its place without a second face there.
    heights = [shell.points[list(face), 2].max() for face in shell.faces]
    walls = [face for face, top in zip(shell.faces, heights, strict=True) if top > 0.0]
    room = Assembly().add(paint, type(shell)(shell.points, walls))
    room.build("Walls", collection)
    Assembly().add(paint, _square(2.0)).build("Floor", collection)
    light = staging.new_light(
        "Point",
        "POINT",
        collection,
        (0.0, 0.0, 1.0),
        "LUMINOUS_FLUX",
        1000.0,
        "ILLUMINANT",
        illuminant="E",
    )
    light.data.shadow_soft_size = 0.02
    staging.set_sky((0.0, 0.0, 0.0), 0.0)
    staging.new_camera((0.9, -0.9, 1.2), (82.0, 0.0, 45.0), lens=20.0)
    staging.set_render(256, 256, 25.0)


def build_materials():
    """Build a checkered plane, a glass and a copper ball and a luminous panel, in sunlight."""
    collection = staging.new_collection("Scene")
    picture = textures.packed_image("Checker", textures.checker())
    table = staging.new_material(
        "Checker",
        "ShaderNodeBsdfPrincipled",
        {"Base Color": (0.5, 0.5, 0.5), "Roughness": 0.6},
        picture,
    )
    ground = quad((-2.0, -2.0, 0.0), (4.0, 0.0, 0.0), (0.0, 4.0, 0.0), (2.0, 2.0))
    Assembly().add(table, ground).build("Ground", collection)
    glass = {"Color": (1.0, 1.0, 1.0), "Roughness": 0.0, "IOR": 1.5}
    glass = staging.new_material("Glass", "ShaderNodeBsdfGlass", glass)
    ball = Assembly().add(glass, sphere(0.3, 64, 32))
    ball.build("Glass Ball", collection, (-0.40, 0.0, 0.3002))
    copper = {"Base Color": (0.93, 0.62, 0.50), "Metallic": 1.0, "Roughness": 0.1}
    copper = staging.new_material("Copper", "ShaderNodeBsdfPrincipled", copper)
    staging.override(copper, "CONDUCTOR", metal="Cu", roughness=0.1)
    ball = Assembly().add(copper, sphere(0.3, 64, 32))
    ball.build("Copper Ball", collection, (0.40, 0.1, 0.3002))
    efficacy = bpy.context.scene.lumenray.efficacy
    glow = {"Color": (1.0, 1.0, 1.0), "Strength": 1000.0 / efficacy}
    glow = staging.new_material("Panel", "ShaderNodeEmission", glow)
    staging.override(
        glow, "EMITTER", luminance=1000.0, two_sided=False, spectrum="ILLUMINANT", illuminant="D65"
    )
    panel = quad((-0.5, 0.9, 0.2), (1.0, 0.0, 0.0), (0.0, 0.0, 0.8))
    Assembly().add(glow, panel).build("Panel", collection)
    sun = staging.new_light(
        "Sun",
        "SUN",
        collection,
        (0.0, 0.0, 4.0),
        "ILLUMINANCE",
        10000.0,
        "DAYLIGHT",
        colour_temperature=5500.0,
    )
    sun.data.angle = np.radians(0.53)
    sun.rotation_euler = np.radians((-35.0, 0.0, 50.0))
    staging.set_sky((0.85, 0.93, 1.0), 1500.0)
    staging.new_camera((0.0, -2.6, 1.1), (72.0, 0.0, 0.0), lens=40.0)
    staging.set_render(480, 320, 4000.0)
