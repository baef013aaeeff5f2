"""The small scene on which a material is shown: a ball on a chequered floor, a lamp above, windows in the room around.

Sheets that let light through are a hollow ball with a lamp inside; road signs get a lamp beside the eye, as a car has.
"""

import numpy as np

from ...engine.errors import LumenrayError
from ...engine.scattering.readers.reader import read_scattering
from ...engine.scene.camera import Camera, Projection
from ...engine.scene.light import AreaLight, ImageWorld, Output, PointLight, Quantity, SpotLight
from ...engine.scene.material import (
    Cauchy,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Material,
    Measured,
    Surface,
    ThinGlass,
)
from ...engine.scene.mesh import Mesh
from ...engine.scene.spectrum import Constant, Illuminant, Rgb
from ...engine.scene.texture import ImageTexture
from ...libraries.materials import Entry

RADIUS = 0.5
"""Of the ball, which lies on the floor at the origin. [m]"""

EYE, TARGET, FIELD = (0.55, -3.1, 1.35), (0.0, 0.0, 0.46), 24.0
"""Of the camera; its field from side to side. [m], [m], [degree]"""

TILE, TILES = 0.25, 16
"""Side of a tile of the floor [m], and how many there are along each side."""

LIGHT_TILE, DARK_TILE, WALL = 0.45, 0.12, 0.30
"""Reflectances."""

HEADLAMP = "Road/Signs"
"""Category that is shown by a lamp beside the eye."""


def surface_of(entry: Entry) -> Surface:
    """Surface of the engine for a material of a library.

    Raises
    ------
    LumenrayError    Its scattering file cannot be used.
    """
    settings = entry.settings
    match entry.model:
        case "MEASURED":
            sides = read_scattering(entry.file).sides
            for side, other in (("back", "front"), ("front", "back")):
                for way in ("reflection", "transmission"):
                    if f"{other}_{way}" in sides:
                        sides.setdefault(f"{side}_{way}", sides[f"{other}_{way}"])
            rotation = settings["measured"].get("rotation", 0.0)
            return Measured(**sides, rotation=rotation)
        case "CONDUCTOR":
            return Conductor(settings["metal"], settings.get("roughness", 0.2))
        case "DIELECTRIC":
            return Dielectric(_index(settings), settings.get("roughness", 0.0))
        case "THIN_GLASS":
            index = _index(settings)
            # At the line d, as where only one number fits.
            single = index.a + index.b / 0.58756**2
            return ThinGlass(single, Constant(settings.get("transmittance", 0.0)))
        case "COATED":
            return Coated(
                _reflectance(settings), settings.get("ior", 1.5), settings.get("roughness", 0.2)
            )
        case "DIFFUSE":
            transmittance = settings.get("transmittance", 0.0)
            passing = Constant(transmittance) if transmittance > 0.0 else None
            return Diffuse(_reflectance(settings), passing)
    raise LumenrayError(f"{entry.name}: no picture of the model {entry.model} can be made")


def _index(settings: dict) -> Cauchy:
    has_dispersion = settings.get("ior_source") == "CAUCHY"
    return Cauchy(settings.get("ior", 1.5), settings.get("cauchy_b", 0.0042) * has_dispersion)


def _reflectance(settings: dict):
    if settings.get("reflectance_source") == "COLOR":
        return Rgb(*settings.get("reflectance_color", (0.5, 0.5, 0.5)))
    return Constant(settings.get("reflectance", 0.5))


def lets_through(surface: Surface) -> bool:
    """Whether a surface is a sheet that lets light through, so that a lamp inside of the ball tells more."""
    if isinstance(surface, Measured):
        return surface.front_transmission is not None
    return isinstance(surface, Diffuse) and surface.transmittance is not None


def set_material_stage(entry: Entry, surface: Surface, size: int) -> tuple[tuple, Camera]:
    """Return the items of a scene that shows a material, and the camera.

    Parameters
    ----------
    entry : Entry
    surface : Surface    Of the ball, see `surface_of`.
    size : int    Of the picture. [pixel]
    """
    daylight = Illuminant("D65")
    items = [
        ImageWorld(ImageTexture(_room()), 100.0),
        Material("ball", "ball", surface),
        Material("light tile", "light tile", Diffuse(Constant(LIGHT_TILE))),
        Material("dark tile", "dark tile", Diffuse(Constant(DARK_TILE))),
        Material("wall", "wall", Diffuse(Constant(WALL))),
        _ball(),
        _floor(),
        _wall(),
        AreaLight(
            "key",
            "key",
            Output(Quantity.LUMINOUS_FLUX, 4500.0, daylight),
            _look((1.3, -1.3, 2.3), (0.0, 0.0, RADIUS)),
            0.7,
            0.7,
            visible_to_camera=False,
        ),
    ]
    if lets_through(surface):
        output = Output(Quantity.LUMINOUS_FLUX, 700.0, daylight)
        items.append(PointLight("inner", "inner", output, np.array([0.0, 0.0, RADIUS]), 0.06))
    if entry.category == HEADLAMP:
        towards = np.subtract((0.0, 0.0, RADIUS), EYE)
        lamp = np.add(EYE, (0.0, 0.0, 0.02))
        output = Output(Quantity.LUMINOUS_INTENSITY, 14.0, daylight)
        items.append(
            SpotLight(
                "headlamp", "headlamp", output, lamp, towards / np.linalg.norm(towards),
                np.radians(20.0), 0.3,
            )
        )  # fmt: skip
    extent = 2.0 * np.tan(np.radians(0.5 * FIELD))
    camera = Camera(_look(EYE, TARGET), Projection.PERSPECTIVE, size, size, extent, extent)
    return tuple(items), camera


