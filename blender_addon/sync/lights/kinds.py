"""Kinds of lights as Blender states them: one class for each, with all that conversion, readings and panels ask."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....engine.errors import SceneError
from ....engine.scene.light import (
    AreaLight,
    LineLight,
    Output,
    PointLight,
    Quantity,
    SpotLight,
    SunLight,
)
from ....imports import loaded_when_used
from .readings import Reading, read_area, read_line, read_point, read_spot, read_sun

with loaded_when_used():
    from ....engine.sky.atmosphere import scattered_sky

UNEVEN = 1.001
"""Ratio of a spot's scales from which on its cone is an ellipse."""


@dataclass(frozen=True, eq=False)
class Place:
    """Where a light is to stand.

    Parameters
    ----------
    id, name : str    Of the light.
    matrix : (4, 4) array    World matrix, in Blender units.
    scale : float    Metres per Blender unit.
    visible_to_camera : bool
    """

    id: str
    name: str
    matrix: np.ndarray
    scale: float
    visible_to_camera: bool = True

    @property
    def position(self) -> np.ndarray:
        """World space. (3,) [m]"""
        return np.array(self.matrix, dtype=np.float64)[:3, 3] * self.scale

    @cached_property
    def lengths(self) -> np.ndarray:
        """Of the axes. (3,) [-]"""
        return np.linalg.norm(np.array(self.matrix, dtype=np.float64)[:3, :3], axis=0)

    @cached_property
    def axes(self) -> np.ndarray:
        """Directions of the axes, in columns. (3, 3)"""
        return np.array(self.matrix, dtype=np.float64)[:3, :3] / np.maximum(self.lengths, 1e-30)

    @property
    def size(self) -> float:
        """Mean scale of the axes, for what is as large in every direction. [-]"""
        return float(np.cbrt(np.prod(self.lengths)))

    @property
    def frame(self) -> np.ndarray:
        """Rigid placement that keeps the direction of x. (4, 4) [m]"""
        frame, axes = np.eye(4), self.axes
        z = axes[:, 2] - axes[:, 0] * np.dot(axes[:, 0], axes[:, 2])
        frame[:3, 0] = axes[:, 0]
        frame[:3, 2] = z / max(np.linalg.norm(z), 1e-30)
        frame[:3, 1] = np.cross(frame[:3, 2], frame[:3, 0])
        frame[:3, 3] = self.position
        return frame


class Kind(ABC):
    """A kind of light. ``data`` is the `bpy.types.Light`."""

    makes: type
    """What the engine has for it."""

    quantities = (
        "LUMINOUS_FLUX",
        "LUMINOUS_INTENSITY",
        "ILLUMINANCE",
        "LUMINANCE",
        "RADIANT_FLUX",
    )
    """In which it can be stated."""

    settings: tuple[str, ...] = ("size",)
    """What the panel shows of its shape, by names of properties or of `ui.light.DRAWN`."""

    whole = Quantity.LUMINOUS_FLUX
    """Quantity of all of its light."""

    radiant = "Radiant Flux", "W"
    """What watts are called, and their unit."""

    place_of_illuminance = "At 1 m on the axis"
    """Where the illuminance of its reading is."""

    @staticmethod
    @abstractmethod
    def fits(data) -> bool:
        """Whether a light is of this kind."""

    def quantities_of(self, data) -> tuple[str, ...]:
        """Return the quantities in which this light can be stated."""
        return self.quantities

    def amount(self, data, place: Place, lumens: float) -> tuple[Quantity, float]:
        """Return what lumens by Blender's own watts mean; of a normal source the flux, of others per unit of its size."""
        if is_spread_out(data):
            return Quantity.LUMINANCE, lumens / np.pi
        return Quantity.LUMINOUS_FLUX, lumens

    @abstractmethod
    def make(self, data, place: Place, output: Output):
        """Return the engine's light."""

    @abstractmethod
    def read(self, light) -> Reading | None:
        """Return what the engine's light gives in all quantities; None if it has none for lack of size."""

    def find_fault(self, data, place: Place) -> tuple[str, str] | None:
        """Say what Blender makes of the object's scale and this engine does not, and what is done."""
        return None


class _Round(Kind):
    """Light with a radius."""

    def amount(self, data, place, lumens):
        size = data.shadow_soft_size * place.size
        factor = size**2 if is_spread_out(data) else 0.25 / np.pi
        return Quantity.LUMINOUS_INTENSITY, lumens * factor


class Point(_Round):
    """Ball or point."""

    makes = PointLight
    settings = ("size", "tube_length")

    @staticmethod
    def fits(data) -> bool:
        return data.type == "POINT" and not Tube.fits(data)

    def make(self, data, place, output) -> PointLight:
        radius = _radius(data, place)
        return PointLight(
            place.id, place.name, output, place.position, radius, place.visible_to_camera
        )

    def read(self, light: PointLight):
        quantity, value = light.output.quantity.name, light.output.value
        if quantity == "LUMINANCE" and light.radius <= 0.0:
            return None
        return read_point(quantity, value, light.radius)


