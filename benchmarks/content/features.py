"""What is compared: a scene for each feature of Blender, by group."""

import math
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from .stage import Stage, image, panorama

FEATURES: dict[str, "Feature"] = {}
"""All features by key."""


@dataclass(frozen=True)
class Feature:
    """A scene. ``build``: makes it on an empty `Stage`; ``is_loose``: light goes below its surfaces."""

    key: str
    group: str
    build: Callable[[Stage], None]
    is_loose: bool = False


def _note(group: str, key: str, build, is_loose: bool = False) -> None:
    FEATURES[key] = Feature(key, group, build, is_loose)


def _feature(group: str, key: str, is_loose: bool = False):
    """Note what a function builds."""

    def keep(build):
        _note(group, key, build, is_loose)
        return build

    return keep


# ---- surfaces ----


def _principled(**values):
    def build(stage):
        tree = stage.material()
        base = {"Base_Color": (0.7, 0.4, 0.2, 1.0), **values}
        stage.studio(tree.show(tree.add("BsdfPrincipled", **base)))

    return build


def _shader(kind, attributes=None, **values):
    def build(stage):
        tree = stage.material()
        stage.studio(tree.show(tree.add(kind, attributes, **values)))

    return build


PAINT = (0.7, 0.4, 0.2, 1.0)

for _key, _values in {
    "Principled": {},
    "Principled, rough": {"Roughness": 0.9},
    "Principled, IOR": {"IOR": 1.8},
    "Principled, no specular": {"Specular_IOR_Level": 0.0},
    "Principled, specular level": {"Specular_IOR_Level": 0.9},
    "Principled, specular tint": {"Specular_Tint": (0.2, 0.5, 1.0, 1.0)},
    "Principled, dark specular tint": {"Specular_Tint": (0.1, 0.2, 0.1, 1.0), "IOR": 2.0},
    "Principled, metal 0.2": {"Metallic": 1.0, "Roughness": 0.2},
    "Principled, metal 0.6": {"Metallic": 1.0, "Roughness": 0.6},
    "Principled, metal, edge tint": {
        "Metallic": 1.0,
        "Roughness": 0.4,
        "Specular_Tint": (0.3, 0.6, 1.0, 1.0),
    },
    "Principled, half metal": {"Metallic": 0.5},
    "Principled, glass": {"Transmission_Weight": 1.0, "Roughness": 0.0},
    "Principled, rough glass": {"Transmission_Weight": 1.0, "Roughness": 0.4},
    "Principled, alpha": {"Alpha": 0.5},
    "Principled, emission": {"Emission_Strength": 0.5, "Emission_Color": (1.0, 0.8, 0.5, 1.0)},
    "Principled, coat": {"Coat_Weight": 1.0},
    "Principled, rough coat": {"Coat_Weight": 0.7, "Coat_Roughness": 0.4, "Coat_IOR": 1.8},
    "Principled, coat on metal": {"Coat_Weight": 1.0, "Metallic": 1.0, "Roughness": 0.5},
    "Principled, coat on glass": {"Coat_Weight": 1.0, "Transmission_Weight": 1.0, "Roughness": 0.0},
    "Principled, coat tint": {"Coat_Weight": 1.0, "Coat_Tint": (0.3, 0.6, 1.0, 1.0)},
    "Principled, sheen": {"Sheen_Weight": 1.0},
    "Principled, coloured sheen": {
        "Sheen_Weight": 0.8,
        "Sheen_Roughness": 0.3,
        "Sheen_Tint": (0.9, 0.3, 0.5, 1.0),
        "Base_Color": (0.05, 0.05, 0.2, 1.0),
    },
    "Principled, sheen on metal": {
        "Sheen_Weight": 1.0,
        "Sheen_Roughness": 0.8,
        "Metallic": 1.0,
        "Roughness": 0.3,
    },
    "Principled, sheen on coat": {"Sheen_Weight": 1.0, "Coat_Weight": 1.0},
    "Principled, anisotropy": {"Metallic": 1.0, "Roughness": 0.4, "Anisotropic": 0.8},
    "Principled, anisotropic coat": {
        "Roughness": 0.3,
        "Anisotropic": 0.9,
        "Base_Color": (0, 0, 0, 1),
    },
    "Principled, anisotropy turned": {
        "Metallic": 1.0,
        "Roughness": 0.5,
        "Anisotropic": 1.0,
        "Anisotropic_Rotation": 0.15,
    },
    "Principled, diffuse roughness": {"Diffuse_Roughness": 1.0},
    "Principled, thin film": {"Thin_Film_Thickness": 400.0, "Metallic": 1.0, "Roughness": 0.2},
    "Principled, film on paint": {"Thin_Film_Thickness": 300.0, "Thin_Film_IOR": 1.8},
    "Principled, thick film": {
        "Thin_Film_Thickness": 3000.0,
        "Thin_Film_IOR": 1.6,
        "Metallic": 1.0,
        "Roughness": 0.3,
    },
    "Principled, film on glass": {
        "Thin_Film_Thickness": 250.0,
        "Thin_Film_IOR": 1.9,
        "Transmission_Weight": 1.0,
        "Roughness": 0.3,
    },
}.items():
    _note("Surfaces", _key, _principled(**_values))
_note("Surfaces", "Principled, subsurface", _principled(Subsurface_Weight=1.0), True)

for _key, (_kind, _attributes, _values) in {
    "Diffuse": ("BsdfDiffuse", {}, {"Color": PAINT}),
    "Diffuse, rough": ("BsdfDiffuse", {}, {"Color": PAINT, "Roughness": 1.0}),
    "Glossy 0.1": ("BsdfAnisotropic", {}, {"Color": PAINT, "Roughness": 0.1}),
    "Glossy 0.4": ("BsdfAnisotropic", {}, {"Color": PAINT, "Roughness": 0.4}),
    "Glossy 0.8": ("BsdfAnisotropic", {}, {"Color": PAINT, "Roughness": 0.8}),
    "Glossy, anisotropic": (
        "BsdfAnisotropic",
        {},
        {"Color": PAINT, "Roughness": 0.4, "Anisotropy": 0.8},
    ),
    "Glossy, anisotropic across": (
        "BsdfAnisotropic",
        {},
        {"Color": PAINT, "Roughness": 0.4, "Anisotropy": -0.6, "Rotation": 0.1},
    ),
    "Metallic, anisotropic": (
        "BsdfMetallic",
        {},
        {"Base_Color": PAINT, "Roughness": 0.4, "Anisotropy": 0.8, "Rotation": 0.3},
    ),
    "Metallic": ("BsdfMetallic", {}, {"Base_Color": PAINT, "Roughness": 0.3}),
    "Metallic, edge tint": (
        "BsdfMetallic",
        {},
        {"Base_Color": PAINT, "Edge_Tint": (0.2, 0.5, 1.0, 1.0), "Roughness": 0.3},
    ),
    "Metallic, by index": (
        "BsdfMetallic",
        {"fresnel_type": "PHYSICAL_CONDUCTOR"},
        {"Roughness": 0.3},
    ),
    "Glass": ("BsdfGlass", {}, {"Roughness": 0.0}),
    "Glass, thin film": (
        "BsdfGlass",
        {},
        {"Roughness": 0.0, "Thin_Film_Thickness": 300.0, "Thin_Film_IOR": 2.0},
    ),
    "Metallic, thin film": (
        "BsdfMetallic",
        {},
        {
            "Base_Color": PAINT,
            "Edge_Tint": (0.5, 0.7, 0.9, 1.0),
            "Roughness": 0.3,
            "Thin_Film_Thickness": 250.0,
            "Thin_Film_IOR": 1.5,
        },
    ),
    "Metallic, film by index": (
        "BsdfMetallic",
        {"fresnel_type": "PHYSICAL_CONDUCTOR"},
        {"Roughness": 0.3, "Thin_Film_Thickness": 350.0},
    ),
    "Glass, rough": ("BsdfGlass", {}, {"Roughness": 0.4}),
    "Glass, coloured": ("BsdfGlass", {}, {"Roughness": 0.0, "Color": (0.6, 0.9, 0.7, 1.0)}),
    "Glass, coloured, rough": ("BsdfGlass", {}, {"Roughness": 0.3, "Color": (0.6, 0.9, 0.7, 1.0)}),
    "Refraction": ("BsdfRefraction", {}, {"Roughness": 0.0, "IOR": 1.45}),
    "Refraction, rough": ("BsdfRefraction", {}, {"Roughness": 0.3, "IOR": 1.45}),
    "Translucent": ("BsdfTranslucent", {}, {"Color": PAINT}),
    "Transparent": ("BsdfTransparent", {}, {"Color": PAINT}),
    "Sheen": ("BsdfSheen", {}, {"Color": PAINT}),
    "Sheen, rough": ("BsdfSheen", {}, {"Color": PAINT, "Roughness": 0.9}),
    "Sheen, Ashikhmin": (
        "BsdfSheen",
        {"distribution": "ASHIKHMIN"},
        {"Color": PAINT, "Roughness": 0.6},
    ),
    "Toon": ("BsdfToon", {}, {"Color": PAINT}),
    "Toon, glossy": (
        "BsdfToon",
        {"component": "GLOSSY"},
        {"Color": PAINT, "Size": 0.3, "Smooth": 0.2},
    ),
    "Toon, smooth": ("BsdfToon", {}, {"Color": PAINT, "Size": 0.4, "Smooth": 0.3}),
    "Emission": ("Emission", {}, {"Color": PAINT, "Strength": 2.0}),
    "Holdout": ("Holdout", {}, {}),
}.items():
    _note("Surfaces", _key, _shader(_kind, _attributes, **_values))
