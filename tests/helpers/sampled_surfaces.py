"""Surfaces by themselves: their plug-ins, hits to ask them about, and how much light they send on."""

import numpy as np
from scattering_models import towards


def plugin(surface):
    """Make the plug-in of a surface in the active variant, in light of equal energy."""
    import mitsuba as mi

    from lumenray.engine.materials import plugins
    from lumenray.engine.transport.compiled.surfaces import bsdf
    from lumenray.engine.transport.compiled.textures import TextureMaker

    plugins.register()
    made = bsdf(surface, TextureMaker(np.ones(471)))
    return mi.load_dict(made) if isinstance(made, dict) else made


def interaction(direction, count):
    """Hits of a flat surface, seen from a local direction at 450, 550, 600 and 650 nm if the variant has wavelengths."""
    import drjit as dr
    import mitsuba as mi

    si = dr.zeros(mi.SurfaceInteraction3f, count)
    si.wi = mi.Vector3f(*map(float, direction))
    si.n, si.sh_frame = mi.Normal3f(0, 0, 1), mi.Frame3f(mi.Normal3f(0, 0, 1))
    if len(si.wavelengths) == 4:
        si.wavelengths = mi.Spectrum(450.0, 550.0, 600.0, 650.0)
    return si


def albedo(surface, angle, count=1 << 16):
    """Mean weight of samples: share of light that is reflected and let through, by radiance. [-]"""
    import mitsuba as mi

    stream = mi.PCG32(size=count, initstate=9)
    si = interaction(towards(angle), count)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    _, weight = plugin(surface).sample(mi.BSDFContext(), si, stream.next_float32(), sample, True)
    return float(np.array(weight).mean())


def flux(surface, angle, count):
    """Share of light that goes on; radiance grows with the square of the index that it passes to."""
    import mitsuba as mi

    stream = mi.PCG32(size=count, initstate=9)
    si = interaction(towards(angle), count)
    sample = mi.Point2f(stream.next_float32(), stream.next_float32())
    bs, weight = plugin(surface).sample(mi.BSDFContext(), si, stream.next_float32(), sample, True)
    return float((np.array(weight)[0] * np.array(bs.eta) ** 2).mean())
