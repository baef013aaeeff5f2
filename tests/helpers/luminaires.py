"""Made intensity distributions and luminaires, and what is expected of them by other ways than the engine's."""

from functools import cache

import numpy as np
from scipy import stats
from scipy.interpolate import RegularGridInterpolator

from lumenray.engine.luminaires.coordinates import FRAMES
from lumenray.engine.scene.distribution import IntensityDistribution, Opening
from lumenray.engine.scene.light import Luminaire, Output, Quantity
from lumenray.engine.scene.spectrum import Constant


def grid(azimuth, polar, intensity, kind="C"):
    """Distribution by angles in degrees; ``intensity``: (a, p) array or a function of both angles [rad]."""
    azimuth = np.deg2rad(np.atleast_1d(np.asarray(azimuth, dtype=np.float64)))
    polar = np.deg2rad(np.asarray(polar, dtype=np.float64))
    if callable(intensity):
        intensity = intensity(azimuth[:, None], polar[None, :]) + np.zeros(
            (len(azimuth), len(polar))
        )
    return IntensityDistribution(azimuth, polar, np.asarray(intensity, float), FRAMES[kind])


def rotational(values, step=0.5):
    """Distribution of a function of gamma [rad] on a grid of a step [degree]."""
    polar = np.deg2rad(np.linspace(0.0, 180.0, round(180.0 / step) + 1))
    return IntensityDistribution(np.zeros(1), polar, np.maximum(values(polar), 0.0)[None])


def _random(azimuth, polar, seed, power=1.0, kind="C"):
    values = 0.05 + np.random.default_rng(seed).random((len(azimuth), len(polar))) ** power
    # One direction, one value.
    for end, angle in ((0, 0.0), (-1, 180.0)):
        if polar[end] == angle:
            values[:, end] = values[0, end]
    if azimuth[-1] - azimuth[0] == 360:
        values[-1] = values[0]
    return grid(azimuth, polar, values, kind)


def _spike():
    """Almost even, with one cell of 5 x 10 degrees that is 10 000 times as bright."""
    values = np.ones((37, 37))
    values[22:24, 9:11] = 1e4
    return grid(np.arange(0, 361, 10), np.arange(0, 181, 5), values)


def _lambertian(azimuth, polar):
    return np.maximum(np.cos(polar), 0.0)


def _gaussian(half_width):
    """Beam that has half of its peak at this angle from the axis. [degree]"""
    return lambda azimuth, polar: np.exp(-np.log(2.0) * (polar / np.deg2rad(half_width)) ** 2)


def _batwing(azimuth, polar):
    wide = 1.0 + 2.0 * np.sin(polar) ** 2 * (1.0 + np.cos(2.0 * azimuth))
    return np.maximum(np.cos(polar), 0.0) * wide


def _up_and_down(azimuth, polar):
    return np.where(polar < 1.6, 1.0, 0.0) * np.cos(polar) ** 2 + 3.0 * np.clip(
        -np.cos(polar), 0.0, 1.0
    )


DISTRIBUTIONS = {
    "lambertian": grid(0, np.arange(91), _lambertian),
    "even": grid([0, 360], [0, 90, 180], np.ones((2, 3))),
    "pencil": grid(0, np.arange(0, 5.01, 0.1), _gaussian(1.0)),
    "spot": grid(0, np.arange(0, 20.1, 0.5), _gaussian(3.0)),
    "batwing": grid(np.arange(0, 361, 15), np.arange(0, 91, 2.5), _batwing),
    "up and down": grid(np.arange(0, 361, 30), np.arange(0, 181, 5), _up_and_down),
    "asymmetric": _random(np.linspace(0, 360, 24), np.linspace(0, 180, 37), 1, 3.0),
    "irregular": _random(
        np.array([0, 5, 95, 97.5, 200, 360]), np.array([0, 3, 40, 47, 121, 180]), 2
    ),
    "type A": _random(np.arange(-90, 91, 10), np.arange(0, 181, 7.5), 3, 2.0, "A"),
    "type B": _random(np.arange(-90, 91, 7.5), np.arange(30, 151, 5), 4, 2.0, "B"),
    "spike": _spike(),
    "close nodes": _random(
        np.array([0, 0.002, 45, 45.001, 45.003, 180, 359.99, 360]),
        np.array([0, 20, 20.001, 20.003, 60, 60.01, 90, 90.001, 180]),
        5,
    ),
    "tiny": grid(np.arange(0, 361, 90), np.arange(0, 181, 10), lambda a, p: 1e-6 * (1 + p)),
    "huge": grid(np.arange(0, 361, 90), np.arange(0, 181, 10), lambda a, p: 1e9 * (4 - p)),
    "only up": grid(np.arange(0, 361, 90), [90, 100, 140, 180], lambda a, p: -np.cos(p)),
}
"""Of every kind that files hold, and the hard ones."""

