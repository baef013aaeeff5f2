"""Scenes of the benchmark of pictures, each with its camera."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ...engine.scene.camera import Camera, Projection
from ...engine.scene.light import AreaLight, Output, PointLight, Quantity, SunLight
from ...engine.scene.material import Coated, Dielectric, Glossy, Material, Measured
from ...engine.scene.spectrum import Constant, Illuminant, Rgb
from ...libraries import materials as library
from ..common import interiors
from ..common.interiors import make_matt
from ..common.office import load_office
from ..common.pieces import box, make_mesh, quad, rigid_frame, side_of_box
from ..common.shapes import make_ball

SIZE = (640, 400)
"""Width and height. [pixel]"""


@dataclass(frozen=True, eq=False)
class PictureScene:
    """A scene and how it is seen.

    Parameters
    ----------
    key, title : str
    items : tuple    Of the engine.
    camera : Camera
    stand_ins : dict of str to Surface    For programs that do not know the surface of a material, by its id.
    """

    key: str
    title: str
    items: tuple
    camera: Camera
    stand_ins: dict

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


def build_office() -> PictureScene:
    """Bundled office by its own camera."""
    office = load_office()
    return PictureScene("office", "Office", office.items, office.camera, {})


def build_cabin() -> PictureScene:
    """Cabin whose lamps shine at the ceiling alone, from the aisle."""
    camera = look((11.7, 0.25, 1.5), (6.0, -0.1, 0.45), 1.7)
    return PictureScene("cabin", "Cabin lit only indirectly", interiors.build_cabin(), camera, {})


def build_hall() -> PictureScene:
    """Hall with 120 luminaires from a corner above the floor."""
    camera = look((0.6, 0.6, 3.2), (13.0, 9.0, 1.2), 1.6)
    return PictureScene("hall", "Hall with 120 luminaires", interiors.build_hall(), camera, {})


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
    return PictureScene("window", title, (*items[:-1], sun, sky), camera, {})


def build_glass() -> PictureScene:
    """Table with a ball of glass, a ball of amber, a mirror ball and a polished ring under a small lamp."""
    low, high = (-2.0, -2.0, 0.0), (2.0, 2.0, 2.6)
    paint = {"bottom": "floor", "top": "plaster", "+y": "blue"}
    room = [
        make_mesh(f"wall {side}", [side_of_box(low, high, side)], paint.get(side, "plaster"))
        for side in ("bottom", "top", "-y", "+y", "-x", "+x")
    ]
    top = 0.74
    table = make_mesh("table", [box((-0.7, -0.4, 0.70), (0.7, 0.5, top))], "board")
    things = [
        make_ball("ball", 0.14, (-0.25, 0.0, top + 0.141), "glass", 48),
        make_ball("amber ball", 0.08, (0.02, -0.2, top + 0.081), "amber", 36),
        make_ball("mirror ball", 0.11, (0.12, 0.25, top + 0.111), "chrome", 48),
        _ring("ring", 0.19, 0.07, (0.36, -0.05, top + 0.001), "chrome"),
    ]
    flux = Output(Quantity.LUMINOUS_FLUX, 1500.0)
    lamp = PointLight("lamp", "lamp", flux, np.array([-0.75, 0.55, 1.75]), 0.03)
    materials = [
        make_matt("floor", Constant(0.3)),
        make_matt("plaster", Constant(0.75)),
        make_matt("blue", Rgb(0.25, 0.4, 0.6)),
        make_matt("board", Rgb(0.6, 0.45, 0.3)),
        Material("glass", "glass", Dielectric()),
        Material("amber", "amber", Dielectric(tint=Rgb(0.95, 0.7, 0.35))),
        Material("chrome", "chrome", Glossy(Constant(0.9), 0.0)),
    ]
    camera = look((0.25, -1.5, 1.5), (0.0, 0.05, 0.72), 0.95)
    items = (*materials, *room, table, *things, lamp)
    return PictureScene("glass", "Glass and caustics", items, camera, {})


def _ring(key: str, radius: float, height: float, foot, material: str, sides: int = 96):
    """Upright band with the normals of a true cylinder."""
    angle = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    normal = np.stack([np.cos(angle), np.sin(angle), np.zeros(sides)], axis=1)
    low = radius * normal + np.asarray(foot)
    vertices = np.concatenate([low, low + np.array([0.0, 0.0, height])])
    here = np.arange(sides)
    there = (here + 1) % sides
    triangles = np.concatenate(
        [
            np.stack([here, there, there + sides], 1),
            np.stack([here, there + sides, here + sides], 1),
        ]
    )
    normals = np.concatenate([normal, normal])[triangles].astype(np.float32)
    return make_mesh(key, [(vertices, triangles)], material, normals)


PAINTS = (
    "car_blue",
    "lacquer_red_gloss",
    "aluminium_anodised",
    "wall_white_matt",
    "plaster_sand",
)
"""Measured materials of the library."""


def build_product() -> PictureScene:
    """Product of measured paints before a backdrop, between two soft lights."""
    surfaces = {name: _read_paint(name) for name in PAINTS}
    materials = [Material(key, key, surface) for key, (surface, _) in surfaces.items()]
    things = [
        make_mesh("stage", [quad((-2, -2, 0), (4, 0, 0), (0, 3.2, 0))], "plaster_sand"),
        make_mesh("backdrop", [quad((-2, 1.2, 0), (4, 0, 0), (0, 0, 2.5))], "wall_white_matt"),
        make_ball("body", 0.3, (0.0, 0.0, 0.40), "car_blue", 64),
        make_ball("cap", 0.12, (0.0, 0.0, 0.81), "lacquer_red_gloss", 40),
        make_mesh("foot", [box((-0.22, -0.22, 0.002), (0.22, 0.22, 0.1))], "aluminium_anodised"),
        make_mesh("card", [box((0.42, -0.1, 0.002), (0.72, 0.2, 0.3))], "lacquer_red_gloss"),
    ]
    lights = [
        _softbox("key light", (-1.3, -1.3, 1.9), (0.0, 0.0, 0.4), 0.8, 3000.0),
        _softbox("fill light", (1.6, -0.8, 1.3), (0.0, 0.0, 0.4), 0.5, 900.0),
    ]
    camera = look((0.35, -2.0, 0.95), (0.1, 0.0, 0.44), 0.8)
    return PictureScene(
        "product",
        "Product with measured paints",
        (*materials, *things, *lights),
        camera,
        {key: plain for key, (_, plain) in surfaces.items()},
    )


def _softbox(key: str, place, at, side: float, flux: float) -> AreaLight:
    output = Output(Quantity.LUMINOUS_FLUX, flux, Illuminant("D65"))
    frame = rigid_frame(place, np.asarray(at) - np.asarray(place))
    return AreaLight(key, key, output, frame, side, side)


def _read_paint(name: str):
    """Return a material of the library as it was measured, and the model of Blender's that is fitted to it."""
    from ...engine.scattering.look import fit_look
    from ...engine.scattering.readers.reader import read_scattering

    file = read_scattering(library.FOLDER / f"{name}.lumbsdf")
    reflection = file.sides["front_reflection"]
    fitted = fit_look(file)
    colour = Rgb(*fitted.base_colour)
    plain = Coated(colour, fitted.ior, fitted.roughness)
    if fitted.metallic:
        plain = Glossy(colour, fitted.roughness)
    return Measured(front_reflection=reflection, back_reflection=reflection), plain


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
