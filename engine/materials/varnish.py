"""A clear or tinted microfacet coat over any other surface.

With the coat's weight w, and where light leaves on the side that it comes from,

    f = w F(cos h) D(h) G2(i, o) / (4 cos_i cos_o) + (1 - w + w S(i, o)) f_base,
    S = a(cos_i) b(cos_o) t^(p(cos_i) + q(cos_o))

with the coat's colour t for one way along the normal. a, b, p and q come from `layering`: over an opaque base a = b and
p = q, which is reciprocal, and the base loses of light from each direction what the coat reflects of it. Where the base lets
light through, b = 1 and q = 0, which is Blender's answer to a direction that is looked along and is not reciprocal.
"""

import numpy as np

from .facets import (
    MINIMUM_ALPHA,
    directional_reflectance,
    mirror_light,
    read_row,
    reflect_on_facet,
)
from .layering import absorbing, passing, slant, spreading

DARKEST = 0.1
"""Least reflectance that bases are taken to have where a lobe is chosen. [-]"""


def varnish_class():
    """Return the plug-in for the active Mitsuba variant."""
    import drjit as dr
    import mitsuba as mi

    from ..arrays import average, upload

    class Varnish(mi.BSDF):
        """``base``: what lies below; ``weight`` and ``tint``: textures; `set_coat` gives it the rest."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.base, self.weight, self.tint = props["base"], props["weight"], props["tint"]
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            own = mi.BSDFFlags.GlossyReflection | sides
            count = self.base.component_count()
            self.m_components = [own, *(self.base.flags(i) for i in range(count))]
            self.m_flags = own | self.base.flags()

        def set_coat(self, alpha, eta, facets):
            """Set the coat's width and index; ``facets``: of an opaque base, as `spreading` takes them, else None."""
            alpha = max(float(alpha), MINIMUM_ALPHA)
            reflected = directional_reflectance(round(alpha, 4), round(float(eta), 4))
            left, lengths = 1.0 - reflected, slant(float(eta))
            if facets is None:
                tables, spread = (left, np.ones_like(left), lengths, np.zeros_like(left)), 0.0
            else:
                shares = spreading(*facets)
                factor, (exponent, spread) = passing(left, shares), absorbing(lengths, shares)
                tables = factor, factor, exponent, exponent
            self.table = upload(mi.Float, np.stack([reflected, *tables]))
            self.alpha, self.eta, self.spread = (
                dr.opaque(mi.Float, float(value)) for value in (alpha, eta, spread)
            )
            self.is_open = dr.opaque(mi.Bool, facets is None)
            dr.eval(self.table)

        def traverse(self, callback):
            callback.put("base", self.base, mi.ParamFlags.Differentiable)
            callback.put("weight", self.weight, mi.ParamFlags.Differentiable)
            callback.put("tint", self.tint, mi.ParamFlags.Differentiable)

        def _read(self, row, cosine, active):
            return read_row(self.table, mi.UInt32(row), dr.abs(cosine), active)

        def _prepare(self, si, active):
            """Weight, logarithm of the tint, a and p of this side, how likely the coat's lobe is."""
            weight = dr.clip(self.weight.eval_1(si, active), 0.0, 1.0)
            tint = dr.log(dr.maximum(self.tint.eval(si, active), 1e-6))
            cosine = mi.Frame3f.cos_theta(si.wi)
            reflected = weight * self._read(0, cosine, active)
            base = average(self.base.eval_diffuse_reflectance(si, active))
            base = dr.select(self.is_open, 1.0, dr.clip(base, DARKEST, 1.0))
            below = (1.0 - reflected) * base
            chance = reflected / dr.maximum(reflected + below, 1e-8)
            return (
                weight,
                tint,
                self._read(1, cosine, active),
                self._read(3, cosine, active),
                chance,
            )

        def _left(self, cosine, prepared, active):
            """What the coat leaves of the light that its base sends on."""
            weight, tint, own, exponent, _ = prepared
            way = exponent + self._read(4, cosine, active)
            absorbed = dr.exp(tint * way - 0.5 * dr.square(tint) * self.spread)
            return 1.0 - weight + weight * own * self._read(2, cosine, active) * absorbed

        def _evaluate(self, si, wo, below, prepared, active):
            """Value and density. ``below``: those of the base."""
            weight, *_, chance = prepared
            value, pdf = below
            light, density, cosine = mirror_light(si.wi, wo, self.alpha)
            is_same = active & (mi.Frame3f.cos_theta(si.wi) * mi.Frame3f.cos_theta(wo) > 0.0)
            gloss = dr.select(is_same, weight * mi.fresnel(cosine, self.eta)[0] * light, 0.0)
            value = value * self._left(mi.Frame3f.cos_theta(wo), prepared, active) + gloss
            return value, dr.select(is_same, chance * density, 0.0) + (1.0 - chance) * pdf

        def sample(self, ctx, si, sample1, sample2, active=True):
            active = mi.Bool(active)
            prepared = self._prepare(si, active)
            chance = prepared[-1]
            is_gloss = sample1 < chance
            wi = mi.Vector3f(si.wi)
            wi.z = dr.abs(wi.z)
            gloss = reflect_on_facet(wi, self.alpha, sample2)
            is_seen = (gloss.z > 0.0) & (wi.z > 0.0)
            gloss.z = dr.select(si.wi.z < 0.0, -gloss.z, gloss.z)
            reused = (sample1 - chance) / dr.maximum(1.0 - chance, 1e-8)
            bs, weight = self.base.sample(ctx, si, reused, sample2, active & ~is_gloss)
            bs.wo = dr.select(is_gloss, gloss, bs.wo)
            bs.eta = dr.select(is_gloss, 1.0, bs.eta)
            bs.sampled_component = dr.select(is_gloss, 0, bs.sampled_component)
            kind = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
            bs.sampled_type = dr.select(is_gloss, kind, bs.sampled_type)
            single = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
            single |= mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)
            spreads = active & ~single & (~is_gloss | is_seen)
            below = self.base.eval_pdf(ctx, si, bs.wo, spreads)
            value, pdf = self._evaluate(si, bs.wo, below, prepared, spreads)
            left = self._left(mi.Frame3f.cos_theta(bs.wo), prepared, active)
            straight = weight * left / dr.maximum(1.0 - chance, 1e-8)
            weight = dr.select(single, straight, value / dr.maximum(pdf, 1e-20))
            bs.pdf = dr.select(single, bs.pdf * (1.0 - chance), pdf)
            valid = active & (single | spreads) & (bs.pdf > 0.0)
            return bs, mi.Spectrum(dr.select(valid, weight, 0.0))

        def eval_pdf(self, ctx, si, wo, active=True):
            below = self.base.eval_pdf(ctx, si, wo, active)
            return self._evaluate(si, wo, below, self._prepare(si, active), active)

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def eval_diffuse_reflectance(self, si, active=True):
            left = self._left(mi.Float(1.0), self._prepare(si, active), active)
            return self.base.eval_diffuse_reflectance(si, active) * left

        def eval_null_transmission(self, si, active=True):
            left = self._left(mi.Frame3f.cos_theta(si.wi), self._prepare(si, active), active)
            return self.base.eval_null_transmission(si, active) * left

        def to_string(self):
            return "Varnish[]"

    return Varnish
