"""Materials of the office by name."""

import bpy

from .. import textures
from ..staging import new_material, override

PRINCIPLED = {
    # name: (linear base colour, roughness, metallic)
    "Wall Paint": ((0.80, 0.785, 0.755), 0.90, 0.0),
    "Ceiling Tile": ((0.85, 0.85, 0.84), 0.95, 0.0),
    "Plaster": ((0.70, 0.69, 0.67), 0.95, 0.0),
    "White Steel": ((0.78, 0.78, 0.77), 0.45, 0.0),
    "White Lacquer": ((0.74, 0.73, 0.71), 0.35, 0.0),
    "Grey Lacquer": ((0.33, 0.34, 0.35), 0.40, 0.0),
    "Opal Diffuser": ((0.82, 0.82, 0.82), 0.60, 0.0),
    "Black Plastic": ((0.022, 0.022, 0.024), 0.42, 0.0),
    "Grey Plastic": ((0.15, 0.155, 0.16), 0.50, 0.0),
    "Key Caps": ((0.045, 0.046, 0.05), 0.55, 0.0),
    "Rubber": ((0.02, 0.02, 0.02), 0.75, 0.0),
    "Seat Fabric": ((0.055, 0.10, 0.135), 0.95, 0.0),
    "Aluminium": ((0.80, 0.81, 0.82), 0.30, 1.0),
    "Brushed Steel": ((0.58, 0.57, 0.55), 0.35, 1.0),
    "Chrome": ((0.60, 0.61, 0.62), 0.08, 1.0),
    "Brass": ((0.75, 0.55, 0.25), 0.25, 1.0),
    "Lamp Green": ((0.03, 0.13, 0.085), 0.30, 0.0),
    "Paper": ((0.82, 0.81, 0.78), 0.90, 0.0),
    "Porcelain": ((0.78, 0.77, 0.74), 0.15, 0.0),
    "Blue Glaze": ((0.05, 0.13, 0.28), 0.18, 0.0),
    "Terracotta": ((0.45, 0.19, 0.10), 0.80, 0.0),
    "Soil": ((0.035, 0.023, 0.015), 1.00, 0.0),
    "Leaf": ((0.045, 0.145, 0.035), 0.40, 0.0),
    "Foliage": ((0.022, 0.058, 0.012), 0.80, 0.0),
    "Stem": ((0.13, 0.11, 0.055), 0.80, 0.0),
    "Book Red": ((0.32, 0.035, 0.03), 0.60, 0.0),
    "Book Blue": ((0.04, 0.09, 0.24), 0.60, 0.0),
    "Book Green": ((0.05, 0.16, 0.09), 0.60, 0.0),
    "Book Ochre": ((0.48, 0.27, 0.06), 0.60, 0.0),
    "Book Cream": ((0.66, 0.60, 0.46), 0.65, 0.0),
    "Book Charcoal": ((0.05, 0.05, 0.055), 0.60, 0.0),
    "Brick": ((0.17, 0.075, 0.05), 0.95, 0.0),
    "Concrete": ((0.30, 0.29, 0.27), 0.95, 0.0),
    "Asphalt": ((0.085, 0.085, 0.088), 0.95, 0.0),
    "Grass": ((0.055, 0.10, 0.03), 1.00, 0.0),
    "Facade Glass": ((0.012, 0.015, 0.018), 0.08, 0.0),
}
"""Opaque materials: linear base colour, roughness, metallic."""


def build_palette():
    """Make all materials of the office and return them by name."""
    palette = {}
    for name, (colour, roughness, metallic) in PRINCIPLED.items():
        inputs = {"Base Color": colour, "Roughness": roughness, "Metallic": metallic}
        palette[name] = new_material(name, "ShaderNodeBsdfPrincipled", inputs)
    pictures = {
        "Oak Floor": (textures.oak_planks(), 0.45),
        "Wood": (textures.light_wood(), 0.40),
        "Picture": (textures.landscape(), 0.60),
    }
    for name, (colour, roughness) in pictures.items():
        image = textures.packed_image(name, colour)
        inputs = {"Base Color": (0.5, 0.5, 0.5), "Roughness": roughness}
        palette[name] = new_material(name, "ShaderNodeBsdfPrincipled", inputs, image)
    glass = {"Color": (1.0, 1.0, 1.0), "Roughness": 0.0, "IOR": 1.50}
    palette["Glass"] = new_material("Glass", "ShaderNodeBsdfGlass", glass)
    # The node stands in for other engines; 0.92 is the transmittance of a clear pane.
    pane = new_material("Window Pane", "ShaderNodeBsdfTransparent", {"Color": (0.92, 0.92, 0.92)})
    palette["Window Pane"] = override(
        pane, "THIN_GLASS", ior_source="CONSTANT", ior=1.52, transmittance=1.0
    )
    efficacy = bpy.context.scene.lumenray.efficacy
    for name, luminance in (("Screen Page", 250.0), ("Screen Desktop", 45.0)):
        inputs = {"Color": (0.95, 0.98, 1.0), "Strength": luminance / efficacy}
        screen = new_material(name, "ShaderNodeEmission", inputs)
        emitter = {"spectrum": "ILLUMINANT", "illuminant": "D65", "two_sided": False}
        palette[name] = override(screen, "EMITTER", luminance=luminance, **emitter)
    override(palette["Chrome"], "CONDUCTOR", metal="Cr", roughness=0.05)
    return palette
