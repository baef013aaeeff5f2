"""Two surfaces with weights by the side and the angle that they are seen from.

With the weights u and v of both parts, f = s (u(cos_i) f_1 + v(cos_i) f_2), where i is the direction that is looked along.
This is Blender's mixture by Fresnel or facing, its pair of a front and a back, and its sum, where u and v are 1 or less if
both together would send out more light than comes; s does the same by wavelengths. Where u and v depend on the angle the
surface is reciprocal for mirrors only.
"""

import numpy as np

from ..scene.material import BLEND_STEPS


def blend_class():
    """Return the plug-in for the active Mitsuba variant."""
    import drjit as dr
    import mitsuba as mi

    from ..arrays import upload

    class Blend(mi.BSDF):
        """``first`` and ``second``: the parts; ``limit``: s, a texture; `set_weights` gives it the rest."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.first, self.second, self.limit = props["first"], props["second"], props["limit"]
            self.m_components = [
                bsdf.flags(i)
                for bsdf in (self.first, self.second)
                for i in range(bsdf.component_count())
            ]
            self.m_flags = self.first.flags() | self.second.flags()

        def set_weights(self, weights):
            """Set the weights by side, part and cosine. (2, 2, `BLEND_STEPS`)"""
            self.table = upload(mi.Float, np.clip(weights, 0.0, 1.0))
            dr.eval(self.table)

        def traverse(self, callback):
            callback.put("first", self.first, mi.ParamFlags.Differentiable)
            callback.put("second", self.second, mi.ParamFlags.Differentiable)
            callback.put("limit", self.limit, mi.ParamFlags.Differentiable)

        def _weights(self, si, active):
            """Both weights, and the probability of the second part."""
            cosine = mi.Frame3f.cos_theta(si.wi)
            place = dr.sqrt(dr.clip(dr.abs(cosine), 0.0, 1.0)) * (BLEND_STEPS - 1)
            below = dr.minimum(mi.UInt32(place), BLEND_STEPS - 2)
            side = dr.select(cosine > 0.0, mi.UInt32(0), mi.UInt32(2 * BLEND_STEPS))
            weights = []
            for part in range(2):
                index = side + part * BLEND_STEPS + below
                low = dr.gather(mi.Float, self.table, index, active)
                high = dr.gather(mi.Float, self.table, index + 1, active)
                weights.append(dr.lerp(low, high, place - mi.Float(below)))
            first, second = weights
            total = first + second
            return first, second, dr.select(total > 0.0, second / dr.maximum(total, 1e-8), 0.0)

        def _sum(self, si, wo, weights, active):
            first, second, chance = weights
            ctx = mi.BSDFContext()
            value0, pdf0 = self.first.eval_pdf(ctx, si, wo, active & (first > 0.0))
            value1, pdf1 = self.second.eval_pdf(ctx, si, wo, active & (second > 0.0))
            value = (value0 * first + value1 * second) * self.limit.eval(si, active)
            return value, dr.lerp(pdf0, pdf1, chance)

        def sample(self, ctx, si, sample1, sample2, active=True):
            weights = self._weights(si, active)
            first, second, chance = weights
            is_second = sample1 < chance
            reused = dr.select(
                is_second,
                sample1 / dr.maximum(chance, 1e-8),
                (sample1 - chance) / dr.maximum(1.0 - chance, 1e-8),
            )
            bs0, weight0 = self.first.sample(ctx, si, reused, sample2, active & ~is_second)
            bs1, weight1 = self.second.sample(ctx, si, reused, sample2, active & is_second)
            bs = dr.select(is_second, bs1, bs0)
            # u / (1 - chance) and v / chance are both their sum.
            weight = dr.select(is_second, weight1, weight0)
            weight *= (first + second) * self.limit.eval(si, active)
            # Where the direction is spread out, the density of both parts counts.
            spread = ~mi.has_flag(bs.sampled_type, mi.BSDFFlags.Delta) & ~mi.has_flag(
                bs.sampled_type, mi.BSDFFlags.Null
            )
            value, pdf = self._sum(si, bs.wo, weights, active & spread)
            combined = dr.select(pdf > 0.0, value / dr.maximum(pdf, 1e-20), 0.0)
            bs.pdf = dr.select(spread, pdf, bs.pdf * dr.select(is_second, chance, 1.0 - chance))
            return bs, mi.Spectrum(dr.select(active, dr.select(spread, combined, weight), 0.0))

        def eval_pdf(self, ctx, si, wo, active=True):
            return self._sum(si, wo, self._weights(si, active), active)

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def eval_diffuse_reflectance(self, si, active=True):
            first, second, _ = self._weights(si, active)
            value = self.first.eval_diffuse_reflectance(si, active) * first
            value += self.second.eval_diffuse_reflectance(si, active) * second
            return value * self.limit.eval(si, active)

        def eval_null_transmission(self, si, active=True):
            first, second, _ = self._weights(si, active)
            value = self.first.eval_null_transmission(si, active) * first
            value += self.second.eval_null_transmission(si, active) * second
            return value * self.limit.eval(si, active)

        def to_string(self):
            return "Blend[]"

    return Blend
