"""Illuminance at points: next-event to the lights plus one cosine-distributed ray that goes on as a path."""

import drjit as dr
import mitsuba as mi

from ...scene.sensor import SensorKind
from ..compiled.compile import CompiledScene
from ..compiled.textures import is_spectral
from ..rays import spawn_ray
from . import path_loop as paths
from .sampler import sobol_pair

PAIR_WAVELENGTH, PAIR_LIGHT, PAIR_SCATTER, PAIR_PLACE, PAIR_LENS, PAIR_FILM = range(6)
"""Which pair of the low-discrepancy sequence serves what."""


def receiver(point, normal, geometric_normal, wavelengths, extent=0.0):
    """Return a virtual surface at the given place, from which rays start with an offset along its normal.

    ``extent``: largest coordinate of the object that the place lies on. [m]
    """
    si = dr.zeros(mi.SurfaceInteraction3f)
    si.p = point
    si.n = geometric_normal
    si.sh_frame = mi.Frame3f(normal)
    # Rays start off a surface by how exact its place is, and the way to it is a part of that.
    si.t = extent
    if wavelengths is not None:
        si.wavelengths = wavelengths
    return si


def _response(kind: SensorKind, si):
    """How much radiance from a direction counts, as a function of the direction. [sr-1 -> -] (EN 12665, CIE S 017)"""

    def sine(direction):
        return dr.safe_sqrt(1.0 - dr.square(direction.z))

    match kind:
        case SensorKind.SPHERICAL:
            return lambda direction: mi.Float(0.25)
        case SensorKind.CYLINDRICAL:
            return lambda direction: sine(direction) * dr.inv_pi
        case SensorKind.SEMICYLINDRICAL:
            # 1 + cos of the angle in plan between direction and facing, times the sine of the zenith angle.
            ahead = dr.normalize(mi.Vector3f(si.sh_frame.n.x, si.sh_frame.n.y, 0.0))
            return lambda direction: (sine(direction) + dr.dot(direction, ahead)) * dr.inv_pi
    # Directions below the geometric surface give nothing, whatever the shading normal says.
    return lambda direction: dr.select(
        dr.dot(direction, si.n) > 0.0, dr.maximum(dr.dot(direction, si.sh_frame.n), 0.0), 0.0
    )


def spectral_illuminance(
    scene: CompiledScene,
    si,
    wavelengths,
    stream,
    light_sample,
    scatter_sample,
    active,
    kind: SensorKind = SensorKind.PLANAR,
    limit=None,
):
    """One-sample estimate of the illuminance at a receiver.

    Parameters
    ----------
    kind : SensorKind
    limit : UInt32 or None    Most reflections that light may have had.

    Returns
    -------
    Spectrum    Spectral irradiance [W/(m2 nm)], or illuminance [lx] in photometric variants.
    """
    total = mi.Spectrum(0.0)
    respond = _response(kind, si)
    is_planar = kind is SensorKind.PLANAR

    def density(direction):
        if is_planar:
            return dr.maximum(dr.dot(direction, si.sh_frame.n), 0.0) * dr.inv_pi
        return mi.Float(dr.inv_four_pi)

    if scene.lights.count:
        ds, value = paths.sample_emitter(scene, si, light_sample, active)
        response = respond(ds.d)
        lit = active & (ds.pdf > 0.0) & (response > 0.0)
        weight = dr.select(ds.delta, 1.0, paths.power_heuristic(ds.pdf, density(ds.d)))
        amount = dr.select(lit, value * response * weight, 0.0)
        lit &= dr.any(amount != 0.0)
        total += dr.select(lit, amount * paths.transmittance(scene, si, ds, lit), 0.0)
        if scene.mirrors is not None:
            sample = mi.Point2f(stream.next_float32(), stream.next_float32())
            total += paths.mirrored_light(
                scene,
                si,
                sample,
                stream,
                lambda direction, asked: (respond(direction), density(direction)),
                active,
                limit,
            )

    if scene.bent is not None:

        def respond_alone(direction, asked):
            return dr.select(asked, respond(direction), 0.0)

        total += scene.bent.light(si, stream, respond_alone, active, limit=limit)

    if scene.spots is not None and scene.lights.count:
        asked = active if limit is None else active & (limit > 0)

        def respond_to_spot(direction, asked):
            return dr.select(asked, respond(direction), 0.0), density(direction)

        rest = None if limit is None else mi.UInt32(dr.maximum(limit, 1) - 1)
        total += paths.spotted_light(scene, si, stream, respond_to_spot, asked, rest)

    if is_planar:
        local = mi.warp.square_to_cosine_hemisphere(scatter_sample)
        pdf = mi.warp.square_to_cosine_hemisphere_pdf(local)
        direction = si.sh_frame.to_world(local)
    else:
        direction = mi.warp.square_to_uniform_sphere(scatter_sample)
        pdf = mi.Float(dr.inv_four_pi)
    response = respond(direction)
    gathers = active & (pdf > 0.0) & (response > 0.0)
    incoming = paths.trace(
        scene,
        spawn_ray(scene, si, direction),
        wavelengths,
        stream,
        pdf,
        si.p,
        gathers,
        depth=1,
        limit=limit,
    )
    return total + dr.select(gathers, incoming * (response / pdf), 0.0)


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
