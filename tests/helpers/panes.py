"""Panes by the sum over their inner reflections, each with its amplitudes in both polarisations; no engine in it.

Light is a matrix (3, 3): the mean product of the components of its field, whose trace is the amount.
"""

import numpy as np
from small_scenes import quad


def unit(vector):
    """Vector of length 1."""
    vector = np.asarray(vector, float)
    return vector / np.linalg.norm(vector)


def unpolarised(direction):
    """Unpolarised light of amount 1 that goes in a direction."""
    return 0.5 * (np.eye(3) - np.outer(direction, direction))


def send_on(light, direction, normal, index, internal, is_reflected, orders=100):
    """What a pane sends on of light, without interference of its inner reflections.

    Returns
    -------
    ((3, 3) array, (3,) array)    The light and its direction.
    """
    normal = -np.sign(direction @ normal) * np.asarray(normal, float)
    cosine = -(direction @ normal)
    across = np.cross(direction, normal)
    if np.linalg.norm(across) < 1e-9:
        across = np.cross(direction, [1.0, 0.3, 0.2])
    across = unit(across)
    onwards = direction + 2.0 * cosine * normal if is_reflected else direction
    before, after = np.cross(direction, across), np.cross(onwards, across)
    inside = np.sqrt(1.0 - (1.0 - cosine**2) / index**2)
    outer = np.array(
        [
            (cosine - index * inside) / (cosine + index * inside),
            (index * cosine - inside) / (index * cosine + inside),
        ]
    )
    both, body = 1.0 - outer**2, internal ** (0.5 / inside)
    if is_reflected:
        inner = [-outer * both * body**2 * (outer * body) ** (2 * k) for k in range(orders)]
        ways = [outer, *inner]
    else:
        ways = [both * body * (outer * body) ** (2 * k) for k in range(orders)]
    total = np.zeros((3, 3))
    for s, p in ways:
        amplitude = s * np.outer(across, across) + p * np.outer(after, before)
        total += amplitude @ light @ amplitude.T
    return total, onwards


def share(degrees, index, internal, is_reflected, polarisation=None):
    """Share that one pane reflects or lets pass, of one polarisation (0: s, 1: p) or unpolarised."""
    angle = np.radians(degrees)
    direction = np.array([np.sin(angle), 0.0, -np.cos(angle)])
    light = unpolarised(direction)
    if polarisation is not None:
        axis = np.array([0.0, 1.0, 0.0])
        axis = np.cross(direction, axis) if polarisation else axis
        light = np.outer(axis, axis)
    return float(np.trace(send_on(light, direction, [0, 0, 1], index, internal, is_reflected)[0]))


def stack_share(degrees, index, internal, count):
    """Share that parallel panes let pass with all reflections between them, each polarisation by itself."""
    passed = 0.0
    for polarisation in (0, 1):
        r, t = (share(degrees, index, internal, flag, polarisation) for flag in (True, False))
        up, down, through = r, r, t
        for _ in range(count - 1):
            # One more pane behind: what goes to and fro between it and those before adds up.
            between = 1.0 / (1.0 - up * r)
            up, down, through = (
                r + t * t * up * between,
                down + through * through * r * between,
                through * t * between,
            )
        passed += 0.5 * through
    return passed


def tilted_pane(name, centre, normal, half, material):
    """Square pane about a point."""
    first = unit(np.cross(normal, [0.31, 0.52, 0.93]))
    second = np.cross(normal, first)
    corner = np.asarray(centre, float) - half * (first + second)
    return quad(name, corner, 2.0 * half * first, 2.0 * half * second, material)
