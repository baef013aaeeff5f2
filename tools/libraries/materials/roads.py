"""Dry road surfaces after the figures that road lighting sorts them by: Q0 and S1, seen under 1 degree.

The luminance coefficient q is the BRDF towards a driver 1 degree above the road. With gamma the angle of the light to the
normal and beta its azimuth from the driver's line of sight, r = q cos^3 gamma.

References
----------
CIE 144: Road surface and road marking reflection characteristics.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from .coats import Coat
from .grains import Grains

SIGHT = np.radians(1.0)
"""Angle between the driver's line of sight and the road."""


@dataclass(frozen=True, eq=False)
class Asphalt:
    """Stones in bitumen: rough matt matter, a share of which is covered by facets.

    Parameters
    ----------
    grains : Grains
    cover : float    Share of the area that is facets. [-]
    coat : Coat    Of the facets.
    """

    grains: Grains
    cover: float
    coat: Coat

    def evaluate(self, wi, wo) -> np.ndarray:
        """BRDF. (n, w) [1/sr]"""
        left = 1.0 / (1.0 - self.cover * self.coat.mean_share)
        for v in (wi, wo):
            left = left * (1.0 - self.cover * self.coat.share(v[:, 2]))
        return self.grains.evaluate(wi, wo) * left[:, None] + self.cover * self.coat.gloss(wi, wo)


def luminance_coefficient(evaluate, along, across) -> np.ndarray:
    """Luminance coefficient of light from points above the road.

    Parameters
    ----------
    evaluate : callable    BRDF. [1/sr]
    along, across : (n,) arrays
        Place of the lamp from the spot that is looked at, over its height: away from the driver, and to the side. [-]

    Returns
    -------
    (n, w) array    [1/sr]
    """
    length = np.sqrt(along**2 + across**2 + 1.0)
    wi = np.stack([along, across, np.ones_like(along)], axis=1) / length[:, None]
    wo = np.array([-np.cos(SIGHT), 0.0, np.sin(SIGHT)])
    return evaluate(wi, np.broadcast_to(wo, wi.shape))


def figures_of(evaluate) -> tuple[float, float]:
    """Average luminance coefficient Q0 [cd/(m2 lx)] and specular factor S1 = r(0, 2) / r(0, 0) of the first band."""
    straight = luminance_coefficient(evaluate, np.array([0.0, 2.0]), np.zeros(2))[:, 0]
    specular = straight[1] * 5.0**-1.5 / straight[0]
    # By solid angle, over lamps up to 12 heights ahead, 4 behind, and 3 to both sides.
    along, across, weight = _area()
    found = luminance_coefficient(evaluate, along, across)[:, 0]
    return float(weight @ found / weight.sum()), float(specular)


@lru_cache
def _area() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    nodes, weights = np.polynomial.legendre.leggauss(40)
    parts = []
    for low, high in ((-4.0, 0.0), (0.0, 4.0), (4.0, 12.0)):
        x, wx = low + 0.5 * (high - low) * (nodes + 1.0), 0.5 * (high - low) * weights
        y, wy = 1.5 * (nodes + 1.0), 1.5 * weights
        grid, share = np.meshgrid(x, y), np.outer(wy, wx)
        parts.append([grid[0].ravel(), grid[1].ravel(), share.ravel()])
    x, y, share = np.concatenate(parts, axis=1)
    return x, y, share * (x * x + y * y + 1.0) ** -1.5


def asphalt_of_class(
    average: float, specular: float, colour, alpha: float, roughness: float
) -> Asphalt:
    """Return the surface that has stated figures Q0 and S1.

    Parameters
    ----------
    average, specular : float    Q0 [cd/(m2 lx)] and S1 [-].
    colour : (w,) array    Spectrum of the matt part on any scale.
    alpha : float    Roughness of the facets, of GGX. [-]
    roughness : float    Of the matt part. [-]
    """
    coat, shape = Coat(1.55, alpha), np.asarray(colour) / np.max(colour)

    def surface(reflectance, cover):
        return Asphalt(Grains(reflectance * shape, roughness), cover, coat)

    x = np.array([0.1, 0.3])
    for _ in range(40):
        found = np.array(figures_of(surface(*x).evaluate))
        slope = np.stack(
            [
                (np.array(figures_of(surface(*(x + step)).evaluate)) - found) / 1e-5
                for step in 1e-5 * np.eye(2)
            ],
            axis=1,
        )
        x = x + np.clip(np.linalg.solve(slope, [average, specular] - found), -0.05, 0.05)
    return surface(*x)
