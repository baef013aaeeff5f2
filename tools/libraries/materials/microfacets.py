"""Rough boundaries as facets whose normals follow the distribution of Trowbridge and Reitz (GGX).

Light that meets a second facet is left out, so rough metals are somewhat darker than they are.

References
----------
B. Walter et al.: Microfacet Models for Refraction through Rough Surfaces, EGSR 2007.
E. Heitz: Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs, JCGT 3(2), 2014.
J. Dupuy, A. Benyoub: Sampling Visible GGX Normals with Spherical Caps, Computer Graphics Forum 42(8), 2023.
"""

from dataclasses import dataclass

import numpy as np

POINTS = 96
"""Points along each side of the square on which totals are found."""


def dot(a, b) -> np.ndarray:
    """Cosines between directions. (n, 3), (n, 3) -> (n,)"""
    return (a * b).sum(axis=-1)


def unit(v) -> np.ndarray:
    """Directions of unit length. (n, 3)"""
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


@dataclass(frozen=True)
class Facets:
    """A rough boundary.

    Parameters
    ----------
    along, across : float    Roughness alpha of GGX towards x and towards y. [-]
    """

    along: float
    across: float

    def density(self, h) -> np.ndarray:
        """Density of the facets' normals. (n, 3) -> (n,) [1/sr]"""
        x, y, z = h[..., 0] / self.along, h[..., 1] / self.across, h[..., 2]
        return 1.0 / (np.pi * self.along * self.across * (x * x + y * y + z * z) ** 2)

    def _slope(self, v) -> np.ndarray:
        """Smith's Lambda. (n,)"""
        x, y = self.along * v[..., 0], self.across * v[..., 1]
        return 0.5 * (np.sqrt(1.0 + (x * x + y * y) / v[..., 2] ** 2) - 1.0)

    def seen(self, wi, wo) -> np.ndarray:
        """Share of facets that both directions reach, correlated by height; both on the same side. (n,)"""
        return 1.0 / (1.0 + self._slope(wi) + self._slope(wo))

    def reflection(self, wi, wo, fresnel) -> np.ndarray:
        """BRDF. ``fresnel``: from cosines (n,) to reflectances (n,) or (n, w). [1/sr]"""
        h = unit(wi + wo)
        shape = self.density(h) * self.seen(wi, wo) / (4.0 * wi[..., 2] * wo[..., 2])
        share = fresnel(dot(wi, h))
        return shape[:, None] * (share if share.ndim == 2 else share[:, None])

    def transmission(self, wi, wt, index: float, fresnel) -> np.ndarray:
        """BTDF into matter of a refractive index, per solid angle there; ``wt`` points downwards. (n,) [1/sr]"""
        h = -unit(wi + index * wt)
        ci, ct = dot(wi, h), dot(wt, h)
        upright = np.stack([wt[..., 0], wt[..., 1], -wt[..., 2]], axis=-1)
        # Uncorrelated heights: facets that light passes are seen from both sides.
        seen = 1.0 / ((1.0 + self._slope(wi)) * (1.0 + self._slope(upright)))
        shape = index**2 * self.density(h) * seen / (ci + index * ct) ** 2
        passed = 1.0 - fresnel(np.maximum(ci, 1e-9))
        value = np.abs(ci * ct) * passed * shape / (wi[..., 2] * upright[..., 2])
        return np.where((ci > 0.0) & (ct < 0.0) & (h[..., 2] > 0.0), value, 0.0)

    def albedo(self, cosines, fresnel) -> np.ndarray:
        """Share of light that is reflected, by facets that are as rough along x as along y. (c,) -> (c,) or (c, w) [-]"""
        points = (np.arange(POINTS) + 0.5) / POINTS
        u, v = (m.ravel() for m in np.meshgrid(points, points))
        found = []
        for cosine in np.atleast_1d(cosines):
            wi = np.array([np.sqrt(max(1.0 - cosine**2, 0.0)), 0.0, cosine])
            h = self._visible_normals(wi, u, v)
            wo = 2.0 * (h @ wi)[:, None] * h - wi
            above = wo[:, 2] > 1e-6
            h, wo = h[above], wo[above]
            each = np.broadcast_to(wi, wo.shape)
            weight = self.seen(each, wo) * (1.0 + self._slope(each))
            share = fresnel(h @ wi)
            share = share if share.ndim == 2 else share[:, None]
            found.append((weight[:, None] * share).sum(axis=0) / len(u))
        return np.array(found).squeeze()

    def _visible_normals(self, wi, u, v) -> np.ndarray:
        """Normals of facets as often as they are seen from a direction. (n, 3)"""
        scale = np.array([self.along, self.across, 1.0])
        stretched = unit(scale * wi)
        turn = 2.0 * np.pi * u
        z = (1.0 - v) * (1.0 + stretched[2]) - stretched[2]
        sine = np.sqrt(np.maximum(1.0 - z * z, 0.0))
        cap = np.stack([sine * np.cos(turn), sine * np.sin(turn), z], axis=1)
        return unit(scale * (cap + stretched))


def smooth_to_rough(alpha: float) -> Facets:
    """Facets that are as rough in all directions."""
    return Facets(alpha, alpha)
