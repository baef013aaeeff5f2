"""Small rooms made by chance, with what is hard to find in them: panes, bulbs, mirrors, gaps, keyholes, lamps at walls."""

from dataclasses import dataclass

import numpy as np

from ...engine.scene.light import AreaLight, Output, PointLight, Quantity, SpotLight, SunLight
from ...engine.scene.material import (
    Black,
    Cauchy,
    Coated,
    Dielectric,
    Diffuse,
    Emission,
    Glossy,
    Material,
    ThinGlass,
)
from ...engine.scene.mesh import Mesh
from ...engine.scene.spectrum import Constant, Rgb
from ..common.shapes import make_ball, make_box, make_rectangle

GLASS = Material("glass", "glass", Dielectric(Cauchy(1.5)))
PANE = Material("pane", "pane", ThinGlass(1.52, Constant(0.95)))
MIRROR = Material("mirror", "mirror", Glossy(Constant(0.92), 0.0))
SCREEN = Material("screen", "screen", Diffuse(Constant(0.3)))


@dataclass(frozen=True)
class Room:
    """A room and where it is measured.

    Parameters
    ----------
    items : tuple    Of the scene; the object ``room`` is baked.
    places, normals : (n, 3) array    Of sensors. [m]
    words : str    What is in it, for people.
    """

    items: tuple
    places: np.ndarray
    normals: np.ndarray
    words: str


def make_room(number: int) -> Room:
    """One room; the same number gives the same one."""
    draw = np.random.default_rng([number, 41])
    size = draw.uniform(1.5, 4.0, 3)
    words = [f"{size[0]:.1f} x {size[1]:.1f} x {size[2]:.1f} m"]
    has_keyhole = draw.random() < 0.2
    width = float(np.exp(draw.uniform(np.log(0.01), np.log(0.3))))
    room = make_box(size, width if has_keyhole else 0.0)
    items: list = [room, _paint(draw, words)]
    if has_keyhole:
        direction = np.array([*draw.uniform(-0.4, 0.4, 2), -1.0])
        direction /= np.linalg.norm(direction)
        items.append(
            SunLight(
                "sun", "sun", Output(Quantity.ILLUMINANCE, 50_000.0), direction, np.radians(0.53)
            )
        )
        words.append(f"sun through a hole of {1000 * width:.0f} mm")
    for k in range(0 if has_keyhole and draw.random() < 0.5 else int(draw.integers(1, 4))):
        items += _lamp(draw, size, k, words)
    if draw.random() < 0.3:
        x = draw.uniform(0.3, 0.7) * size[0]
        items += [PANE, _wall("pane", x, size, "pane")]
        words.append("a pane across")
    if draw.random() < 0.25:
        items += [MIRROR, *_mirror(draw, size, words)]
    if draw.random() < 0.25:
        gap = float(np.exp(draw.uniform(np.log(0.01), np.log(0.5))))
        items += [SCREEN, _screen(draw.uniform(0.3, 0.7) * size[0], size, gap)]
        words.append(f"a partition with a gap of {1000 * gap:.0f} mm")
    places = np.stack(
        [*(draw.uniform(0.15, 0.85, 4) * s for s in size[:2]), np.full(4, 0.0)], axis=1
    )
    places[2:, 2] = draw.uniform(0.2, 0.8) * size[2]
    return Room(tuple(items), places, np.tile([0.0, 0.0, 1.0], (4, 1)), ", ".join(words))


def _paint(draw, words: list[str]) -> Material:
    grey = float(draw.uniform(0.1, 0.85))
    if draw.random() < 0.35:
        colour = Rgb(*(float(x) for x in draw.uniform(0.1, 0.8, 3)))
        words.append("coloured walls")
        return Material("paint", "paint", Diffuse(colour))
    words.append(f"walls {grey:.2f}")
    if draw.random() < 0.2:
        words.append("coated")
        return Material(
            "paint", "paint", Coated(Constant(grey), 1.5, 1.0, float(draw.uniform(0.1, 0.5)))
        )
    return Material("paint", "paint", Diffuse(Constant(grey)))


def _lamp(draw, size, k: int, words: list[str]) -> list:
    """A lamp, which may be close to a wall or in a bulb."""
    place = draw.uniform(0.2, 0.8, 3) * size
    near = draw.random() < 0.2
    if near:
        place[0] = float(np.exp(draw.uniform(np.log(1e-3), np.log(0.1))))
    flux = Output(Quantity.LUMINOUS_FLUX, float(draw.uniform(300.0, 2000.0)))
    name, kind = f"lamp {k}", draw.choice(["point", "ball", "spot", "panel", "mesh"])
    radius = float(np.exp(draw.uniform(np.log(5e-4), np.log(0.05))))
    if near:
        radius = min(radius, 0.5 * place[0])
    at = f"{1000 * place[0]:.1f} mm off a wall" if near else ""
    bulb = draw.random() < 0.25 and not near and kind in ("point", "ball", "mesh")
    wide = f" r = {1000 * radius:.1f} mm" if kind in ("ball", "mesh") else ""
    words.append(f"{kind}{wide}{' in a bulb' if bulb else ''} {at}".strip())
    made: list = []
    if kind == "point":
        made = [PointLight(name, name, flux, place, 0.0)]
    elif kind == "ball":
        made = [PointLight(name, name, flux, place, radius)]
    elif kind == "spot":
        aim = draw.normal(size=3)
        half = float(np.radians(draw.uniform(3.0, 60.0)))
        made = [SpotLight(name, name, flux, place, aim / np.linalg.norm(aim), half, 0.3)]
    elif kind == "panel":
        frame = np.eye(4)
        frame[:3, 3] = place
        sides = np.exp(draw.uniform(np.log(0.005), np.log(0.5), 2))
        made = [AreaLight(name, name, flux, frame, float(sides[0]), float(sides[1]), "rectangle")]
    else:
        mesh = make_ball(name, radius, place, f"glow {k}", 12)
        area = float(mesh.areas().sum())
        glow = Emission(Constant(1.0), flux.value / (np.pi * area), None, False)
        made = [Material(f"glow {k}", f"glow {k}", Black(), glow), mesh]
    if bulb:
        clear = max(2.5 * radius, 0.02)
        made += [GLASS, make_ball(f"bulb {k}", clear, place, "glass", 48)]
    return made


def _mirror(draw, size, words: list[str]) -> list:
    if draw.random() < 0.5:
        words.append("a mirror ball")
        place = draw.uniform(0.25, 0.75, 3) * size
        return [make_ball("silver", 0.15, place, "mirror", 48)]
    words.append("a mirror before a wall")
    corner, width, height = (0.2, size[1] - 0.01, 0.2), size[0] - 0.4, size[2] - 0.4
    return [make_rectangle("silver", corner, (width, 0.0, 0.0), (0.0, 0.0, height), "mirror")]


def _screen(x: float, size, gap: float) -> Mesh:
    """Partition that leaves a gap over the floor."""
    edges = (0.0, size[1], 0.0), (0.0, 0.0, size[2] - gap)
    return make_rectangle("screen", (x, 0.0, gap), *edges, "screen")


def _wall(name: str, x: float, size, material: str) -> Mesh:
    return make_rectangle(name, (x, 0.0, 0.0), (0.0, size[1], 0.0), (0.0, 0.0, size[2]), material)
