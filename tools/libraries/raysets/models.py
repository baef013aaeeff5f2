"""Models of lamps whose rays we make: an LED under a dome, one in a collimator, a filament lamp, a fluorescent tube.

They are drawn after the kind of lamp, not after a product. Light goes along +z, the origin lies in the middle of the board
on which an LED sits, and in the middle of a lamp.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ....libraries.raysets.catalogue import ENTRIES, Entry
from .lathe import Profile, pass_through

MILLIMETRE = 1e-3
"""[m]"""

SILICONE, ACRYLIC = 1.41, 1.49
"""Refractive indices about 550 nm. [-]"""


@dataclass(frozen=True)
class RayModel:
    """A lamp.

    Parameters
    ----------
    entry : Entry    What it is called, and how much light it gives.
    make : callable    From a number of rays and a random generator to positions [m], directions, and relative flux.
    """

    entry: Entry
    make: Callable


def lambertian(normal: np.ndarray, rng) -> np.ndarray:
    """Directions by the cosine law about normals (n, 3)."""
    helper = np.where(np.abs(normal[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normal, first)
    square, turn = rng.random((len(normal), 1)), 2.0 * np.pi * rng.random((len(normal), 1))
    across = np.cos(turn) * first + np.sin(turn) * second
    return np.sqrt(square) * across + np.sqrt(1.0 - square) * normal


def _chip(count: int, side: float, rng):
    """Rays of a square chip in the plane z = 0."""
    position = np.zeros((count, 3))
    position[:, :2] = side * (rng.random((count, 2)) - 0.5)
    return position, lambertian(np.tile([0.0, 0.0, 1.0], (count, 1)), rng)


def _above(position, direction, rays):
    """Keep rays that go upwards from the board; it swallows the others."""
    kept = direction[:, 2] > 1e-3
    return position[kept], direction[kept], np.ones(int(kept.sum()))


def _traced(profile: Profile, index: float, emit: Callable) -> Callable:
    """Make rays of what comes out of a body, as many as wanted."""

    def make(count: int, rng):
        positions, directions = [], []
        left = count
        while left > 0:
            start, towards = emit(max(left, 256), rng)
            position, direction, number = pass_through(profile, index, start, towards, rng)
            position, direction, _ = _above(position, direction, number)
            positions.append(position)
            directions.append(direction)
            left -= len(position)
        position = np.concatenate(positions)[:count]
        return position, np.concatenate(directions)[:count], np.ones(count)

    return make


def dome_profile(radius: float, pieces: int = 90) -> Profile:
    """Return a hemisphere on the plane z = 0; light comes from below its flat side."""
    angle = np.linspace(0.0, 0.5 * np.pi, pieces + 1)
    return Profile(radius * np.stack([np.cos(angle), np.sin(angle)], axis=1))


def _dome() -> RayModel:
    profile = dome_profile(1.25 * MILLIMETRE)
    return RayModel(
        _entry("led_dome"),
        _traced(profile, SILICONE, lambda count, rng: _chip(count, 1.0 * MILLIMETRE, rng)),
    )


def collimator_profile(pieces: int = 80) -> Profile:
    """Return a collimator: a lens over the chip and a wall that reflects totally what passes beside it.

    The lens is the surface that makes light of one point parallel in the body: equal optical paths give
    rho = n z - (n - 1) z0. The wall is found piece by piece: its normal halves the angle between the refracted ray of the
    chip's middle and the axis.
    """
    wall, bottom, lens = 2.0 * MILLIMETRE, 0.0, 2.2 * MILLIMETRE
    wide, n = 9.0 * MILLIMETRE, ACRYLIC
    r = np.linspace(0.0, wall, pieces // 2)
    # (n z - (n - 1) z0)^2 = z^2 + r^2, solved for z.
    k = (n - 1.0) * lens
    z = (n * k + np.sqrt((n * k) ** 2 - (n**2 - 1.0) * (k**2 - r**2))) / (n**2 - 1.0)
    ceiling = np.stack([r, z], axis=1)
    outer = [np.array([wall + 0.3 * MILLIMETRE, bottom])]
    step = (wide - outer[0][0]) / pieces
    while outer[-1][0] < wide:
        # By the slope in the middle of the step (midpoint method).
        half = outer[-1] + 0.5 * step * _wall_slope(*outer[-1], wall, n)
        outer.append(outer[-1] + step * _wall_slope(*half, wall, n))
    outer = np.array(outer)
    top = outer[-1, 1]
    # Around the body with its inside to the left: up the wall, over the top, down the axis to the lens, out and down.
    return Profile(
        np.concatenate([outer, [[0.0, top]], ceiling, [[wall, bottom], [outer[0, 0], bottom]]])
    )


def _wall_slope(radius: float, height: float, wall: float, index: float) -> np.ndarray:
    """Way along the reflecting wall for a step of 1 away from the axis."""
    tangent = _through_wall(radius, height, wall, index) + np.array([0.0, 1.0])
    return tangent / tangent[0]


def _through_wall(radius: float, height: float, wall: float, index: float) -> np.ndarray:
    """Direction (r, z) in the body of the ray from the origin that passes the upright wall and reaches a point."""
    low, high = 0.0, max(height, 1e-12) * 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        sine = middle / np.hypot(wall, middle) / index
        reached = middle + (radius - wall) * sine / np.sqrt(1.0 - sine**2)
        low, high = (middle, high) if reached < height else (low, middle)
    sine = low / np.hypot(wall, low) / index
    return np.array([np.sqrt(1.0 - sine**2), sine])


def _collimator() -> RayModel:
    return RayModel(
        _entry("led_collimator"),
        _traced(
            collimator_profile(), ACRYLIC, lambda count, rng: _chip(count, 1.0 * MILLIMETRE, rng)
        ),
    )


def _filament() -> RayModel:
    """Coil of ten turns; a ray that meets the wire again is drawn anew."""
    turns, coil, wire, half = 10, 0.75 * MILLIMETRE, 0.12 * MILLIMETRE, 2.4 * MILLIMETRE
    path = np.linspace(-1.0, 1.0, 40 * turns)
    turn = np.pi * turns * path
    middles = np.stack([half * path, coil * np.cos(turn), coil * np.sin(turn)], axis=1)

    def emit(count, rng):
        u = 2.0 * rng.random(count) - 1.0
        turn = np.pi * turns * u
        outward = np.stack([0.0 * u, np.cos(turn), np.sin(turn)], axis=1)
        middle = coil * outward + half * u[:, None] * np.array([1.0, 0.0, 0.0])
        rate = np.pi * turns * coil
        along = np.stack([np.full(count, half), -rate * np.sin(turn), rate * np.cos(turn)], axis=1)
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        about = 2.0 * np.pi * rng.random((count, 1))
        normal = np.cos(about) * outward + np.sin(about) * np.cross(along, outward)
        return middle + wire * normal, lambertian(normal, rng)

    def make(count, rng):
        positions, directions, left = [], [], count
        while left > 0:
            position, direction = emit(min(max(left, 256), 4096), rng)
            away = middles[None] - position[:, None]
            ahead = np.einsum("nki,ni->nk", away, direction)
            apart = np.einsum("nki,nki->nk", away, away) - ahead**2
            # The wire that it leaves is behind it or at its side.
            free = ~((ahead > 2.0 * wire) & (apart < wire**2)).any(axis=1)
            positions.append(position[free])
            directions.append(direction[free])
            left -= int(free.sum())
        position = np.concatenate(positions)[:count]
        return position, np.concatenate(directions)[:count], np.ones(count)

    return RayModel(
        _entry("filament"),
        make,
    )


def _tube() -> RayModel:
    """Tube of 26 mm by 590 mm along x, darker towards its ends."""
    length, radius = 590.0 * MILLIMETRE, 13.0 * MILLIMETRE

    def make(count, rng):
        u = rng.random(count) - 0.5
        turn = 2.0 * np.pi * rng.random(count)
        normal = np.stack([0.0 * u, np.cos(turn), np.sin(turn)], axis=1)
        position = radius * normal
        position[:, 0] = length * u
        # The luminance rises over the first 40 mm from the electrode.
        inside = (0.5 - np.abs(u)) * length
        flux = 1.0 - 0.75 * np.exp(-inside / (25.0 * MILLIMETRE))
        return position, lambertian(normal, rng), flux

    return RayModel(
        _entry("tube_t8_18w"),
        make,
    )


def _entry(name: str) -> Entry:
    return next(entry for entry in ENTRIES if entry.name == name)


MODELS = (_dome(), _collimator(), _filament(), _tube())
"""All."""
