"""Scenes of which each needs something else, with the sensors that are asked for."""

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...engine.raysets.emission import prepare_light
from ...engine.raysets.record import LUMINOUS, Rays
from ...engine.raysets.writers import write_tm25
from ...engine.scene.distribution import Opening
from ...engine.scene.light import (
    AreaLight,
    CieSky,
    Luminaire,
    Output,
    PointLight,
    Quantity,
    SunLight,
)
from ...engine.scene.material import Coated, Material
from ...engine.scene.spectrum import Blackbody, Constant, Illuminant, Rgb
from ..common import interiors, still_lifes
from ..common.interiors import make_matt
from ..common.pieces import box, make_mesh, quad, rigid_frame, side_of_box
from ..common.ray_sources import disk, even_numbers

RAYS, RAY_FLUX = 1 << 21, 100.0
"""Of the ray file, and their light. [lm]"""

SIDES = ("bottom", "top", "-y", "+y", "-x", "+x")


@dataclass(frozen=True, eq=False)
class NeedScene:
    """A scene and what is asked of it.

    Parameters
    ----------
    key, title : str
    items : tuple    Of the engine.
    positions, normals : (n, 3) arrays    Sensors. [m]
    """

    key: str
    title: str
    items: tuple
    positions: np.ndarray
    normals: np.ndarray


def _grid(low, high, columns: int = 50, rows: int = 40) -> tuple[np.ndarray, np.ndarray]:
    """Level sensors between two corners at one height, facing up."""
    x, y = np.meshgrid(
        np.linspace(low[0], high[0], columns), np.linspace(low[1], high[1], rows), indexing="ij"
    )
    places = np.stack([x.ravel(), y.ravel(), np.full(x.size, low[2])], axis=1)
    return places, np.tile([0.0, 0.0, 1.0], (len(places), 1))


def _room(size, paint: dict[str, str], standard: str = "wall") -> list:
    corners = (0.0, 0.0, 0.0), size
    return [
        make_mesh(f"wall {side}", [side_of_box(*corners, side)], paint.get(side, standard))
        for side in SIDES
    ]


def _panel(number: int, place, flux: float, spectrum=None, side: float = 0.6) -> AreaLight:
    output = Output(Quantity.LUMINOUS_FLUX, flux, spectrum or Illuminant("D65"))
    frame = rigid_frame(place, (0, 0, -1))
    return AreaLight(f"panel {number}", f"panel {number}", output, frame, side, side)


