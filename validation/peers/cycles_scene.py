"""Scenes as plain data for `blender_server`, in lumens for watts."""

import numpy as np

from lumenray.engine.luminaires.distribution import flux, intensity
from lumenray.engine.scene.light import (
    AreaLight,
    CieSky,
    Luminaire,
    PointLight,
    SpotLight,
    SunLight,
    UniformWorld,
)
from lumenray.engine.scene.material import (
    Black,
    Diffuse,
    Glossy,
    TabulatedPane,
    ThinGlass,
    Transparent,
)

from ..bench import CannotStateError
from .contents import (
    Contents,
    Face,
    Part,
    area_luminance,
    candelas,
    luminaire_flux,
    neutral_value,
    sun_illuminance,
)
from .skies import OVERCAST, PARAMETERS, ground_luminance, luminance_scale, unit_sun

MOST_PORTALS = 64
"""Faces of a pane that are still marked as portals."""

IES_EFFICACY = 177.83
"""What Cycles' node for photometric files divides candelas by. [lm/W]"""

SHARPEST = 1e-3
"""Angular diameter below which mirrored light cannot be found by chance. [rad]"""


def describe(contents: Contents, middle: np.ndarray, unit: float) -> dict:
    """Describe meshes, lights and world, in lengths of ``unit`` about ``middle``.

    Raises
    ------
    CannotStateError    Cycles has nothing for a part of it.
    """
    meshes, portals = [], []
    for part in contents.parts:
        moved = Part((part.vertices - middle) / unit, part.triangles, part.material)
        entry = _material(part.material)
        if entry is not None:
            used, triangles = np.unique(moved.triangles, return_inverse=True)
            meshes.append(
                {
                    "vertices": moved.vertices[used],
                    "triangles": triangles.reshape(-1, 3),
                    "material": entry,
                }
            )
        is_pane = isinstance(part.material.surface, Transparent | ThinGlass | TabulatedPane)
        if is_pane and contents.world is not None and len(part.triangles) <= MOST_PORTALS:
            portals += [entry for face in moved.faces() for entry in _portals(face)]
    lights = [_light(light, middle, unit) for light in contents.lights]
    _check_mirrors(contents)
    return {"meshes": meshes, "lights": lights + portals, "world": _world(contents.world)}


def _check_mirrors(contents: Contents) -> None:
    """Refuse mirrors with lights that a ray cannot meet."""
    if not any(isinstance(part.material.surface, Glossy) for part in contents.parts):
        return
    for light in contents.lights:
        is_ideal = isinstance(light, PointLight | SpotLight) and light.radius == 0.0
        if is_ideal or (isinstance(light, SunLight) and light.angle < SHARPEST):
            raise CannotStateError("Cycles' paths cannot meet ideal points in ideal mirrors")


def _material(material) -> dict | None:
    """Description of a material, None where nothing is there."""
    surface, emission = material.surface, material.emission
    glow = {"luminance": 0.0, "two_sided": False}
    if emission is not None:
        if emission.pattern is not None:
            raise CannotStateError("patterns of emission are not translated")
        glow = {"luminance": emission.luminance, "two_sided": emission.two_sided}
    match surface:
        case Black():
            entry = {"kind": "diffuse", "reflectance": 0.0, "transmittance": 0.0}
        case Diffuse():
            entry = {
                "kind": "diffuse",
                "reflectance": neutral_value(surface.reflectance),
                "transmittance": neutral_value(surface.transmittance),
            }
        case Glossy() if surface.roughness == 0.0:
            entry = {"kind": "mirror", "reflectance": neutral_value(surface.reflectance)}
        case ThinGlass():
            entry = {
                "kind": "glass",
                "ior": surface.ior,
                "transmittance": neutral_value(surface.transmittance),
            }
        case TabulatedPane():
            entry = {
                "kind": "table",
                "angles": surface.angles,
                "through": surface.transmittance,
                "back": surface.reflectance,
            }
        case Transparent():
            value = neutral_value(surface.transmittance)
            if value == 1.0 and emission is None:
                return None
            level = np.full(2, value)
            entry = {
                "kind": "table",
                "angles": np.array([0.0, 90.0]),
                "through": level,
                "back": 0.0 * level,
            }
        case _:
            raise CannotStateError(f"{type(surface).__name__} of Cycles is another model")
    return entry | glow


