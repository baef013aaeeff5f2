"""Rooms for small pictures, and how pictures by cells and by paths are compared."""

import numpy as np
from glass_scenes import ball
from small_scenes import box, paint, quad, session_of

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import AreaLight, Output, Quantity
from lumenray.engine.scene.material import (
    Cauchy,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Glossy,
    Material,
    ThinGlass,
)
from lumenray.engine.scene.spectrum import Constant, Illuminant, Rgb
from lumenray.engine.scene.texture import ImageTexture
from lumenray.engine.views import ViewSettings

ROOM = box(3.0, 4.0, 2.5)
RED = Material("red", "red", Diffuse(Rgb(0.6, 0.15, 0.1)))
CHECKS = np.array([[[0.1, 0.2, 0.7], [0.8, 0.8, 0.8]], [[0.5, 0.1, 0.1], [0.2, 0.5, 0.2]]])


def lamp(x=1.5, y=2.4, z=2.3, size=0.3):
    """Small area lamp that looks down."""
    frame = np.eye(4)
    frame[:3, 3] = x, y, z
    light = Output(Quantity.LUMINOUS_FLUX, 1000.0, Illuminant("A"))
    return AreaLight("lamp", "lamp", light, frame, size, size)


def look_in(width=48, height=32):
    """Camera at one end of the room, level."""
    frame = np.eye(4)
    frame[:3, :3] = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    frame[:3, 3] = 1.5, 0.1, 1.2
    return Camera(frame, Projection.PERSPECTIVE, width, height, 1.6, 1.6 * height / width)


def _upright(name, material):
    """Sheet across the room, which faces the camera."""
    return quad(name, (0.4, 2.2, 0.4), (1.0, 0.0, 0.0), (0.0, 0.3, 1.2), material)


def _material(name, surface):
    return Material(name, name, surface)


ROOMS = {
    "matt": (ROOM, paint(0.6), lamp(), RED, _upright("screen", "red")),
    "coats": (
        ROOM,
        _material("paint", Coated(Constant(0.5), 1.5, 0.3)),
        lamp(),
        _upright("screen", "shiny"),
        _material("shiny", Coated(Rgb(0.7, 0.2, 0.1), 1.5, 0.05)),
    ),
    "pane": (
        ROOM,
        paint(0.6),
        lamp(),
        _upright("pane", "pane"),
        _material("pane", ThinGlass(1.5, Constant(0.9))),
    ),
    "mirror": (
        ROOM,
        paint(0.6),
        lamp(),
        _upright("mirror", "mirror"),
        _material("mirror", Glossy(Constant(0.9), 0.0)),
    ),
    "metal": (
        ROOM,
        paint(0.6),
        lamp(),
        _upright("metal", "metal"),
        _material("metal", Conductor("Al", 0.2)),
    ),
    "glass ball": (
        ROOM,
        paint(0.6),
        lamp(),
        ball("ball", 0.35, (1.5, 2.0, 0.6), "glass", 32),
        _material("glass", Dielectric(Cauchy(1.5))),
    ),
    "smooth ball": (ROOM, paint(0.6), lamp(), ball("ball", 0.5, (1.5, 2.2, 0.6), "red", 8), RED),
    "textured floor": (
        ROOM,
        paint(0.6),
        lamp(),
        quad("carpet", (0.1, 0.2, 0.01), (2.8, 0, 0), (0, 3.6, 0), "checks"),
        _material("checks", Diffuse(ImageTexture(CHECKS.astype(np.float32)))),
    ),
}
"""By what they try."""


def picture_of(items, samples, method, seed=0, view=None, **more):
    """Picture of a room by a method. ``samples``: or a rule.

    Unless ``shares`` says so, pixels share nothing, so that their errors are independent and those of squares are known.
    """
    more = {"shares": False} | more
    rule = samples if isinstance(samples, StopRule) else StopRule(samples=samples)
    settings = ViewSettings(rule, seed, method=method, **more)
    return session_of(*items).render(view or look_in(), settings)


def blocks_of(values, side=8):
    """Means of squares of pixels. (h / side, w / side, ...)"""
    height, width = values.shape[:2]
    shape = (height // side, side, width // side, side, *values.shape[2:])
    return values.astype(np.float64).reshape(shape).mean(axis=(1, 3))


def block_errors(picture, side=8):
    """Standard errors of the means of squares of pixels, as their errors are independent. (h / side, w / side)"""
    return np.sqrt(blocks_of(picture.luminance_error.astype(np.float64) ** 2, side)) / side