def build_neutral_office() -> tuple:
    """Grey and white room with desks, under panels of two colour temperatures."""
    size = (8.0, 6.0, 2.9)
    desks = [
        box((1.0 + 2.4 * i, 1.0 + 2.4 * j, 0.72), (2.6 + 2.4 * i, 1.8 + 2.4 * j, 0.75))
        for i in range(3)
        for j in range(2)
    ]
    panels = [
        _panel(n, (1.4 + 2.6 * (n % 3), 1.6 + 2.8 * (n // 3), 2.88), 3600.0, Blackbody(kelvin))
        for n, kelvin in enumerate((3000.0, 4000.0) * 3)
    ]
    materials = (
        make_matt("floor", Constant(0.2)),
        make_matt("ceiling", Constant(0.85)),
        make_matt("wall", Constant(0.6)),
        Material("desk", "desk", Coated(Constant(0.5), roughness=0.4)),
    )
    room = _room(size, {"bottom": "floor", "top": "ceiling"})
    items = (*materials, *room, make_mesh("desks", desks, "desk"), *panels)
    return items, *_grid((0.5, 0.5, 0.8), (7.5, 5.5, 0.8))


def build_coloured_room() -> tuple:
    """Room of strong colours under white LEDs and a warm lamp."""
    size = (4.0, 5.0, 2.7)
    materials = (
        make_matt("floor", Rgb(0.35, 0.22, 0.12)),
        make_matt("ceiling", Rgb(0.85, 0.85, 0.82)),
        make_matt("wall", Rgb(0.7, 0.65, 0.5)),
        make_matt("red", Rgb(0.6, 0.08, 0.06)),
        make_matt("green", Rgb(0.1, 0.45, 0.12)),
    )
    room = _room(size, {"bottom": "floor", "top": "ceiling", "-x": "red", "+x": "green"})
    lamps = (
        _panel(0, (1.3, 2.5, 2.68), 3000.0, Illuminant("LED-B3")),
        _panel(1, (2.7, 2.5, 2.68), 2000.0, Illuminant("LED-B1")),
    )
    return (*materials, *room, *lamps), *_grid((0.4, 0.4, 0.75), (3.6, 4.6, 0.75))


def build_caustic_glass() -> tuple:
    """Table with glass and mirrors under a small lamp; sensors on the table and the floor."""
    items = still_lifes.build_glass()
    table = _grid((-0.65, -0.35, 0.742), (0.65, 0.45, 0.742), 30, 20)
    floor = _grid((-1.6, -1.6, 0.002), (1.6, 1.6, 0.002), 20, 20)
    return items, np.concatenate([table[0], floor[0]]), np.concatenate([table[1], floor[1]])


def build_bulb() -> tuple:
    """One bulb over a table, out of doors at night."""
    bulb = PointLight(
        "bulb", "bulb", Output(Quantity.LUMINOUS_FLUX, 800.0), np.array([0, 0, 1.9]), 0.03
    )
    table = make_mesh("table", [box((-0.8, -0.5, 0.70), (0.8, 0.5, 0.74))], "board")
    ground = make_mesh("ground", [quad((-10, -10, 0), (20, 0, 0), (0, 20, 0))], "ground")
    materials = make_matt("board", Constant(0.5)), make_matt("ground", Constant(0.2))
    return (*materials, table, ground, bulb), *_grid((-2.0, -2.0, 0.002), (2.0, 2.0, 0.002))


def build_many_luminaires() -> tuple:
    """Hall of 100 m with 1000 panels."""
    size = (100.0, 40.0, 8.0)
    panels = [
        _panel(n, (2.0 + 2.4 * (n % 40), 1.0 + 1.55 * (n // 40), 7.9), 8000.0) for n in range(1000)
    ]
    materials = (
        make_matt("floor", Constant(0.25)),
        make_matt("ceiling", Constant(0.6)),
        make_matt("wall", Constant(0.5)),
    )
    room = _room(size, {"bottom": "floor", "top": "ceiling"})
    return (*materials, *room, *panels), *_grid((3.0, 2.0, 0.8), (97.0, 38.0, 0.8), 42, 24)


def build_daylight() -> tuple:
    """Room that a clear sky lights through a small window."""
    return interiors.build_window(), *_grid((0.8, 0.4, 0.8), (5.6, 3.6, 0.8))


def build_ray_lamp() -> tuple:
    """Light of a ray file, near a sheet and far over a floor.

    The file has so many rays that it tells its light within the asked error; smoothing of fewer would be compared, and not
    what is modelled.
    """
    position, direction = disk(even_numbers(RAYS, 1))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "disk.tm25ray"
        shares = np.full(RAYS, RAY_FLUX / RAYS, np.float32)
        write_tm25(path, [Rays(position, direction, shares)], LUMINOUS)
        made = prepare_light(path)
    frame = rigid_frame((0.0, 0.0, 1.0), (0, 0, -1))
    lamp = Luminaire(
        "lamp",
        "lamp",
        Output(Quantity.LUMINOUS_FLUX, RAY_FLUX),
        frame,
        made.distribution,
        Opening(),
        rays=made.emission,
    )
    near = 1.0 - 6.0 * made.emission.size
    sheet = make_mesh("sheet", [quad((0.0, -0.02, near), (0.03, 0, 0), (0, 0.04, 0))], "paper")
    floor = make_mesh("floor", [quad((-2, -2, 0), (4, 0, 0), (0, 4, 0))], "paper")
    close = _grid((0.003, -0.015, near + 1e-4), (0.025, 0.015, near + 1e-4), 30, 25)
    far = _grid((-1.5, -1.5, 0.001), (1.5, 1.5, 0.001), 35, 35)
    items = (make_matt("paper", Constant(0.7)), sheet, floor, lamp)
    return items, np.concatenate([close[0], far[0]]), np.concatenate([close[1], far[1]])


def build_measured_paint() -> tuple:
    """Product of measured paints between two soft lights; sensors on its stage."""
    return still_lifes.build_product()[0], *_grid((-1.2, -1.2, 0.002), (1.2, 0.9, 0.002))


def build_indirect_cabin() -> tuple:
    """Closed tube whose lamps shine at its ceiling."""
    return interiors.build_cabin(), *_grid((0.6, -1.2, 0.62), (11.4, 1.2, 0.62), 42, 24)


def build_court() -> tuple:
    """Paved court between four houses, under sun and sky."""
    ground = make_mesh("ground", [quad((-30, -30, 0), (60, 0, 0), (0, 60, 0))], "paving")
    houses = [
        box((-14, -12, 0.0), (-8, 12, 11)),
        box((8, -12, 0.0), (14, 12, 14)),
        box((-8, 8, 0.0), (8, 14, 9)),
        box((-8, -14, 0.0), (8, -8, 12)),
    ]
    towards = np.array([0.3, -0.45, 0.84])
    sun = SunLight("sun", "sun", Output(Quantity.ILLUMINANCE, 70_000.0), -towards, np.radians(0.53))
    materials = (
        make_matt("paving", Rgb(0.30, 0.29, 0.27)),
        make_matt("render", Rgb(0.6, 0.58, 0.53)),
    )
    items = (*materials, ground, make_mesh("houses", houses, "render"), sun)
    return (*items, CieSky(12, towards, 15_000.0, 0.2)), *_grid((-7, -7, 0.01), (7, 7, 0.01))


def build_empty() -> tuple:
    """Two lamps and nothing else."""
    flux = Output(Quantity.LUMINOUS_FLUX, 1000.0)
    lamps = (
        PointLight("bulb", "bulb", flux, np.array([0.0, 0.0, 2.0]), 0.05),
        _panel(0, (1.5, 0.0, 2.5), 2000.0),
    )
    return lamps, *_grid((-3, -3, 0), (3, 3, 0))


def build_huge() -> tuple:
    """Hall of 600 m, 40 km from the world's origin, with high masts and one corner that is worked in."""
    size, away = (600.0, 300.0, 30.0), np.array([40_000.0, -9_000.0, 120.0])
    materials = (
        make_matt("floor", Constant(0.3)),
        make_matt("ceiling", Constant(0.5)),
        make_matt("wall", Constant(0.5)),
    )
    racks = [box((20.0 + 8 * i, 20.0, 0.1), (22.0 + 8 * i, 280.0, 12.0)) for i in range(60)]
    meshes = [
        *_room(size, {"bottom": "floor", "top": "ceiling"}),
        make_mesh("racks", racks, "wall"),
    ]
    panels = [
        _panel(
            n,
            np.add(away, (25.0 + 50.0 * (n % 12), 30.0 + 60.0 * (n // 12), 29.0)),
            60_000.0,
            side=1.0,
        )
        for n in range(60)
    ]
    moved = [replace(mesh, vertices=mesh.vertices + away) for mesh in meshes]
    places, normals = _grid((502.0, 20.0, 0.8), (590.0, 280.0, 0.8), 40, 50)
    return (*materials, *moved, *panels), places + away, normals


BUILDERS: dict[str, tuple[str, Callable[[], tuple]]] = {
    "neutral office": ("Neutral office, two kinds of white", build_neutral_office),
    "coloured room": ("Coloured room under LEDs", build_coloured_room),
    "caustic glass": ("Glass and caustics", build_caustic_glass),
    "one bulb": ("One bulb over a table", build_bulb),
    "1000 luminaires": ("Hall with 1000 luminaires", build_many_luminaires),
    "daylight": ("Daylight through a small window", build_daylight),
    "ray lamp": ("Ray set near and far", build_ray_lamp),
    "measured paint": ("Product with measured paints", build_measured_paint),
    "indirect cabin": ("Cabin lit only indirectly", build_indirect_cabin),
    "court": ("Court under sun and sky", build_court),
    "empty": ("Two lamps and nothing else", build_empty),
    "huge": ("Hall of 600 m far from the origin", build_huge),
}
"""Titles and what builds each scene: its items, and positions and normals of its sensors."""


def build(key: str) -> NeedScene:
    """Build a scene out of `BUILDERS`."""
    title, builder = BUILDERS[key]
    return NeedScene(key, title, *builder())
