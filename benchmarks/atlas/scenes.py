"""Scenes of the benchmark of the atlas: what is baked in them, and plain variants that other programs know too."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ...engine.scene.light import AreaLight, Output, PointLight, Quantity
from ...engine.scene.material import Coated, Glossy, Material
from ...engine.scene.mesh import Mesh
from ...engine.scene.spectrum import Constant, Rgb
from ..common import interiors
from ..common.interiors import FEET, make_matt
from ..common.pieces import box, make_mesh, rigid_frame, side_of_box


@dataclass(frozen=True, eq=False)
class AtlasScene:
    """A scene and what is baked in it.

    Parameters
    ----------
    key, title : str
    items : tuple    Of the engine.
    objects : tuple of str    Ids of what is baked.
    density : float    Lumels per metre.
    judged : int    Lumels for which a reference is computed: fewer where paths are noisy.
    """

    key: str
    title: str
    items: tuple
    objects: tuple[str, ...]
    density: float
    judged: int


def build_cornell() -> AtlasScene:
    """Box of 5 m with a red and a green wall, two boxes and a square light."""
    side = 5.0
    room = ((0.0, 0.0, 0.0), (side, side, side))
    paint = {"-x": "red", "+x": "green"}
    walls = [
        make_mesh(f"wall {name}", [side_of_box(*room, name)], paint.get(name, "white"))
        for name in ("bottom", "top", "-y", "+y", "-x", "+x")
    ]
    boxes = [
        make_mesh("short box", [_turned_box((3.3, 1.6), (1.5, 1.5, 1.5), -0.29)], "white"),
        make_mesh("tall box", [_turned_box((1.7, 3.3), (1.5, 1.5, 3.0), 0.31)], "white"),
    ]
    lamp = AreaLight(
        "lamp",
        "lamp",
        Output(Quantity.LUMINOUS_FLUX, 9000.0),
        rigid_frame((2.5, 2.5, 4.99), (0, 0, -1)),
        1.2,
        1.2,
    )
    materials = [
        make_matt("white", Constant(0.75)),
        make_matt("red", Rgb(0.6, 0.06, 0.05)),
        make_matt("green", Rgb(0.1, 0.45, 0.1)),
    ]
    objects = tuple(mesh.id for mesh in [*walls, *boxes])
    return AtlasScene(
        "cornell",
        "Box with two coloured walls",
        (*materials, *walls, *boxes, lamp),
        objects,
        16.0,
        768,
    )


def build_cabin() -> AtlasScene:
    """Closed tube with seats, see `interiors.build_cabin`."""
    return AtlasScene(
        "cabin",
        "Cabin with indirect light only",
        interiors.build_cabin(),
        ("floor", "side walls", "seats"),
        8.0,
        192,
    )


def build_window() -> AtlasScene:
    """Room that a clear sky lights through a small window."""
    items = interiors.build_window()
    objects = tuple(
        item.id for item in items if isinstance(item, Mesh) and item.id not in {"reveal", "opening"}
    )
    return AtlasScene("window", "Room with a small window", items, objects, 16.0, 1024)


def build_hall() -> AtlasScene:
    """Hall with 120 luminaires of three distributions, and machines."""
    items = interiors.build_hall()
    objects = tuple(item.id for item in items if isinstance(item, Mesh))
    return AtlasScene("hall", "Hall with 120 luminaires", items, objects, 3.0, 384)


def build_lamp() -> AtlasScene:
    """Room with a small lamp near a table, and shiny surfaces."""
    room = ((0.0, 0.0, 0.0), (5.0, 4.0, 2.8))
    paint = {"bottom": "varnish", "top": "plaster"}
    walls = [
        make_mesh(f"wall {name}", [side_of_box(*room, name)], paint.get(name, "gloss paint"))
        for name in ("bottom", "top", "-y", "+y", "-x", "+x")
    ]
    table = make_mesh("table", [box((1.6, 1.4, 0.71), (3.2, 2.3, 0.75))], "lacquer")
    sheet = make_mesh("sheet", [box((0.6, 3.2, 0.3), (1.8, 3.22, 1.6))], "steel")
    bulb = PointLight(
        "bulb",
        "bulb",
        Output(Quantity.LUMINOUS_FLUX, 470.0),
        np.array([2.3, 1.9, 1.1]),
        0.03,
    )
    ceiling_lamp = AreaLight(
        "panel",
        "panel",
        Output(Quantity.LUMINOUS_FLUX, 600.0),
        rigid_frame((3.9, 2.8, 2.79), (0, 0, -1)),
        0.6,
        0.6,
    )
    materials = [
        Material("varnish", "varnish", Coated(Constant(0.3), roughness=0.3)),
        make_matt("plaster", Constant(0.8)),
        Material("gloss paint", "gloss paint", Coated(Constant(0.6), roughness=0.4)),
        Material("lacquer", "lacquer", Coated(Rgb(0.45, 0.25, 0.1), roughness=0.25)),
        Material("steel", "steel", Glossy(Constant(0.6), 0.35)),
    ]
    meshes = [*walls, table, sheet]
    return AtlasScene(
        "lamp",
        "Small lamp near a shiny table",
        (*materials, *meshes, bulb, ceiling_lamp),
        (*(mesh.id for mesh in walls), "table"),
        8.0,
        768,
    )


def build_office() -> AtlasScene:
    """Bundled office, as Blender shows it."""
    from ..common.office import load_office

    office = load_office()
    return AtlasScene("office", "Bundled office", office.items, office.baked, 16.0, 320)


BUILDERS: dict[str, Callable[[], AtlasScene]] = {
    "office": build_office,
    "cornell": build_cornell,
    "cabin": build_cabin,
    "window": build_window,
    "lamp": build_lamp,
    "hall": build_hall,
}

RACE = ("office", "cornell", "cabin", "window")
"""Scenes in which programs race."""

QUICK = ("cornell", "window")
"""Scenes of a quick run."""


def build(key: str) -> AtlasScene:
    """Build a scene out of `BUILDERS`."""
    return BUILDERS[key]()


def _turned_box(middle, size, angle: float):
    """Box that stands on its feet, turned about the vertical."""
    x, y, height = 0.5 * size[0], 0.5 * size[1], size[2]
    vertices, triangles = box((-x, -y, FEET), (x, y, height))
    c, s = np.cos(angle), np.sin(angle)
    turn = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    return vertices @ turn.T + [*middle, 0.0], triangles
