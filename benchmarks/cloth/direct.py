"""Tables of a cloth against light that is sent anew, from directions that no table stands at, counted in round windows."""

import numpy as np

from ...engine.cloth.composition import Cloth
from ...engine.cloth.records import EXITS
from ...engine.cloth.woven import Maker
from ...engine.scattering.data.evaluation import evaluate
from ...engine.scene.scattering import ScatterTable

FLOOR = 0.02
"""Least value that differences are told relative to. [1/sr]"""

RADIUS = np.radians(7.0)
"""Of a window. [rad]"""

STEEPEST = np.radians(80.0)
"""Largest angle of light and of the middle of a window to the normal. [rad]"""

POINTS = 19
"""Of a window, at which the table is read."""


def compare_directly(
    cloth: Cloth,
    sides: dict[str, ScatterTable],
    lights: int,
    windows: int,
    rays: int,
    seed: int = 7,
    exits: int = EXITS,
    wavelength: float = 640.0,
) -> dict[str, dict[str, float]]:
    """Compare the tables of light onto the front with rays, in one band.

    Parameters
    ----------
    lights, windows : int    Directions of light, and windows of each, at random by projected solid angle; pairs in all.
    rays : int    Of each light.
    wavelength : float    Of the band, about. [nm]

    Returns
    -------
    dict    Of ``reflection`` and ``transmission``: ``rms``, the root mean square of the difference over the larger of the
        value and `FLOOR`, without what the rays' own noise adds; ``noise``, that noise; ``mean``, the difference of the
        means over that of the table; ``pairs``.
    """
    wavelengths = sides["front_reflection"].wavelengths
    band = int(np.argmin(np.abs(wavelengths - wavelength)))
    maker = Maker(cloth, wavelengths[band : band + 1], rays, seed, exits)
    rng = np.random.default_rng(seed)
    rows = {"reflection": [], "transmission": []}
    for number in range(lights):
        wi = _draw(rng, 1)[0]
        lost, events, ways, *direction = maker.trace(-wi, maker.rays, 1000 * seed + number)
        weight = maker.weigh((events > 0) & ~lost, ways)[:, 0]
        leaving = np.stack(direction, axis=1)
        wo = _draw(rng, windows)
        for part, is_there in (
            ("reflection", leaving[:, 2] > 0.0),
            ("transmission", leaving[:, 2] < 0.0),
        ):
            # Tables tell of what passes with z turned round.
            seen = leaving[is_there]
            seen[:, 2] = np.abs(seen[:, 2])
            inside = seen @ wo.T > np.cos(RADIUS)
            own = weight[is_there]
            size = np.pi * np.sin(RADIUS) ** 2 * wo[:, 2] * maker.rays
            value = own @ inside / size
            variance = own**2 @ inside / size**2
            rows[part].append((value, variance, _read(sides[f"front_{part}"], wi, wo, band)))
    return {part: _summed(*np.concatenate(each, axis=1)) for part, each in rows.items()}


def _draw(rng, count: int) -> np.ndarray:
    """Directions at random by projected solid angle, up to `STEEPEST`. (n, 3)"""
    sine, turn = np.sin(STEEPEST) * np.sqrt(rng.random(count)), 2.0 * np.pi * rng.random(count)
    return np.stack([sine * np.cos(turn), sine * np.sin(turn), np.sqrt(1.0 - sine**2)], axis=1)


def _read(table: ScatterTable, wi, wo, band: int) -> np.ndarray:
    """Means of a table over windows, by projected solid angle. (n, 3) -> (n,)"""
    share, turn = (np.arange(POINTS) + 0.5) / POINTS, np.pi * (3.0 - 5.0**0.5) * np.arange(POINTS)
    cosine = 1.0 - share * (1.0 - np.cos(RADIUS))
    sine = np.sqrt(1.0 - cosine**2)
    one = np.cross(wo, [0.0, 1.0, 0.0])
    one /= np.linalg.norm(one, axis=1, keepdims=True)
    two = np.cross(wo, one)
    points = (
        cosine[:, None, None] * wo
        + (sine * np.cos(turn))[:, None, None] * one
        + (sine * np.sin(turn))[:, None, None] * two
    )
    flat = points.reshape(-1, 3)
    values = evaluate(table, np.tile(wi, (len(flat), 1)), flat)[:, band].reshape(POINTS, -1)
    return (values * points[..., 2]).sum(axis=0) / points[..., 2].sum(axis=0)


def _summed(value, variance, table) -> dict[str, float]:
    scale = np.maximum(table, FLOOR)
    noise = (variance / scale**2).mean()
    square = (((table - value) / scale) ** 2).mean() - noise
    return {
        "rms": float(np.sqrt(max(square, 0.0))),
        "noise": float(np.sqrt(noise)),
        "mean": float(value.mean() / table.mean() - 1.0),
        "pairs": len(value),
    }