OPENINGS = {
    "rectangle": Opening("rectangle", (0.6, 0.0, 0.3), "y"),
    "ellipse": Opening("ellipse", (0.4, 0.5, 0.0), "z"),
    "box": Opening("box", (0.5, 0.3, 0.2)),
    "sphere": Opening("ellipsoid", (0.4, 0.4, 0.4)),
    "ellipsoid": Opening("ellipsoid", (0.6, 0.3, 0.2)),
    "cylinder": Opening("cylinder", (0.2, 0.2, 0.8), "z"),
    "oval cylinder": Opening("cylinder", (0.8, 0.3, 0.2), "x"),
}
"""Every shape, along different axes."""

POINT, WHITE = Opening(), Constant(1.0)


def turn(seed):
    """Random rotation. (3, 3)"""
    q = np.random.default_rng(seed).normal(size=4)
    w, x, y, z = q / np.linalg.norm(q)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def frame_of(place=(0.0, 0.0, 0.0), rotation=None):
    """Rigid placement. (4, 4)"""
    frame = np.eye(4)
    frame[:3, :3] = np.eye(3) if rotation is None else rotation
    frame[:3, 3] = place
    return frame


def luminaire(
    distribution,
    opening=POINT,
    place=(0.0, 0.0, 0.0),
    rotation=None,
    lumens=1000.0,
    key="a",
    spectrum=WHITE,
    **more,
):
    """Luminaire of a flux."""
    if isinstance(distribution, str):
        distribution = DISTRIBUTIONS[distribution]
    output = Output(Quantity.LUMINOUS_FLUX, lumens, spectrum)
    return Luminaire(key, key, output, frame_of(place, rotation), distribution, opening, **more)


# ---- intensity and flux ----


@cache
def _interpolator(distribution):
    azimuth, values = distribution.azimuth, distribution.intensity
    if len(azimuth) == 1:
        azimuth, values = np.array([0.0, 2.0 * np.pi]), np.repeat(values, 2, axis=0)
    # Angles are known to rounding only, and the first and last one must count.
    azimuth, polar = azimuth.copy(), distribution.polar.copy()
    for nodes in (azimuth, polar):
        nodes[0] -= 1e-12
        nodes[-1] += 1e-12
    made = RegularGridInterpolator((azimuth, polar), values, bounds_error=False, fill_value=0.0)
    return made, azimuth[0]


def intensity(distribution, direction):
    """Intensity in directions (..., 3) of the luminaire's axes, by SciPy. [cd]"""
    made, start = _interpolator(distribution)
    d = np.asarray(direction, dtype=np.float64) @ distribution.frame
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    azimuth = start + np.mod(np.arctan2(d[..., 1], d[..., 0]) - start, 2.0 * np.pi)
    polar = np.arctan2(np.hypot(d[..., 0], d[..., 1]), -d[..., 2])
    return made(np.stack([azimuth, polar], axis=-1))


def _hats(nodes, edges, weight):
    """Integrals over bins of the functions that are 1 at one node, 0 at all others and straight between. (bins, nodes)"""
    cuts = np.union1d(nodes, edges)
    cuts = cuts[(cuts >= edges[0]) & (cuts <= edges[-1])]
    x, w = np.polynomial.legendre.leggauss(6)
    half = 0.5 * np.diff(cuts)
    places = (cuts[:-1] + half)[:, None] + half[:, None] * x
    amounts = half[:, None] * w * weight(places)
    inside = (places >= nodes[0]) & (places <= nodes[-1])
    bins = np.clip(np.searchsorted(edges, places[:, 0], side="right") - 1, 0, len(edges) - 2)
    made = np.zeros((len(edges) - 1, len(nodes)))
    for node in range(len(nodes)):
        values = np.interp(places, nodes, np.eye(len(nodes))[node]) * inside
        np.add.at(made[:, node], bins, (values * amounts).sum(axis=1))
    return made


def bin_fluxes(distribution, azimuth_edges, polar_edges):
    """Flux of the bilinear interpolant in bins of the grid's own angles [rad], by Gauss-Legendre quadrature. [lm]"""
    around = (
        np.diff(azimuth_edges)[:, None]
        if len(distribution.azimuth) == 1
        else _hats(distribution.azimuth, azimuth_edges, np.ones_like)
    )
    return around @ distribution.intensity @ _hats(distribution.polar, polar_edges, np.sin).T


