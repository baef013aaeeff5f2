"""What a scene holds, sorted for programs that know neither our items nor spectra."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from lumenray.engine.scene.light import (
    AreaLight,
    CieSky,
    CloudySky,
    FormulaSky,
    ImageWorld,
    Luminaire,
    Output,
    PerezSky,
    PointLight,
    Quantity,
    SpotLight,
    SunLight,
    UniformWorld,
)
from lumenray.engine.scene.material import Diffuse, Material
from lumenray.engine.scene.mesh import Geometry, Mesh, Placement, place
from lumenray.engine.scene.sensor import SensorKind, SensorSet
from lumenray.engine.scene.spectrum import Constant, Rgb, Tabulated

from ..bench import CannotStateError, Query

_NEAR = 1e-9
"""Rounding of corners, relative to the size of a triangle."""


@dataclass(frozen=True)
class Face:
    """Flat polygon. ``corners`` (3 or 4, 3): anticlockwise seen from its front; four are a parallelogram. [m]"""

    corners: np.ndarray

    @property
    def normal(self) -> np.ndarray:
        """Unit normal."""
        normal = np.cross(self.corners[1] - self.corners[0], self.corners[-1] - self.corners[0])
        return normal / np.linalg.norm(normal)

    @property
    def area(self) -> float:
        """[m2]"""
        u, v = self.corners[1] - self.corners[0], self.corners[-1] - self.corners[0]
        return float(np.linalg.norm(np.cross(u, v))) * (1.0 if len(self.corners) == 4 else 0.5)


@dataclass(frozen=True)
class Part:
    """Triangles (t, 3) of vertices (v, 3) with one material. [m]"""

    vertices: np.ndarray
    triangles: np.ndarray
    material: Material

    def faces(self) -> list[Face]:
        """Polygons, pairs of triangles that make a parallelogram as one."""
        corners = self.vertices[self.triangles]
        faces, index = [], 0
        while index < len(corners):
            joined = None
            if index + 1 < len(corners):
                joined = _join(corners[index], corners[index + 1])
            faces.append(Face(corners[index] if joined is None else joined))
            index += 1 if joined is None else 2
        return [face for face in faces if face.area > 0.0]


@dataclass
class Contents:
    """A scene's parts, lights and surroundings."""

    parts: list[Part] = field(default_factory=list)
    lights: list = field(default_factory=list)
    world: UniformWorld | FormulaSky | ImageWorld | None = None


def sort_items(items: Sequence) -> Contents:
    """Sort items. Raises `CannotStateError` for kinds that no peer is told of."""
    contents = Contents()
    materials = {item.id: item for item in items if isinstance(item, Material)}
    geometries = {item.id: item for item in items if isinstance(item, Geometry)}
    for item in items:
        match item:
            case Material() | Geometry() | SensorSet():
                pass
            case Placement():
                contents.parts += _parts(place(geometries[item.geometry], item), materials)
            case Mesh():
                contents.parts += _parts(item, materials)
            case PointLight() | SpotLight() | SunLight() | AreaLight() | Luminaire():
                contents.lights.append(item)
            case UniformWorld() | CieSky() | CloudySky() | PerezSky() | ImageWorld():
                contents.world = item
            case _:
                raise CannotStateError(f"{type(item).__name__} is not translated")
    return contents


def check_query(query: Query) -> None:
    """Refuse what takes more than planar illuminances. Raises `CannotStateError`."""
    if query.kind is not SensorKind.PLANAR:
        raise CannotStateError(f"{query.kind.value} illuminance is not one of its quantities")
    if query.colour:
        raise CannotStateError("it computes with three channels, not with spectra")
    if query.reflections not in {None, 0}:
        raise CannotStateError("light cannot be told by the number of its reflections")


def neutral_value(colour) -> float:
    """Value of a spectrum that is the same at all wavelengths. Raises `CannotStateError`."""
    match colour:
        case None:
            return 0.0
        case Constant():
            return float(colour.value)
        case Rgb() if colour.red == colour.green == colour.blue:
            return float(colour.red)
        case Tabulated() if np.ptp(colour.values) == 0.0:
            return float(colour.values[0])
    raise CannotStateError("it computes with three channels, not with spectra of surfaces")


def scattered(surface) -> float:
    """Share of light that a surface scatters. [-]"""
    if not isinstance(surface, Diffuse):
        return 0.0
    return neutral_value(surface.reflectance) + neutral_value(surface.transmittance)


