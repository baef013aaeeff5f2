"""Sheets that spread light: embossed and holographic films by their angle, and ground glass by its facets."""

from dataclasses import dataclass

import numpy as np

from .coats import Coat
from .colour import solve
from .microfacets import smooth_to_rough

MOST_ALPHA = 0.9
"""Roughest facets that a film's relief is taken to have."""


def width_of(angle: float) -> float:
    """Standard deviation of the direction cosines of a film whose intensity falls to half within an angle. [rad] -> [-]

    Light falls along the normal; the angle is the full one between both directions of half the intensity.
    """
    half = 0.5 * angle
    return float(np.sin(half) / np.sqrt(2.0 * np.log(2.0 * np.cos(half))))


@dataclass(frozen=True, eq=False)
class Film:
    """A clear film with a relief in front and a smooth back, which shifts direction cosines by a bell's law.

    Parameters
    ----------
    angle_x, angle_y : float    Full angles of half the intensity, light along the normal. [rad]
    clearness : float    Share of light that the film does not absorb. [-]
    index : float    Refractive index. [-]
    """

    angle_x: float
    angle_y: float
    clearness: float = 0.97
    index: float = 1.49

    def _bell(self, shift, wider: float) -> np.ndarray:
        """Density of shifts of the direction cosines (n, 2). (n,)"""
        x, y = wider * width_of(self.angle_x), wider * width_of(self.angle_y)
        exponent = (shift[:, 0] / x) ** 2 + (shift[:, 1] / y) ** 2
        return np.exp(-0.5 * exponent) / (2.0 * np.pi * x * y)

    def _relief(self) -> Coat:
        """The relief as facets: slopes that deviate light by (n - 1) times themselves."""
        slope = np.sqrt(width_of(self.angle_x) * width_of(self.angle_y)) / (self.index - 1.0)
        return Coat(self.index, float(min(np.sqrt(2.0) * slope, MOST_ALPHA)))

    def transmit(self, wi, wo) -> np.ndarray:
        """BTDF, the same from both sides. (n, 1) [1/sr]"""
        relief, back = self._relief(), Coat(self.index)
        passed = [(1.0 - relief.share(v[:, 2])) * (1.0 - back.share(v[:, 2])) for v in (wi, wo)]
        # The smaller one: reciprocal, and never more than enters.
        made = self.clearness * np.minimum(*passed) * self._bell(wi[:, :2] + wo[:, :2], 1.0)
        return made[:, None]

    def reflect(self, wi, wo) -> np.ndarray:
        """BRDF of the relief's side: of its facets, and of the back through the relief twice. (n, 1) [1/sr]"""
        relief, back = self._relief(), Coat(self.index)
        weights = [(1.0 - relief.share(v[:, 2])) ** 2 * back.share(v[:, 2]) for v in (wi, wo)]
        again = self.clearness**2 * np.minimum(*weights)
        again = again * self._bell(wi[:, :2] + wo[:, :2], np.sqrt(2.0))
        return relief.gloss(wi, wo) + again[:, None]

    def reflect_back(self, wi, wo) -> np.ndarray:
        """BRDF of the smooth side: what its relief reflects inside; the mirror image is `direct`. (n, 1) [1/sr]"""
        back = Coat(self.index)
        passed = (1.0 - back.share(wi[:, 2])) * (1.0 - back.share(wo[:, 2])) * self.clearness**2
        # Slopes turn light inside by twice themselves, and refraction adds to it.
        inner = Coat(self.index, min(self.index * self._relief().alpha, MOST_ALPHA))
        return passed[:, None] * inner.gloss(wi, wo)

    def direct(self, incidences) -> np.ndarray:
        """Share of light that the smooth side mirrors. (s,) [rad] -> (s, 1) [-]"""
        return Coat(self.index).direct(incidences)