_note("Surfaces", "Subsurface Scattering", _shader("SubsurfaceScattering"), True)


def _two(tree):
    return (
        tree.add("BsdfDiffuse", Color=PAINT),
        tree.add("BsdfAnisotropic", Color=(0.9, 0.9, 0.9, 1.0), Roughness=0.2),
    )


def _along(**settings):
    def build(stage):
        tree = stage.material()
        tangent = tree.add("Tangent", settings)
        stage.studio(
            tree.show(
                tree.add(
                    "BsdfPrincipled",
                    Base_Color=PAINT,
                    Metallic=1.0,
                    Roughness=0.4,
                    Anisotropic=0.9,
                    Tangent=tangent,
                )
            )
        )

    return build


_note("Surfaces", "Anisotropy round X", _along(direction_type="RADIAL", axis="X"))
_note("Surfaces", "Anisotropy along U", _along(direction_type="UV_MAP"))


@_feature("Surfaces", "Mix Shader")
def _mixed(stage):
    tree = stage.material()
    first, second = _two(tree)
    stage.studio(tree.show(tree.add("MixShader", Fac=0.3, _1=first, _2=second)))


@_feature("Surfaces", "Add Shader")
def _added(stage):
    tree = stage.material()
    first, second = _two(tree)
    stage.studio(tree.show(tree.add("AddShader", _0=first, _1=second)))


@_feature("Surfaces", "Add Shader, dark")
def _added_dark(stage):
    tree = stage.material()
    first = tree.add("BsdfDiffuse", Color=(0.4, 0.2, 0.1, 1.0))
    second = tree.add("BsdfAnisotropic", Color=(0.5, 0.5, 0.5, 1.0), Roughness=0.3)
    stage.studio(tree.show(tree.add("AddShader", _0=first, _1=second)))


@_feature("Surfaces", "Mix by Fresnel")
def _by_fresnel(stage):
    tree = stage.material()
    first, second = _two(tree)
    factor = tree.add("Fresnel", IOR=1.5)
    stage.studio(tree.show(tree.add("MixShader", Fac=factor, _1=first, _2=second)))


@_feature("Surfaces", "Mix by facing")
def _by_facing(stage):
    tree = stage.material()
    first, second = _two(tree)
    factor = tree.add("LayerWeight", out=1, Blend=0.3)
    stage.studio(tree.show(tree.add("MixShader", Fac=factor, _1=first, _2=second)))


@_feature("Surfaces", "Mix by a ramp of facing")
def _by_ramp(stage):
    tree = stage.material()
    first, second = _two(tree)
    power = tree.add("Math", {"operation": "POWER"}, _0=tree.add("LayerWeight", out=1), _1=2.5)
    stage.studio(tree.show(tree.add("MixShader", Fac=power, _1=first, _2=second)))


@_feature("Surfaces", "Colour by facing")
def _colour_by_facing(stage):
    tree = stage.material()
    colour = tree.add(
        "MixRGB",
        Fac=tree.add("LayerWeight", out=1, Blend=0.4),
        Color1=(0.1, 0.2, 0.6, 1.0),
        Color2=(0.9, 0.7, 0.5, 1.0),
    )
    stage.studio(tree.show(tree.add("BsdfPrincipled", Base_Color=colour, Roughness=0.6)))


@_feature("Surfaces", "Pane by Fresnel")
def _pane(stage):
    tree = stage.material()
    clear = tree.add("BsdfTransparent")
    gloss = tree.add("BsdfAnisotropic", Roughness=0.0)
    shader = tree.add("MixShader", Fac=tree.add("Fresnel", IOR=1.5), _1=clear, _2=gloss)
    stage.studio()
    corners = [(-1.5, -1.2, 0.0), (1.5, -1.2, 0.0), (1.5, -1.2, 2.0), (-1.5, -1.2, 2.0)]
    stage.mesh("Pane", corners, [(0, 1, 2, 3)], tree.show(shader))


@_feature("Surfaces", "Front and back")
def _sides(stage):
    tree = stage.material()
    side = tree.add("NewGeometry", out=6)
    front, back = (
        tree.add("BsdfDiffuse", Color=colour)
        for colour in ((0.8, 0.2, 0.2, 1.0), (0.2, 0.3, 0.8, 1.0))
    )
    material = tree.show(tree.add("MixShader", Fac=side, _1=front, _2=back))
    stage.studio()
    for x, turn in ((-1.3, 1.2), (1.3, 1.2 + math.pi)):
        stage.tile(
            material, location=(x, -0.5, 0.8), rotation_euler=(turn, 0.0, 0.0), scale=[0.6] * 3
        )


# ---- relief ----


def _bumpy(stage, tree, height):
    shader = tree.add("BsdfDiffuse", Color=(0.7, 0.7, 0.7, 1.0), Normal=height)
    stage.world((1.0, 1.0, 1.0), 0.2)
    stage.light("SUN", energy=3.0, turn=(0.8, 0.0, 0.4))
    stage.tile(tree.show(shader))
    stage.above()


@_feature("Relief", "Bump")
def _bump(stage):
    tree = stage.material()
    height = tree.add("TexImage", {"image": image()}, Vector=tree.add("UVMap"))
    _bumpy(stage, tree, tree.add("Bump", Strength=1.0, Distance=0.3, Height=height))


@_feature("Relief", "Normal map")
def _normal_map(stage):
    tree = stage.material()
    colour = tree.add("TexImage", {"image": image(is_float=True)}, Vector=tree.add("UVMap"))
    _bumpy(stage, tree, tree.add("NormalMap", Color=colour, Strength=0.7))


@_feature("Relief", "Displacement as bump")
def _displaced(stage):
    tree = stage.material()
    height = tree.add("TexImage", {"image": image()}, Vector=tree.add("UVMap"))
    tree.links.new(
        tree.add("Displacement", Height=height, Scale=0.3), tree.output.inputs["Displacement"]
    )
    stage.world((1.0, 1.0, 1.0), 0.2)
    stage.light("SUN", energy=3.0, turn=(0.8, 0.0, 0.4))
    stage.tile(tree.show(tree.add("BsdfDiffuse", Color=(0.7, 0.7, 0.7, 1.0))))
    stage.above()


@_feature("Relief", "Bump of a procedural texture")
def _procedural_bump(stage):
    tree = stage.material()
    height = tree.add("TexNoise", Vector=tree.add("UVMap"), Scale=3.0, Detail=0.0)
    _bumpy(stage, tree, tree.add("Bump", Strength=0.6, Distance=0.2, Height=height))


@_feature("Relief", "Bump on a normal map")
def _chained(stage):
    tree = stage.material()
    colour = tree.add("TexImage", {"image": image(is_float=True)}, Vector=tree.add("UVMap"))
    below = tree.add("NormalMap", Color=colour, Strength=0.3)
    height = tree.add("TexImage", {"image": image("Heights")}, Vector=tree.add("UVMap"))
    bump = tree.add("Bump", {"invert": True}, Distance=0.2, Height=height, Normal=below)
    _bumpy(stage, tree, bump)


