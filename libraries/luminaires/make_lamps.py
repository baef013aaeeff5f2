"""Lamps made of several emitters that share one distribution: where each lies, how large it is, and its part of the flux.

The emitters stand for the uneven luminance of the lamp, which shows close by, in reflectors and in shadows; from more than
about five times the lamp's size only the sum counts.
"""

import numpy as np

from . import make_distributions as shapes
from .make_files import Photometry, write_ies

SECOND_RADIATION_CONSTANT = 0.01438777
"""Of Planck's law. [m K]"""

EYE = 570e-9
"""Wavelength about which incandescent light is seen. [m]"""


class Lamp:
    """A lamp of the library: its shared distribution as a file, and its emitters."""

    def __init__(self, name, category, title, description, spectrum, photometry, parts, **more):
        self.name = name
        self.photometry = Photometry(kind="C", **photometry)
        self.entry = {
            "file": f"photometry/{name}.ies",
            "title": title,
            "description": description,
            "category": category,
            "spectrum": spectrum,
            "luminous_flux_lm": self.photometry.flux,
            "watts": self.photometry.watts,
            **more,
            "parts": parts,
        }

    def content(self) -> bytes:
        """Return the bytes of the photometric file."""
        return write_ies(self.photometry, self.name, self.entry["title"])


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


def _fluorescent_tube() -> Lamp:
    """T8 of 36 W: seven cylinders of different luminance.

    Before each electrode lies a dark space and sputtered metal darkens the glass; further in, the luminance rises to that of
    the even positive column. A cylinder of luminance L without ends gives the flux pi L times its area, so the parts are as
    luminance times length.
    """
    length, diameter = 1.16, 0.026
    outer = np.array([0.0, 0.015, 0.045, 0.12])
    borders = np.concatenate([outer, length - outer[::-1]]) - 0.5 * length
    luminance = np.array([0.25, 0.65, 0.92, 1.0, 0.92, 0.65, 0.25])
    lengths, middles = np.diff(borders), 0.5 * (borders[1:] + borders[:-1])
    parts = [
        _part((x, 0.0, 0.0), share, ("cylinder", (extent, diameter, diameter), "x"))
        for x, extent, share in zip(middles, lengths, _shares(luminance * lengths), strict=True)
    ]
    return Lamp(
        "tube_t8_36w",
        "Lamps/Fluorescent",
        "Fluorescent tube T8 36 W",
        "Bare tube in seven zones of luminance with dark ends; intensity as the sine of the angle to its axis (local x).",
        {"illuminant": "FL11"},
        {
            "formula": shapes.tube(0),
            "symmetry": "quadrant",
            "horizontal": np.arange(0.0, 361.0, 5.0),
            "vertical": np.arange(0.0, 181.0, 2.5),
            "flux": 3350.0,
            "watts": 36.0,
            "opening": ("cylinder", (length, diameter, diameter)),
            "lamp": "T8 36 W/840",
            "lamp_flux": 3350.0,
            "colour": "4000 K",
        },
        parts,
        mount="pendant",
        tags=["lamp", "fluorescent", "T8", "tube"],
    )


