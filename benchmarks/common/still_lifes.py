"""Things on a table: glass and mirrors, and a product of measured paints."""

import numpy as np

from ...engine.scene.light import AreaLight, Output, PointLight, Quantity
from ...engine.scene.material import Coated, Dielectric, Glossy, Material, Measured
from ...engine.scene.spectrum import Constant, Illuminant, Rgb
from ...libraries import materials as library
from .interiors import make_matt
from .pieces import box, make_mesh, quad, rigid_frame, side_of_box
from .shapes import make_ball


def build_glass() -> tuple:
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
    return (*materials, *room, table, *things, lamp)


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


def build_product() -> tuple[tuple, dict]:
    """Product of measured paints before a backdrop, between two soft lights; and stand-ins for the paints by their ids."""
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
    stand_ins = {key: plain for key, (_, plain) in surfaces.items()}
    return (*materials, *things, *lights), stand_ins


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
