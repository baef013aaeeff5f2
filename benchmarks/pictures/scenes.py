"""Scenes of the benchmark of pictures, each with its camera."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...engine.scene.camera import Camera, Projection
from ...engine.scene.light import Output, Quantity, SunLight
from ...engine.scene.material import Material
from ..common import interiors, still_lifes
from ..common.office import load_office

SIZE = (640, 400)
"""Width and height. [pixel]"""

SENSORS = (12, 8)
"""Across and along a plane."""


@dataclass(frozen=True, eq=False)
class PictureScene:
    """A scene and how it is seen.

    Parameters
    ----------
    key, title : str
    items : tuple    Of the engine.
    camera : Camera
    stand_ins : dict of str to Surface    For programs that do not know the surface of a material, by its id.
    plane : (3, 3) array    Where sensors measure: a corner of a rectangle and its edges. [m]
    """

    key: str
    title: str
    items: tuple
    camera: Camera
    stand_ins: dict
    plane: np.ndarray

    @property
    def sensors(self) -> tuple[np.ndarray, np.ndarray]:
        """Places of sensors over the plane, row by row, and their normals. (n, 3) each"""
        corner, across, up = self.plane
        steps = [(np.arange(count) + 0.5) / count for count in SENSORS]
        v, u = (each.reshape(-1, 1) for each in np.meshgrid(*steps[::-1], indexing="ij"))
        places = corner + u * across + v * up
        normal = np.cross(across, up)
        return places, np.tile(normal / np.linalg.norm(normal), (len(places), 1))

    @property
    def known_items(self) -> tuple:
        """The items as programs are given them that need the stand-ins."""
        return tuple(
            replace(item, surface=self.stand_ins[item.id])
            if isinstance(item, Material) and item.id in self.stand_ins
            else item
            for item in self.items
        )


def resize(camera: Camera, size: tuple[int, int]) -> Camera:
    """Give a camera another film of square pixels; what it sees across stays."""
    width, height = size
    return replace(camera, width=width, height=height, extent_y=camera.extent_x * height / width)


def look(place, at, width: float) -> Camera:
    """Upright camera. ``width``: of what it sees at a distance of 1. [m]"""
    backwards = np.asarray(place, dtype=np.float64) - at
    backwards /= np.linalg.norm(backwards)
    right = np.cross((0.0, 0.0, 1.0), backwards)
    right /= np.linalg.norm(right)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([right, np.cross(backwards, right), backwards], axis=1)
    frame[:3, 3] = place
    return resize(Camera(frame, Projection.PERSPECTIVE, *SIZE, extent_x=width), SIZE)


def _plane(corner, across: float, along: float) -> np.ndarray:
    """A horizontal one. [m]"""
    return np.array([corner, (across, 0.0, 0.0), (0.0, along, 0.0)])


def build_office() -> PictureScene:
    """Bundled office by its own camera."""
    office = load_office()
    plane = _plane((0.5, 0.4, 0.85), 2.6, 2.6)
    return PictureScene("office", "Office", office.items, office.camera, {}, plane)


def build_cabin() -> PictureScene:
    """Cabin whose lamps shine at the ceiling alone, from the aisle."""
    camera = look((11.7, 0.25, 1.5), (6.0, -0.1, 0.45), 1.7)
    plane = _plane((1.0, -1.2, 1.2), 10.0, 2.4)
    title = "Cabin lit only indirectly"
    return PictureScene("cabin", title, interiors.build_cabin(), camera, {}, plane)


def build_hall() -> PictureScene:
    """Hall with 120 luminaires from a corner above the floor."""
    camera = look((0.6, 0.6, 3.2), (13.0, 9.0, 1.2), 1.6)
    plane = _plane((1.0, 1.0, 2.2), 22.0, 14.0)
    title = "Hall with 120 luminaires"
    return PictureScene("hall", title, interiors.build_hall(), camera, {}, plane)


TO_SUN = (0.25, 0.75, 0.55)
"""Direction in which the sun stands before the window."""


def build_window() -> PictureScene:
    """Room with a small window by which sun and sky come in."""
    items = interiors.build_window()
    sun = SunLight(
        "sun",
        "sun",
        Output(Quantity.ILLUMINANCE, 60_000.0),
        -np.array(TO_SUN) / np.linalg.norm(TO_SUN),
        np.radians(0.53),
    )
    sky = replace(items[-1], towards_sun=np.array(TO_SUN))
    camera = look((5.6, 0.3, 1.7), (2.2, 3.4, 0.9), 1.5)
    title = "Sunlit room through a small window"
    plane = _plane((0.8, 0.5, 0.85), 4.7, 3.0)
    return PictureScene("window", title, (*items[:-1], sun, sky), camera, {}, plane)


def build_glass() -> PictureScene:
    """Table with glass and mirrors under a small lamp."""
    camera = look((0.25, -1.5, 1.5), (0.0, 0.05, 0.72), 0.95)
    plane = _plane((-0.6, -0.35, 1.2), 1.2, 0.7)
    return PictureScene("glass", "Glass and caustics", still_lifes.build_glass(), camera, {}, plane)


def build_product() -> PictureScene:
    """Product of measured paints."""
    items, stand_ins = still_lifes.build_product()
    camera = look((0.35, -2.0, 0.95), (0.1, 0.0, 0.44), 0.8)
    plane = _plane((-0.9, -1.2, 0.02), 2.1, 0.7)
    title = "Product with measured paints"
    return PictureScene("product", title, items, camera, stand_ins, plane)


BUILDERS: dict[str, Callable[[], PictureScene]] = {
    "office": build_office,
    "cabin": build_cabin,
    "hall": build_hall,
    "glass": build_glass,
    "window": build_window,
    "product": build_product,
}


def build(key: str, size: tuple[int, int] = SIZE) -> PictureScene:
    """Build a scene out of `BUILDERS` for pictures of a size."""
    scene = BUILDERS[key]()
    return replace(scene, camera=resize(scene.camera, size))
