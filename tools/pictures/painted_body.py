"""Paints on a ball and on a body like a car's under a sunny sky, and close by: a picture for the documents.

    python -m lumenray.tools.pictures.painted_body OUT.png [PRESET...]

The body is a loft of superellipses along the axis of the car; no wheel turns and no window opens.
"""

import json
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
from PIL import Image

from ...benchmarks.common.shapes import make_ball, make_mesh, make_rectangle
from ...engine.accuracy.stopping import StopRule
from ...engine.paint.painted import paint_surface
from ...engine.scene.light import CieSky, Output, Quantity, SunLight
from ...engine.scene.material import Diffuse, Material
from ...engine.scene.mesh import Mesh
from ...engine.scene.scene import SceneDelta
from ...engine.scene.spectrum import Blackbody, Constant, Illuminant
from ...engine.session import Session
from ...engine.views import ViewSettings
from ...libraries import paints
from .views import camera_at, shown, smoothed

SAMPLES = ("violet_pearl", "yellow_green_pearl", "near_white_pearl")
"""The reference's three."""

SUN = np.array([-0.45, -0.55, 0.70])
"""Towards it."""

SIZE, CLOSE = (420, 236), (236, 236)
"""Of the view, and of that close by. [pixel]"""

SAMPLES_OF_PIXEL = 160

WHITE = 9000.0
"""Luminance that is shown as white. [cd/m2]"""

LENGTH, BELOW, SECTIONS, POINTS = 2.2, 0.24, 240, 160
"""Half of the body's length and its lowest height [m]; rings of the loft, and points of each."""

ROOF = (
    (-2.2, 0.50), (-2.05, 0.66), (-1.6, 0.82), (-1.0, 0.90), (-0.75, 0.94), (-0.15, 1.34),
    (0.35, 1.42), (0.95, 1.36), (1.55, 1.08), (1.95, 0.98), (2.15, 0.82), (2.2, 0.6),
)  # fmt: skip
"""Heights of the body's upper edge along it, the front first. [m]"""


def make_body(material: str) -> Mesh:
    """Closed smooth body, its front towards -x. [m]"""
    share = np.linspace(-1.0, 1.0, SECTIONS)
    x = LENGTH * np.sin(0.5 * np.pi * share)
    top = _smooth_heights(x)
    # What the ends lose of height and width.
    end = np.maximum(1.0 - np.abs(x / LENGTH) ** 5.0, 1e-4) ** (1.0 / 2.5)
    width = 0.88 * np.maximum(1.0 - 0.16 * (x / LENGTH) ** 2, 0.0) * end
    middle, half = 0.5 * (top + BELOW), 0.5 * (top - BELOW) * end
    turn = np.linspace(0.0, 2.0 * np.pi, POINTS, endpoint=False)
    y = np.sign(np.cos(turn)) * np.abs(np.cos(turn)) ** (2.0 / 3.2)
    z = np.sign(np.sin(turn)) * np.abs(np.sin(turn)) ** (2.0 / 3.0)
    height = middle[:, None] + half[:, None] * z
    # Above the belt the cabin leans inwards.
    lean = np.clip((height - 0.80) / 0.62, 0.0, 1.0)
    across = width[:, None] * y * (1.0 - 0.42 * lean * lean * (3.0 - 2.0 * lean))
    points = np.stack([np.broadcast_to(x[:, None], across.shape), across, height], axis=-1)
    number = np.arange(SECTIONS * POINTS).reshape(SECTIONS, POINTS)
    a, b = number[:-1], np.roll(number, -1, axis=1)[:-1]
    c, d = number[1:], np.roll(number, -1, axis=1)[1:]
    faces = np.concatenate(
        [np.stack([a, b, d], axis=-1).reshape(-1, 3), np.stack([a, d, c], axis=-1).reshape(-1, 3)]
    )
    return smoothed(_outwards(make_mesh("body", points.reshape(-1, 3), faces, material)))


def _smooth_heights(x: np.ndarray) -> np.ndarray:
    """Heights of the roof's line, its corners rounded over a quarter of a metre."""
    fine = np.linspace(-3.0, 3.0, 2401)
    line = np.interp(fine, *np.transpose(ROOF))
    step = np.arange(-1.0, 1.0, fine[1] - fine[0])
    kernel = np.exp(-0.5 * (step / 0.13) ** 2)
    return np.interp(x, fine, np.convolve(line, kernel / kernel.sum(), mode="same"))


def _outwards(mesh: Mesh) -> Mesh:
    """A mesh about the middle of the body whose faces look outwards."""
    corners = mesh.vertices[mesh.triangles]
    own = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    if (own * (corners.mean(axis=1) - [0.0, 0.0, 0.7])).sum() >= 0.0:
        return mesh
    return replace(mesh, triangles=np.ascontiguousarray(mesh.triangles[:, ::-1]))


def draw(preset: str) -> np.ndarray:
    """Draw a paint on the body and a ball, and the ball from close by. (h, w, 3) uint8"""
    content = json.loads(paints.presets()[preset].read_text(encoding="utf-8"))
    surface = paint_surface(content).surface
    ground = Material("ground", "Ground", Diffuse(Constant(0.28)))
    ball = (-1.35, -1.75, 0.28)
    things = (
        Material("paint", "Paint", surface),
        ground,
        Material("rubber", "Rubber", Diffuse(Constant(0.04))),
        make_rectangle("floor", (-900, -900, 0), (1800, 0, 0), (0, 1800, 0), "ground"),
        make_body("paint"),
        make_ball("ball", 0.28, ball, "paint", 96),
        *(
            make_ball(f"wheel {x} {y}", 0.31, (x, y, 0.31), "rubber", 40)
            for x in (-1.35, 1.35)
            for y in (-0.62, 0.62)
        ),
        CieSky(12, SUN, 14_000.0, 0.25, Illuminant("D65")),
        SunLight(
            "sun",
            "Sun",
            Output(Quantity.ILLUMINANCE, 75_000.0, Blackbody(5500.0)),
            -SUN / np.linalg.norm(SUN),
            np.radians(0.53),
        ),
    )
    session = Session(witness=False)
    session.apply(SceneDelta(changed=things))
    towards = np.array([-0.42, -0.62, 0.66])
    near = np.asarray(ball) + 0.28 * towards / np.linalg.norm(towards)
    views = (
        (
            camera_at((-3.6, -5.2, 1.75), np.array([-0.1, -0.35, 0.55]), SIZE, 0.78),
            SAMPLES_OF_PIXEL,
        ),
        (camera_at(near + 0.22 * towards, near, CLOSE, 0.30), 2 * SAMPLES_OF_PIXEL),
    )
    pixels = [
        shown(
            session.render(camera, ViewSettings(StopRule(samples=samples), method="paths")), WHITE
        )
        for camera, samples in views
    ]
    return np.concatenate([pixels[0], np.full((SIZE[1], 6, 3), 255, np.uint8), pixels[1]], axis=1)


def main(arguments: list[str]) -> None:
    """Draw paints below each other."""
    out, *names = arguments
    rows = [draw(name) for name in names or SAMPLES]
    gap = np.full((6, rows[0].shape[1], 3), 255, np.uint8)
    stacked = [piece for row in rows for piece in (row, gap)][:-1]
    Image.fromarray(np.concatenate(stacked)).save(Path(out))


if __name__ == "__main__":
    main(sys.argv[1:])
