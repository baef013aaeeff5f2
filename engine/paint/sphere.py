"""A sphere of a paint for a look: quick enough to follow a slider.

A few bands are enough for a look, and the waves of its surface are left out. What single flakes reflect is sharp and in
closed form, so it is computed at every other pixel; the rest is smooth and computed at every fourth.
"""

import numpy as np

from ..photometry.colour import XYZ_TO_REC709
from ..scattering.data.tristimulus import weights_of
from .composition import Paint
from .first_order import pairs_of
from .solution import Resolution, Solution, resolution_for, solve

WAVELENGTHS = np.array([430.0, 470.0, 510.0, 550.0, 590.0, 630.0, 670.0])
"""Bands of the look. [nm]"""

LIGHT = np.array([-0.5, 0.6, 0.62])
"""Direction of the light, which is far away; the eye is along z."""

BRIGHTNESS = 1.15
"""Irradiance of the light across its rays over pi, in units of what a screen shows as white. [-]"""

ROOM, WINDOW = 0.22, 2.5
"""Radiance of the room around, and of the window that the clear surface mirrors. [-]"""

SHARP, SMOOTH = 2, 4
"""Every how many pixels are computed."""

KNEE = 0.8
"""From which on highlights are rolled off. [-]"""

COARSE = 2.0 / 3.0
"""Share of directions and modes of a solution that a look is made of."""

EDGE = 0.985
"""Radius of the sphere over half the side of the picture. [-]"""


