"""Boundaries of a body that refract and do not reflect, as Blender's Refraction BSDF.

All light passes, and none beyond the critical angle.
"""

import drjit as dr
import mitsuba as mi

from .absorption import body_of
from .specular import specular


def refraction_class():
    """Return the plug-in of smooth boundaries for the active Mitsuba variant."""

    @specular
    class Refraction(mi.BSDF):
        """``ior`` and ``tint``: textures."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.ior, self.tint = props["ior"], props["tint"]
            self.body = body_of(props)
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [mi.BSDFFlags.DeltaTransmission | sides | mi.BSDFFlags.NonSymmetric]
            self.m_flags = self.m_components[0]

        def traverse(self, callback):
            callback.put("ior", self.ior, mi.ParamFlags.NonDifferentiable)
            callback.put("tint", self.tint, mi.ParamFlags.Differentiable)
            if self.body is not None:
                callback.put("internal", self.body.internal, mi.ParamFlags.Differentiable)

        def sample(self, ctx, si, sample1, sample2, active=True):
            cosine = mi.Frame3f.cos_theta(si.wi)
            index = self.ior.eval(si, active)[0]
            reflected, cos_t, eta_it, eta_ti = mi.fresnel(cosine, index)
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = mi.refract(si.wi, cos_t, eta_ti)
            bs.pdf = 1.0
            bs.eta = eta_it
            bs.sampled_component = mi.UInt32(0)
            bs.sampled_type = mi.UInt32(+mi.BSDFFlags.DeltaTransmission)
            passes = active & (reflected < 1.0) & (cosine != 0.0)
            weight = self.tint.eval(si, active) * dr.square(eta_ti)
            if self.body is not None:
                weight *= self.body.passed(si, active)
            return bs, mi.Spectrum(dr.select(passes, weight, 0.0))

        def to_string(self):
            return "Refraction[]"

    return Refraction


def rough_refraction_class():
    """Return the plug-in of rough boundaries for the active Mitsuba variant."""

    class RoughRefraction(mi.BSDF):
        """``nested``: a rough boundary of ``index`` whose facets let through what they do not reflect."""

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.nested = props["nested"]
            self.body = body_of(props)
            self.index = dr.opaque(mi.Float, float(props["index"]))
            count = self.nested.component_count()
            self.m_components = [self.nested.flags(i) for i in range(count)]
            self.m_flags = self.nested.flags()

        def traverse(self, callback):
            callback.put("nested", self.nested, mi.ParamFlags.Differentiable)
            if self.body is not None:
                callback.put("internal", self.body.internal, mi.ParamFlags.Differentiable)

        def _scale(self, si, wo):
            """Takes back what facets reflect of light that is refracted from ``wi`` to ``wo``; 0 where none is."""
            cosine = mi.Frame3f.cos_theta(si.wi)
            eta = dr.select(cosine > 0.0, self.index, 1.0 / self.index)
            facet = dr.normalize(si.wi + wo * eta)
            facet = dr.mulsign(facet, mi.Frame3f.cos_theta(facet))
            reflected = mi.fresnel(dr.dot(si.wi, facet), self.index)[0]
            passes = (cosine * mi.Frame3f.cos_theta(wo) < 0.0) & (reflected < 1.0)
            scale = dr.select(passes, 1.0 / dr.maximum(1.0 - reflected, 1e-4), 0.0)
            return scale if self.body is None else scale * self.body.passed(si, passes)

        def sample(self, ctx, si, sample1, sample2, active=True):
            # Radiance in whichever way light goes, as all surfaces here.
            bs, weight = self.nested.sample(mi.BSDFContext(), si, sample1, sample2, active)
            return bs, weight * self._scale(si, bs.wo)

        def eval_pdf(self, ctx, si, wo, active=True):
            value, pdf = self.nested.eval_pdf(ctx, si, wo, active)
            return value * self._scale(si, wo), pdf

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.nested.pdf(ctx, si, wo, active)

        def to_string(self):
            return "RoughRefraction[]"

    return RoughRefraction
