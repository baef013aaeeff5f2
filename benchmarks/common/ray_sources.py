"""Sources with closed forms as rays: a Lambertian disk, sphere and filament, and where their light lands."""

import warnings

import numpy as np
from scipy.stats import qmc

RADIUS = 0.001
"""Of disk and sphere, half of the filament's length. [m]"""

TURNS, COIL, WIRE = 5, 0.3 * RADIUS, 0.05 * RADIUS
"""Of the filament: turns, radius of the coil and of the wire. [m]"""


def numbers(count: int, seed: int) -> np.ndarray:
    """Random numbers for as many rays. (n, 4)"""
    return np.random.default_rng(seed).random((count, 4))


def even_numbers(count: int, seed: int) -> np.ndarray:
    """Low-discrepancy numbers (Sobol's, scrambled) for as many rays, as programs that write ray files use them. (n, 4)"""
    with warnings.catch_warnings():
        # Counts of files are round numbers, which are no powers of two.
        warnings.simplefilter("ignore", UserWarning)
        return qmc.Sobol(4, seed=seed).random(count)


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
    position, normal = _wire(u[:, 0], 2.0 * np.pi * u[:, 1:2])
    return position.astype(np.float32), _lambert(u, normal)


def _wire(along, about):
    """Points of the wire and their normals: along it (n,) 0 to 1, and around it (n, 1) [rad]."""
    turn = 2.0 * np.pi * TURNS * along
    cosine, sine = np.cos(turn), np.sin(turn)
    middle = np.stack([COIL * cosine, COIL * sine, RADIUS * (2.0 * along - 1.0)], axis=1)
    rise = RADIUS / (np.pi * TURNS)
    towards = np.stack([-COIL * sine, COIL * cosine, np.full(len(along), rise)], axis=1)
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    outward = np.stack([cosine, sine, 0.0 * turn], axis=1)
    normal = np.cos(about) * outward + np.sin(about) * np.cross(towards, outward)
    return middle + WIRE * normal, normal


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


def landed_shares(position, direction, height: float, cells: int, flux=None) -> np.ndarray:
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
    place, weight = _nodes(height, cells, 6)
    square = place[:, None] ** 2 + place[None, :] ** 2
    total = square + height**2 + RADIUS**2
    factor = 0.5 * (1.0 - (total - 2.0 * RADIUS**2) / np.sqrt(total**2 - 4.0 * RADIUS**2 * square))
    # Exitance 1 / (pi R2) for a flux of 1.
    return _cells(factor / (np.pi * RADIUS**2), weight, cells)


def exact_sphere(height: float, cells: int) -> np.ndarray:
    """The same for `sphere`: outside it lights like a point."""
    place, weight = _nodes(height, cells, 6)
    square = place[:, None] ** 2 + place[None, :] ** 2 + height**2
    return _cells(height / (4.0 * np.pi * square**1.5), weight, cells)


def exact_helix(height: float, cells: int) -> np.ndarray:
    """The same for `helix`, by midpoints along and around the wire (9600 pieces)."""
    place, weight = _nodes(height, cells, 2)
    point = np.stack(
        [*np.meshgrid(place, place, indexing="ij"), np.full((len(place),) * 2, height)], axis=-1
    )
    along, around = 200, 48
    share = (np.arange(along) + 0.5) / along
    about = 2.0 * np.pi * (np.arange(around) + 0.5) / around
    density = np.zeros(point.shape[:2])
    for u in share:
        position, normal = _wire(np.full(around, u), about[:, None])
        way = point[:, :, None] - position
        distance = np.linalg.norm(way, axis=-1)
        sent = np.maximum((way * normal).sum(axis=-1), 0.0)
        density += (sent * way[..., 2] / distance**4).mean(axis=-1) / (np.pi * along)
    return _cells(density, weight, cells)


SOURCES = {
    "disk": (disk, exact_disk),
    "sphere": (sphere, exact_sphere),
    "helix": (helix, exact_helix),
}
"""Rays, and shares of the light in the cells of a plane."""


def _nodes(height: float, cells: int, order: int):
    """Nodes of Gauss and Legendre in the cells along one side of the plane, and their weights."""
    node, weight = np.polynomial.legendre.leggauss(order)
    half = 0.75 * height
    edge = np.linspace(-half, half, cells + 1)
    middle, step = 0.5 * (edge[1:] + edge[:-1]), half / cells
    return (middle[:, None] + step * node).ravel(), np.tile(step * weight, cells)


def _cells(density, weight, cells: int) -> np.ndarray:
    """Integrals over cells of what is known at all pairs of nodes."""
    part = density * weight[:, None] * weight[None, :]
    return part.reshape(cells, -1, cells, len(weight) // cells).sum(axis=(1, 3)).ravel()