@dataclass(frozen=True, eq=False)
class GroundGlass:
    """A pane whose front is ground or etched, whose back is smooth.

    Parameters
    ----------
    alpha : float    Roughness of the front, of GGX. [-]
    index : float    Refractive index. [-]
    clearness : float    Share of light that the glass does not absorb. [-]
    """

    alpha: float
    index: float = 1.52
    clearness: float = 0.98

    def transmit(self, wi, wo) -> np.ndarray:
        """BTDF from the ground side to the smooth one. (n, 1) [1/sr]"""
        coat = Coat(self.index)
        flat = wo[:, :2] / self.index
        down = np.concatenate([flat, -np.sqrt(1.0 - (flat**2).sum(axis=1))[:, None]], axis=1)
        inside = smooth_to_rough(self.alpha).transmission(wi, down, self.index, coat.fresnel)
        # Radiance shrinks by n^2 on its way out: f is per solid angle times cosine.
        left = self.clearness * (1.0 - coat.fresnel(wo[:, 2])) / self.index**2
        return (inside * left)[:, None]

    def transmit_back(self, wi, wo) -> np.ndarray:
        """BTDF from the smooth side, which reciprocity gives. (n, 1) [1/sr]"""
        return self.transmit(wo, wi)

    def reflect(self, wi, wo) -> np.ndarray:
        """BRDF of the ground side; what the back reflects through the front again is spread evenly. (n, 1) [1/sr]"""
        rough, smooth = Coat(self.index, self.alpha), Coat(self.index)
        passed = self.clearness**2
        for v in (wi, wo):
            passed = passed * (1.0 - rough.share(v[:, 2])) * np.sqrt(smooth.share(v[:, 2]))
        return rough.gloss(wi, wo) + passed[:, None] / np.pi

    def reflect_back(self, wi, wo) -> np.ndarray:
        """BRDF of the smooth side without the mirror image. (n, 1) [1/sr]"""
        smooth, rough = Coat(self.index), Coat(self.index, self.alpha)
        passed = self.clearness**2
        for v in (wi, wo):
            passed = passed * (1.0 - smooth.share(v[:, 2])) * np.sqrt(rough.share(v[:, 2]))
        return passed[:, None] / np.pi

    def direct(self, incidences) -> np.ndarray:
        """Share of light that the smooth side mirrors. (s,) [rad] -> (s, 1) [-]"""
        return Coat(self.index).direct(incidences)


@dataclass(frozen=True, eq=False)
class Screen:
    """A projection screen: matt white with a broad lobe of fine flakes, after its gain.

    Parameters
    ----------
    body : float    Reflectance of the matt part. [-]
    lobe : float    Share of the facets. [-]
    alpha : float    Roughness of the facets, of GGX. [-]
    """

    body: float
    lobe: float
    alpha: float

    def evaluate(self, wi, wo) -> np.ndarray:
        """BRDF. (n, 1) [1/sr]"""
        facets = smooth_to_rough(self.alpha)
        return self.lobe * facets.reflection(wi, wo, np.ones_like) + self.body / np.pi


def screen_of_gain(gain: float, half_angle: float, reflectance: float) -> Screen:
    """Return the screen of a luminance factor towards the normal and of the angle at which it has fallen to half.

    Parameters
    ----------
    gain : float    Luminance over that of a white Lambertian surface, light and sight along the normal. [-]
    half_angle : float    Between the normal and the sight at which half the gain is left. [rad]
    reflectance : float    Of the whole, light along the normal. [-]
    """
    normal = np.array([[0.0, 0.0, 1.0]])
    aside = np.array([[np.sin(half_angle), 0.0, np.cos(half_angle)]])

    def screen(alpha):
        peak = 1.0 / (4.0 * alpha**2)
        total = float(smooth_to_rough(alpha).albedo([1.0], np.ones_like))
        # body + lobe total = reflectance, body + lobe peak = gain
        lobe = (gain - reflectance) / (peak - total)
        return Screen(reflectance - lobe * total, lobe, alpha)

    def left(alpha):
        made = screen(alpha)
        return float(made.evaluate(normal, aside)[0, 0] / made.evaluate(normal, normal)[0, 0])

    return screen(solve(left, 0.5, 0.05, 0.45))