@_feature("Relief", "Object-space normal map")
def _object_normals(stage):
    tree = stage.material()
    colour = tree.add("TexImage", {"image": image(is_float=True)}, Vector=tree.add("UVMap"))
    mixed = tree.add("MixRGB", Fac=0.3, Color1=(0.5, 0.5, 1.0, 1.0), Color2=colour)
    normal = tree.add("NormalMap", {"space": "OBJECT"}, Color=mixed)
    stage.world((1.0, 1.0, 1.0), 0.2)
    stage.light("SUN", energy=3.0, turn=(0.8, 0.0, 0.4))
    shader = tree.add("BsdfDiffuse", Color=(0.7, 0.7, 0.7, 1.0), Normal=normal)
    stage.tile(tree.show(shader), rotation_euler=(0.2, -0.1, 0.6), scale=(1.0, 1.3, 1.0))
    stage.above()


def _shiny(stage, tree, shader):
    stage.studio(tree.show(shader))


def _beside_noise(place):
    """Show a normal map on a UV map, on a matt surface whose colour lies by the object. ``place(stage, material)``."""

    def build(stage):
        tree = stage.material()
        colour = tree.add("TexImage", {"image": image(is_float=True)}, Vector=tree.add("UVMap"))
        normal = tree.add("NormalMap", Color=colour, Strength=0.4)
        shown = tree.add("TexNoise", Vector=tree.add("TexCoord", out=3), Scale=2.0, out=1)
        shader = tree.add("BsdfDiffuse", Color=shown, Normal=normal)
        place(stage, tree.show(shader))

    return build


def _turned_tile(stage, material):
    stage.world((1.0, 1.0, 1.0), 0.2)
    stage.light("SUN", energy=3.0, turn=(0.8, 0.0, 0.4))
    stage.tile(material, rotation_euler=(0.2, -0.1, 0.6), scale=(1.0, 1.3, 1.0))
    stage.above()


_note("Relief", "Normal map beside noise of the object", _beside_noise(_turned_tile))
_note(
    "Relief",
    "Normal map beside noise of a ball",
    _beside_noise(lambda stage, material: stage.studio(material)),
)


@_feature("Relief", "Normal map on metal")
def _metal_relief(stage):
    tree = stage.material()
    colour = tree.add("TexImage", {"image": image(is_float=True)}, Vector=tree.add("UVMap"))
    normal = tree.add("NormalMap", Color=colour, Strength=0.3)
    _shiny(
        stage,
        tree,
        tree.add("BsdfPrincipled", Base_Color=PAINT, Metallic=1.0, Roughness=0.4, Normal=normal),
    )


@_feature("Relief", "Bump on varnish")
def _varnish_relief(stage):
    tree = stage.material()
    height = tree.add("TexImage", {"image": image()}, Vector=tree.add("UVMap"))
    normal = tree.add("Bump", Distance=0.15, Height=height)
    _shiny(stage, tree, tree.add("BsdfPrincipled", Base_Color=PAINT, Roughness=0.3, Normal=normal))


def _waves(stage, method, is_smooth, height=None):
    """A grid that is displaced in a low sun."""
    tree = stage.material()
    if height is None:
        height = tree.add("TexImage", {"image": image(size=32)}, Vector=tree.add("UVMap"))
    else:
        height = height(tree)
    tree.links.new(
        tree.add("Displacement", Height=height, Scale=0.3), tree.output.inputs["Displacement"]
    )
    tree.owner.displacement_method = method
    material = tree.show(tree.add("BsdfDiffuse", Color=(0.7, 0.7, 0.7, 1.0)))
    stage.world((1.0, 1.0, 1.0), 0.2)
    stage.light("SUN", energy=3.0, turn=(0.8, 0.0, 0.4))
    stage.grid(material, is_smooth)
    stage.above()


@_feature("Relief", "True displacement")
def _true(stage):
    _waves(stage, "DISPLACEMENT", True)


@_feature("Relief", "True displacement, flat")
def _true_flat(stage):
    _waves(stage, "DISPLACEMENT", False)


@_feature("Relief", "Displacement and bump")
def _both(stage):
    _waves(stage, "BOTH", True)


@_feature("Relief", "True displacement by a texture of the object")
def _true_object(stage):
    _waves(stage, "DISPLACEMENT", True, lambda tree: tree.add("TexNoise", Scale=2.0, Detail=1.0))


# ---- textures and nodes ----


def _tile(make):
    """Show a colour over a tile in even light. ``make(tree)``: the colour's output."""

    def build(stage):
        stage.world()
        tree = stage.material()
        stage.tile(tree.show(tree.add("BsdfDiffuse", Color=make(tree))))
        stage.above()

    return build


def _on(coordinate):
    return lambda tree: tree.add("TexCoord", out=tree_output(coordinate))


def tree_output(name):
    """Return the number of an output of the Texture Coordinate node."""
    return ("Generated", "Normal", "UV", "Object", "Camera", "Window", "Reflection").index(name)


def _texture(kind, attributes=None, where="UV", out=0, **values):
    return lambda tree: tree.add(kind, attributes, out, Vector=_on(where)(tree), **values)


def _picture(where="UV", interpolation="Linear", **how):
    return lambda tree: tree.add(
        "TexImage",
        {"image": image(**how), "interpolation": interpolation},
        Vector=_on(where)(tree),
    )


_COLOURS = {"Color1": (0.8, 0.7, 0.2, 1.0), "Color2": (0.1, 0.2, 0.6, 1.0)}

for _key, _make in {
    "Image, float": _picture(),
    "Image, sRGB bytes": _picture(is_float=False),
    "Image, closest": _picture(interpolation="Closest"),
    "Image, noise in sRGB bytes": _picture(is_float=False, is_smooth=False),
    "Image, generated coordinates": _picture("Generated"),
    "Image, object coordinates": _picture("Object"),
    "Image, box projection": lambda tree: tree.add(
        "TexImage", {"image": image(), "projection": "BOX"}, Vector=_on("Object")(tree)
    ),
    "Checker on UV": _texture("TexChecker", Scale=4.0, **_COLOURS),
    "Checker, generated": _texture("TexChecker", where="Generated", Scale=4.0, **_COLOURS),
    "Brick on UV": _texture("TexBrick", Scale=3.0, **_COLOURS),
    "Brick, generated": _texture("TexBrick", where="Generated", Scale=3.0, **_COLOURS),
    "Noise on UV": _texture("TexNoise", Scale=4.0),
    "Noise, generated": _texture("TexNoise", where="Generated", Scale=4.0),
    "Noise, object": _texture("TexNoise", where="Object", Scale=4.0),
    "Noise, colour": _texture("TexNoise", out=1, Scale=4.0),
    "Voronoi on UV": _texture("TexVoronoi", Scale=4.0),
    "Voronoi, generated": _texture("TexVoronoi", where="Generated", Scale=4.0),
    "Voronoi, colour": _texture("TexVoronoi", out=1, Scale=4.0),
    "Wave on UV": _texture("TexWave", Scale=3.0),
    "Wave, generated": _texture("TexWave", where="Generated", Scale=3.0),
    "Magic on UV": _texture("TexMagic", Scale=3.0),
    "Gradient on UV": _texture("TexGradient"),
    "Gradient, generated": _texture("TexGradient", where="Generated"),
    "White noise on UV": _texture("TexWhiteNoise"),
    "Generated as colour": _on("Generated"),
    "UV as colour": _on("UV"),
    "Object as colour": _on("Object"),
    "Position as colour": lambda tree: tree.add("NewGeometry"),
    "Pointiness": lambda tree: tree.add("NewGeometry", out=7),
    "Random per island": lambda tree: tree.add("NewGeometry", out=8),
    "Ambient occlusion": lambda tree: tree.add("AmbientOcclusion"),
    # Lines so wide that the camera sees those at the edges of the tile as well.
    "Wireframe": lambda tree: tree.add("Wireframe", Size=0.2),
    "Random per object": lambda tree: tree.add("ObjectInfo", out=5),
    "Object's colour": lambda tree: tree.add("ObjectInfo", out=1),
    "Camera distance": lambda tree: tree.add("CameraData", out=2),
    "Is Camera Ray": lambda tree: tree.add("LightPath"),
    # Seen from above a tile faces the camera, where *Facing* is 0.
    "Layer weight": lambda tree: tree.add("LayerWeight", Blend=0.8),
    "Colour ramp": lambda tree: tree.add("ValToRGB", Fac=_texture("TexGradient")(tree)),
    "Curves": lambda tree: tree.add("RGBCurve", Color=_picture()(tree)),
    "Hue and saturation": lambda tree: tree.add(
        "HueSaturation", Hue=0.7, Saturation=0.6, Color=_picture()(tree)
    ),
    "Multiply": lambda tree: tree.add(
        "MixRGB",
        {"blend_type": "MULTIPLY"},
        Fac=1.0,
        Color1=_picture()(tree),
        Color2=(0.9, 0.5, 0.3, 1.0),
    ),
    "Blackbody": lambda tree: tree.add("Blackbody", Temperature=4000.0),
}.items():
    _note("Textures and nodes", _key, _tile(_make))