def _portals(face: Face) -> list[dict]:
    """Portals of a rectangle, one for each side; none for other shapes."""
    if len(face.corners) != 4:
        return []
    u, v = face.corners[1] - face.corners[0], face.corners[3] - face.corners[0]
    if abs(np.dot(u, v)) > 1e-6 * np.linalg.norm(u) * np.linalg.norm(v):
        return []
    entries = []
    for first, second in ((u, v), (v, u)):
        frame = np.eye(4)
        frame[:3, 0] = first / np.linalg.norm(first)
        frame[:3, 1] = second / np.linalg.norm(second)
        frame[:3, 2] = np.cross(frame[:3, 0], frame[:3, 1])
        frame[:3, 3] = face.corners.mean(axis=0)
        entries.append(
            {
                "kind": "AREA",
                "shape": "RECTANGLE",
                "size_x": float(np.linalg.norm(first)),
                "size_y": float(np.linalg.norm(second)),
                "is_portal": True,
                "frame": frame,
            }
        )
    return entries


def _light(light, middle: np.ndarray, unit: float) -> dict:
    """Lamp of Blender; its powers are those of formulas I = P / 4 pi, L = P / pi A and E = P."""
    match light:
        case PointLight():
            return {
                "kind": "POINT",
                "power": 4.0 * np.pi * candelas(light) / unit**2,
                "radius": light.radius / unit,
                "frame": _frame(light.position, (0.0, 0.0, -1.0), middle, unit),
            }
        case SpotLight():
            return {
                "kind": "SPOT",
                "power": 4.0 * np.pi * candelas(light) / unit**2,
                "radius": light.radius / unit,
                "spot_size": 2.0 * light.half_angle,
                "spot_blend": light.blend,
                "frame": _frame(light.position, light.direction, middle, unit),
            }
        case SunLight():
            return {
                "kind": "SUN",
                "power": sun_illuminance(light),
                "angle": light.angle,
                "frame": _frame(middle, light.direction, middle, unit),
            }
        case AreaLight():
            size_x, size_y = light.size_x / unit, light.size_y / unit
            area = size_x * size_y * (np.pi / 4.0 if light.shape == "ellipse" else 1.0)
            frame = np.array(light.frame, dtype=np.float64)
            frame[:3, 3] = (frame[:3, 3] - middle) / unit
            return {
                "kind": "AREA",
                "power": np.pi * area * area_luminance(light),
                "shape": light.shape.upper(),
                "size_x": size_x,
                "size_y": size_y,
                "is_portal": False,
                "frame": frame,
            }
        case Luminaire() if light.opening.shape == "point":
            frame = np.array(light.frame, dtype=np.float64)
            frame[:3, 3] = (frame[:3, 3] - middle) / unit
            return {
                "kind": "POINT",
                "power": IES_EFFICACY / unit**2,
                "radius": 0.0,
                "frame": frame,
                "ies": _ies_text(light),
            }
        case Luminaire():
            raise CannotStateError("files give Cycles' lamps no openings of their own")
    raise CannotStateError(f"{type(light).__name__} is not translated")


def _ies_text(light: Luminaire) -> str:
    """LM-63 text that Cycles reads as a luminaire's intensities. [cd]

    Cycles counts horizontal angles from -y, clockwise seen from above, and interpolates with cubic curves, so the table
    is given finely, turned and mirrored.
    """
    vertical, horizontal = np.arange(0.0, 180.5, 1.0), np.arange(0.0, 362.0, 2.5)
    around, across = np.radians(270.0 - horizontal)[:, None], np.radians(vertical)[None, :]
    directions = np.stack(
        [np.sin(across) * np.cos(around), np.sin(across) * np.sin(around),
         -np.cos(across) * np.ones_like(around)], axis=-1,
    )  # fmt: skip
    table = intensity(light.distribution, directions)
    table *= luminaire_flux(light) / flux(light.distribution)
    head = f"1 -1 1 {len(vertical)} {len(horizontal)} 1 2 0 0 0"
    rows = [vertical, horizontal, *table]
    lines = [" ".join(f"{value:.7g}" for value in row) for row in rows]
    return "\n".join(["IESNA:LM-63-2002", "TILT=NONE", head, "1 1 0", *lines, ""])


def _frame(position, direction, middle: np.ndarray, unit: float) -> np.ndarray:
    """Placement whose -z is a direction."""
    frame = np.eye(4)
    z = -np.asarray(direction, dtype=np.float64)
    z /= np.linalg.norm(z)
    x = np.cross((0.0, 1.0, 0.0) if abs(z[1]) < 0.9 else (1.0, 0.0, 0.0), z)
    x /= np.linalg.norm(x)
    frame[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    frame[:3, 3] = (np.asarray(position, dtype=np.float64) - middle) / unit
    return frame


def _world(world) -> dict | None:
    if world is None:
        return None
    if not isinstance(world, UniformWorld | CieSky):
        raise CannotStateError("skies of weather and of measurements are not translated for Cycles")
    if isinstance(world, CieSky):
        return {
            "kind": "sky",
            "parameters": None if world.type == OVERCAST else PARAMETERS[world.type],
            "towards_sun": unit_sun(world),
            "scale": luminance_scale(world),
            "ground": ground_luminance(world),
        }
    return {"kind": "uniform", "luminance": world.luminance}
