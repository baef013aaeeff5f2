"""Evaluation of a world's nodes for all directions: a grid of them takes the place of a surface's UV map."""

from functools import lru_cache

import numpy as np

from ...foundation.report import ConversionReport
from ..images.cache import ImageCache
from ..images.pixels import MISSING
from .evaluation import Context
from .fields import Field, Layout, constant, map_fields, rgb
from .graph import trace
from .mapping import legacy_matrix
from .sky_texture import show_sky

LAYOUT = Layout("directions", np.eye(3), name="directions")
"""Layout of what depends on the direction; it lies on no surface."""

CAMERA_RAYS, LIGHT_RAYS = "Is Camera Ray", ("Is Diffuse Ray", "Is Reflection Ray")
"""Outputs of the Light Path node: of rays from the eye, and of those that gather light."""

FLIPPED = {"Normal", "True Normal", "Incoming", "Reflection"}
"""Outputs of coordinates that point against the direction that is looked along."""


@lru_cache(maxsize=2)
def directions(height: int) -> np.ndarray:
    """Return unit vectors to the middles of the pixels of an equirectangular picture. (height, 2 height, 3) float32"""
    elevation = np.pi * ((np.arange(height) + 0.5) / height - 0.5)
    azimuth = 2.0 * np.pi * (0.5 - (np.arange(2 * height) + 0.5) / (2 * height))
    cosine = np.cos(elevation)[:, None]
    made = np.stack(
        np.broadcast_arrays(
            cosine * np.cos(azimuth), cosine * np.sin(azimuth), np.sin(elevation)[:, None]
        ),
        axis=-1,
    ).astype(np.float32)
    made.flags.writeable = False
    return made


class DirectionContext(Context):
    """The conversion of a world, as rays that gather light see it, or as the camera does.

    Parameters
    ----------
    datablock, report, images    As of `Context`.
    height : int or (h, w, 3) float32 array    Of the picture; or the directions themselves, unit vectors.
    is_camera : bool
    shown_sun : tuple or None    Of Sky Textures, whose disk is shown (`sky_texture.sun_of`); None: no disk.

    Attributes
    ----------
    skies : set of ScatteredSky    Of Sky Textures that were met, those with a sun.
    """

    def __init__(
        self,
        datablock: str,
        report: ConversionReport,
        images: ImageCache | None,
        height: int | np.ndarray,
        is_camera: bool = False,
        shown_sun: tuple | None = None,
    ):
        super().__init__(datablock, report, images)
        self._directions = directions(height) if isinstance(height, int) else height
        self.is_camera, self.shown_sun = is_camera, shown_sun
        self.skies: set = set()

    def take_output(self, at) -> Field | None:
        """Return what a node gives for every direction; None: it gives the same as on a surface."""
        found = _SOURCES.get(at.node.bl_idname)
        return None if found is None else found(at, self)

    def coordinates(self) -> Field:
        """Return the directions themselves, by which textures go where nothing is linked."""
        return Field(self._directions, LAYOUT)

    def is_ray(self, name: str) -> float:
        """Whether the rays that look are of the kind that an output of the Light Path node names."""
        return float(name == CAMERA_RAYS if self.is_camera else name in LIGHT_RAYS)


def _coordinates(at, context) -> Field | None:
    name = at.output.identifier
    if name in FLIPPED:
        return at.map(np.negative, context.coordinates())
    return context.coordinates() if name in {"Generated", "Object", "Position"} else None


def _light_path(at, context) -> Field | None:
    name = at.output.identifier
    if name == CAMERA_RAYS or not name.startswith("Is "):
        return constant(context.is_ray(name)) if name == CAMERA_RAYS else None
    if name in LIGHT_RAYS[1:] or name in {"Is Glossy Ray", "Is Transmission Ray"}:
        at.note(f"{name} tells rays of light apart", "all that light surfaces are told alike")
    return constant(context.is_ray(name))


def _environment(at, context) -> Field:
    node, socket = at.node, at.node.inputs["Vector"]
    is_linked = trace(socket, at.groups).is_output
    vector = at.field(socket) if is_linked else context.coordinates()
    before = legacy_matrix(node)
    reading = context.images.read(node.image, True, at.note)
    if reading is None:
        file = f" ({node.image.filepath})" if node.image and node.image.filepath else ""
        at.miss(
            f"the environment texture has no picture that can be read{file}",
            f"grey {MISSING} is used",
        )
        return constant(MISSING)
    look_up = _mirror_ball if node.projection == "MIRROR_BALL" else _equirectangular
    is_smooth = node.interpolation != "Closest"

    def show(vector):
        vector = np.array(rgb(vector), dtype=np.float64)
        if before is not None:
            vector = vector @ before[:3, :3].T + before[:3, 3]
        vector /= np.maximum(np.linalg.norm(vector, axis=-1, keepdims=True), 1e-30)
        return sample_picture(reading.colour, *look_up(vector), is_smooth)

    # Not kept, as what it gives depends on the picture too.
    return map_fields(show, vector, note=at.note)


def _equirectangular(vector):
    x, y, z = np.moveaxis(vector, -1, 0)
    return 0.5 - np.arctan2(y, x) / (2.0 * np.pi), 0.5 + np.arctan2(z, np.hypot(x, y)) / np.pi


def _mirror_ball(vector):
    x, y, z = np.moveaxis(vector, -1, 0)
    y = y - 1.0
    size = 2.0 * np.sqrt(np.maximum(-0.5 * y, 0.0))
    size = np.where(size > 0.0, size, 1.0)
    return 0.5 * (x / size + 1.0), 0.5 * (z / size + 1.0)


def sample_picture(pixels, u, v, is_smooth: bool) -> np.ndarray:
    """Look up a picture (h, w, c) that goes on around in u and stays as it is beyond its ends in v."""
    height, width = pixels.shape[:2]
    if not is_smooth:
        column = np.floor(u * width).astype(int) % width
        row = np.clip(np.floor(v * height).astype(int), 0, height - 1)
        return pixels[row, column]
    x, y = u * width - 0.5, np.clip(v * height - 0.5, 0.0, height - 1.0)
    left, low = np.floor(x).astype(int), np.minimum(np.floor(y).astype(int), max(height - 2, 0))
    high = np.minimum(low + 1, height - 1)
    a, b = (x - left)[..., None], (y - low)[..., None]
    left, right = left % width, (left + 1) % width
    return (pixels[low, left] * (1.0 - a) + pixels[low, right] * a) * (1.0 - b) + (
        pixels[high, left] * (1.0 - a) + pixels[high, right] * a
    ) * b


_SOURCES = {
    "ShaderNodeTexCoord": _coordinates,
    "ShaderNodeNewGeometry": _coordinates,
    "ShaderNodeLightPath": _light_path,
    "ShaderNodeTexEnvironment": _environment,
    "ShaderNodeTexSky": show_sky,
}
"""What a world's nodes give by the direction, by their ``bl_idname``."""