@_feature("Lights", "Light, slide in colour on grey")
def _grey_slide(stage):
    FEATURES["Light, slide in colour"].build(stage)
    bpy.data.objects["Ball"].data.materials[0] = stage.paint((0.5, 0.5, 0.5))


@_feature("Textures and nodes", "Colour attribute")
def _attribute(stage):
    stage.world()
    tree = stage.material()
    colour = tree.add("VertexColor", {"layer_name": "Tint"})
    item = stage.tile(tree.show(tree.add("BsdfDiffuse", Color=colour)))
    layer = item.data.color_attributes.new("Tint", "FLOAT_COLOR", "POINT")
    layer.data.foreach_set(
        "color", [0.8, 0.1, 0.1, 1, 0.1, 0.8, 0.1, 1, 0.1, 0.1, 0.8, 1, 0.7, 0.7, 0.7, 1]
    )
    stage.above()


def _numbered(kind, domain, field, values):
    """Show an attribute of a tile of two by two faces."""

    def build(stage):
        stage.world()
        tree = stage.material()
        shown = tree.add("Attribute", {"attribute_name": "Own"}, out=0)
        at = [(x - 1.0, y - 1.0, 0.0) for y in range(3) for x in range(3)]
        faces = [(k, k + 1, k + 4, k + 3) for k in (0, 1, 3, 4)]
        item = stage.mesh("Tile", at, faces, tree.show(tree.add("BsdfDiffuse", Color=shown)))
        item.data.attributes.new("Own", kind, domain).data.foreach_set(field, values)
        stage.above()

    return build


_note(
    "Textures and nodes",
    "Float attribute of vertices",
    _numbered("FLOAT", "POINT", "value", [0.1 * k for k in range(9)]),
)
_note(
    "Textures and nodes",
    "Float attribute of faces",
    _numbered("FLOAT", "FACE", "value", [0.2, 0.7, 0.5, 0.1]),
)
_note(
    "Textures and nodes",
    "Byte colours of corners",
    _numbered("BYTE_COLOR", "CORNER", "color", [(0.05 * k) % 1.0 for k in range(64)]),
)


def _coloured_ball(make):
    """Show a colour on a ball and on the floor below it, of its own. ``make(tree)``: the colour's output."""

    def build(stage):
        tree = stage.material()
        stage.studio(tree.show(tree.add("BsdfDiffuse", Color=make(tree))))

    return build


def _other(tree):
    """Return the coordinates of another object, which stands askew."""
    item = bpy.data.objects.new("Other", None)
    item.location, item.rotation_euler, item.scale = (0.4, 0.3, 1.0), (0.4, 0.2, 0.7), (0.5, 1, 1)
    bpy.context.scene.collection.objects.link(item)
    return tree.add("TexCoord", {"object": item}, out=tree_output("Object"))


def _far_uv(tree):
    """Return noise on a UV map that is stretched over three tiles."""
    for item in bpy.data.meshes:
        for layer in item.uv_layers:
            uv = np.empty(2 * len(layer.data), np.float32)
            layer.data.foreach_get("uv", uv)
            layer.data.foreach_set("uv", 3.0 * uv)
    return tree.add("TexNoise", Vector=_on("UV")(tree), Scale=2.0)


for _key, _make in {
    "Noise on a ball, object": _texture("TexNoise", where="Object", Scale=2.0),
    "Checker on a ball, object": _texture("TexChecker", where="Object", Scale=3.1, **_COLOURS),
    "Gradient on a ball, another object": lambda tree: tree.add("TexGradient", Vector=_other(tree)),
    "Box projection on a ball, blended": lambda tree: tree.add(
        "TexImage",
        {"image": image(), "projection": "BOX", "projection_blend": 0.4},
        Vector=_on("Object")(tree),
    ),
    "Tube projection on a ball": lambda tree: tree.add(
        "TexImage", {"image": image(), "projection": "TUBE"}, Vector=_on("Generated")(tree)
    ),
    "Pointiness on a ball": lambda tree: tree.add("NewGeometry", out=7),
    "Normal as colour on a ball": lambda tree: tree.add(
        "VectorMath",
        {"operation": "MULTIPLY_ADD"},
        _0=_on("Normal")(tree),
        _1=(0.4, 0.4, 0.4),
        _2=(0.5, 0.5, 0.5),
    ),
    "Bevel": lambda tree: tree.add("Bevel"),
    "Ambient occlusion as a factor": lambda tree: tree.add(
        "AmbientOcclusion", Color=PAINT, Distance=2.0
    ),
}.items():
    _note("Textures and nodes", _key, _coloured_ball(_make))


@_feature("Textures and nodes", "Generated, bent by a modifier")
def _bent(stage):
    tree = stage.material()
    shown = tree.add("TexNoise", Vector=_on("Generated")(tree), Scale=2.0)
    item = stage.studio(tree.show(tree.add("BsdfDiffuse", Color=shown)))
    bend = item.modifiers.new("Bend", "SIMPLE_DEFORM")
    bend.deform_method, bend.deform_axis, bend.angle = "TAPER", "Z", 0.0
    bend.factor = 0.8


@_feature("Textures and nodes", "Glowing ball, object")
def _glowing_by_object(stage):
    tree = stage.material()
    shown = tree.add("TexChecker", Vector=_on("Object")(tree), Scale=1.7, **_COLOURS)
    stage.world((0.0, 0.0, 0.0))
    stage.tile(stage.paint(), scale=(3.0, 3.0, 3.0))
    stage.camera()
    stage.ball(tree.show(tree.add("Emission", Color=shown, Strength=3.0)))


@_feature("Textures and nodes", "Alpha and metal of an object's own")
def _alpha_by_object(stage):
    tree = stage.material()
    where = tree.add("SeparateXYZ", out=2, Vector=_on("Generated")(tree))
    metal = tree.add("TexNoise", Vector=_on("Object")(tree), Scale=2.0)
    stage.studio(
        tree.show(
            tree.add("BsdfPrincipled", Base_Color=PAINT, Roughness=0.5, Metallic=metal, Alpha=where)
        )
    )


def _tiled_image(numbers, is_packed=False, is_normal=False):
    """Return an image of tiles, each of a size, colours and a contrast of its own."""
    folder = Path(tempfile.mkdtemp())
    for step, number in enumerate(numbers):
        side = 8 << step % 2
        made = image(f"Tile {number}", size=side)
        pixels = np.empty(len(made.pixels), np.float32)
        made.pixels.foreach_get(pixels)
        pixels = pixels.reshape(side, side, 4)
        tone = np.array([0.5 + 0.3 * np.cos(2.1 * step + k) for k in range(3)])
        pixels[..., :3] = 0.4 * pixels[..., :3] + 0.5 * tone
        if is_normal:
            pixels[..., :3] = 0.35 * pixels[..., :3] + 0.65 * np.array([0.5, 0.5, 1.0])
        made.pixels.foreach_set(pixels.ravel())
        made.filepath_raw, made.file_format = str(folder / f"tile.{number}.exr"), "OPEN_EXR"
        made.save()
    tiled = bpy.data.images.load(str(folder / f"tile.{numbers[0]}.exr"))
    tiled.source, tiled.filepath = "TILED", str(folder / "tile.<UDIM>.exr")
    tiled.reload()
    for number in numbers:
        if tiled.tiles.get(number) is None:
            tiled.tiles.new(number)
    if is_normal:
        tiled.colorspace_settings.name = "Non-Color"
    if is_packed:
        tiled.pack()
        shutil.rmtree(folder)
    return tiled


def _on_tiles(make, corners=((0, 0), (2, 2)), numbers=(1001, 1002, 1011, 1012), **how):
    """Show a shader of an image of tiles over a tile. ``make(tree, shown)``: the shader."""

    def build(stage):
        stage.world((1.0, 1.0, 1.0), 0.3)
        stage.light("SUN", energy=3.0, turn=(0.8, 0.0, 0.4))
        tree = stage.material()
        shown = tree.add(
            "TexImage", {"image": _tiled_image(numbers, **how)}, Vector=_on("UV")(tree)
        )
        # Cycles loads the tiles alone in which it finds corners of faces.
        item = stage.grid(tree.show(make(tree, shown)), count=12)
        layer = item.data.uv_layers[0]
        uv = np.empty(2 * len(layer.data), np.float32)
        layer.data.foreach_get("uv", uv)
        (u, v), (p, q) = corners
        layer.data.foreach_set("uv", (uv.reshape(-1, 2) * (p - u, q - v) + (u, v)).ravel())
        stage.above()

    return build


