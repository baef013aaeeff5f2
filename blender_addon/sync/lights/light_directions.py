"""Evaluation of a light's nodes for all directions in which it shines."""

import numpy as np

from ....engine.luminaires.coordinates import directions
from ...foundation.report import ConversionReport
from ..images.cache import ImageCache
from ..nodes.dependencies import nodes_of
from ..nodes.directions import sample_picture
from ..nodes.fields import Field, Layout, map_fields, rgb
from ..nodes.mapping import legacy_matrix
from ..nodes.rays import RayContext

LAYOUT = Layout("light", np.eye(3), name="light")
"""Layout of what depends on the direction; it lies on no surface."""

AWAY = {"Normal", "True Normal", "Incoming"}
"""Outputs of the Geometry node that point to where the light goes, in the world."""

TINY = 1e-9


class LightContext(RayContext):
    """The conversion of a light's nodes, by direction.

    Parameters
    ----------
    datablock, report, images    As of `Context`.
    azimuth, polar : (a,), (p,) array    Grid of directions about the object's -z, by its own axes. [rad]
    matrix : (3, 3) array    From the object's axes to the world, with its scale.
    half_angle : float or None    Of a spot. [rad]
    """

    def __init__(
        self,
        datablock: str,
        report: ConversionReport,
        images: ImageCache | None,
        azimuth: np.ndarray,
        polar: np.ndarray,
        matrix: np.ndarray,
        half_angle: float | None,
    ):
        super().__init__(datablock, report, images)
        axes = matrix / np.linalg.norm(matrix, axis=0)
        own = directions(azimuth[None, :], polar[:, None])
        self._world = own @ axes.T
        # Blender brings it back as a normal.
        self._own = _unit(self._world @ matrix)
        self._half_angle = half_angle

    def take_output(self, at) -> Field | None:
        """Return what a node gives for every direction; None: it gives the same as on a surface."""
        found = _SOURCES.get(at.node.bl_idname)
        return super().take_output(at) if found is None else found(at, self)

    def along(self, is_own: bool) -> Field:
        """Return the directions, in the object's axes or in the world."""
        return _field(self._own if is_own else self._world)

    def uv(self) -> Field:
        """Return the coordinates by which Blender lays pictures over a light: of a spot as a projector does."""
        x, y, z = np.moveaxis(self._own, -1, 0)
        if self._half_angle is None:
            u = 0.5 * (1.0 - np.arctan2(x, y) / np.pi)
            v = 1.0 - np.arccos(np.clip(z, -1.0, 1.0)) / np.pi
        else:
            width = 2.0 * np.tan(self._half_angle) * np.maximum(-z, TINY)
            u, v = 0.5 + x / width, 0.5 + y / width
        return _field(np.stack([u, v, np.zeros_like(u)], axis=-1))


def knows_directions(tree) -> bool:
    """Tell whether what nodes give may depend on the direction."""
    return any(node.bl_idname in _SOURCES for node in nodes_of(tree))


def _field(values) -> Field:
    return Field(np.ascontiguousarray(values, dtype=np.float32), LAYOUT)


def _unit(vector):
    return vector / np.maximum(np.linalg.norm(vector, axis=-1, keepdims=True), TINY)


def _coordinates(at, context) -> Field | None:
    match at.output.identifier:
        case "Normal":
            return context.along(is_own=True)
        case "Reflection":
            return context.along(is_own=False)
        case "UV":
            return context.uv()
    return None


def _geometry(at, context) -> Field | None:
    return context.along(is_own=False) if at.output.identifier in AWAY else None


def _uv_map(at, context) -> Field | None:
    return context.uv() if at.output.identifier == "UV" else None


def _placed(at) -> Field | None:
    """Return the vector of a texture, None where it does not depend on the direction."""
    if not any(not link.is_muted for link in at.node.inputs["Vector"].links):
        return None
    vector = at.field(at.node.inputs["Vector"])
    return None if vector.is_stand_in or vector.is_constant else vector


def _image(at, context) -> Field | None:
    node = at.node
    is_linked = any(not link.is_muted for link in node.inputs["Vector"].links)
    vector = _placed(at) if is_linked else context.uv()
    if vector is None or node.projection != "FLAT":
        return None
    before = legacy_matrix(node)
    reading = context.images.read(node.image, True, at.note)
    if reading is None:
        return None
    pixels = reading.alpha if at.output.identifier == "Alpha" else reading.colour
    if pixels is None:
        return None
    is_smooth = node.interpolation != "Closest"

    def show(vector):
        place = np.array(rgb(vector), dtype=np.float64)
        if before is not None:
            place = place @ before[:3, :3].T + before[:3, 3]
        u, v = place[..., 0], place[..., 1]
        inside = (u >= 0.0) & (u <= 1.0) & (v >= 0.0) & (v <= 1.0)
        match node.extension:
            case "REPEAT":
                u, v = np.mod(u, 1.0), np.mod(v, 1.0)
            case "MIRROR":
                u, v = (1.0 - np.abs(np.mod(each, 2.0) - 1.0) for each in (u, v))
        u, v = np.clip(u, 0.0, 1.0 - TINY), np.clip(v, 0.0, 1.0)
        found = sample_picture(pixels, u, v, is_smooth)
        return np.where(inside[..., None], found, 0.0) if node.extension == "CLIP" else found

    # Not kept, as what it gives depends on the picture too.
    return map_fields(show, vector, note=at.note)


def _checker(at, context) -> Field | None:
    vector = _placed(at)
    if vector is None:
        return None
    is_share = at.output.identifier == "Fac"

    def show(vector, scale, first, second):
        place = np.array(rgb(vector), dtype=np.float64) * scale
        place = np.floor((place + 1e-6) * 0.999999).astype(np.int64)
        is_first = (place.sum(axis=-1, keepdims=True) % 2) == 1
        return is_first.astype(np.float32) if is_share else np.where(is_first, first, second)

    return at.map(show, vector, at("Scale"), at("Color1"), at("Color2"))


_SOURCES = {
    "ShaderNodeTexCoord": _coordinates,
    "ShaderNodeNewGeometry": _geometry,
    "ShaderNodeUVMap": _uv_map,
    "ShaderNodeTexImage": _image,
    "ShaderNodeTexChecker": _checker,
}
"""What a light's nodes give by the direction, by their ``bl_idname``."""
