"""Illuminance at points: next-event to the lights plus one cosine-distributed ray that goes on as a path."""

import drjit as dr
import mitsuba as mi

from . import paths
from .compile import CompiledScene
from .sampler import sobol_pair
from .textures import is_spectral

PAIR_WAVELENGTH, PAIR_LIGHT, PAIR_SCATTER, PAIR_PLACE, PAIR_LENS, PAIR_FILM = range(6)
"""Which pair of the low-discrepancy sequence serves what."""


def receiver(point, normal, geometric_normal, wavelengths):
    """Return a virtual surface at the given place, from which rays start with an offset along its normal."""
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.p = point
    si.n = geometric_normal
    si.sh_frame = mi.Frame3f(normal)
    si.t = 0.0
    if wavelengths is not None:
        si.wavelengths = wavelengths
    return si


def spectral_illuminance(
    scene: CompiledScene, si, wavelengths, stream, light_sample, scatter_sample, active
):
    """One-sample estimate of the illuminance at a receiver.

    Directions below the geometric surface give nothing, whatever the shading normal says.

    Returns
    -------
    Spectrum    Spectral irradiance [W/(m2 nm)], or illuminance [lx] in photometric variants.
    """
    total = mi.Spectrum(0.0)
    normal = si.sh_frame.n
    if scene.lights.count:
        ds, value = paths.sample_emitter(scene, si, light_sample, active)
        cosine = dr.dot(ds.d, normal)
        lit = active & (ds.pdf > 0.0) & (cosine > 0.0) & (dr.dot(ds.d, si.n) > 0.0)
        weight = dr.select(ds.delta, 1.0, paths.power_heuristic(ds.pdf, cosine * dr.inv_pi))
        amount = dr.select(lit, value * cosine * weight, 0.0)
        lit &= dr.any(amount != 0.0)
        total += dr.select(lit, amount * paths.transmittance(scene, si, ds.p, lit), 0.0)

    local = mi.warp.square_to_cosine_hemisphere(scatter_sample)
    pdf = mi.warp.square_to_cosine_hemisphere_pdf(local)
    direction = si.sh_frame.to_world(local)
    gathers = active & (pdf > 0.0) & (dr.dot(direction, si.n) > 0.0)
    incoming = paths.trace(
        scene, si.spawn_ray(direction), wavelengths, stream, pdf, si.p, gathers, depth=1
    )
    return total + dr.select(gathers, incoming * dr.pi, 0.0)


def photometric(sampler, value, wavelengths):
    """Photometric amount of a spectral estimate; in photometric variants it already is one."""
    if is_spectral():
        return sampler.luminance(value, wavelengths)
    return value[0] if len(value) == 1 else value.x


def draw_wavelengths(sampler, index, seed):
    """Return the four wavelengths of each path, None in photometric variants. [nm]"""
    if not is_spectral():
        return None
    return sampler.sample(sobol_pair(index, seed, PAIR_WAVELENGTH).x)


def typical_wavelengths():
    """Return four wavelengths that stand for the visible range, None in photometric variants. [nm]"""
    return mi.Spectrum(450.0, 530.0, 570.0, 610.0) if is_spectral() else None
