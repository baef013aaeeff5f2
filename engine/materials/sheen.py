"""A sheen of fibres over any other surface.

With the weight w and the colour t of the fibres, the largest of t being t_m, and where light leaves on the side that it
comes from,

    f = w t f_fibres + (1 - u + u S(i, o)) f_base,    S = min(T(i), T(o)) g(i) g(o),    u = w t_m,

f_fibres being that of `fibres`, T what the fibres leave of light from a direction, and g the factor near 1 with which the
mean of S over what an opaque base sends out is T(i) (see `layering`). So the base loses of light from each direction the
largest share that the fibres send on, light that it mirrors too, and no more goes on than comes. Where the base lets light
through, S = T of the direction that is looked along, which is Blender's answer and not reciprocal.
"""

import numpy as np

from .facets import read_row
from .fibres import Fibres, sent_on
from .layering import passing, spreading

DARKEST = 0.1
"""Least reflectance that bases are taken to have where a lobe is chosen. [-]"""


def sheen_class():
    """Return the plug-in for the active Mitsuba variant."""
    import drjit as dr
    import mitsuba as mi

    from ..arrays import average, upload

    class Sheen(mi.BSDF):
        """``base``: what lies below; ``weight`` and ``tint``: textures; `set_fibres` gives it the rest."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.base, self.weight, self.tint = props["base"], props["weight"], props["tint"]
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            own = mi.BSDFFlags.GlossyReflection | sides
            count = self.base.component_count()
            self.m_components = [own, *(self.base.flags(i) for i in range(count))]
            self.m_flags = own | self.base.flags()

        def set_fibres(self, roughness, is_velvet, most, facets):
            """Set the fibres.

            Parameters
            ----------
            roughness : float    Theirs. [-]
            is_velvet : bool    Whether they are upright.
            most : float    Largest value of the tint. [-]
            facets : tuple or None    Of an opaque base, as `spreading` takes them; None: light passes it.
            """
            roughness = round(float(roughness), 4)
            self.fibres = Fibres(roughness, is_velvet)
            sent = sent_on(roughness, is_velvet)
            left, factor = 1.0 - sent, np.ones_like(sent)
            if facets is not None:
                factor = passing(left, spreading(*facets) * np.minimum.outer(left, left))
            self.table = upload(mi.Float, np.stack([sent, factor]))
            self.most = dr.opaque(mi.Float, float(most))
            self.is_open = dr.opaque(mi.Bool, facets is None)
            dr.eval(self.table)

        def traverse(self, callback):
            callback.put("base", self.base, mi.ParamFlags.Differentiable)
            callback.put("weight", self.weight, mi.ParamFlags.Differentiable)
            callback.put("tint", self.tint, mi.ParamFlags.Differentiable)

        def _read(self, row, cosine, active):
            return read_row(self.table, mi.UInt32(row), dr.abs(cosine), active)

        def _prepare(self, si, active):
            """Weight of the fibres by colour, u, what they send on and g of this side, how likely they are chosen."""
            weight = dr.clip(self.weight.eval_1(si, active), 0.0, 1.0)
            colour = weight * self.tint.eval(si, active)
            cover = weight * self.most
            cosine = mi.Frame3f.cos_theta(si.wi)
            sent = self._read(0, cosine, active)
            base = average(self.base.eval_diffuse_reflectance(si, active))
            base = dr.select(self.is_open, 1.0, dr.clip(base, DARKEST, 1.0))
            own, below = sent * average(colour), (1.0 - sent * cover) * base
            chance = own / dr.maximum(own + below, 1e-8)
            return colour, cover, (sent, self._read(1, cosine, active)), chance

        def _left(self, cosine, prepared, active):
            """What the fibres leave of the light that their base sends on."""
            _, cover, (sent, factor), _ = prepared
            other, beyond = (self._read(row, cosine, active) for row in (0, 1))
            both = (1.0 - dr.maximum(sent, other)) * factor * beyond
            return 1.0 - cover + cover * dr.select(self.is_open, 1.0 - sent, both)

        def _evaluate(self, si, wo, below, prepared, active):
            """Value and density. ``below``: those of the base."""
            colour, *_, chance = prepared
            value, pdf = below
            is_same = active & (mi.Frame3f.cos_theta(si.wi) * mi.Frame3f.cos_theta(wo) > 0.0)
            shine, density = self.fibres.evaluate(_raised(si.wi), _raised(wo), is_same)
            value = value * self._left(mi.Frame3f.cos_theta(wo), prepared, active)
            value += dr.select(is_same, colour * shine, 0.0)
            return value, dr.select(is_same, chance * density, 0.0) + (1.0 - chance) * pdf

        def sample(self, ctx, si, sample1, sample2, active=True):
            active = mi.Bool(active)
            prepared = self._prepare(si, active)
            chance = prepared[-1]
            is_own = sample1 < chance
            wi = _raised(si.wi)
            choice = sample1 / dr.maximum(chance, 1e-8)
            own = self.fibres.sample(wi, choice, sample2, active & is_own)
            is_seen = (own.z > 0.0) & (wi.z > 0.0)
            own.z = dr.select(si.wi.z < 0.0, -own.z, own.z)
            reused = (sample1 - chance) / dr.maximum(1.0 - chance, 1e-8)
            bs, weight = self.base.sample(ctx, si, reused, sample2, active & ~is_own)
            bs.wo = dr.select(is_own, own, bs.wo)
            bs.eta = dr.select(is_own, 1.0, bs.eta)
            bs.sampled_component = dr.select(is_own, 0, bs.sampled_component)
            kind = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
            bs.sampled_type = dr.select(is_own, kind, bs.sampled_type)
            single = mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta)
            single |= mi.has_flag(bs.sampled_type, mi.BSDFFlags.Null)
            spreads = active & ~single & (~is_own | is_seen)
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
            prepared = self._prepare(si, active)
            below = self.base.eval_diffuse_reflectance(si, active)
            below = below * self._left(mi.Float(1.0), prepared, active)
            return below + prepared[0] * self._read(0, mi.Float(1.0), active)

        def eval_null_transmission(self, si, active=True):
            left = self._left(mi.Frame3f.cos_theta(si.wi), self._prepare(si, active), active)
            return self.base.eval_null_transmission(si, active) * left

        def to_string(self):
            return "Sheen[]"

    def _raised(w):
        return mi.Vector3f(w.x, w.y, dr.abs(w.z))

    return Sheen
