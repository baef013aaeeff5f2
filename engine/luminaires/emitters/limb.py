"""Suns that are darker towards their edge."""

from dataclasses import dataclass

import drjit as dr
import mitsuba as mi


@dataclass(frozen=True)
class Limb:
    """How much darker the edge of a disk is than its middle.

    Parameters
    ----------
    amount : Float    Part of the middle's radiance that the edge lacks. [-]
    middle : Float    Radiance of the middle over that of an even disk with the same illuminance. [-]
    """

    amount: object
    middle: object

    @staticmethod
    def of(amount: float, cap: float) -> "Limb | None":
        """Return the limb of a disk, None of an even one. ``cap``: 1 - cos of its angular radius."""
        if amount <= 0.0:
            return None
        # Integrals over the disk with the cosine, of an even one and of the profile, per pi and squared chord.
        even = 1.0 - 0.5 * cap
        given = (1.0 - amount) * even + amount * (2.0 / 3.0 - 4.0 / 15.0 * cap)
        made = Limb(mi.Float(amount), mi.Float(even / given))
        dr.make_opaque(made.amount, made.middle)
        return made


def darken(radiance, limb: Limb | None, direction, towards, cap):
    """Return the radiance of a disk in a direction.

    Parameters
    ----------
    radiance : Spectrum    Of an even disk with the same illuminance.
    limb : Limb or None    None: it is even.
    direction, towards : Vector3f    Unit vectors, the latter to the disk's middle.
    cap : Float    1 - cos of the angular radius.
    """
    if limb is None:
        return radiance
    place = 0.5 * dr.squared_norm(direction - towards) / cap
    profile = 1.0 - limb.amount * (1.0 - dr.safe_sqrt(1.0 - place))
    return radiance * (limb.middle * profile)
