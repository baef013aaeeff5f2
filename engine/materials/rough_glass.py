"""Rough boundaries of glass that keep the light which passes from facet to facet.

Mitsuba's rough dielectric follows light to one facet only. What it sends on is divided by the share E(cos_i) that it keeps
of light from a direction, so that with colourless glass all light goes on. This is the answer to a direction that is looked
along, as paths from eyes and sensors ask for; the reverse would differ a little.

References
----------
E. Turquin: Practical Multiple Scattering Compensation for Microfacet Models, Industrial Light & Magic, 2019.
"""

import numpy as np

from .absorption import body_of
from .facets import kept_by_glass, read_row


def rough_glass_class():
    """Return the plug-in for the active Mitsuba variant."""
    import drjit as dr
    import mitsuba as mi

    from ..arrays import upload

    class RoughGlass(mi.BSDF):
        """``nested``: the boundary by single scattering; ``alpha`` and ``index``: numbers that it was made with.

        ``internal`` and ``thickness``: as of `absorption.Body`, if light is absorbed inside.
        """

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.nested = props["nested"]
            self.body = body_of(props)
            alpha, index = float(props["alpha"]), float(props["index"])
            kept = np.stack([kept_by_glass(alpha, index), kept_by_glass(alpha, 1.0 / index)])
            self.table = upload(mi.Float, kept)
            dr.eval(self.table)
            count = self.nested.component_count()
            self.m_components = [self.nested.flags(i) for i in range(count)]
            self.m_flags = self.nested.flags()

        def traverse(self, callback):
            callback.put("nested", self.nested, mi.ParamFlags.Differentiable)
            if self.body is not None:
                callback.put("internal", self.body.internal, mi.ParamFlags.Differentiable)

        def _scale(self, si, active):
            cosine = mi.Frame3f.cos_theta(si.wi)
            side = dr.select(cosine > 0.0, mi.UInt32(0), mi.UInt32(1))
            scale = 1.0 / dr.maximum(read_row(self.table, side, dr.abs(cosine), active), 0.05)
            return scale if self.body is None else scale * self.body.passed(si, active)

        def sample(self, ctx, si, sample1, sample2, active=True):
            # Radiance in whichever way light goes, as all surfaces here.
            bs, weight = self.nested.sample(mi.BSDFContext(), si, sample1, sample2, active)
            return bs, weight * self._scale(si, active)

        def eval_pdf(self, ctx, si, wo, active=True):
            value, pdf = self.nested.eval_pdf(ctx, si, wo, active)
            return value * self._scale(si, active), pdf

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.nested.pdf(ctx, si, wo, active)

        def to_string(self):
            return "RoughGlass[]"

    return RoughGlass
