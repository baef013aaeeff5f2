"""Blender's Toon: light goes evenly into a cone about the normal or the mirror direction, whose edge may be soft.

With the cone's half angle a, the width b of its edge and the whole half angle c = min(a + b, 90 degrees),

    f cos_o = rho I(theta) / (2 pi (1 - cos c)),    I = 1 up to a, from there falling to 0 at a + b,

theta being the angle of o to the cone's axis. The diffuse one is the same from all sides; of the glossy one what would go
below the surface is lost. Neither is reciprocal.
"""

import numpy as np

from ..scene.material import toon_angles


def toon_class():
    """Return the plug-in for the active Mitsuba variant."""
    import drjit as dr
    import mitsuba as mi

    class Toon(mi.BSDF):
        """``reflectance``: a texture; ``size`` and ``edge``: numbers from 0 to 1, of right angles.

        ``is_glossy``: whether the cone lies about the mirror direction.
        """

        def __init__(self, props):
            mi.BSDF.__init__(self, props)
            self.is_glossy = bool(props["is_glossy"])
            self.is_matt = not self.is_glossy
            self.reflectance = props["reflectance"]
            size, edge, whole = toon_angles(float(props["size"]), float(props["edge"]))
            self.size, self.edge, self.least, self.even = (
                dr.opaque(mi.Float, value)
                for value in (
                    size,
                    max(edge, 1e-6),
                    np.cos(whole),
                    1.0 / (2.0 * np.pi * (1.0 - np.cos(whole))),
                )
            )
            sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
            self.m_components = [mi.BSDFFlags.GlossyReflection | sides]
            self.m_flags = self.m_components[0]

        def traverse(self, callback):
            callback.put("reflectance", self.reflectance, mi.ParamFlags.Differentiable)

        def eval_pdf(self, ctx, si, wo, active=True):
            cos_i, cos_o = mi.Frame3f.cos_theta(si.wi), mi.Frame3f.cos_theta(wo)
            valid = mi.Bool(active) & (cos_i * cos_o > 0.0)
            near = dr.dot(mi.reflect(si.wi), wo) if self.is_glossy else dr.abs(cos_o)
            valid &= near >= self.least
            beyond = (dr.safe_acos(near) - self.size) / self.edge
            shine = self.even * dr.clip(1.0 - beyond, 0.0, 1.0)
            value = self.reflectance.eval(si, active) * shine
            return mi.Spectrum(dr.select(valid, value, 0.0)), dr.select(valid, self.even, 0.0)

        def sample(self, ctx, si, sample1, sample2, active=True):
            wo = mi.warp.square_to_uniform_cone(sample2, self.least)
            if self.is_glossy:
                wo = mi.Frame3f(mi.reflect(si.wi)).to_world(wo)
            else:
                wo.z = dr.select(mi.Frame3f.cos_theta(si.wi) < 0.0, -wo.z, wo.z)
            bs = dr.zeros(mi.BSDFSample3f)
            bs.wo = wo
            bs.eta = 1.0
            bs.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
            value, bs.pdf = self.eval_pdf(ctx, si, wo, active)
            valid = mi.Bool(active) & (bs.pdf > 0.0)
            return bs, mi.Spectrum(dr.select(valid, value / dr.maximum(bs.pdf, 1e-20), 0.0))

        def eval(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[0]

        def pdf(self, ctx, si, wo, active=True):
            return self.eval_pdf(ctx, si, wo, active)[1]

        def eval_diffuse_reflectance(self, si, active=True):
            return self.reflectance.eval(si, active)

        def to_string(self):
            return "Toon[]"

    return Toon
