"""What fibres on a surface send on: microfibres by linearly transformed cosines, and velvet.

Microfibres seen from a direction i send the share R(i) on into a lobe with the density

    L(i, o) = cos_o / pi * (a / l)^2,    l = (a x + b cos_o)^2 + (a y)^2 + cos_o^2,

x being the part of o along the surface towards i; a, b and R follow from the roughness and the cosine of i. These lobes
stand for a layer that is reciprocal and are so only nearly. The mean of both ways is, and sends as much on over all
directions:

    f = (R(i) L(i, o) / cos_o + R(o) L(o, i) / cos_i) / 2.

Velvet has fibres upright, with s for the roughness and the half direction h at the angle t to the normal:

    f = D G / (4 cos_i cos_o),    D = exp(-1 / (s tan t)^2) / (pi s^2 sin^4 t),
    G = min(1, 2 cos_t cos_i / (i h), 2 cos_t cos_o / (i h)).

References
----------
T. Zeltner, B. Burley, M. J.-Y. Chiang: Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines, SIGGRAPH
2022.
M. Ashikhmin, S. Premoze, P. Shirley: A Microfacet-Based BRDF Generator, SIGGRAPH 2000.
"""

from functools import cache, lru_cache

import numpy as np

from ...libraries import materials as library
from .facets import cosines

NODES = 32
"""Entries of the table of lobes along the roughness and along the cosine."""

SMOOTHEST = 1e-3
"""Least roughness of microfibres. [-]"""

SLIMMEST = 0.01
"""Least roughness of velvet. [-]"""

STEPS, TURNS = 192, 96
"""Directions of the sums for what is sent on: by the cosine, evenly in its root, and by the azimuth over half a turn."""


@cache
def _lobes() -> np.ndarray:
    """Table of a, b and R by roughness and cosine, as Cycles 5.0 has them. (32, 32, 3)"""
    path = library.LIBRARY / "microfibre.csv"
    return np.loadtxt(path, delimiter=",", skiprows=1).reshape(NODES, NODES, 3)


@lru_cache(maxsize=64)
def lobes_of(roughness: float) -> np.ndarray:
    """Return a, b and R by the cosine, at `NODES` even steps. (3, 32) [-]"""
    place = np.clip(roughness, SMOOTHEST, 1.0) * (NODES - 1)
    below = min(int(place), NODES - 2)
    low, high = _lobes()[below : below + 2]
    return np.ascontiguousarray((low + (place - below) * (high - low)).T)


@lru_cache(maxsize=64)
def sent_on(roughness: float, is_velvet: bool) -> np.ndarray:
    """Share of light that fibres send on, by the cosine at `facets.COSINES` steps even in the root. (64,) [-]"""
    cos_i = cosines().astype(np.float64)[:, None, None]
    root = (np.arange(STEPS) + 0.5) / STEPS
    cos_o = (root**2)[None, :, None]
    phi = ((np.arange(TURNS) + 0.5) / TURNS * np.pi)[None, None, :]
    weight = (2.0 * root / STEPS)[None, :, None] * 2.0 * np.pi / TURNS
    if is_velvet:
        share = (_velvet(cos_i, cos_o, phi, max(roughness, SLIMMEST)) * cos_o * weight).sum((1, 2))
        return np.clip(share, 0.0, 1.0)
    back = (_lobe(lobes_of(roughness), cos_o, cos_i, phi) * cos_o / cos_i * weight).sum((1, 2))
    ahead = np.interp(cos_i.ravel(), np.linspace(0.0, 1.0, NODES), lobes_of(roughness)[2])
    return np.clip(0.5 * (ahead + back), 0.0, 1.0)


def _lobe(lobes, cos_i, cos_o, phi):
    """R L of microfibres."""
    nodes = np.linspace(0.0, 1.0, NODES)
    a, b, share = (np.interp(cos_i, nodes, row) for row in lobes)
    sine = np.sqrt(1.0 - cos_o**2)
    x, y = sine * np.cos(phi), sine * np.sin(phi)
    length = (a * x + b * cos_o) ** 2 + (a * y) ** 2 + cos_o**2
    return share * cos_o / np.pi * (a / length) ** 2