class Tube(Kind):
    """Straight tube, which Blender draws as a ball. By its watts it gives what a ball gives, or has a ball's luminance."""

    makes = LineLight
    settings = Point.settings

    @staticmethod
    def fits(data) -> bool:
        return data.type == "POINT" and data.lumenray.tube_length > 0.0

    def make(self, data, place, output) -> LineLight:
        length = data.lumenray.tube_length * float(place.lengths[0]) * place.scale
        radius = _radius(data, place)
        return LineLight(
            place.id, place.name, output, place.frame, length, radius, place.visible_to_camera
        )

    def read(self, light: LineLight):
        if light.radius <= 0.0:
            return None
        return read_line(light.output.quantity.name, light.output.value, light.length, light.radius)


class Spot(_Round):
    """Cone of light."""

    makes = SpotLight
    quantities = ("LUMINOUS_FLUX", "LUMINOUS_INTENSITY", "ILLUMINANCE", "RADIANT_FLUX")
    settings = ("size", "beam")

    @staticmethod
    def fits(data) -> bool:
        return data.type == "SPOT"

    def make(self, data, place, output) -> SpotLight:
        return SpotLight(
            place.id,
            place.name,
            output,
            place.position,
            -place.axes[:, 2],
            0.5 * data.spot_size,
            data.spot_blend,
            _radius(data, place),
        )

    def read(self, light: SpotLight):
        return read_spot(
            light.output.quantity.name, light.output.value, light.half_angle, light.blend
        )


class Sun(Kind):
    """Parallel light, or that of a disk at infinity."""

    makes = SunLight
    quantities = ("ILLUMINANCE", "LUMINANCE", "RADIANT_FLUX")
    settings = ("angle", "limb_darkening")
    whole = Quantity.ILLUMINANCE
    radiant = "Irradiance", "W/m²"
    place_of_illuminance = "Facing the sun"

    @staticmethod
    def fits(data) -> bool:
        return data.type == "SUN"

    def quantities_of(self, data):
        """Without a size it has no luminance."""
        return tuple(q for q in self.quantities if q != "LUMINANCE" or data.angle > 0.0)

    def amount(self, data, place, lumens):
        factor = np.pi * np.sin(0.5 * data.angle) ** 2 if is_spread_out(data) else 1.0
        return Quantity.ILLUMINANCE, lumens * factor

    def make(self, data, place, output) -> SunLight:
        limb = scattered_sky.LIMB if data.lumenray.limb_darkening else 0.0
        return SunLight(place.id, place.name, output, -place.axes[:, 2], data.angle, limb)

    def read(self, light: SunLight):
        quantity, value = light.output.quantity.name, light.output.value
        if quantity == "LUMINANCE" and light.angle <= 0.0:
            return None
        return read_sun(quantity, value, light.angle)


class Area(Kind):
    """Flat face that shines to one side."""

    makes = AreaLight
    settings = ("size", "portal", "spread")
    place_of_illuminance = "At 1 m (point)"

    @staticmethod
    def fits(data) -> bool:
        return data.type == "AREA"

    def make(self, data, place, output) -> AreaLight:
        size_x, size_y = sizes_of(data) * (place.lengths[:2] * place.scale)
        return AreaLight(
            place.id,
            place.name,
            output,
            place.frame,
            size_x,
            size_y,
            "ellipse" if is_ellipse(data) else "rectangle",
            data.spread,
            place.visible_to_camera,
        )

    def read(self, light: AreaLight):
        if light.area <= 0.0:
            return None
        return read_area(light.output.quantity.name, light.output.value, light.area, light.spread)

    def find_fault(self, data, place):
        if abs(np.dot(place.axes[:, 0], place.axes[:, 1])) <= 1e-4:
            return None
        return "the area light is sheared", "its sides are taken as perpendicular"


KINDS = (Point(), Tube(), Spot(), Sun(), Area())
"""All kinds of lights."""


def kind_of(data) -> Kind:
    """Return the kind of a light, if no file says how it shines.

    Raises
    ------
    SceneError    It is none that is known.
    """
    for kind in KINDS:
        if kind.fits(data):
            return kind
    raise SceneError(f"lights of type {data.type} are unknown")


def read_light(light) -> Reading | None:
    """Return what a light of the engine, other than a luminaire, gives in all quantities; None as of `Kind.read`."""
    return next(kind for kind in KINDS if kind.makes is type(light)).read(light)


def is_spread_out(data) -> bool:
    """Whether Blender's watts are per unit of a light's size."""
    return not getattr(data, "normalize", True)


def is_scaled_unevenly(lengths) -> bool:
    """Tell whether a spot's scales make its cone an ellipse. ``lengths``: (3,)."""
    return max(lengths) > UNEVEN * min(lengths)


def sizes_of(data) -> np.ndarray:
    """Full width and height of an area light, in its own units. (2,)"""
    return np.array(
        [data.size, data.size_y if data.shape in {"RECTANGLE", "ELLIPSE"} else data.size]
    )


def is_ellipse(data) -> bool:
    """Whether an area light is round."""
    return data.shape in {"DISK", "ELLIPSE"}


def _radius(data, place: Place) -> float:
    """[m]"""
    return data.shadow_soft_size * place.size * place.scale
