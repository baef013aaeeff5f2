"""Scenes as other programs can state them too: neutral, matt, flat, lights by their photometry."""

from dataclasses import replace

import numpy as np

from ...engine.photometry.spectra import GRID, evaluate_reflectance, luminous_efficiency
from ...engine.scene.light import AreaLight, CieSky, Quantity, UniformWorld
from ...engine.scene.material import (
    Black,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Emission,
    Glossy,
    Material,
    Mix,
    TabulatedPane,
    ThinGlass,
    Transparent,
)
from ...engine.scene.mesh import Geometry, Mesh
from ...engine.scene.scene import Item, Scene, SceneDelta
from ...engine.scene.spectrum import Constant, Rgb
from ...engine.scene.texture import ImageTexture
from ..common.pieces import make_mesh, quad
from .scenes import AtlasScene

METAL = 0.6
"""Reflectance that stands for metals. [-]"""

SOLID_GLASS = 0.85
"""Transmittance of a face that stands for solid glass, straight on. [-]"""

THICKNESS = 0.001
"""Of a face that glows. [m]"""

BACK = "back of lamp"
"""Material of it."""

RELATIVE_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Of the primaries of Rec. 709 (ITU-R BT.709). [-]"""


def make_plain(scene: AtlasScene) -> AtlasScene:
    """Return a variant without colours, gloss, pictures and smooth normals.

    Geometry and lights stay, but lights with an area are black faces that glow: the engine's and Cycles' area lights let the
    light of others pass, and Radiance's do not.
    """
    # Pictures have their pixels in a scene only.
    held = Scene()
    held.apply(SceneDelta(changed=scene.items))
    items = [
        *(_plain_material(item) for item in held.materials.values()),
        *(_flat(item) for item in held.geometries.values()),
        *(_flat(item) for item in held.meshes.values()),
        *(each for item in held.lights.values() for each in _plain_lights(item)),
    ]
    if held.world is not None:
        items.append(_plain_world(held.world))
    return replace(scene, items=tuple({item.id: item for item in items}.values()))


def _flat(item: Item) -> Item:
    is_mesh = isinstance(item, Geometry | Mesh)
    return replace(item, corner_normals=None, uv_maps={}) if is_mesh else item


def _plain_lights(light) -> list:
    """A light as it is stated to all: itself, or a face and its material."""
    is_face = isinstance(light, AreaLight) and light.shape == "rectangle"
    if not is_face or light.output.quantity is not Quantity.LUMINOUS_FLUX:
        return [replace(light, output=replace(light.output, spectrum=Constant(1.0)))]
    frame = np.asarray(light.frame, dtype=np.float64)
    x, y = frame[:3, 0] * light.size_x, frame[:3, 1] * light.size_y
    # It shines along -z, so the face runs the other way round; its back is no inside of a solid.
    corner = frame[:3, 3] - 0.5 * (x + y)
    back = make_mesh(f"{light.id} back", [quad(corner + THICKNESS * frame[:3, 2], x, y)], BACK)
    key = f"{light.id} glow"
    luminance = light.output.value / (np.pi * light.size_x * light.size_y)
    glow = Material(key, light.name, Black(), Emission(luminance=luminance, two_sided=False))
    return [
        make_mesh(f"{light.id} face", [quad(corner, y, x)], key),
        back,
        glow,
        Material(BACK, BACK, Black()),
    ]


def _plain_world(world):
    assert isinstance(world, UniformWorld | CieSky)
    return replace(world, spectrum=Constant(1.0))


def _plain_material(material: Material) -> Material:
    emission = material.emission
    if emission is not None:
        level = emission.luminance * (1.0 if emission.pattern is None else _mean(emission.pattern))
        emission = Emission(luminance=level, two_sided=False)
        return replace(material, surface=Black(), emission=emission)
    return replace(material, surface=_plain_surface(material.surface))


def _plain_surface(surface):
    match surface:
        case Diffuse():
            through = surface.transmittance
            return Diffuse(
                Constant(_luminous(surface.reflectance)),
                None if through is None else Constant(_luminous(through)),
            )
        case Coated() | Glossy():
            return Diffuse(Constant(_luminous(surface.reflectance)))
        case Conductor():
            return Diffuse(Constant(METAL))
        case Dielectric():
            return Transparent(Constant(SOLID_GLASS))
        case ThinGlass():
            return replace(surface, transmittance=Constant(_luminous(surface.transmittance)))
        case Transparent():
            return Transparent(Constant(_luminous(surface.transmittance)))
        case Mix():
            parts = [_plain_surface(part) for part in (surface.first, surface.second)]
            matt = [part for part in parts if isinstance(part, Diffuse)]
            return matt[-1] if matt else parts[0]
        case TabulatedPane() | Black():
            return surface
    raise AssertionError(surface)


def _luminous(value) -> float:
    """Share of equal-energy light. [-]"""
    match value:
        case Constant():
            return float(value.value)
        case Rgb():
            return float(np.dot(RELATIVE_LUMINANCE, (value.red, value.green, value.blue)))
        case ImageTexture():
            return _mean(value)
    weight = luminous_efficiency()
    return float(weight @ evaluate_reflectance(value, GRID) / weight.sum())


def _mean(picture: ImageTexture) -> float:
    """Mean relative luminance of a picture. [-]"""
    pixels = np.asarray(picture.pixels, dtype=np.float64)
    means = pixels.reshape(-1, pixels.shape[-1]).mean(axis=0)
    return float(means @ RELATIVE_LUMINANCE) if len(means) >= 3 else float(means[0])
