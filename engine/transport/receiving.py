"""One-sample estimates of the light at a receiver, direct light and interreflection apart.

Both meet light that comes straight from an emitter: next-event by choosing it, the ray by running into it. They
are weighed by the power heuristic for as many samples as each takes (E. Veach, 1997, ch. 9), so any numbers add up.
"""

import drjit as dr
import mitsuba as mi

from . import paths
from .cached_gather import incoming
from .rays import spawn_ray


def direct(scene, si, sample, stream, active, ratio, respond):
    """Light by next-event.

    Parameters
    ----------
    si : SurfaceInteraction3f    The receiver; its normals face the receiving side.
    sample : Point2f
    stream : PCG32
    active : Bool
    ratio : Float    Next-event samples for every ray of `gathered`.
    respond : callable    How much radiance from a direction of the scene's frame counts, cosine included. [-]

    Returns
    -------
    Spectrum    Spectral irradiance [W/(m2 nm)], or illuminance [lx] in photometric variants.
    """
    total = mi.Spectrum(0.0)
    if not scene.lights.count:
        return total

    def weigh(direction, density):
        competing = dr.maximum(dr.dot(direction, si.sh_frame.n), 0.0) * dr.inv_pi
        return paths.power_heuristic(density * ratio, competing)

    ds, value = paths.sample_emitter(scene, si, sample, active)
    response = respond(ds.d)
    lit = active & (ds.pdf > 0.0) & (response > 0.0)
    amount = value * response * dr.select(ds.delta, 1.0, weigh(ds.d, ds.pdf))
    amount = dr.select(lit, amount, 0.0)
    lit &= dr.any(amount != 0.0)
    total += dr.select(lit, amount * paths.transmittance(scene, si, ds, lit), 0.0)
    if scene.mirrors is not None:
        mirror_sample = mi.Point2f(stream.next_float32(), stream.next_float32())

        def answer(direction, asked):
            # The heuristic there compares one sample of each kind.
            competing = dr.maximum(dr.dot(direction, si.sh_frame.n), 0.0) * dr.inv_pi
            return respond(direction), competing / ratio

        total += paths.mirrored_light(scene, si, mirror_sample, stream, answer, active)
    return total


def gathered(scene, cells, si, wavelengths, stream, sample, active, ratio, respond, **more):
    """Light along one cosine-distributed ray. Parameters as of `direct` and `cached_gather.incoming`."""
    local = mi.warp.square_to_cosine_hemisphere(sample)
    density = mi.warp.square_to_cosine_hemisphere_pdf(local)
    direction = si.sh_frame.to_world(local)
    response = respond(direction)
    gathers = active & (density > 0.0) & (response > 0.0)
    value = incoming(
        scene,
        cells,
        spawn_ray(scene, si, direction),
        wavelengths,
        stream,
        density,
        si.p,
        gathers,
        ratio,
        **more,
    )
    return dr.select(gathers, value * (response / density), 0.0)
