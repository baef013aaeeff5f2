"""Sources with closed forms as rays: a Lambertian disk, sphere and filament, and where their light lands."""

import numpy as np

RADIUS = 0.001
"""Of disk and sphere, half of the filament's length. [m]"""

TURNS, COIL, WIRE = 5, 0.3 * RADIUS, 0.05 * RADIUS
"""Of the filament: turns, radius of the coil and of the wire. [m]"""


def numbers(count: int, seed: int) -> np.ndarray:
    """Random numbers for as many rays. (n, 4)"""
    return np.random.default_rng(seed).random((count, 4))


def disk(u):
    """Rays of a disk in the plane z = 0 that shines upwards by the cosine law. (n, 4) -> (n, 3) [m], (n, 3)"""
    radius, turn = RADIUS * np.sqrt(u[:, 0]), 2.0 * np.pi * u[:, 1]
    position = np.stack([radius * np.cos(turn), radius * np.sin(turn), 0.0 * turn], axis=1)
    return position.astype(np.float32), _lambert(u, np.array([[0.0, 0.0, 1.0]]))


def sphere(u):
    """Rays of a sphere about the origin whose every point shines by the cosine law."""
    height, turn = 2.0 * u[:, 0] - 1.0, 2.0 * np.pi * u[:, 1]
    width = np.sqrt(1.0 - height**2)
    normal = np.stack([width * np.cos(turn), width * np.sin(turn), height], axis=1)
    return (RADIUS * normal).astype(np.float32), _lambert(u, normal)


def helix(u):
    """Rays of a coiled filament along z whose wire shines by the cosine law; one turn does not shade another."""
    turn = 2.0 * np.pi * TURNS * u[:, 0]
    cosine, sine = np.cos(turn), np.sin(turn)
    middle = np.stack([COIL * cosine, COIL * sine, RADIUS * (2.0 * u[:, 0] - 1.0)], axis=1)
    rise = RADIUS / (np.pi * TURNS)
    along = np.stack([-COIL * sine, COIL * cosine, np.full(len(u), rise)], axis=1)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    outward = np.stack([cosine, sine, 0.0 * turn], axis=1)
    across = np.cross(along, outward)
    about = 2.0 * np.pi * u[:, 1:2]
    normal = np.cos(about) * outward + np.sin(about) * across
    return (middle + WIRE * normal).astype(np.float32), _lambert(u, normal)


def _lambert(u, normal):
    """Directions by the cosine law about normals, from the last two numbers."""
    normal = np.broadcast_to(normal, (len(u), 3))
    helper = np.where(np.abs(normal[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    first = np.cross(normal, helper)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    second = np.cross(normal, first)
    sine, turn = np.sqrt(u[:, 2:3]), 2.0 * np.pi * u[:, 3:4]
    made = sine * np.cos(turn) * first + sine * np.sin(turn) * second
    return (made + np.sqrt(1.0 - u[:, 2:3]) * normal).astype(np.float32)


def landing(position, direction, height: float, cells: int, flux=None) -> np.ndarray:
    """Share of the light that lands in each cell of a square of 1.5 times its height, at a height over the origin."""
    rate = np.where(np.abs(direction[:, 2]) < 1e-9, 1e-9, direction[:, 2]).astype(np.float64)
    way = (height - position[:, 2]) / rate
    place = position[:, :2] + way[:, None] * direction[:, :2]
    half = 0.75 * height
    cell = np.floor((place / half + 1.0) * (0.5 * cells)).astype(np.int64)
    inside = (way > 0.0) & (cell >= 0).all(axis=1) & (cell < cells).all(axis=1)
    flux = np.ones(len(way)) if flux is None else flux
    number = cell[inside, 0] * cells + cell[inside, 1]
    return np.bincount(number, flux[inside], cells**2) / flux.sum()


def exact_disk(height: float, cells: int) -> np.ndarray:
    """The same for `disk` in closed form: illuminance of a Lambertian disk on a parallel plane, integrated over cells.

    Factor of a plane element and a parallel disk, J. R. Howell, A Catalog of Radiation Heat Transfer Configuration Factors,
    B-13 and its like.
    """
    node, weight = np.polynomial.legendre.leggauss(6)
    half = 0.75 * height
    edge = np.linspace(-half, half, cells + 1)
    middle, step = 0.5 * (edge[1:] + edge[:-1]), half / cells
    place = (middle[:, None] + step * node).ravel()
    square = place[:, None] ** 2 + place[None, :] ** 2
    total = square + height**2 + RADIUS**2
    factor = 0.5 * (1.0 - (total - 2.0 * RADIUS**2) / np.sqrt(total**2 - 4.0 * RADIUS**2 * square))
    # Exitance 1 / (pi R2) for a flux of 1.
    density = factor / (np.pi * RADIUS**2)
    weights = np.tile(step * weight, cells)
    cell = density * weights[:, None] * weights[None, :]
    return cell.reshape(cells, 6, cells, 6).sum(axis=(1, 3)).ravel()