def _velvet(cos_i, cos_o, phi, roughness):
    """F of velvet."""
    sin_i, sin_o = np.sqrt(1.0 - cos_i**2), np.sqrt(1.0 - cos_o**2)
    together = 1.0 + cos_i * cos_o + sin_i * sin_o * np.cos(phi)
    squared = np.clip((cos_i + cos_o) ** 2 / (2.0 * together), 0.0, 1.0 - 1e-9)
    sine = 1.0 - squared
    facets = np.exp(-squared / (sine * roughness**2)) / (np.pi * roughness**2 * sine**2)
    shade = np.minimum(1.0, 2.0 * (cos_i + cos_o) / together * np.minimum(cos_i, cos_o))
    return facets * shade / (4.0 * cos_i * cos_o)


class Fibres:
    """Fibres on the device. ``roughness``: theirs; ``is_velvet``: whether they are upright, and no microfibres."""

    def __init__(self, roughness: float, is_velvet: bool):
        import drjit as dr
        import mitsuba as mi

        from ..arrays import upload

        self.is_velvet = is_velvet
        self.width = dr.opaque(mi.Float, float(max(roughness, SLIMMEST)))
        self.lobes = upload(mi.Float, np.zeros(3 * NODES) if is_velvet else lobes_of(roughness))
        dr.eval(self.lobes)

    def _look_up(self, cosine, active):
        """a, b and R from a direction of microfibres."""
        import drjit as dr
        import mitsuba as mi

        place = dr.clip(cosine, 0.0, 1.0) * (NODES - 1)
        below = dr.minimum(mi.UInt32(place), NODES - 2)
        share = place - mi.Float(below)
        return [
            dr.lerp(
                dr.gather(mi.Float, self.lobes, n * NODES + below, active),
                dr.gather(mi.Float, self.lobes, n * NODES + below + 1, active),
                share,
            )
            for n in range(3)
        ]

    def evaluate(self, wi, wo, active):
        """Evaluate f cos_o for directions above the surface, and the density by which `sample` draws."""
        import drjit as dr

        if self.is_velvet:
            return self._evaluate_velvet(wi, wo), 0.5 * dr.inv_pi
        ahead, density = self._evaluate_lobe(wi, wo, active)
        back, _ = self._evaluate_lobe(wo, wi, active)
        value = 0.5 * (ahead + back * wo.z / dr.maximum(wi.z, 1e-6))
        return value, 0.75 * density + 0.25 * wo.z * dr.inv_pi

    def _evaluate_lobe(self, wi, wo, active):
        """R L and L of microfibres."""
        import drjit as dr

        a, b, share = self._look_up(wi.z, active)
        sine = dr.sqrt(dr.square(wi.x) + dr.square(wi.y))
        is_aslant = sine > 1e-6
        along = dr.select(is_aslant, (wi.x * wo.x + wi.y * wo.y) / dr.maximum(sine, 1e-6), wo.x)
        squared = dr.maximum(1.0 - dr.square(wo.z) - dr.square(along), 0.0)
        length = dr.square(a * along + b * wo.z) + dr.square(a) * squared + dr.square(wo.z)
        density = wo.z * dr.inv_pi * dr.square(a / dr.maximum(length, 1e-12))
        return share * density, density

    def _evaluate_velvet(self, wi, wo):
        import drjit as dr

        half = dr.normalize(wi + wo)
        cosine = dr.maximum(dr.dot(wi, half), 1e-5)
        squared = dr.square(half.z)
        sine = dr.maximum(dr.square(half.x) + dr.square(half.y), 1e-9)
        narrow = dr.rcp(dr.square(self.width))
        facets = dr.exp(-squared / sine * narrow) * narrow * dr.inv_pi / dr.square(sine)
        shade = dr.minimum(1.0, 2.0 * half.z / cosine * dr.minimum(wi.z, wo.z))
        return 0.25 * facets * shade / dr.maximum(wi.z, 1e-6)

    def sample(self, wi, choice, sample, active):
        """Draw a direction above the surface. ``choice``: a number from 0 to 1."""
        import drjit as dr
        import mitsuba as mi

        if self.is_velvet:
            return mi.warp.square_to_uniform_hemisphere(sample)
        even = mi.warp.square_to_cosine_hemisphere(sample)
        a, b, _ = self._look_up(wi.z, active)
        bent = dr.normalize(mi.Vector3f(even.x - even.z * b, even.y, even.z * a))
        sine = dr.sqrt(dr.square(wi.x) + dr.square(wi.y))
        is_aslant = sine > 1e-6
        x = dr.select(is_aslant, wi.x / dr.maximum(sine, 1e-6), 1.0)
        y = dr.select(is_aslant, wi.y / dr.maximum(sine, 1e-6), 0.0)
        turned = mi.Vector3f(bent.x * x - bent.y * y, bent.x * y + bent.y * x, bent.z)
        return dr.select(choice < 0.75, turned, even)
