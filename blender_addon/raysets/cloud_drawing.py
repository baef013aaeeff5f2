"""Points and rays by which a ray set is drawn, in the light's own axes."""

import numpy as np

from ...engine.raysets.emission import RayLight

POINTS, RAYS = 1500, 60
"""How many of each are drawn."""

REACH = 1.5
"""Length of the rays, over the size of the source."""


def make_points(light: RayLight) -> np.ndarray:
    """Starting points, brighter rays more often. (n, 3) float32 [m]"""
    return _places(light, _choose(light, POINTS, 1))


def make_rays(light: RayLight) -> np.ndarray:
    """Both ends of rays. (2 n, 3) float32 [m]"""
    chosen = _choose(light, RAYS, 2)
    direction = light.emission.direction[chosen].astype(np.float64)
    direction /= np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-12)
    first = _places(light, chosen)
    last = first + REACH * light.emission.size * direction
    return np.stack([first, last], axis=1).reshape(-1, 3).astype(np.float32)


def _choose(light: RayLight, count: int, seed: int) -> np.ndarray:
    """Numbers of rays, drawn by their flux; always the same ones."""
    rng, emission = np.random.default_rng(seed), light.emission
    number = rng.integers(0, len(emission.threshold), count)
    stays = rng.random(count) < emission.threshold[number]
    return np.where(stays, number, emission.other[number])


def _places(light: RayLight, chosen: np.ndarray) -> np.ndarray:
    return (light.emission.position[chosen] + light.centre).astype(np.float32)