@cache
def flux(distribution):
    """Total flux. [lm]"""
    start = distribution.azimuth[0]
    edges = np.array([start, start + 2.0 * np.pi])
    return float(bin_fluxes(distribution, edges, np.array([0.0, np.pi]))[0, 0])


def quantile_edges(distribution, count):
    """Bin edges of azimuth and polar angle that split the flux into about equal parts along each."""
    start = distribution.azimuth[0]
    ends = start, start + 2.0 * np.pi
    if len(distribution.azimuth) > 1:
        ends = start, distribution.azimuth[-1]
    azimuth = np.linspace(*ends, 40 * count + 1)
    azimuth = np.union1d(azimuth, distribution.azimuth[distribution.azimuth <= ends[1]])
    polar = np.linspace(distribution.polar[0], distribution.polar[-1], 40 * count + 1)
    polar = np.union1d(polar, distribution.polar)
    cells = bin_fluxes(distribution, azimuth, polar)
    made = []
    for edges, amounts in ((azimuth, cells.sum(axis=1)), (polar, cells.sum(axis=0))):
        running = np.concatenate([[0.0], np.cumsum(amounts)]) / amounts.sum()
        inner = np.interp(np.arange(1, count) / count, running, edges)
        made.append(np.unique(np.concatenate([edges[:1], inner, edges[-1:]])))
    return made


def grid_angles(distribution, direction):
    """Azimuth from the grid's first one on and polar angle of directions (n, 3) of the luminaire's axes. [rad]"""
    d = np.asarray(direction, dtype=np.float64) @ distribution.frame
    start = distribution.azimuth[0]
    azimuth = start + np.mod(np.arctan2(d[:, 1], d[:, 0]) - start + 1e-6, 2.0 * np.pi) - 1e-6
    return azimuth, np.arctan2(np.hypot(d[:, 0], d[:, 1]), -d[:, 2])


def chi_square(observed, expected):
    """Probability of counts that lie at least this far from what is expected; bins below 5 are pooled."""
    observed, expected = np.ravel(observed).astype(float), np.ravel(expected).astype(float)
    order = np.argsort(expected)
    observed, expected = observed[order], expected[order]
    # The smallest bins together until each pool has 5.
    pool = np.floor(np.minimum(np.cumsum(expected), 1e15) / 5.0)
    small = expected < 5.0
    label = np.where(small, pool, pool[small].max(initial=0) + 1 + np.arange(len(pool)))
    _, label = np.unique(label, return_inverse=True)
    observed, expected = np.bincount(label, observed), np.bincount(label, expected)
    if len(expected) > 1 and expected[0] < 5.0:
        observed[1] += observed[0]
        expected[1] += expected[0]
        observed, expected = observed[1:], expected[1:]
    if len(expected) == 1:
        return 1.0
    statistic = ((observed - expected) ** 2 / expected).sum()
    return float(stats.chi2.sf(statistic, len(expected) - 1))


# ---- openings ----


def opening_axes(opening):
    """The opening's own axes as columns, in the luminaire's, and half sizes along them; its z is the normal or axis."""
    order = {"x": [1, 2, 0], "y": [2, 0, 1], "z": [0, 1, 2]}[opening.axis]
    return np.eye(3)[:, order], 0.5 * np.asarray(opening.size, dtype=np.float64)[order]


