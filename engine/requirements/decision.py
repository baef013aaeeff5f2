"""What a decision is: what was asked for, what was chosen, and what that may cost."""

import math
from dataclasses import dataclass, field

import numpy as np

from ..scene.camera import Camera, Projection
from ..scene.modelling import Switch

NEAR = 0.2
"""Within which of a camera what it sees begins, at most, where that is known. [m]"""

Box = tuple[tuple[float, float, float], tuple[float, float, float]]


MOST_BOXES = 256
"""Points up to which each has a box of its own."""


def boxes_of(points) -> tuple[Box, ...] | None:
    """Boxes round points (n, 3) for `Asked.places`; None where one is not finite. [m]"""
    points = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    if not np.isfinite(points).all():
        return None
    if len(points) > MOST_BOXES:
        low, high = (tuple(map(float, each)) for each in (points.min(axis=0), points.max(axis=0)))
        return ((low, high),)
    corners = [tuple(map(float, point)) for point in points]
    return tuple((corner, corner) for corner in corners)


def places_of(camera: Camera) -> tuple[Box, ...] | None:
    """Box round the places that a camera looks from, for `Asked.places`; None where they are not near its own. [m]"""
    if camera.projection is Projection.ORTHOGRAPHIC or camera.clip_start > NEAR:
        return None
    place, reach = np.asarray(camera.frame, dtype=np.float64)[:3, 3], camera.aperture_radius + NEAR
    return boxes_of(place) and (tuple(tuple(map(float, place + k * reach)) for k in (-1, 1)),)


@dataclass(frozen=True)
class Asked:
    """What a job wants of a scene.

    Parameters
    ----------
    error : float or None    Relative standard error of the whole; None where no error is asked for, so that only what
        changes nothing is simplified. [-]
    has_colour : bool    Whether colours or spectra are wanted, and not photometric quantities alone.
    objects : frozenset of str    Ids of objects whose own light is wanted.
    places : tuple of ((float, float, float), (float, float, float)), or None    Boxes, by their lowest and highest corners,
        which hold everything else that light is wanted at, and from where it is looked at; None: it may be anywhere. [m]
    """

    error: float | None = None
    has_colour: bool = True
    objects: frozenset[str] = frozenset()
    places: tuple[Box, ...] | None = None


@dataclass(frozen=True)
class Decision:
    """One decision, for people.

    Parameters
    ----------
    name : str    Of the decision; the same as that of its switch.
    choice : str    What is computed.
    reason : str    Why.
    bound : float    Largest relative error of the light by what is left out; 0: exact. [-]
    saving : float    Share of the time that is saved, about, as `docs/benchmarks/requirements.md` has it. [-]
    switch : Switch    Who made it.
    """

    name: str
    choice: str
    reason: str
    bound: float = 0.0
    saving: float = 0.0
    switch: Switch = Switch.AUTO


@dataclass(frozen=True)
class Late:
    """By how much a bound is larger where light comes late, which only those know who measure it.

    Parameters
    ----------
    reflections : int    By more of them light has come late.
    share : float    Of the light, up to which it may do so by the decision's own bound. [-]
    more : float    What is added to that bound where more of it does. [-]
    """

    reflections: int
    share: float
    more: float


@dataclass(frozen=True)
class Outcome:
    """A decision with what it does.

    Parameters
    ----------
    decision : Decision
    changes : dict    Items in place of the scene's, by id; None: left out.
    is_spectral : bool or None    Whether light has wavelengths; None where it is not what was decided.
    is_dispersive : bool    Whether glass refracts by the wavelength.
    late : tuple of Late    By the number of reflections.
    draws_evenly : bool    Whether wavelengths are drawn evenly from all that there are.
    samples_evenly : bool    Whether all sensors get as many samples.
    reflectance : float    Of surfaces on the mean, by which roulette waits; 0: it begins at once. [-]
    method : str    How reflected light is found, as of `Session.measure`.
    """

    decision: Decision
    changes: dict[str, object] = field(default_factory=dict)
    is_spectral: bool | None = None
    is_dispersive: bool = False
    late: tuple[Late, ...] = ()
    draws_evenly: bool = False
    samples_evenly: bool = False
    reflectance: float = 0.0
    method: str = "auto"


def accepts(bound: float, allowance: float, switch: Switch) -> bool:
    """Whether a simplification of a bound is made.

    Parameters
    ----------
    bound : float    Infinite where none is known. [-]
    allowance : float    What is left of the budget. [-]
    switch : Switch
    """
    if switch is Switch.OFF or not math.isfinite(bound):
        return False
    return switch is Switch.FORCE or bound <= allowance
