"""One-sample estimates of the light at a receiver, direct light and interreflection apart.

Both meet light that comes straight from an emitter: next-event by choosing it, the ray by running into it. They
are weighed by the power heuristic for as many samples as each takes (E. Veach, 1997, ch. 9), so any numbers add up.
"""

from dataclasses import dataclass, field

import drjit as dr
import mitsuba as mi

from ..paths.next_event import mirrored_light, next_event
from ..rays import spawn_ray
from .cached_gather import incoming
from .path_guiding import Cosine


@dataclass(frozen=True)
class Receiver:
    """Where light is received, and the samples for it.

    Parameters
    ----------
    si : SurfaceInteraction3f    Its normals face the receiving side.
    wavelengths : Spectrum or None    Four of each path, None in photometric variants. [nm]
    stream : PCG32
    sample : Point2f    For the choice of a light, or for a direction.
    ratio : Float    Samples of the same kind for every ray of `gathered`; for a ray: those of `direct`.
    respond : callable    How much radiance from a direction of the scene's frame counts, cosine included. [-]
    aim : Cosine or TileAim    Which directions rays take.
    """

    si: object
    wavelengths: object
    stream: object
    sample: object
    ratio: object
    respond: object
    aim: object = field(default_factory=Cosine)

    def density(self, direction):
        """Density with which a direction of the scene's frame is taken by rays. [sr-1]"""
        return self.aim.density(self.si.to_local(direction))

    def answer(self, direction, asked):
        """Response and density of a direction, as `next_event` asks for them."""
        return self.respond(direction), self.density(direction)


def direct(scene, receiver: Receiver, active=True):
    """Light by next-event straight to lights.

    Returns
    -------
    Spectrum    Spectral irradiance [W/(m2 nm)], or illuminance [lx] in photometric variants.
    """
    if not scene.lights.count:
        return mi.Spectrum(0.0)
    return next_event(
        scene, receiver.si, receiver.sample, receiver.answer, mi.Bool(active), receiver.ratio
    )


def mirrored(scene, receiver: Receiver):
    """Light by next-event over plane mirrors and panes; returns as `direct`."""
    if scene.mirrors is None or not scene.lights.count:
        return mi.Spectrum(0.0)

    def answer(direction, asked):
        # The heuristic there compares one sample of each kind.
        return receiver.respond(direction), receiver.density(direction) / receiver.ratio

    si, stream = receiver.si, receiver.stream
    return mirrored_light(scene, si, receiver.sample, stream, answer, mi.Bool(True))


def gathered(scene, cells, receiver: Receiver, is_apart: bool = False, **more):
    """Light along one ray as the receiver aims it; ``cells`` and ``more`` as of `cached_gather.incoming`.

    Returns
    -------
    Spectrum or (Spectrum, Spectrum)
        Spectral irradiance [W/(m2 nm)], or illuminance [lx] in photometric variants; what was read from cells apart
        from the rest where that is asked for.
    """
    si = receiver.si
    local, density = receiver.aim.sample(receiver.sample)
    direction = si.sh_frame.to_world(local)
    response = receiver.respond(direction)
    sends = (density > 0.0) & (response > 0.0)
    rest, read = incoming(
        scene,
        cells,
        spawn_ray(scene, si, direction),
        receiver.wavelengths,
        receiver.stream,
        density,
        si.p,
        sends,
        receiver.ratio,
        **more,
    )
    rest, read = (dr.select(sends, each * (response / density), 0.0) for each in (rest, read))
    return (rest, read) if is_apart else rest + read