def opening_pieces(opening, count, is_scattered=False):
    """Surface of an opening by pieces: points and area elements [m2] along the outward normals, in the luminaire's axes.

    Parameters
    ----------
    count : int    Points along each side.
    is_scattered : bool    Whether they lie evenly without rows, which would line up with the edges of bins.

    Returns
    -------
    list of ((count * count, 3), (count * count, 3))    Every piece has the sum of its elements' lengths as its area.
    """
    axes, h = opening_axes(opening)
    place = (np.arange(count) + 0.5) / count
    u, v = (values.ravel() for values in np.meshgrid(place, place))
    if is_scattered:
        # The additive sequence of the plastic number.
        nth = np.arange(count * count) + 0.5
        u, v = np.mod(0.7548776662466927 * nth, 1.0), np.mod(0.5698402909980532 * nth, 1.0)
    full = 2.0 * np.pi * v
    none = np.zeros_like(u)
    root = np.sqrt(u)
    disk = np.stack([h[0] * root * np.cos(full), h[1] * root * np.sin(full), none], axis=1)
    pieces = []
    match opening.shape:
        case "rectangle":
            flat = np.stack([h[0] * (2 * u - 1), h[1] * (2 * v - 1), none], axis=1)
            area = 4.0 * h[0] * h[1]
            pieces = [(flat, np.tile([0.0, 0.0, side * area], (len(u), 1))) for side in (1, -1)]
        case "ellipse":
            area = np.pi * h[0] * h[1]
            pieces = [(disk, np.tile([0.0, 0.0, side * area], (len(u), 1))) for side in (1, -1)]
        case "box":
            for axis in range(3):
                others = [k for k in range(3) if k != axis]
                for side in (1, -1):
                    points, normal = np.zeros((len(u), 3)), np.zeros(3)
                    points[:, others] = np.stack([2 * u - 1, 2 * v - 1], axis=1) * h[others]
                    points[:, axis] = side * h[axis]
                    normal[axis] = side * 4.0 * np.prod(h[others])
                    pieces.append((points, np.tile(normal, (len(u), 1))))
        case "ellipsoid":
            z = 2 * u - 1
            flat = np.sqrt(1 - z * z)
            unit = np.stack([flat * np.cos(full), flat * np.sin(full), z], axis=1)
            pieces = [(unit * h, unit / h * np.prod(h) * 4.0 * np.pi)]
        case "cylinder":
            c, s = np.cos(full), np.sin(full)
            wall = np.stack([h[0] * c, h[1] * s, h[2] * (2 * u - 1)], axis=1)
            pieces = [(wall, np.stack([h[1] * c, h[0] * s, none], axis=1) * 4.0 * np.pi * h[2])]
            area = np.pi * h[0] * h[1]
            for side in (1, -1):
                cap = disk + np.array([0.0, 0.0, side * h[2]])
                pieces.append((cap, np.tile([0.0, 0.0, side * area], (len(u), 1))))
    return [(points @ axes.T, normals @ axes.T) for points, normals in pieces]


def shown_area(opening, direction):
    """Area that an opening shows towards directions (n, 3) of unit length in the luminaire's axes. [m2]"""
    axes, (a, b, c) = opening_axes(opening)
    x, y, z = np.abs(direction @ axes).T
    match opening.shape:
        case "rectangle":
            return 4.0 * a * b * z
        case "ellipse":
            return np.pi * a * b * z
        case "box":
            return 4.0 * (b * c * x + a * c * y + a * b * z)
        case "ellipsoid":
            return np.pi * np.sqrt((b * c * x) ** 2 + (a * c * y) ** 2 + (a * b * z) ** 2)
        case "cylinder":
            return np.pi * a * b * z + 4.0 * c * np.hypot(a * y, b * x)


def illuminance(light, positions, normals, count=96, is_scattered=False):
    """Direct illuminance by quadrature over the opening; the inverse-square law for a point. (n,) [lx]

    Parameters
    ----------
    light : Luminaire    Of a luminous flux.
    positions, normals : (n, 3) array    Of sensors. [m]
    count, is_scattered    As in `opening_pieces`; without rows, where the distribution has edges.
    """
    positions = np.asarray(positions, dtype=np.float64).reshape(-1, 3)
    normals = np.asarray(normals, dtype=np.float64).reshape(-1, 3)
    normals = normals / np.linalg.norm(normals, axis=1, keepdims=True)
    rotation, centre = light.frame[:3, :3], light.frame[:3, 3]
    local = (positions - centre) @ rotation
    facing = normals @ rotation
    scale = light.output.value / flux(light.distribution)
    if light.opening.shape == "point":
        distance = np.linalg.norm(local, axis=1)
        direction = local / distance[:, None]
        cosine = np.maximum(-(direction * facing).sum(axis=1), 0.0)
        return scale * intensity(light.distribution, direction) * cosine / distance**2
    made = np.zeros(len(positions))
    for points, elements in opening_pieces(light.opening, count, is_scattered):
        for row in range(len(positions)):
            away = local[row] - points
            distance = np.linalg.norm(away, axis=1)
            direction = away / distance[:, None]
            seen = np.maximum((elements * direction).sum(axis=1), 0.0)
            cosine = np.maximum(-direction @ facing[row], 0.0)
            use = (seen > 0.0) & (cosine > 0.0)
            if use.any():
                luminance = intensity(light.distribution, direction[use]) / shown_area(
                    light.opening, direction[use]
                )
                amount = luminance * (seen * cosine / distance**2)[use]
                made[row] += scale * amount.sum() / len(points)
    return made
