"""What surfaces share that reflect and transmit into single directions only."""

import drjit as dr
import mitsuba as mi

from ..arrays import average


def specular(cls):
    """Class decorator: nothing to evaluate for a given pair of directions (nanobind allows one base only)."""
    cls.eval_pdf = lambda self, ctx, si, wo, active=True: (mi.Spectrum(0.0), mi.Float(0.0))
    cls.eval = lambda self, ctx, si, wo, active=True: mi.Spectrum(0.0)
    cls.pdf = lambda self, ctx, si, wo, active=True: mi.Float(0.0)
    return cls


def pane_components():
    """Flags of a pane's two components: mirror reflection and straight transmission, from both sides."""
    sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
    return [mi.BSDFFlags.DeltaReflection | sides, mi.BSDFFlags.Null | sides]


def sample_pane(si, reflectance, transmittance, sample, active):
    """Reflect or go straight on, in proportion to a pane's reflectance and transmittance.

    Parameters
    ----------
    si : SurfaceInteraction3f
    reflectance, transmittance : Spectrum    [-]
    sample : Float    In [0, 1).

    Returns
    -------
    (BSDFSample3f, Spectrum)    The sample and its weight.
    """
    r, t = average(reflectance), average(transmittance)
    p_reflect = r / dr.maximum(r + t, 1e-8)
    reflects = sample < p_reflect
    bs = dr.zeros(mi.BSDFSample3f)
    bs.wo = dr.select(reflects, mi.reflect(si.wi), -si.wi)
    bs.pdf = dr.select(reflects, p_reflect, 1.0 - p_reflect)
    bs.eta = 1.0
    bs.sampled_component = dr.select(reflects, mi.UInt32(0), mi.UInt32(1))
    bs.sampled_type = dr.select(
        reflects, mi.UInt32(+mi.BSDFFlags.DeltaReflection), mi.UInt32(+mi.BSDFFlags.Null)
    )
    weight = dr.select(reflects, reflectance, transmittance) / dr.maximum(bs.pdf, 1e-8)
    return bs, mi.Spectrum(dr.select(active, weight, 0.0))