def candelas(light: PointLight | SpotLight) -> float:
    """Luminous intensity of a point light in every direction, of a spot light on its axis. [cd]"""
    output = _luminous(light.output)
    match output.quantity:
        case Quantity.LUMINOUS_INTENSITY | Quantity.ILLUMINANCE:
            return output.value
        case Quantity.LUMINOUS_FLUX if isinstance(light, PointLight):
            return output.value / (4.0 * np.pi)
        case Quantity.LUMINOUS_FLUX if light.blend == 0.0:
            return output.value / (2.0 * np.pi * (1.0 - np.cos(light.half_angle)))
        case Quantity.LUMINANCE if light.radius > 0.0:
            return output.value * np.pi * light.radius**2
    raise CannotStateError(f"the {output.quantity.value} of a {light.name} is not translated")


def area_luminance(light: AreaLight) -> float:
    """Luminance of a Lambertian area light. [cd/m2]"""
    output = _luminous(light.output)
    if light.spread < np.pi:
        raise CannotStateError("area lights with a narrowed spread are not translated")
    area = light.size_x * light.size_y * (np.pi / 4.0 if light.shape == "ellipse" else 1.0)
    match output.quantity:
        case Quantity.LUMINANCE:
            return output.value
        case Quantity.LUMINOUS_FLUX:
            return output.value / (np.pi * area)
        case Quantity.LUMINOUS_INTENSITY | Quantity.ILLUMINANCE:
            return output.value / area
    raise CannotStateError(f"the {output.quantity.value} of {light.name} is not translated")


def sun_illuminance(light: SunLight) -> float:
    """Illuminance of a plane that faces the sun. [lx]"""
    output = _luminous(light.output)
    match output.quantity:
        case Quantity.ILLUMINANCE:
            return output.value
        case Quantity.LUMINANCE if light.angle > 0.0:
            return output.value * np.pi * np.sin(0.5 * light.angle) ** 2
    raise CannotStateError(f"the {output.quantity.value} of {light.name} is not translated")


def luminaire_flux(light: Luminaire) -> float:
    """Luminous flux. [lm]"""
    output = _luminous(light.output)
    if output.quantity is not Quantity.LUMINOUS_FLUX:
        raise CannotStateError(f"the {output.quantity.value} of {light.name} is not translated")
    return output.value


def extent(contents: Contents, positions: np.ndarray) -> tuple[np.ndarray, float]:
    """Middle of the sensors, and the size of sensors, lights and surfaces together. [m]"""
    points = [positions]
    points += [part.vertices for part in contents.parts]
    for light in contents.lights:
        if isinstance(light, PointLight | SpotLight):
            points.append(np.asarray(light.position, dtype=np.float64)[None])
        elif isinstance(light, AreaLight | Luminaire):
            points.append(np.asarray(light.frame, dtype=np.float64)[None, :3, 3])
    points = np.concatenate(points)
    middle = 0.5 * (positions.min(axis=0) + positions.max(axis=0))
    return middle, float(np.linalg.norm(np.ptp(points, axis=0)))


def _luminous(output: Output) -> Output:
    # The spectrum of a light makes no difference where all surfaces are neutral, and others are refused.
    if output.quantity is Quantity.RADIANT_FLUX:
        raise CannotStateError("it knows no spectra, so radiant quantities have no lumens")
    return output


def _parts(mesh: Mesh, materials: dict[str, Material]) -> list[Part]:
    slots = np.minimum(mesh.material_index, len(mesh.materials) - 1)
    vertices = np.asarray(mesh.vertices, dtype=np.float64)
    return [
        Part(vertices, mesh.triangles[slots == slot], materials[mesh.materials[slot]])
        for slot in np.unique(slots)
    ]


def _join(one: np.ndarray, two: np.ndarray) -> np.ndarray | None:
    """Corners (4, 3) of the parallelogram that two triangles make, or None."""
    size = float(np.abs(one - one[0]).max())
    same = np.abs(one[:, None] - two[None]).max(axis=2) <= _NEAR * size
    if same.sum() != 2:
        return None
    tip = int(np.flatnonzero(~same.any(axis=1))[0])
    other = two[int(np.flatnonzero(~same.any(axis=0))[0])]
    a, b, c = one[tip], one[(tip + 1) % 3], one[(tip + 2) % 3]
    # Opposite corners of a parallelogram; this also keeps the two in one plane.
    if np.abs(a + other - b - c).max() > 1e-6 * size:
        return None
    return np.stack([a, b, other, c])
