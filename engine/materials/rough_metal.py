"""Rough metals, and gloss of a constant colour: facets that reflect, and light that passes from facet to facet.

The reflectance distribution is

    f = F(cos h) D(h) G2(i, o) / (4 cos_i cos_o)  +  M / pi * (1 - E(cos_i)) (1 - E(cos_o)) / (1 - E_mean)
    M = F_mean^2 E_mean / (1 - F_mean (1 - E_mean))

with the reflectance of facets F = F_c (R + s (1 - R) (1 - c)^5 - b c (1 - c)^6) at a cosine c, F_c being Fresnel's by a
complex index; s is 0 for a reflectance that is the same from all sides, and b gives it the wanted tint at the cosine 1/7, 82
degrees. E is what white facets reflect once; means are over the hemisphere, that of F_c where Schlick's formula has it. The
model is reciprocal, and with F = 1 it reflects everything, whatever the roughness. Of facets that lie along a direction, E
depends on the azimuth too (see `grain`).

References
----------
C. Kulla, A. Conty: Revisiting Physically Based Shading at Imageworks, SIGGRAPH courses 2017.
N. Kutz, M. Hasan, D. Edmondson: Novel aspects of the Adobe Standard Material, 2021 (F82 tint).
"""

from functools import cache

import numpy as np

from .facets import (
    MINIMUM_ALPHA,
    directional_reflectance,
    mean_reflectance,
    mirror_light,
    read_row,
    reflect_on_facet,
)
from .grain import grain_reflectance, mean_over_azimuths

ROUGHNESSES = 25
"""Rows of the tables, evenly over the root of the width."""

TINTED = 1.0 / 7.0
"""Cosine at which the edge has its tint."""

EDGE = TINTED * (1.0 - TINTED) ** 6
"""c (1 - c)^6 there, its largest value."""

MEAN_COSINE = 1.0 - (1.0 / 21.0) ** 0.2
"""Cosine at which F0 + (1 - F0) (1 - cos)^5 has its mean over the hemisphere, F0 + (1 - F0) / 21. [-]"""


@cache
def tables() -> tuple[np.ndarray, np.ndarray]:
    """What white facets reflect once, and its mean, by roughness. (25, 64), (25,)"""
    alphas = np.maximum(np.linspace(0.0, 1.0, ROUGHNESSES) ** 2, MINIMUM_ALPHA)
    rows = np.stack([directional_reflectance(float(alpha)) for alpha in alphas])
    return rows, np.array([mean_reflectance(row) for row in rows])


@cache
def tables_along(stretch: float, alpha: float | None) -> tuple[np.ndarray, np.ndarray]:
    """The same of facets that lie along a direction, by roughness, azimuth and cosine.

    ``alpha``: their width; None: all. With one width there are two rows alike, of which a look-up takes the mean.
    """
    alphas = [alpha] if alpha is not None else np.linspace(0.0, 1.0, ROUGHNESSES) ** 2
    rows = [grain_reflectance(round(float(each), 6), stretch) for each in alphas]
    rows = rows * 2 if alpha is not None else rows
    return np.stack(rows), np.array([mean_over_azimuths(row, stretch) for row in rows])


