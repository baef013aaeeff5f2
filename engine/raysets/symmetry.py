"""Whether a ray set is the same all around an axis, so that each of its rays stands for a whole ring of them.

What a set of few rays lacks most is their number: four numbers place a ray, and ten thousand rays leave ten places along
each. Of a lamp that is the same all around, three numbers place a ray. So symmetry is looked for where turning keeps the
body, and taken where the rays do not speak against it.
"""

from dataclasses import dataclass

import numpy as np

from .body import Hull, Plane, Sphere
from .record import Rays

MOST_POWER = 12.0
"""A harmonic of even rays is larger than that, in units of its own chance, once in exp(12) = 160 000 cases. [-]"""

LOOKED_AT = 1 << 17
"""Rays that are asked at most."""

ORDERS = 8
"""Harmonics that are looked at: eight-sided lamps and all below are told from round ones."""


@dataclass(frozen=True, eq=False)
class Axis:
    """What a source can be turned about. ``centre`` (3,) [m], ``direction`` (3,) unit vector, float64."""

    centre: np.ndarray
    direction: np.ndarray

    def turn(self, position: np.ndarray, direction: np.ndarray, angle: np.ndarray):
        """Turn rays. (n, 3) [m], (n, 3), (n,) [rad] -> the first two"""
        cosine, sine = np.cos(angle)[:, None], np.sin(angle)[:, None]

        def rotate(vector):
            along = (vector @ self.direction)[:, None] * self.direction
            return along + cosine * (vector - along) + sine * np.cross(self.direction, vector)

        return self.centre + rotate(position - self.centre), rotate(direction)


def find_axis(rays: Rays, body: Plane | Sphere | Hull, is_sure: bool = False) -> Axis | None:
    """Find an axis about which rays are even, as far as their number can tell; None where there is none.

    Only bodies that are round about an axis by themselves are asked: of others, turning would start rays beside the body.

    Parameters
    ----------
    rays : Rays
    body : Plane, Sphere or Hull    From which they start.
    is_sure : bool    Whether it is known that there is one: then the one that fits best is returned, whatever the body.
    """
    if len(rays) > LOOKED_AT:
        # By chance: every second point of a low-discrepancy sequence lies on one side of the axis.
        some = np.random.default_rng(0).choice(len(rays), LOOKED_AT, replace=False)
        rays = Rays(rays.position[some], rays.direction[some], rays.weight[some])
    weight = rays.weight.astype(np.float64)
    weight /= weight.sum()
    centre = body.centre if isinstance(body, Sphere) else weight @ rays.position.astype(np.float64)
    if isinstance(body, Plane):
        candidates = [Axis(centre, body.normal)]
    elif isinstance(body, Sphere) or is_sure:
        candidates = [Axis(centre, each) for each in _directions(rays, weight)]
    else:
        return None
    powers = [strongest_harmonic(rays, axis) for axis in candidates]
    if is_sure:
        return candidates[int(np.argmin(powers))]
    even = [axis for axis, power in zip(candidates, powers, strict=True) if power < MOST_POWER]
    return even[0] if even else None


def strongest_harmonic(rays: Rays, axis: Axis) -> float:
    """Power of the strongest harmonic around an axis, in units of what chance gives a set of as many rays. [-]

    Looked at are starting points, directions, and the points where rays pass the axis, and how they go together: sums of
    products that a turn by an angle t multiplies by exp(i m t), which are zero in the mean if nothing depends on that angle.
    """
    first = np.cross(axis.direction, np.eye(3)[np.argmin(np.abs(axis.direction))])
    first /= np.linalg.norm(first)
    second = np.cross(axis.direction, first)
    direction = rays.direction.astype(np.float64)
    away = rays.position.astype(np.float64) - axis.centre
    # Where the ray comes closest to the centre tells the shape of what shines within a clear body.
    nearest = away - (away * direction).sum(axis=1, keepdims=True) * direction
    seen = [vector @ first + 1j * (vector @ second) for vector in (away, direction, nearest)]
    # Points on the axis have no angle; they count for nothing there.
    scale = [max(np.sqrt((np.abs(each) ** 2).mean()), 1e-200) for each in seen]
    angle = [each / np.maximum(np.abs(each), 1e-9 * s) for each, s in zip(seen, scale, strict=True)]
    far = [np.abs(each) / s for each, s in zip(seen, scale, strict=True)]
    weight = rays.weight.astype(np.float64)
    strongest = 0.0
    for order in range(1, ORDERS + 1):
        for own, size in zip(angle, far, strict=True):
            strongest = max(
                strongest, _power(weight, own**order), _power(weight, size * own**order)
            )
        for one, other in ((0, 1), (0, 2), (1, 2)):
            for share in (order // 2, -1, order + 1):
                mixed = _power_of(angle[one], order - share) * _power_of(angle[other], share)
                strongest = max(strongest, _power(weight, mixed))
    return strongest


def _power_of(angle: np.ndarray, order: int) -> np.ndarray:
    """exp(i m t) from exp(i t), also for m < 0."""
    return angle**order if order >= 0 else np.conj(angle) ** -order


def _power(weight: np.ndarray, value: np.ndarray) -> float:
    """Power of a mean over that of its chance."""
    chance = (weight**2 * np.abs(value) ** 2).sum()
    return float(np.abs((weight * value).sum()) ** 2 / max(chance, 1e-300))


def _directions(rays: Rays, weight: np.ndarray) -> list[np.ndarray]:
    """Directions that may be the axis of a sphere's light: z, the mean direction, and the main ones of all."""
    direction = rays.direction.astype(np.float64)
    found = [np.array([0.0, 0.0, 1.0])]
    mean = weight @ direction
    if np.linalg.norm(mean) > 0.05:
        found.append(mean / np.linalg.norm(mean))
    main = np.linalg.eigh(direction.T @ (weight[:, None] * direction))[1].T
    return found + list(main)
