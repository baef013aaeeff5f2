"""Luminance pictures of simple scenes, exact at every pixel's centre, and what evalglare says of them."""

import subprocess
from importlib import util
from pathlib import Path

import numpy as np
from radiance_files import write_picture

from lumenray.engine.analysis.picture_view import Mapping, PictureView

RADIANCE_TYPES = {
    Mapping.EQUIDISTANT: "-vta",
    Mapping.ORTHOGRAPHIC: "-vth",
    Mapping.PERSPECTIVE: "-vtv",
}


def view_of(mapping, size, degrees=180.0):
    angle = np.radians(degrees)
    return PictureView.of_angles(mapping, size, size, angle, angle)


def _window(u, v, d):
    return np.where((np.abs(u - 0.5) < 0.35) & (np.abs(v - 0.4) < 0.45), 4000.0 + 3000.0 * v, 0.0)


def _sun(u, v, d):
    light = np.where((np.abs(u - 0.2) < 0.6) & (np.abs(v - 0.5) < 0.45), 9000.0, 0.0)
    towards = np.array([0.3, 0.5, -np.sqrt(0.66)])
    return np.where(d @ towards > np.cos(np.radians(2.5)), 8e5, light)


def _lamps(u, v, d):
    with np.errstate(all="ignore"):
        aside, ahead = 1.8 * u / v, 1.8 / v
    shines = np.zeros(v.shape, bool)
    for x in (-1.0, 0.3, 1.2):
        for y in (2.0, 4.0):
            shines |= (v > 0.0) & (np.abs(aside - x) < 0.3) & (np.abs(ahead - y) < 0.3)
    return np.where(shines, 6000.0, 0.0)


def _low(u, v, d):
    towards = np.array([0.4, -0.3, -np.sqrt(0.75)])
    return np.where(d @ towards > np.cos(np.radians(6.0)), 20000.0, 0.0)


SCENES = {"window": _window, "sun": _sun, "lamps": _lamps, "low": _low}


def picture_of(scene, view):
    """Luminances of a scene before a dim room. (h, w) [cd/m2]"""
    directions, solid = view.pixels()
    depth = np.where(directions[..., 2] < 0.0, -directions[..., 2], np.nan)
    room = np.where(directions[..., 1] > 0.0, 80.0 + 200.0 * directions[..., 1], 40.0)
    u, v = directions[..., 0] / depth, directions[..., 1] / depth
    bright = SCENES[scene](u, v, directions)
    return np.where(solid > 0.0, np.where(bright > 0.0, bright, room), 0.0)


def write_radiance(path, luminance, view, degrees=180.0) -> Path:
    """Write a picture as Radiance does, with its view."""
    line = f"VIEW= {RADIANCE_TYPES[view.mapping]} -vp 0 0 0 -vd 0 1 0 -vu 0 0 1 -vh {degrees} -vv {degrees}"
    colours = np.repeat(luminance[..., None] / 179.0, 3, axis=2)
    path.write_bytes(write_picture(colours, [line], packed=True))
    return path


def evalglare(path) -> dict:
    """What Radiance's evalglare says of a picture; it comes with the package `pyradiance`."""
    program = Path(util.find_spec("pyradiance").origin).parent / "bin" / "evalglare"
    made = subprocess.run([program, "-d", path], capture_output=True, text=True, check=True)
    line = next(each for each in made.stdout.splitlines() if each.startswith("dgp,"))
    names, values = line.split(": ")
    return dict(zip(names.split(","), map(float, values.split()), strict=True))
