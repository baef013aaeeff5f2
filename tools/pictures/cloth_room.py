"""A curtain of voile before a sunny window, and a seat of red cotton in its light: a picture for the documents.

    python -m lumenray.tools.pictures.cloth_room OUT.png [SAMPLES]

Cloths are drafts as *Cloth* in Blender has them, their warps along V of UV maps.
"""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from ...benchmarks.cloth.uses import compute
from ...benchmarks.common.shapes import make_mesh, make_rectangle
from ...engine.accuracy.stopping import StopRule
from ...engine.scene.light import CieSky, Output, Quantity, SunLight
from ...engine.scene.material import Diffuse, Material
from ...engine.scene.mesh import Mesh
from ...engine.scene.scene import SceneDelta
from ...engine.scene.spectrum import Blackbody, Constant, Illuminant
from ...engine.session import Session
from ...engine.views import ViewSettings
from .views import camera_at, shown, smoothed

WIDTH, DEPTH, HEIGHT = 4.0, 4.0, 2.7
"""Of the room. [m]"""

WINDOW = (0.8, 3.2, 0.6, 2.35)
"""Its left and right side, and its lower and upper one. [m]"""

SUN = np.array([-0.35, 0.75, 0.62])
"""Towards it."""

SIZE, SAMPLES, WHITE = (360, 240), 32, 5500.0
"""Of the picture [pixel], of each pixel, and the luminance that is shown as white. [cd/m2]"""


def make_sheet(name: str, points: np.ndarray, uv: np.ndarray, material: str) -> Mesh:
    """Smooth mesh of a grid of points (rows, columns, 3) with texture coordinates (rows, columns, 2)."""
    rows, columns = points.shape[:2]
    number = np.arange(rows * columns).reshape(rows, columns)
    a, b, c, d = number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]
    faces = np.concatenate(
        [np.stack(each, axis=-1).reshape(-1, 3) for each in ((a, b, c), (a, c, d))]
    )
    mesh = smoothed(make_mesh(name, points.reshape(-1, 3), faces, material))
    return replace(mesh, uv_maps={"drape": uv.reshape(-1, 2)[faces].astype(np.float32)})


def make_curtain(left: float, right: float) -> Mesh:
    """Curtain in folds inside the window. [m]"""
    x, z = np.meshgrid(np.linspace(left, right, 241), np.linspace(0.25, 2.5, 31))
    share = (x - left) / (right - left)
    y = DEPTH - 0.16 + 0.035 * np.sin(2.0 * np.pi * 8.0 * share + 0.5 * z) * (1.25 - 0.2 * z)
    return make_sheet("curtain", np.stack([x, y, z], axis=-1), np.stack([x, z], axis=-1), "voile")


def make_cushion(name: str, middle, half, turn: float = 0.0) -> Mesh:
    """Rounded box about a middle, with half its sides [m], turned about x. Its warp runs from below to above."""
    u, v = np.meshgrid(np.linspace(-np.pi, np.pi, 97), np.linspace(-0.5 * np.pi, 0.5 * np.pi, 49))

    def power(value):
        return np.sign(value) * np.abs(value) ** 0.45

    shape = [
        power(np.cos(v)) * power(np.cos(u)),
        power(np.cos(v)) * power(np.sin(u)),
        power(np.sin(v)),
    ]
    points = np.stack(shape, axis=-1) * half
    c, s = np.cos(turn), np.sin(turn)
    points = points @ np.array([[1.0, 0.0, 0.0], [0.0, c, s], [0.0, -s, c]]) + middle
    return make_sheet(name, points, np.stack([u, v], axis=-1), "cotton")


def make_room() -> list[Mesh]:
    """Walls about the window, floor and ceiling. [m]"""
    left, right, low, high = WINDOW
    x, y, z = np.eye(3)
    wall = [
        make_rectangle(f"wall {number}", (a, DEPTH, b), (c - a) * x, (d - b) * z, "white")
        for number, (a, b, c, d) in enumerate(
            (
                (0.0, 0.0, WIDTH, low),
                (0.0, high, WIDTH, HEIGHT),
                (0.0, low, left, high),
                (right, low, WIDTH, high),
            )
        )
    ]
    return [
        *wall,
        make_rectangle("left", (0, 0, 0), DEPTH * y, HEIGHT * z, "white"),
        make_rectangle("right", (WIDTH, 0, 0), HEIGHT * z, DEPTH * y, "white"),
        make_rectangle("back", (0, 0, 0), HEIGHT * z, WIDTH * x, "white"),
        make_rectangle("ceiling", (0, 0, HEIGHT), DEPTH * y, WIDTH * x, "white"),
        make_rectangle("floor", (0, 0, 0), WIDTH * x, DEPTH * y, "wood"),
        make_rectangle("ground", (-200, DEPTH + 0.05, -0.3), 400 * x, 400 * y, "ground"),
    ]


def draw(samples: int = SAMPLES) -> np.ndarray:
    """Draw the room. (h, w, 3) uint8, from above"""
    things = (
        Material("voile", "Voile", compute("voile").surface),
        Material("cotton", "Red cotton", compute("red_cotton").surface),
        Material("white", "White", Diffuse(Constant(0.75))),
        Material("wood", "Wood", Diffuse(Constant(0.3))),
        Material("ground", "Ground", Diffuse(Constant(0.2))),
        *make_room(),
        make_curtain(WINDOW[0] - 0.15, 2.35),
        make_cushion("seat", (2.55, 2.3, 0.42), (0.46, 0.44, 0.15)),
        make_cushion("back", (2.55, 2.72, 0.85), (0.46, 0.13, 0.45), -0.15),
        CieSky(12, SUN, 12_000.0, 0.25, Illuminant("D65")),
        SunLight(
            "sun",
            "Sun",
            Output(Quantity.ILLUMINANCE, 40_000.0, Blackbody(5500.0)),
            -SUN / np.linalg.norm(SUN),
            np.radians(0.53),
        ),
    )
    session = Session(witness=False)
    session.apply(SceneDelta(changed=things))
    camera = camera_at((1.0, 0.12, 1.65), np.array([2.15, 3.6, 0.95]), SIZE, 1.15)
    return shown(session.render(camera, ViewSettings(StopRule(samples=samples))), WHITE)


def main(arguments: list[str]) -> None:
    """Draw it into a file."""
    out, *samples = arguments
    Image.fromarray(draw(*map(int, samples))).save(Path(out))


if __name__ == "__main__":
    main(sys.argv[1:])
