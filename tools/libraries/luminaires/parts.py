"""Lamps made of several emitters that share one distribution: where each lies, how large it is, and its part of the flux.

The emitters stand for the uneven luminance of the lamp, which shows close by, in reflectors and in shadows; from more than
about five times the lamp's size only the sum counts. All sizes are in metres.
"""

import numpy as np

SECOND_RADIATION_CONSTANT = 0.01438777
"""Of Planck's law. [m K]"""

EYE = 570e-9
"""Wavelength about which incandescent light is seen. [m]"""


def _shares(weights) -> list[float]:
    """Parts of the whole with six digits, whose sum is 1."""
    shares = [round(float(share), 6) for share in np.asarray(weights) / np.sum(weights)]
    largest = int(np.argmax(shares))
    shares[largest] = round(1.0 - sum(shares[:largest] + shares[largest + 1 :]), 6)
    return shares


def _part(position, share, opening=None, axis=None) -> dict:
    part = {"position_m": [round(float(value), 6) for value in position], "share": share}
    if axis is not None:
        part["axis"] = list(axis)
    if opening is not None:
        shape, sides, own = opening
        size = [round(float(side), 6) for side in sides]
        part["opening"] = {"shape": shape, "size_m": size, "axis": own}
    return part


def fluorescent_tube(length: float, diameter: float) -> list[dict]:
    """Seven cylinders of different luminance along x.

    Before each electrode lies a dark space and sputtered metal darkens the glass; further in, the luminance rises to that of
    the even positive column. A cylinder of luminance L without ends gives the flux pi L times its area, so the parts are as
    luminance times length.
    """
    outer = np.array([0.0, 0.015, 0.045, 0.12])
    borders = np.concatenate([outer, length - outer[::-1]]) - 0.5 * length
    luminance = np.array([0.25, 0.65, 0.92, 1.0, 0.92, 0.65, 0.25])
    lengths, middles = np.diff(borders), 0.5 * (borders[1:] + borders[:-1])
    return [
        _part((x, 0.0, 0.0), share, ("cylinder", (extent, diameter, diameter), "x"))
        for x, extent, share in zip(middles, lengths, _shares(luminance * lengths), strict=True)
    ]


def filament(temperature: float, length: float, count: int) -> list[dict]:
    """Upright coil as a chain of points.

    The leads cool the ends: T(s) = T0 (1 - 0.2 exp(-s / 0.6 mm)) at the distance s from the nearer end. By Wien's law the
    luminance is then in proportion to exp(-c2 / (lambda T)), lambda the wavelength about which the light is seen.
    """
    z = (np.arange(count) + 0.5) / count * length - 0.5 * length
    kelvin = temperature * (1.0 - 0.2 * np.exp((np.abs(z) - 0.5 * length) / 0.0006))
    weights = np.exp(-SECOND_RADIATION_CONSTANT / (EYE * kelvin))
    return [
        _part((0.0, 0.0, height), share) for height, share in zip(z, _shares(weights), strict=True)
    ]


def bent_tube(diameter: float, foot: float, leg: float, apart: float) -> list[dict]:
    """Two legs and their bridge: the feet are dark before the electrodes, the bridge is the cool end.

    That a leg hides part of the other is left out.
    """
    heights = (-0.5 * leg, 0.5 * foot)
    lengths = np.array([foot, leg, apart, leg, foot])
    shares = _shares(np.array([0.45, 1.0, 0.85, 1.0, 0.45]) * lengths)
    places = [
        ((-0.5 * apart, 0.0, heights[0]), (0.0, 0.0, 1.0)),
        ((-0.5 * apart, 0.0, heights[1]), (0.0, 0.0, 1.0)),
        ((0.0, 0.0, 0.5 * (foot + leg)), (1.0, 0.0, 0.0)),
        ((0.5 * apart, 0.0, heights[1]), (0.0, 0.0, 1.0)),
        ((0.5 * apart, 0.0, heights[0]), (0.0, 0.0, 1.0)),
    ]
    return [
        _part(position, share, ("cylinder", (diameter, diameter, extent), "z"), axis)
        for (position, axis), extent, share in zip(places, lengths, shares, strict=True)
    ]


def led_filaments(radius: float, length: float, diameter: float) -> list[dict]:
    """Four upright filaments with yellow phosphor all around, on a circle."""
    turns = 2.0 * np.pi * (np.arange(4) + 0.5) / 4.0
    return [
        _part(
            (radius * np.cos(turn), radius * np.sin(turn), 0.0),
            0.25,
            ("cylinder", (diameter, diameter, length), "z"),
        )
        for turn in turns
    ]


PARTS = {maker.__name__: maker for maker in (fluorescent_tube, filament, bent_tube, led_filaments)}
"""What makes the emitters of a lamp, by name."""
