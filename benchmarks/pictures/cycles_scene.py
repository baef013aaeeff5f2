"""Scenes of pictures as plain data for Blender's process, in lumens for watts and in Rec. 709 for spectra."""

import numpy as np

from ...engine.formats.gltf_colour import flatten
from ...engine.photometry.colour import REC709_LUMINANCE, XYZ_TO_REC709
from ...engine.photometry.spectra import GRID, evaluate_emission, observer
from ...engine.scene.camera import Camera, Projection
from ...engine.scene.material import (
    Black,
    Cauchy,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Glossy,
    Material,
    TabulatedPane,
    ThinGlass,
    Transparent,
)
from ...engine.scene.scene import Scene, SceneDelta
from ...engine.scene.texture import ImageTexture
from ...validation.bench import CannotStateError
from ...validation.peers.contents import Contents, Part
from ...validation.peers.cycles_scene import describe as describe_plain

PANES = (ThinGlass, TabulatedPane, Transparent)
"""Surfaces that are stated as in the validation suite, which also marks them as portals of daylight."""


def describe(items: tuple, camera: Camera) -> dict:
    """Describe a scene and its camera.

    Raises
    ------
    CannotStateError    Cycles has nothing for a part of it.
    """
    held = Scene()
    held.apply(SceneDelta(changed=items))
    meshes, panes = [], []
    for key in held.meshes:
        mesh = held.mesh(key)
        slots = np.minimum(mesh.material_index, len(mesh.materials) - 1)
        for slot in np.unique(slots):
            material, chosen = held.materials[mesh.materials[slot]], slots == slot
            if isinstance(material.surface, PANES):
                panes.append(Part(mesh.vertices, mesh.triangles[chosen], material))
            else:
                meshes.append(_describe_mesh(mesh, chosen, material))
    lights = list(held.lights.values())
    request = describe_plain(Contents(panes, lights, held.world), np.zeros(3), 1.0)
    for entry, light in zip(request["lights"], lights, strict=False):
        entry["tint"] = find_tint(light.output.spectrum)
        entry["is_seen"] = getattr(light, "visible_to_camera", False)
    if held.world is not None:
        request["world"]["tint"] = find_tint(held.world.spectrum)
    return request | {"textured": meshes, "camera": _describe_camera(camera)}


def find_tint(spectrum) -> tuple[float, float, float]:
    """Linear Rec. 709 of luminance 1 of a light."""
    tristimulus = evaluate_emission(spectrum, GRID) @ observer()
    colour = np.maximum(XYZ_TO_REC709 @ (tristimulus / tristimulus[1]), 0.0)
    return tuple(float(part) for part in colour / (colour @ REC709_LUMINANCE))


def _describe_mesh(mesh, chosen: np.ndarray, material: Material) -> dict:
    used, triangles = np.unique(mesh.triangles[chosen], return_inverse=True)
    entry = _describe_material(material)
    uv = None
    if "image" in entry:
        name = entry["image"].pop("uv_map") or next(iter(mesh.uv_maps))
        uv = mesh.uv_maps[name][chosen]
    normals = mesh.corner_normals
    return {
        "vertices": mesh.vertices[used],
        "triangles": triangles.reshape(-1, 3),
        "normals": None if normals is None else normals[chosen],
        "uv": uv,
        "material": entry,
        "is_seen": mesh.visible_to_camera,
    }


def _describe_material(material: Material) -> dict:
    surface, flat = material.surface, flatten(material)
    glow = material.emission
    entry = {
        "emitted": tuple(map(float, flat.emitted)),
        "colour": tuple(map(float, flat.reflected)),
    }
    if glow is not None:
        entry["two_sided"] = glow.two_sided
    reflectance = getattr(surface, "reflectance", None)
    if isinstance(reflectance, ImageTexture):
        entry["image"] = _describe_image(reflectance)
    match surface:
        case Black():
            return entry | {"kind": "diffuse"}
        case Diffuse() if surface.transmittance is None:
            return entry | {"kind": "diffuse"}
        case Coated():
            shape = {"ior": surface.ior, "roughness": surface.roughness}
            return entry | {"kind": "coated", "specular": surface.specular} | shape
        case Glossy() | Conductor() if not isinstance(surface.roughness, ImageTexture):
            roughness = 0.0 if surface.is_mirror else surface.roughness
            return entry | {"kind": "glossy", "roughness": roughness}
        case Dielectric() if isinstance(surface.ior, Cauchy) and surface.ior.b == 0.0:
            tint = flatten(Material("", "", Diffuse(surface.tint))).reflected
            shape = {"ior": surface.ior.a, "roughness": surface.roughness}
            return entry | {"kind": "dielectric", "tint": tuple(map(float, tint))} | shape
    raise CannotStateError(f"{type(surface).__name__} of '{material.name}' is not translated")


def _describe_image(image: ImageTexture) -> dict:
    if image.extension != "repeat" or not np.array_equal(image.transform, np.eye(3)):
        raise CannotStateError("pictures that are moved or end at their edges are not translated")
    pixels = np.broadcast_to(image.pixels, (*image.pixels.shape[:2], 3))
    return {
        "pixels": np.ascontiguousarray(pixels, dtype=np.float32),
        "uv_map": image.uv_map,
        "interpolation": image.interpolation.capitalize(),
    }


def _describe_camera(camera: Camera) -> dict:
    if camera.projection is not Projection.PERSPECTIVE or camera.aperture_radius > 0.0:
        raise CannotStateError("only pinholes with a flat film are translated")
    return {
        "frame": np.asarray(camera.frame, dtype=np.float64),
        "size": (camera.width, camera.height),
        "extent": camera.extent_x,
        # Of the wider side, as Blender counts them.
        "shift": (camera.shift_x / camera.extent_x, camera.shift_y / camera.extent_x),
        "clip": max(camera.clip_start, 1e-3),
    }