def _look(eye, target) -> np.ndarray:
    """Placement at a point whose -z points to another, upright. (4, 4) [m]"""
    z = np.subtract(eye, target)
    z = z / np.linalg.norm(z)
    x = np.cross((0.0, 0.0, 1.0), z)
    x = x / np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    frame[:3, 3] = eye
    return frame


def _room(width: int = 256) -> np.ndarray:
    """Surroundings: a dim room, a window with bars to the left, a bright strip to the right. (h, w, 3)"""
    u = (np.arange(width) + 0.5) / width
    v = (np.arange(width // 2) + 0.5) / (width // 2)
    azimuth = np.degrees(2.0 * np.pi * (0.5 - u))[None, :]
    height = np.degrees(np.pi * (v - 0.5))[:, None]
    value = 0.25 + 0.35 * np.clip(height / 90.0, 0.0, 1.0) + 0.0 * azimuth

    def is_in(middle, half, low, high):
        away = (azimuth - middle + 180.0) % 360.0 - 180.0
        return (np.abs(away) < half) & (height > low) & (height < high), away

    window, away = is_in(-150.0, 26.0, 8.0, 58.0)
    bars = (np.abs(away) < 1.6) | (np.abs(height - 33.0) < 1.6)
    value = np.where(window & ~bars, 14.0, value)
    strip, _ = is_in(0.0, 7.0, 5.0, 70.0)
    value = np.where(strip, 6.0, value)
    return np.repeat(value[..., None], 3, axis=2).astype(np.float32)


def _ball(around: int = 96, rings: int = 48) -> Mesh:
    """The ball, U along its parallels."""
    u, v = np.meshgrid(np.linspace(0.0, 1.0, around + 1), np.linspace(0.0, 1.0, rings + 1))
    turn, polar = 2.0 * np.pi * u.ravel(), np.pi * (1.0 - v.ravel())
    normal = np.stack(
        [np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=1
    )
    row, column = (m.ravel() for m in np.mgrid[:rings, :around])
    first = row * (around + 1) + column
    quad = np.stack([first, first + 1, first + around + 2, first + around + 1], axis=1)
    triangles = np.concatenate([quad[:, [0, 1, 2]], quad[:, [0, 2, 3]]])
    corners = normal[triangles]
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    triangles = triangles[area > 1e-9].astype(np.int32)
    uv = np.stack([u.ravel(), v.ravel()], axis=1)
    return Mesh(
        "ball",
        "ball",
        RADIUS * normal + [0.0, 0.0, RADIUS],
        triangles,
        ("ball",),
        np.zeros(len(triangles), np.int32),
        normal[triangles].astype(np.float32),
        {"UV": uv[triangles].astype(np.float32)},
    )


def _floor() -> Mesh:
    """Tiles, light and dark."""
    half = 0.5 * TILE * TILES
    x, y = (m.ravel() for m in np.meshgrid(np.arange(TILES), np.arange(TILES)))
    corner = np.stack([TILE * x - half, TILE * y - half, np.zeros(len(x))], axis=1)
    steps = TILE * np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], dtype=float)
    points = (corner[:, None] + steps).reshape(-1, 3)
    first = 4 * np.arange(len(x))
    triangles = np.stack([first, first + 1, first + 2, first, first + 2, first + 3], axis=1)
    slots = np.repeat((x + y) % 2, 2).astype(np.int32)
    return Mesh(
        "floor",
        "floor",
        points,
        triangles.reshape(-1, 3).astype(np.int32),
        ("light tile", "dark tile"),
        slots,
    )


def _wall() -> Mesh:
    """Wall behind the ball."""
    half = 0.5 * TILE * TILES
    points = np.array(
        [(-half, half, 0.0), (half, half, 0.0), (half, half, 3.0), (-half, half, 3.0)]
    )
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    return Mesh("wall", "wall", points, triangles, ("wall",), np.zeros(2, np.int32))