def paint_sphere(paint: Paint, side: int = 256, background=(0.0, 0.0, 0.0, 0.0)) -> np.ndarray:
    """Picture of a sphere of a paint under a light from the left above, in a grey room with a window.

    Parameters
    ----------
    paint : Paint
    side : int    [pixel]
    background : sequence of float    Display-encoded RGBA around it.

    Returns
    -------
    (side, side, 4) float32 array    Display-encoded RGBA 0..1, the bottom row first.

    Raises
    ------
    SceneError    The paint cannot be solved.
    """
    solution = solve(paint, WAVELENGTHS, resolution=_look_of(paint))
    weights = weights_of(WAVELENGTHS) @ XYZ_TO_REC709.T
    colour = _enlarged(_of_flakes(solution, -(-side // SHARP)) @ weights, side)
    colour += _enlarged(_of_rest(solution, -(-side // SMOOTH)) @ weights, side)
    place = _places(side)
    radius = np.hypot(*place)
    inside = radius < EDGE + 1.0 / side
    colour = colour[inside]
    colour += _mirrored(solution, _normals(place[:, inside] / EDGE)[0], weights)
    picture = np.empty((side, side, 4), np.float32)
    picture[...] = background
    # Half a pixel's width of the edge is blended.
    cover = np.clip((EDGE - radius[inside]) * 0.5 * side + 0.5, 0.0, 1.0)[:, None]
    shown = np.concatenate([encode(colour), np.ones((len(colour), 1))], axis=1)
    picture[inside] = picture[inside] * (1.0 - cover) + shown * cover
    return picture


def _look_of(paint: Paint) -> Resolution:
    """Resolution that a look needs: within a few hundredths of what is exact where most differs."""
    size = resolution_for(paint)
    return Resolution(2 * round(0.5 * COARSE * size.directions), round(COARSE * size.modes))


def encode(colour: np.ndarray) -> np.ndarray:
    """Display-encoded values of linear ones that a screen can show (sRGB); highlights are rolled off. (..., 3)"""
    colour = np.maximum(colour, 0.0)
    # What is above the knee comes nearer and nearer to white, all colours by the same factor.
    most = colour.max(axis=-1, keepdims=True)
    over = np.maximum(most - KNEE, 0.0)
    rolled = KNEE + (1.0 - KNEE) * over / (over + 1.0 - KNEE)
    colour = colour * np.where(over > 0.0, rolled / np.maximum(most, 1e-9), 1.0)
    return np.where(colour <= 0.0031308, 12.92 * colour, 1.055 * colour ** (1.0 / 2.4) - 0.055)


def _places(side: int) -> np.ndarray:
    """Places of pixels from -1 to 1, the bottom row first. (2, side, side)"""
    line = (2.0 * np.arange(side) + 1.0) / side - 1.0
    return np.stack(np.meshgrid(line, line))


def _normals(places) -> tuple[np.ndarray, np.ndarray]:
    """Normals of the sphere; beyond its edge those of the edge. (..., 3), and the cosines to the eye"""
    x, y = places
    radius = np.hypot(x, y)
    limit = np.minimum(radius, 0.999) / np.maximum(radius, 1e-9)
    x, y = x * limit, y * limit
    z = np.sqrt(1.0 - x * x - y * y)
    return np.stack([x, y, z], axis=-1), z


def _directions(side: int):
    """Light and eye about the normals of lit pixels, (n, 3) both, which pixels these are, and the light's cosines."""
    normal, _ = _normals(_places(side) / EDGE)
    light = LIGHT / np.linalg.norm(LIGHT)
    cosine = normal @ light
    lit = cosine > 1e-3
    own = normal[lit]
    # Any frame about the normal: the paint looks the same from all sides.
    across = np.cross(own, [0.0, 0.0, 1.0])
    length = np.linalg.norm(across, axis=1, keepdims=True)
    across = np.where(length > 1e-6, across / np.maximum(length, 1e-6), [1.0, 0.0, 0.0])
    along = np.cross(across, own)
    wi, wo = (
        np.stack([across @ w, along @ w, own @ w], axis=1)
        for w in (light, np.array([0.0, 0.0, 1.0]))
    )
    return wi, wo, lit, cosine[lit]


def _of_flakes(solution: Solution, side: int) -> np.ndarray:
    """Light of the lamp that single flakes reflect. (side, side, w)"""
    wi, wo, lit, cosine = _directions(side)
    made = np.zeros((side, side, len(solution.wavelengths)))
    made[lit] = np.pi * BRIGHTNESS * cosine[:, None] * solution.first_order(pairs_of(wi, wo))
    return made


def _of_rest(solution: Solution, side: int) -> np.ndarray:
    """All other light that is scattered, of the lamp and of the room. (side, side, w)"""
    wi, wo, lit, cosine = _directions(side)
    made = np.zeros((side, side, len(solution.wavelengths)))
    rest = np.maximum(solution.rest(pairs_of(wi, wo)), 0.0)
    made[lit] = np.pi * BRIGHTNESS * cosine[:, None] * rest
    _, seen = _normals(_places(side) / EDGE)
    sines = np.linspace(0.0, 1.0, 65)
    albedo = solution.albedo(sines)
    level = np.sqrt(1.0 - seen**2)
    for band in range(albedo.shape[1]):
        made[..., band] += ROOM * np.interp(level, sines, albedo[:, band])
    return made


def _mirrored(solution: Solution, normal: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Light of room and window that the clear surface mirrors. (n, 3), (w, c) -> (n, c)"""
    seen = 2.0 * normal[:, 2:] * normal - [0.0, 0.0, 1.0]
    sines = np.linspace(0.0, 1.0, 65)
    share = solution.mirror(sines) @ weights
    level = np.hypot(normal[:, 0], normal[:, 1])
    # A window above on the left, by the direction that is mirrored, with soft edges.
    azimuth, height = np.arctan2(seen[:, 0], seen[:, 2]), np.arcsin(np.clip(seen[:, 1], -1.0, 1.0))
    inside = [
        np.clip((half - np.abs(angle - middle)) / 0.05 + 0.5, 0.0, 1.0)
        for angle, middle, half in ((azimuth, -0.75, 0.22), (height, 0.75, 0.22))
    ]
    room = ROOM * (1.0 + 0.5 * seen[:, 1]) + WINDOW * inside[0] * inside[1]
    return np.stack([room * np.interp(level, sines, each) for each in share.T], axis=1)


def _enlarged(values: np.ndarray, side: int) -> np.ndarray:
    """Values of coarse pixels between their middles, linear. (k, k, w) -> (side, side, w)"""
    count = len(values)
    place = np.clip((np.arange(side) + 0.5) * count / side - 0.5, 0.0, count - 1.0)
    low = np.minimum(place.astype(int), count - 2)
    share = (place - low)[:, None, None]
    values = values[low] * (1.0 - share) + values[low + 1] * share
    values = values.transpose(1, 0, 2)
    return (values[low] * (1.0 - share) + values[low + 1] * share).transpose(1, 0, 2)