def _matt_tiles(tree, shown):
    return tree.add("BsdfDiffuse", Color=shown)


def _mixed_tiles(tree, shown):
    other = tree.add("TexImage", {"image": image("Other")}, Vector=_on("UV")(tree))
    return _matt_tiles(
        tree, tree.add("MixRGB", {"blend_type": "MULTIPLY"}, Fac=0.8, Color1=shown, Color2=other)
    )


def _bent_tiles(tree, shown):
    normal = tree.add("NormalMap", Color=shown)
    return tree.add("BsdfDiffuse", Color=(0.7, 0.6, 0.5, 1.0), Normal=normal)


for _key, _build in {
    "Image, two tiles (UDIM)": _on_tiles(_matt_tiles, ((0, 0), (2, 1)), (1001, 1002)),
    "Image, tiles and none (UDIM)": _on_tiles(
        _matt_tiles, ((-1.5, -0.4), (2.5, 2.6)), (1001, 1002, 1012)
    ),
    "Image, packed tiles (UDIM)": _on_tiles(_matt_tiles, is_packed=True),
    "Image, tiles times a picture (UDIM)": _on_tiles(_mixed_tiles),
    "Image, tiles as roughness (UDIM)": _on_tiles(
        lambda tree, shown: tree.add(
            "BsdfAnisotropic",
            Color=PAINT,
            Roughness=tree.add("Math", {"operation": "MULTIPLY_ADD"}, _0=shown, _1=0.5, _2=0.5),
        )
    ),
    "Image, tiles that glow (UDIM)": _on_tiles(
        lambda tree, shown: tree.add("Emission", Color=shown)
    ),
    "Image, tiles of normals (UDIM)": _on_tiles(_bent_tiles, is_normal=True),
    "Image, tiles beside noise of the object (UDIM)": _on_tiles(
        lambda tree, shown: _matt_tiles(
            tree,
            tree.add(
                "MixRGB",
                Fac=tree.add("TexNoise", Vector=_on("Object")(tree), Scale=2.0),
                Color1=shown,
                Color2=PAINT,
            ),
        )
    ),
}.items():
    _note("Textures and nodes", _key, _build)


@_feature("Textures and nodes", "Noise on UV beyond its tile")
def _beyond(stage):
    stage.world()
    tree = stage.material()
    stage.tile(tree.owner)
    tree.show(tree.add("BsdfDiffuse", Color=_far_uv(tree)))
    stage.above()


def _crowd(make):
    """Show instances of a tile. ``make(tree)``: the colour's output."""

    def build(stage):
        stage.world()
        tree = stage.material()
        item = stage.tile(tree.show(tree.add("BsdfDiffuse", Color=make(tree))), scale=(0.3,) * 3)
        group = bpy.data.collections.new("Group")
        group.objects.link(item)
        stage.scene.collection.objects.unlink(item)
        for x, y in ((-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)):
            empty = stage.link("Empty", None, location=(x, y, 0.0))
            empty.instance_type, empty.instance_collection = "COLLECTION", group
            empty["tone"] = 0.5 + 0.4 * x
        stage.above()

    return build


for _key, _make in {
    "Random per instance": lambda tree: tree.add("ObjectInfo", out=5),
    "Property of the instancer": lambda tree: tree.add(
        "Attribute", {"attribute_type": "INSTANCER", "attribute_name": "tone"}
    ),
}.items():
    _note("Textures and nodes", _key, _crowd(_make))


@_feature("Textures and nodes", "Property of the object")
def _property(stage):
    stage.world()
    tree = stage.material()
    shown = tree.add("Attribute", {"attribute_type": "OBJECT", "attribute_name": "tone"})
    stage.tile(tree.show(tree.add("BsdfDiffuse", Color=shown)))["tone"] = 0.35
    stage.above()


@_feature("Textures and nodes", "Roughness from a texture")
def _rough_picture(stage):
    tree = stage.material()
    rough = tree.add("TexImage", {"image": image()}, Vector=tree.add("UVMap"))
    stage.studio(tree.show(tree.add("BsdfAnisotropic", Color=PAINT, Roughness=rough)))


@_feature("Textures and nodes", "Emission with a texture")
def _glowing_picture(stage):
    tree = stage.material()
    stage.world((0.0, 0.0, 0.0))
    stage.tile(tree.show(tree.add("Emission", Color=_picture()(tree))))
    stage.above()


# ---- volumes ----


def _volume(kind, **values):
    def build(stage):
        tree = stage.material()
        tree.show(tree.add("BsdfTransparent"))
        tree.show(tree.add(kind, **values), "Volume")
        stage.studio(tree.owner)

    return build


_note("Volumes", "Volume, absorption", _volume("VolumeAbsorption", Density=1.0), True)
_note("Volumes", "Volume, scatter", _volume("VolumeScatter", Density=1.0), True)
_note("Volumes", "Volume, principled", _volume("VolumePrincipled", Density=1.0), True)


def _absorbing(kind, density, **values):
    def build(stage):
        tree = stage.material()
        tree.show(tree.add(kind, **values))
        absorbs = {"Color": (0.3, 0.8, 0.5, 1.0), "Density": density}
        tree.show(tree.add("VolumeAbsorption", **absorbs), "Volume")
        stage.studio(tree.owner)

    return build


for _key, _build in {
    "Glass with absorption": _absorbing("BsdfGlass", 1.0, Roughness=0.0),
    "Glass with much absorption": _absorbing("BsdfGlass", 5.0, Roughness=0.0),
    "Rough glass with absorption": _absorbing("BsdfGlass", 1.0, Roughness=0.3),
    "Principled glass with absorption": _absorbing(
        "BsdfPrincipled",
        1.0,
        Base_Color=(1.0, 1.0, 1.0, 1.0),
        Transmission_Weight=1.0,
        Roughness=0.0,
    ),
}.items():
    _note("Volumes", _key, _build)


# ---- lights ----


def _lit(
    kind, prepare=None, energy=100.0, turn=(0.3, 0.2, 0.0), location=(0.7, -0.7, 2.5), **settings
):
    def build(stage):
        stage.tile(stage.paint(), scale=(3.0, 3.0, 3.0))
        stage.ball(stage.paint((0.7, 0.3, 0.2)))
        stage.camera()
        item = stage.light(kind, location, energy, turn, **settings)
        if prepare is not None:
            prepare(stage, item)

    return build


def _nodes_of_light(item, add):
    data = item.data
    data.use_nodes = True
    tree = data.node_tree
    emission = next(node for node in tree.nodes if node.bl_idname == "ShaderNodeEmission")
    add(tree, emission)


def _constant_falloff(_stage, item):
    def add(tree, emission):
        node = tree.nodes.new("ShaderNodeLightFalloff")
        node.inputs["Strength"].default_value = 0.2
        tree.links.new(node.outputs["Constant"], emission.inputs["Strength"])

    _nodes_of_light(item, add)


def _gobo(_stage, item):
    def add(tree, emission):
        checker = tree.nodes.new("ShaderNodeTexChecker")
        where = tree.nodes.new("ShaderNodeTexCoord")
        tree.links.new(where.outputs["Normal"], checker.inputs["Vector"])
        tree.links.new(checker.outputs[0], emission.inputs["Color"])

    _nodes_of_light(item, add)


def _from_nodes(make, to="Strength"):
    """Return what links nodes to a light's emission. ``make(nodes, links)``: the output."""

    def prepare(_stage, item):
        def add(tree, emission):
            tree.links.new(make(tree.nodes, tree.links), emission.inputs[to])

        _nodes_of_light(item, add)

    return prepare


def _stripes(nodes, links):
    where, part = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeSeparateXYZ")
    wave, high = nodes.new("ShaderNodeMath"), nodes.new("ShaderNodeMath")
    wave.operation, high.operation = "SINE", "MULTIPLY_ADD"
    scaled = nodes.new("ShaderNodeMath")
    scaled.operation, scaled.inputs[1].default_value = "MULTIPLY", 15.0
    links.new(where.outputs["Normal"], part.inputs[0])
    links.new(part.outputs["X"], scaled.inputs[0])
    links.new(scaled.outputs[0], wave.inputs[0])
    links.new(wave.outputs[0], high.inputs[0])
    high.inputs[1].default_value = high.inputs[2].default_value = 0.5
    return high.outputs[0]