def _halogen_filament() -> Lamp:
    """Capsule of 12 V 50 W with its coil upright: a chain of points along it.

    The leads cool the ends: T(s) = T0 (1 - 0.2 exp(-s / 0.6 mm)) at the distance s from the nearer end. By Wien's law the
    luminance is then in proportion to exp(-c2 / (lambda T)), lambda the wavelength about which the light is seen. The coil,
    4.0 x 1.2 mm, shines as the area that it shows; the base hides it from below.
    """
    temperature, length, diameter, count = 3000.0, 0.004, 0.0012, 13
    z = (np.arange(count) + 0.5) / count * length - 0.5 * length
    kelvin = temperature * (1.0 - 0.2 * np.exp((np.abs(z) - 0.5 * length) / 0.0006))
    weights = np.exp(-SECOND_RADIATION_CONSTANT / (EYE * kelvin))
    parts = [
        _part((0.0, 0.0, height), share) for height, share in zip(z, _shares(weights), strict=True)
    ]

    def coil(d):
        side = length * diameter * np.hypot(d[..., 0], d[..., 1])
        return side + 0.25 * np.pi * diameter**2 * np.abs(d[..., 2])

    return Lamp(
        "halogen_50w",
        "Lamps/Halogen",
        "Halogen capsule 12 V 50 W",
        "Upright filament as a chain of 13 points, dimmer at its cooled ends; for reflectors and sharp shadows.",
        {"blackbody_K": temperature},
        {
            "formula": shapes.capped(coil, 12.0, 38.0),
            "symmetry": "rotational",
            "horizontal": np.zeros(1),
            "vertical": np.arange(0.0, 181.0, 2.5),
            "flux": 910.0,
            "watts": 50.0,
            "opening": ("cylinder", (diameter, diameter, length)),
            "lamp": "QT 12 50 W",
            "lamp_flux": 910.0,
            "colour": "3000 K",
        },
        parts,
        mount="table",
        height_m=0.3,
        tags=["lamp", "halogen", "filament", "capsule"],
    )


def _compact_fluorescent() -> Lamp:
    """Two legs and their bridge, of 9 W: the feet are dark before the electrodes, the bridge is the cool end.

    That a leg hides part of the other is left out.
    """
    diameter, foot, leg, apart = 0.012, 0.012, 0.088, 0.016
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
    parts = [
        _part(position, share, ("cylinder", (diameter, diameter, extent), "z"), axis)
        for (position, axis), extent, share in zip(places, lengths, shares, strict=True)
    ]
    return Lamp(
        "compact_fluorescent_9w",
        "Lamps/Compact fluorescent",
        "Compact fluorescent lamp 9 W",
        "Two legs with dark feet and a bridge, upright; each part has the distribution of a bare tube.",
        {"illuminant": "FL11"},
        {
            "formula": shapes.tube(2),
            "symmetry": "rotational",
            "horizontal": np.zeros(1),
            "vertical": np.arange(0.0, 181.0, 2.5),
            "flux": 600.0,
            "watts": 9.0,
            "opening": ("cylinder", (apart + diameter, apart + diameter, foot + leg)),
            "lamp": "TC-S 9 W/840",
            "lamp_flux": 600.0,
            "colour": "4000 K",
        },
        parts,
        mount="table",
        height_m=0.3,
        tags=["lamp", "compact fluorescent"],
    )


def _led_filaments() -> Lamp:
    """Candle-shaped lamp of 2.5 W with four upright LED filaments, each 30 mm long with yellow phosphor all around."""
    diameter, length, radius = 0.0018, 0.030, 0.006
    turns = 2.0 * np.pi * (np.arange(4) + 0.5) / 4.0
    parts = [
        _part(
            (radius * np.cos(turn), radius * np.sin(turn), 0.0),
            0.25,
            ("cylinder", (diameter, diameter, length), "z"),
        )
        for turn in turns
    ]
    return Lamp(
        "led_filament_candle",
        "Lamps/LED",
        "LED filament lamp, candle 2.5 W",
        "Four upright filaments in clear glass; intensity as the sine of the angle to their axis, less what the base hides.",
        {"illuminant": "LED-B1"},
        {
            "formula": shapes.capped(shapes.tube(2), 12.0, 35.0),
            "symmetry": "rotational",
            "horizontal": np.zeros(1),
            "vertical": np.arange(0.0, 181.0, 2.5),
            "flux": 250.0,
            "watts": 2.5,
            "opening": ("cylinder", (2.0 * radius, 2.0 * radius, length)),
            "lamp": "LED E14 2.5 W",
            "colour": "2733 K",
        },
        parts,
        mount="table",
        height_m=0.3,
        tags=["lamp", "LED", "filament", "candle"],
    )


LAMPS = (
    _fluorescent_tube(),
    _halogen_filament(),
    _compact_fluorescent(),
    _led_filaments(),
)
