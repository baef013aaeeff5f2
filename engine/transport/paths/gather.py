"""Illuminance at points: next-event to the lights plus one cosine-distributed ray that goes on as a path."""

import drjit as dr
import mitsuba as mi

from ...scene.sensor import SensorKind
from ..compiled.compile import CompiledScene
from ..compiled.textures import is_spectral
from ..rays import spawn_ray
from .next_event import mirrored_light, next_event
from .path_loop import trace
from .sampler import sobol_pair
from .spotted_light import spotted_light

PAIR_WAVELENGTH, PAIR_LIGHT, PAIR_SCATTER, PAIR_PLACE, PAIR_LENS, PAIR_FILM = range(6)
PAIR_CHOICE = 8
"""Which pair of the low-discrepancy sequence serves what; those between are of the illuminance that pictures tell."""


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


def response_of(kind: SensorKind, si):
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
            return lambda direction: (
                dr.maximum(sine(direction) + dr.dot(direction, ahead), 0.0) * dr.inv_pi
            )
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
    known=None,
    faded=None,
):
    """One-sample estimate of the illuminance at a receiver.

    Parameters
    ----------
    kind : SensorKind
    limit : UInt32 or None    Most reflections that light may have had.
    known : known_directions.Directions or None    Where the receiver is known to get light over bends from.
    faded : Float or None    As of `path_loop.trace`.

    Returns
    -------
    Spectrum    Spectral irradiance [W/(m2 nm)], or illuminance [lx] in photometric variants.
    """
    total = mi.Spectrum(0.0)
    respond = response_of(kind, si)
    is_planar = kind is SensorKind.PLANAR

    def density(direction):
        if is_planar:
            return dr.maximum(dr.dot(direction, si.sh_frame.n), 0.0) * dr.inv_pi
        return mi.Float(dr.inv_four_pi)

    def answer(direction, asked):
        return respond(direction), density(direction)

    if scene.lights.count:
        total += next_event(scene, si, light_sample, answer, active)
        if scene.mirrors is not None:
            sample = mi.Point2f(stream.next_float32(), stream.next_float32())
            total += mirrored_light(scene, si, sample, stream, answer, active, limit)

    if scene.bent is not None:
        total += scene.bent.light(si, stream, answer, active, limit=limit, known=known)

    if scene.spots is not None and scene.lights.count:
        asked = active if limit is None else active & (limit > 0)
        rest = None if limit is None else mi.UInt32(dr.maximum(limit, 1) - 1)
        total += spotted_light(scene, si, stream, answer, asked, rest)

    direction, pdf = _draw_direction(si, scatter_sample, is_planar)
    response = respond(direction)
    gathers = active & (pdf > 0.0) & (response > 0.0)
    incoming = trace(
        scene,
        spawn_ray(scene, si, direction),
        wavelengths,
        stream,
        pdf,
        si.p,
        gathers,
        depth=1,
        limit=limit,
        faded=faded,
    )
    return total + dr.select(gathers, incoming * (response / pdf), 0.0)


def _draw_direction(si, sample, is_planar: bool):
    """Direction of a receiver's ray and its density: by the cosine law on surfaces, else evenly. [sr-1]"""
    if is_planar:
        local = mi.warp.square_to_cosine_hemisphere(sample)
        return si.sh_frame.to_world(local), mi.warp.square_to_cosine_hemisphere_pdf(local)
    return mi.warp.square_to_uniform_sphere(sample), mi.Float(dr.inv_four_pi)


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


def first_points(index, seed):
    """Return the first points of a path of the camera, as `path_loop.trace` takes them."""
    return tuple(sobol_pair(index, seed, pair) for pair in (PAIR_LIGHT, PAIR_SCATTER, PAIR_CHOICE))


def typical_wavelengths():
    """Return four wavelengths that stand for the visible range, None in photometric variants. [nm]"""
    return mi.Spectrum(450.0, 530.0, 570.0, 610.0) if is_spectral() else None