def _slide(nodes, links):
    where, shown = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeTexImage")
    grey = nodes.new("ShaderNodeRGBToBW")
    shown.image = image()
    links.new(where.outputs["UV"], shown.inputs["Vector"])
    links.new(shown.outputs["Color"], grey.inputs[0])
    return grey.outputs[0]


def _slide_in_colour(nodes, links):
    where, shown = nodes.new("ShaderNodeTexCoord"), nodes.new("ShaderNodeTexImage")
    shown.image = image()
    links.new(where.outputs["UV"], shown.inputs["Vector"])
    return shown.outputs["Color"]


def _linked(_stage, item):
    group = bpy.data.collections.new("Lit")
    group.objects.link(bpy.data.objects["Ball"])
    item.light_linking.receiver_collection = group


def _shadow_linked(_stage, item):
    group = bpy.data.collections.new("Shading")
    group.objects.link(bpy.data.objects["Tile"])
    item.light_linking.blocker_collection = group


def _with(**settings):
    def prepare(_stage, item):
        for key, value in settings.items():
            setattr(item, key, value)

    return prepare


def _bounces(_stage, item):
    item.data.cycles.max_bounces = 0


for _key, _build in {
    "Point": _lit("POINT", shadow_soft_size=0.0),
    "Point, ball": _lit("POINT", shadow_soft_size=0.2, use_soft_falloff=False),
    "Point, soft falloff 0.5": _lit("POINT", shadow_soft_size=0.5),
    "Spot": _lit("SPOT", energy=300.0, shadow_soft_size=0.05, spot_size=1.0, spot_blend=0.4),
    "Spot, scaled unevenly": _lit(
        "SPOT", _with(scale=(1.0, 2.0, 1.0)), 300.0, shadow_soft_size=0.05, spot_size=1.0
    ),
    "Sun": _lit("SUN", energy=3.0, angle=0.1),
    "Area, square": _lit("AREA", size=1.0),
    "Area, disk": _lit("AREA", shape="DISK", size=1.0),
    "Area, spread": _lit("AREA", size=1.0, spread=1.0),
    "Light, temperature": _lit("AREA", size=1.0, use_temperature=True, temperature=3000.0),
    "Light, exposure": _lit("AREA", size=1.0, exposure=1.0, energy=50.0),
    "Light, not normalised": _lit("AREA", size=1.5, normalize=False, energy=50.0),
    "Light, no shadow": _lit("AREA", size=1.0, use_shadow=False),
    "Light, negative": _lit("AREA", energy=-50.0, size=1.0),
    "Light, no bounces": _lit("AREA", _bounces, size=1.0),
    "Light, diffuse off": _lit("AREA", _with(visible_diffuse=False), size=1.0),
    "Light, constant falloff": _lit("POINT", _constant_falloff, shadow_soft_size=0.0),
    "Light, gobo": _lit("SPOT", _gobo, 300.0, spot_size=1.0, shadow_soft_size=0.0),
    "Light, stripes of a point": _lit("POINT", _from_nodes(_stripes), shadow_soft_size=0.0),
    "Light, slide of a spot": _lit(
        "SPOT", _from_nodes(_slide), 300.0, spot_size=1.2, shadow_soft_size=0.0
    ),
    "Light, slide in colour": _lit(
        "SPOT", _from_nodes(_slide_in_colour, "Color"), 300.0, spot_size=1.2, shadow_soft_size=0.0
    ),
    "Light, slide of a scaled spot": _lit(
        "SPOT",
        lambda stage, item: (_from_nodes(_stripes)(stage, item), setattr(item, "scale", (1, 2, 1))),
        300.0,
        spot_size=1.0,
        shadow_soft_size=0.05,
    ),
    "Light linking": _lit("AREA", _linked, size=1.0),
    "Shadow linking": _lit("AREA", _shadow_linked, size=1.0),
}.items():
    _note("Lights", _key, _build)


# ---- worlds ----


def _outside(make, colour=(0.7, 0.3, 0.2)):
    """Show a ball of a colour in a world. ``make(tree, vector)``: the shader."""

    def build(stage):
        tree = stage.world()
        tree.show(make(tree, tree.add("TexCoord")))
        stage.tile(stage.paint(), scale=(3.0, 3.0, 3.0))
        stage.ball(stage.paint(colour))
        stage.camera()

    return build


def _map(tree, vector, **attributes):
    return tree.add("TexEnvironment", {"image": panorama(), **attributes}, Vector=vector)


def _turned(tree, vector, **settings):
    return tree.add("Mapping", Vector=vector, **settings)


def _sky(tree, vector=None, **attributes):
    inputs = {} if vector is None else {"Vector": vector}
    return tree.add("TexSky", attributes, **inputs)


def _background(tree, colour, strength=1.0):
    return tree.add("Background", Color=colour, Strength=strength)


BLUE, BROWN = (0.2, 0.4, 1.0, 1.0), (0.3, 0.2, 0.1, 1.0)


def _ramp(tree, vector):
    height = tree.add("SeparateXYZ", out=2, Vector=vector)
    factor = tree.add("MapRange", Value=height, _1=-1.0)
    return tree.add(
        "MixShader", Fac=factor, _1=_background(tree, BROWN), _2=_background(tree, BLUE)
    )


for _key, _make in {
    "World, colour": lambda tree, _: _background(tree, BLUE),
    "World, picture": lambda tree, v: _background(tree, _map(tree, v)),
    "World, turned": lambda tree, v: _background(
        tree, _map(tree, _turned(tree, v, Rotation=(0.3, 0.2, 0.9)))
    ),
    "World, scaled": lambda tree, v: _background(
        tree, _map(tree, _turned(tree, v, Scale=(1.0, 2.0, 0.7)))
    ),
    "World, mirror ball": lambda tree, v: _background(
        tree, _map(tree, v, projection="MIRROR_BALL")
    ),
    "World, multiplied": lambda tree, v: _background(
        tree,
        tree.add("MixRGB", {"blend_type": "MULTIPLY"}, Fac=1.0, Color1=_map(tree, v), Color2=BLUE),
    ),
    "World, two backgrounds": lambda tree, v: tree.add(
        "MixShader", Fac=0.4, _1=_background(tree, _map(tree, v)), _2=_background(tree, BLUE)
    ),
    "World, camera only": lambda tree, v: tree.add(
        "MixShader",
        Fac=tree.add("LightPath"),
        _1=_background(tree, _map(tree, v)),
        _2=_background(tree, BLUE),
    ),
    "World, ramp": _ramp,
    "World, Sky Texture": lambda tree, _: _background(tree, _sky(tree)),
    "World, Sky Texture, no sun": lambda tree, _: _background(tree, _sky(tree, sun_disc=False)),
    "World, Sky Texture, wide sun": lambda tree, _: _background(
        tree, _sky(tree, sun_elevation=0.8, sun_size=0.2, sun_intensity=0.5, sun_rotation=0.5), 0.1
    ),
    "World, Sky Texture, high and dusty": lambda tree, _: _background(
        tree, _sky(tree, altitude=5000.0, air_density=0.5, aerosol_density=5.0, ozone_density=3.0)
    ),
    "World, Sky Texture, single scattering": lambda tree, _: _background(
        tree, _sky(tree, sky_type="SINGLE_SCATTERING", sun_elevation=0.5, sun_rotation=4.0)
    ),
    "World, Sky Texture, Preetham": lambda tree, _: _background(
        tree, _sky(tree, sky_type="PREETHAM", sun_direction=(0.5, -0.4, 0.6), turbidity=4.0)
    ),
    "World, Sky Texture, Hosek and Wilkie": lambda tree, _: _background(
        tree, _sky(tree, sky_type="HOSEK_WILKIE", sun_direction=(0.5, -0.4, 0.6), turbidity=3.5)
    ),
    "World, Sky Texture, turned": lambda tree, v: _background(
        tree, _sky(tree, _turned(tree, v, Rotation=(0.3, 0.2, 0.9)), sun_disc=False)
    ),
    "World, Sky Texture, mixed": lambda tree, v: tree.add(
        "MixShader",
        Fac=0.4,
        _1=_background(tree, tree.add("Gamma", Color=_sky(tree, sun_size=0.05), Gamma=0.8)),
        _2=_background(tree, _map(tree, v)),
    ),
}.items():
    _note("Worlds", _key, _outside(_make))


