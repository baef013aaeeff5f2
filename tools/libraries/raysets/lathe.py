"""Light through a clear body of revolution: refraction and total reflection at a profile turned about the z axis."""

from dataclasses import dataclass

import numpy as np

SMOOTH = np.deg2rad(30.0)
"""Edges of the profile that turn by less are round. [rad]"""

MOST_HITS = 60
"""Surfaces that a ray may meet; what is caught for longer is dropped."""

AWAY = 1e-9
"""Distance within which a ray does not meet the surface that it has left. [m]"""


@dataclass(frozen=True, eq=False)
class Profile:
    """Half of a section through a body, as a line of points; the body lies to its left.

    Parameters
    ----------
    points : (k, 2) float64 array    Distance from the axis and height. [m]
    """

    points: np.ndarray

    def normals(self) -> tuple[np.ndarray, np.ndarray]:
        """Outward normals (r, z) at both ends of every piece, alike where two pieces meet smoothly. (k - 1, 2) each"""
        along = np.diff(self.points, axis=0)
        along /= np.linalg.norm(along, axis=1, keepdims=True)
        flat = np.stack([along[:, 1], -along[:, 0]], axis=1)
        first, second = flat.copy(), flat.copy()
        turn = np.arccos(np.clip((flat[1:] * flat[:-1]).sum(axis=1), -1.0, 1.0))
        for joint in np.flatnonzero(turn < SMOOTH):
            mean = flat[joint] + flat[joint + 1]
            second[joint] = first[joint + 1] = mean / np.linalg.norm(mean)
        return first, second


def meet(profile: Profile, position: np.ndarray, direction: np.ndarray):
    """Find where rays meet the body first.

    Parameters
    ----------
    profile : Profile
    position, direction : (n, 3) float64 arrays    [m], unit vectors

    Returns
    -------
    ((n,) float64 array, (n, 3) float64 array)    Distance, infinite without a hit, [m] and outward normal.
    """
    first, second = profile.normals()
    nearest = np.full(len(position), np.inf)
    normal = np.zeros((len(position), 3))
    x, y, z = position.T
    dx, dy, dz = direction.T
    for (r0, z0), (r1, z1), n0, n1 in zip(
        profile.points[:-1], profile.points[1:], first, second, strict=True
    ):
        length2 = (r1 - r0) ** 2 + (z1 - z0) ** 2
        for way in _roots(x, y, z, dx, dy, dz, r0, z0, r1, z1):
            with np.errstate(invalid="ignore"):
                height = z + way * dz
                radius = np.hypot(x + way * dx, y + way * dy)
                share = ((radius - r0) * (r1 - r0) + (height - z0) * (z1 - z0)) / length2
                # A cone has a second half, and a plane goes on.
                apart = np.hypot(r0 + share * (r1 - r0) - radius, z0 + share * (z1 - z0) - height)
                fits = apart <= 1e-6 * np.sqrt(length2)
                hit = (way > AWAY) & (way < nearest) & (share >= 0.0) & (share <= 1.0) & fits
            own = n0 + share[hit, None] * (n1 - n0)
            own /= np.linalg.norm(own, axis=1, keepdims=True)
            around = np.stack([x + way * dx, y + way * dy], axis=1)[hit]
            around /= np.maximum(np.linalg.norm(around, axis=1, keepdims=True), 1e-30)
            nearest[hit] = way[hit]
            normal[hit] = np.column_stack([own[:, :1] * around, own[:, 1]])
    return nearest, normal


def _roots(x, y, z, dx, dy, dz, r0, z0, r1, z1):
    """Distances at which rays meet the whole cone, cylinder or plane of a piece of the profile."""
    with np.errstate(divide="ignore", invalid="ignore"):
        if abs(z1 - z0) <= 1e-12:
            yield (z0 - z) / dz
            return
        slope = (r1 - r0) / (z1 - z0)
        base = r0 + slope * (z - z0)
        a = dx**2 + dy**2 - (slope * dz) ** 2
        b = x * dx + y * dy - base * slope * dz
        c = x**2 + y**2 - base**2
        root = np.sqrt(b**2 - a * c)
        # Both in the form that loses no digits.
        far = -(b + np.copysign(root, b))
        yield far / a
        yield c / far


def pass_through(profile: Profile, index: float, position, direction, rng):
    """Send rays from inside or outside of a body on until they leave it for good.

    Parameters
    ----------
    profile : Profile
    index : float    Refractive index of the body.
    position, direction : (n, 3) float64 arrays    [m]
    rng : numpy.random.Generator    Chooses between reflection and refraction by Fresnel's formulas.

    Returns
    -------
    ((m, 3), (m, 3), (m,))    Where rays left, their directions, and which of the n they are; without those that met nothing,
        which start where they did, and those that are caught.
    """
    position, direction = position.copy(), direction.copy()
    number = np.arange(len(position))
    done = []
    for _ in range(MOST_HITS):
        way, normal = meet(profile, position, direction)
        free = ~np.isfinite(way)
        done.append((position[free], direction[free], number[free]))
        way, normal, number = way[~free], normal[~free], number[~free]
        position, direction = position[~free], direction[~free]
        position = position + way[:, None] * direction
        if not len(position):
            break
        direction = _refract(direction, normal, index, rng)
    return tuple(np.concatenate(each) for each in zip(*done, strict=True))


def _refract(direction, normal, index, rng):
    """Choose between reflection and refraction of unpolarised light at a surface between air and a body."""
    cosine = -(direction * normal).sum(axis=1)
    outside = cosine > 0.0
    ratio = np.where(outside, 1.0 / index, index)
    normal = np.where(outside[:, None], normal, -normal)
    cosine = np.abs(cosine)
    square = 1.0 - ratio**2 * (1.0 - cosine**2)
    bent = np.sqrt(np.maximum(square, 0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        across = (ratio * cosine - bent) / (ratio * cosine + bent)
        along = (cosine - ratio * bent) / (cosine + ratio * bent)
    share = np.where(square > 0.0, 0.5 * (across**2 + along**2), 1.0)
    mirrored = direction + 2.0 * cosine[:, None] * normal
    passed = ratio[:, None] * direction + (ratio * cosine - bent)[:, None] * normal
    made = np.where((rng.random(len(share)) < share)[:, None], mirrored, passed)
    return made / np.linalg.norm(made, axis=1, keepdims=True)