def rough_metal_class():
    """Return the plug-in for the active Mitsuba variant."""
    import drjit as dr
    import mitsuba as mi

    from ..arrays import average, upload

    class RoughMetal(mi.BSDF):
        """``eta``, ``k``, ``specular_reflectance``, ``edge`` and ``alpha`` are textures, the last may be a number.

        ``rise``: s. `set_grain` lays its facets along a direction, `set_film` a thin film on them.
        """

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.eta, self.k = props["eta"], props["k"]
            self.reflectance, self.edge = props["specular_reflectance"], props["edge"]
            self.rise = mi.Float(float(props["rise"]))
            width = props["alpha"]
            self.texture = None if isinstance(width, int | float) else width
            self.alpha = mi.Float(width if self.texture is None else 0.0)
            self.table, self.means = (upload(mi.Float, each) for each in tables())
            self.grain = self.film = None
            dr.make_opaque(self.alpha, self.rise)
            dr.eval(self.table, self.means)
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [mi.BSDFFlags.GlossyReflection | sides]
            self.m_flags = self.m_components[0]

        def set_grain(self, grain, stretch, alpha):
            """Lay facets along a direction. ``grain``: `GrainOfFacets`; ``alpha``: their width, None if it varies."""
            self.grain = grain
            stretch, alpha = (None if each is None else round(each, 6) for each in (stretch, alpha))
            self.table, self.means = (
                upload(mi.Float, each) for each in tables_along(stretch, alpha)
            )
            dr.eval(self.table, self.means)

        def set_film(self, film):
            """Lay a film on the facets. ``film``: `FilmOnMetal`, which says all that they reflect."""
            self.film = film

        def set_ways(self, ways):
            """Set the ways of the grain's directions, as `GrainOfFacets` has them."""
            if self.grain is not None:
                self.grain.set_ways(ways)

        def traverse(self, callback):
            callback.put("eta", self.eta, mi.ParamFlags.NonDifferentiable)
            callback.put("k", self.k, mi.ParamFlags.NonDifferentiable)
            callback.put("specular_reflectance", self.reflectance, mi.ParamFlags.Differentiable)
            callback.put("edge", self.edge, mi.ParamFlags.Differentiable)

        def _width(self, si, active):
            width = self.alpha if self.texture is None else self.texture.eval_1(si, active)
            return dr.clip(width, MINIMUM_ALPHA, 1.0)

        def _fresnel(self, si, cosine, active):
            """Reflectance by the complex index."""
            eta, k = self.eta.eval(si, active), self.k.eval(si, active)
            value = mi.Spectrum(0.0)
            for n in range(len(value)):
                value[n] = mi.fresnel_conductor(cosine, mi.Complex2f(eta[n], k[n]))
            return value

        def _colours(self, si, active):
            """R, s (1 - R) and b."""
            colour = self.reflectance.eval(si, active)
            rise = self.rise * (1.0 - colour)
            edge = (colour + rise * (1.0 - TINTED) ** 5) * (1.0 - self.edge.eval(si, active))
            return colour, rise, edge * (1.0 / EDGE)

        def _mirror(self, si, colours, cosine, active):
            """Reflectance of facets. ``cosine``: to their normal."""
            if self.film is not None:
                return self.film.mirror(si, cosine, active)
            colour, rise, edge = colours
            away = 1.0 - cosine
            fifth = dr.square(dr.square(away)) * away
            seen = colour + rise * fifth - edge * (cosine * fifth * away)
            return self._fresnel(si, cosine, active) * dr.maximum(seen, 0.0)

        def _mean(self, si, colours, active):
            """Mean reflectance of facets over the hemisphere."""
            if self.film is not None:
                return self.film.mean(si, active)
            colour, rise, edge = colours
            seen = colour + rise * (1.0 / 21.0) - edge * (1.0 / 126.0)
            return self._fresnel(si, mi.Float(MEAN_COSINE), active) * dr.maximum(seen, 0.0)

        def _prepare(self, si, active):
            """Facets, colours, rows of tables and the share of the second, E, its mean, M, how likely one facet reflects."""
            alpha = self._width(si, active)
            if self.grain is None or self.texture is not None:
                place = dr.sqrt(alpha) * (ROUGHNESSES - 1)
                row = dr.minimum(mi.UInt32(place), ROUGHNESSES - 2)
                share = place - mi.Float(row)
            else:
                row, share = mi.UInt32(0), mi.Float(0.0)
            rows = row, share
            if self.grain is not None:
                alpha = self.grain.lay(si, alpha, active)
            once = self._once(alpha, rows, si.wi, active)
            low, high = (dr.gather(mi.Float, self.means, each, active) for each in (row, row + 1))
            mean = dr.lerp(low, high, share)
            colours = self._colours(si, active)
            colour = self._mean(si, colours, active)
            often = dr.square(colour) * mean / dr.maximum(1.0 - colour * (1.0 - mean), 1e-6)
            single, rest = once * average(colour), (1.0 - once) * average(often)
            chance = dr.select(single + rest > 0.0, single / dr.maximum(single + rest, 1e-8), 1.0)
            return alpha, colours, rows, once, mean, often, chance

        def _once(self, facets, rows, w, active):
            """What white facets reflect once of light from a direction."""
            row, share = rows
            if self.grain is not None:
                low, high = (facets.read(self.table, each, w, active) for each in (row, row + 1))
                return dr.lerp(low, high, share)
            cosine = dr.abs(mi.Frame3f.cos_theta(w))
            low, high = (read_row(self.table, each, cosine, active) for each in (row, row + 1))
            return dr.lerp(low, high, share)

        def _evaluate(self, si, wo, prepared, active):
            facets, colours, rows, once, mean, often, chance = prepared
            cos_o = dr.abs(mi.Frame3f.cos_theta(wo))
            valid = active & (mi.Frame3f.cos_theta(si.wi) * mi.Frame3f.cos_theta(wo) > 0.0)
            if self.grain is None:
                light, density, cosine = mirror_light(si.wi, wo, facets)
            else:
                light, density, cosine = facets.mirror_light(si.wi, wo)
            lambert = cos_o * dr.inv_pi
            lost = (1.0 - once) * (1.0 - self._once(facets, rows, wo, active))
            rest = often * (lost / dr.maximum(1.0 - mean, 1e-6) * lambert)
            value = self._mirror(si, colours, cosine, active) * light + rest
            pdf = chance * density + (1.0 - chance) * lambert
            return mi.Spectrum(dr.select(valid, value, 0.0)), dr.select(valid, pdf, 0.0)

        def sample(self, ctx, si, sample1, sample2, active=True):
            prepared = self._prepare(si, active)
            below = mi.Frame3f.cos_theta(si.wi) < 0.0
            wi = mi.Vector3f(si.wi)
            wi.z = dr.abs(wi.z)
            facets = prepared[0]
            if self.grain is None:
                mirrored = reflect_on_facet(wi, facets, sample2)
            else:
                mirrored = facets.reflect(wi, sample2)
            wo = dr.select(
                sample1 < prepared[-1],
                mirrored,
                mi.warp.square_to_cosine_hemisphere(sample2),
            )
            valid = active & (wo.z > 0.0) & (wi.z > 0.0)
            wo.z = dr.select(below, -wo.z, wo.z)
            value, pdf = self._evaluate(si, wo, prepared, valid)
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = wo
            bs.pdf = pdf
            bs.eta = 1.0
            bs.sampled_component = mi.UInt32(0)
            bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
            valid &= pdf > 0.0
            return bs, mi.Spectrum(dr.select(valid, value / dr.maximum(pdf, 1e-20), 0.0))

        def eval_pdf(self, ctx, si, wo, active=True):
            return self._evaluate(si, wo, self._prepare(si, active), active)

        def eval_diffuse_reflectance(self, si, active=True):
            return self._mirror(si, self._colours(si, active), mi.Float(1.0), active)

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def to_string(self):
            return "RoughMetal[]"

    return RoughMetal