@_feature("Worlds", "World, Sky Texture, sun in view")
def _sunny(stage):
    settings = {"sun_elevation": 0.5, "sun_size": 0.2, "sun_rotation": 0.1}
    _outside(lambda tree, _: _background(tree, _sky(tree, **settings), 0.1))(stage)
    stage.scene.camera.rotation_euler = (0.5 * np.pi + 0.45, 0.0, 0.0)


# Its red light on a red ball would compare spectra with three numbers.
_note(
    "Worlds",
    "World, Sky Texture, low sun",
    _outside(
        lambda tree, _: _background(tree, _sky(tree, sun_elevation=0.03, sun_rotation=2.5)),
        colour=(0.5, 0.5, 0.5),
    ),
)


def _world_rays(**settings):
    def build(stage):
        _outside(lambda tree, v: _background(tree, _map(tree, v)))(stage)
        stage.light("AREA", (1.5, -1.5, 3.5), 100.0, (0.5, 0.35, 0.0), size=1.5)
        for key, value in settings.items():
            setattr(stage.scene.world.cycles_visibility, key, value)

    return build


_note("Worlds", "World, not for diffuse rays", _world_rays(diffuse=False))
_note("Worlds", "World, not for the camera", _world_rays(camera=False))
_note(
    "Worlds",
    "World, for the camera alone",
    _world_rays(diffuse=False, glossy=False, transmission=False),
)


@_feature("Worlds", "World, camera only, transparent film")
def _holed(stage):
    _outside(lambda tree, v: _background(tree, _map(tree, v)))(stage)
    stage.scene.world.cycles_visibility.camera = False
    stage.scene.render.film_transparent = True


@_feature("Worlds", "World, backdrop behind glass")
def _behind_glass(stage):
    _outside(
        lambda tree, v: tree.add(
            "MixShader",
            Fac=tree.add("LightPath"),
            _1=_background(tree, _map(tree, v)),
            _2=_background(tree, BLUE),
        )
    )(stage)
    tree = stage.material()
    tree.show(tree.add("BsdfGlass", Roughness=0.0))
    bpy.data.objects["Ball"].data.materials[0] = tree.owner


# ---- objects ----


def _object(**settings):
    def build(stage):
        ball = stage.studio()
        for key, value in settings.items():
            setattr(ball, key, value)

    return build


for _key, _settings in {
    "Object, not for the camera": {"visible_camera": False},
    "Object, not for diffuse rays": {"visible_diffuse": False},
    "Object, not for glossy rays": {"visible_glossy": False},
    "Object, no shadow": {"visible_shadow": False},
    "Object, for the camera alone": {
        "visible_diffuse": False,
        "visible_glossy": False,
        "visible_transmission": False,
        "visible_shadow": False,
        "visible_volume_scatter": False,
    },
    "Object, holdout": {"is_holdout": True},
    "Object, shadow catcher": {"is_shadow_catcher": True},
}.items():
    _note("Objects", _key, _object(**_settings))


@_feature("Objects", "Instances of a collection")
def _instances(stage):
    ball = stage.studio()
    group = bpy.data.collections.new("Group")
    group.objects.link(ball)
    stage.scene.collection.objects.unlink(ball)
    for x in (-1.0, 1.0):
        empty = stage.link("Empty", None, location=(x, 0.0, 0.0), scale=(0.7, 0.7, 0.7))
        empty.instance_type, empty.instance_collection = "COLLECTION", group


@_feature("Objects", "Text")
def _text(stage):
    stage.studio()
    data = bpy.data.curves.new("Text", "FONT")
    data.body, data.extrude = "Lux", 0.1
    data.materials.append(stage.paint((0.2, 0.3, 0.7)))
    stage.link("Text", data, location=(-1.2, -1.5, 0.0), rotation_euler=(1.2, 0.0, 0.0))


@_feature("Objects", "Metaball")
def _meta(stage):
    stage.studio()
    data = bpy.data.metaballs.new("Meta")
    data.elements.new().co = (0.0, 0.0, 0.0)
    data.materials.append(stage.paint((0.2, 0.3, 0.7)))
    stage.link("Meta", data, location=(-1.2, -1.0, 0.5), scale=(0.5, 0.5, 0.5))


def _curves(shape="RIBBONS", count=60, radius=0.02, is_bent=False):
    def build(stage):
        stage.studio()
        stage.scene.cycles_curves.shape = shape
        data = bpy.data.hair_curves.new("Hair")
        data.add_curves([4] * count)
        random = np.random.default_rng(2)
        roots = random.uniform(-1.0, 1.0, (count, 2))
        bend = 0.15 if is_bent else 0.0
        points = [(x + bend * k * k, y - 1.0, 0.3 * k) for x, y in roots for k in range(4)]
        places = np.array(points, np.float32).ravel()
        data.attributes["position"].data.foreach_set("vector", places)
        if radius:
            values = data.attributes.new("radius", "FLOAT", "POINT").data
            values.foreach_set("value", [radius] * 4 * count)
        data.materials.append(stage.paint((0.5, 0.3, 0.1)))
        stage.link("Hair", data)

    return build


def _fur(**settings):
    def build(stage):
        ball = stage.studio()
        ball.modifiers.new("Fur", "PARTICLE_SYSTEM")
        made = ball.particle_systems[0].settings
        made.type, made.count, made.hair_length, made.material = "HAIR", 300, 0.4, 1
        made.root_radius, made.radius_scale, made.render_step = 1.0, 0.03, 3
        for key, value in settings.items():
            setattr(made, key, value)

    return build


def _points(radius=0.06):
    def build(stage):
        stage.studio()
        random = np.random.default_rng(2)
        corners = random.uniform((-1.5, -2.0, 0.1), (1.5, 0.0, 1.2), (200, 3))
        item = stage.mesh("Points", corners.tolist(), [])
        tree = bpy.data.node_groups.new("Points", "GeometryNodeTree")
        tree.interface.new_socket("Geometry", in_out="INPUT", socket_type="NodeSocketGeometry")
        tree.interface.new_socket("Geometry", in_out="OUTPUT", socket_type="NodeSocketGeometry")
        kinds = ("NodeGroupInput", "GeometryNodeMeshToPoints", "NodeGroupOutput")
        first, made, last = (tree.nodes.new(kind) for kind in kinds)
        made.inputs["Radius"].default_value = radius
        paint = tree.nodes.new("GeometryNodeSetMaterial")
        paint.inputs["Material"].default_value = stage.paint((0.2, 0.3, 0.7))
        for before, after in ((first, made), (made, paint), (paint, last)):
            tree.links.new(before.outputs[0], after.inputs[0])
        item.modifiers.new("Points", "NODES").node_group = tree

    return build


for _key, _build in {
    "Hair curves": _curves(),
    "Hair curves, 3D": _curves("THICK"),
    "Hair curves, thick": _curves("THICK", 30, 0.08),
    "Hair curves, many and thin": _curves("THICK", 3000, 0.003),
    "Hair curves, without radii": _curves(radius=0.0, count=600),
    "Hair curves, bent": _curves("THICK", is_bent=True),
    "Hair curves, linear": _curves("THICK_LINEAR", is_bent=True),
    "Particle hair": _fur(),
    "Particle hair, shape": _fur(shape=-0.5, tip_radius=0.5, use_close_tip=False),
    "Particle hair, children": _fur(
        count=60, child_type="INTERPOLATED", rendered_child_count=8, child_percent=8
    ),
    "Particle hair, simple children": _fur(
        count=60, child_type="SIMPLE", rendered_child_count=8, child_percent=8
    ),
    "Points": _points(),
}.items():
    _note("Objects", _key, _build)


@_feature("Objects", "Driven light, frame 10")
def _driven(stage):
    stage.studio()
    stage.scene.frame_set(10)
    data = next(each.data for each in stage.scene.objects if each.type == "LIGHT")
    data.driver_add("energy").driver.expression = "20 * frame"
    stage.scene.frame_set(10)


@_feature("Objects", "Keyframed colour, frame 10")
def _keyframed(stage):
    tree = stage.material()
    shader = tree.add("BsdfDiffuse")
    colour = shader.node.inputs["Color"]
    for frame, value in ((1, 0.1), (19, 0.9)):
        colour.default_value = (value, 0.4, 0.2, 1.0)
        colour.keyframe_insert("default_value", frame=frame)
    stage.studio(tree.show(shader))
    stage.scene.frame_set(10)


# ---- camera and film ----


def _seen(before=None, turn=(1.25, 0.0, 0.0), **settings):
    def build(stage):
        stage.studio()
        bpy.data.objects.remove(stage.scene.camera)
        item = stage.camera(turn=turn)
        for path, value in settings.items():
            holder, name = item.data, path
            if "__" in path:
                part, name = path.split("__")
                holder = getattr(item.data, part)
            if not hasattr(holder, name) and hasattr(item.data, "cycles"):
                # Before Blender 5 panoramas were Cycles' own.
                holder = item.data.cycles
            setattr(holder, name, value)
        if before is not None:
            before(stage.scene)

    return build


def _of_scene(**settings):
    def prepare(scene):
        for path, value in settings.items():
            *steps, name = path.split("__")
            holder = scene
            for step in steps:
                holder = getattr(holder, step)
            setattr(holder, name, value)

    return prepare


_FOCUS = {"dof__use_dof": True, "dof__focus_distance": 3.0, "dof__aperture_fstop": 0.15}

for _key, _build in {
    "Camera, shift": _seen(shift_x=0.2, shift_y=-0.1),
    "Camera, orthographic": _seen(type="ORTHO", ortho_scale=4.0),
    "Camera, equirectangular": _seen(type="PANO", panorama_type="EQUIRECTANGULAR"),
    "Camera, fisheye equidistant": _seen(type="PANO", panorama_type="FISHEYE_EQUIDISTANT"),
    "Camera, fisheye equisolid": _seen(
        type="PANO", panorama_type="FISHEYE_EQUISOLID", fisheye_lens=10.5
    ),
    "Camera, depth of field": _seen(**_FOCUS),
    "Camera, blades": _seen(dof__aperture_blades=3, **_FOCUS),
    "Camera, aperture ratio": _seen(dof__aperture_ratio=2.0, **_FOCUS),
    "Camera, clip start": _seen(clip_start=4.5),
    "Camera, clip end": _seen(clip_end=5.5),
    "Film, region": _seen(
        _of_scene(
            render__use_border=True,
            render__border_min_x=0.2,
            render__border_max_x=0.7,
            render__border_min_y=0.1,
            render__border_max_y=0.9,
        )
    ),
    "Film, exposure of Cycles": _seen(_of_scene(cycles__film_exposure=2.0)),
    "Film, transparent": _seen(_of_scene(render__film_transparent=True), turn=(1.45, 0.0, 0.0)),
    "Film, stereo": _seen(_of_scene(render__use_multiview=True)),
}.items():
    _note("Camera and film", _key, _build)


def _moving(of):
    def build(stage):
        ball = stage.studio()
        item = ball if of == "object" else stage.scene.camera
        for frame, x in ((0, -0.5), (2, 0.5)):
            item.location.x = x
            item.keyframe_insert("location", frame=frame)
        stage.scene.frame_set(1)
        stage.scene.render.use_motion_blur = True

    return build


_note("Camera and film", "Motion blur, object", _moving("object"))
_note("Camera and film", "Motion blur, camera", _moving("camera"))


def _blurred(move, **settings):
    """A studio in which something moves meanwhile; ``move(stage, ball)`` returns what, its data path and ends."""

    def build(stage):
        ball = stage.studio()
        owner, path, ends = move(stage, ball)
        for frame, value in zip((0, 2), ends, strict=True):
            setattr(owner, path, value)
            owner.keyframe_insert(path, frame=frame)
        stage.scene.frame_set(1)
        stage.scene.render.use_motion_blur = True
        stage.scene.render.motion_blur_shutter = 1.0
        _of_scene(**settings)(stage.scene)

    return build


def _pushed(_stage, ball):
    return ball, "location", ((-0.8, 0.0, 0.8), (0.8, 0.0, 0.8))


def _kept_sharp(stage, ball):
    ball.cycles.use_motion_blur = False
    return _pushed(stage, ball)


def _squeezed(_stage, ball):
    ball.shape_key_add(name="Basis")
    key = ball.shape_key_add(name="Wide")
    for point in key.data:
        point.co.x *= 1.8
    return key, "value", (0.0, 1.0)


def _lamp_pushed(_stage, _ball):
    lamp = bpy.data.objects["Light"]
    return lamp, "location", ((-1.5, -1.5, 3.5), (3.5, -1.5, 3.5))


for _key, (_move, _settings) in {
    "Motion blur, from the frame on": (_pushed, {"render__motion_blur_position": "START"}),
    "Motion blur, up to the frame": (_pushed, {"render__motion_blur_position": "END"}),
    "Motion blur, object kept sharp": (_kept_sharp, {"render__motion_blur_position": "START"}),
    "Motion blur, shape": (_squeezed, {}),
    "Motion blur, light": (_lamp_pushed, {"render__motion_blur_position": "START"}),
    "Motion blur, rolling shutter": (_pushed, {"cycles__rolling_shutter_type": "TOP"}),
}.items():
    _note("Camera and film", _key, _blurred(_move, **_settings))


@_feature("Camera and film", "Motion blur, shutter curve")
def _opened_slowly(stage):
    _blurred(_pushed)(stage)
    points = stage.scene.render.motion_blur_shutter_curve.curves[0].points
    points[0].location, points[1].location = (0.0, 0.0), (1.0, 1.0)
    for point in points:
        point.handle_type = "VECTOR"
    stage.scene.render.motion_blur_shutter_curve.update()


# ---- view layers ----


@_feature("View layers", "Material override")
def _clay(stage):
    stage.studio()
    stage.scene.view_layers[0].material_override = stage.paint((0.4, 0.4, 0.7))


@_feature("View layers", "World override")
def _other_world(stage):
    stage.studio()
    layer, world = stage.scene.view_layers[0], stage.scene.world
    stage.world((0.9, 0.4, 0.1), 0.8)
    if hasattr(layer, "world_override"):
        layer.world_override, stage.scene.world = stage.scene.world, world


@_feature("View layers", "Without the world")
def _no_sky(stage):
    stage.studio()
    stage.scene.view_layers[0].use_sky = False


def _collected(stage, **settings):
    ball = stage.studio()
    group = bpy.data.collections.new("Group")
    stage.scene.collection.children.link(group)
    group.objects.link(ball)
    stage.scene.collection.objects.unlink(ball)
    layer = stage.scene.view_layers[0].layer_collection.children["Group"]
    for key, value in settings.items():
        setattr(layer, key, value)


for _film in (False, True):

    def _held(stage, film=_film):
        stage.studio().is_holdout = True
        stage.scene.render.film_transparent = film

    _note("Objects", f"Object, holdout, {'transparent' if _film else 'plain'} film", _held)

    def _caught(stage, film=_film):
        stage.studio()
        stage.scene.objects["Tile"].is_shadow_catcher = True
        stage.scene.render.film_transparent = film

    _note("Objects", f"Shadow catcher, {'transparent' if _film else 'plain'} film", _caught)


def _by_camera(first, second):
    """Show one shader to the camera and another to light, on ball and floor."""

    def build(stage):
        materials = []
        for colours in (first, second):
            tree = stage.material()
            lit, seen = (tree.add(kind, **values) for kind, values in colours)
            factor = tree.add("LightPath")
            materials.append(tree.show(tree.add("MixShader", Fac=factor, _1=lit, _2=seen)))
        stage.studio(*materials)

    return build


_RED, _GREY = {"Color": PAINT}, {"Color": (0.6, 0.6, 0.6, 1.0)}
_note(
    "Surfaces",
    "Mix by Is Camera Ray",
    _by_camera(
        [("BsdfDiffuse", _RED), ("BsdfAnisotropic", {"Roughness": 0.3, **_GREY})],
        [("BsdfDiffuse", {"Color": (0.1, 0.2, 0.8, 1.0)}), ("BsdfDiffuse", _GREY)],
    ),
)
_note(
    "Surfaces",
    "Emission for the camera alone",
    _by_camera(
        [("BsdfDiffuse", _RED), ("Emission", {"Strength": 1.0})],
        [("BsdfDiffuse", _GREY), ("BsdfDiffuse", _GREY)],
    ),
)
_note(
    "Surfaces",
    "Emission, dim to the camera",
    _by_camera(
        [("Emission", {"Strength": 5.0}), ("Emission", {"Strength": 0.5})],
        [("BsdfDiffuse", _GREY), ("BsdfDiffuse", _GREY)],
    ),
)
_note(
    "Surfaces",
    "Transparent to the camera",
    _by_camera(
        [("BsdfDiffuse", _RED), ("BsdfTransparent", {})],
        [("BsdfDiffuse", _GREY), ("BsdfDiffuse", _GREY)],
    ),
)
_note("View layers", "Collection, indirect only", lambda s: _collected(s, indirect_only=True))
_note("View layers", "Collection, holdout", lambda s: _collected(s, holdout=True))
