"""What panels say of a measured material: its file's figures, and its colour, as short text."""

import numpy as np

from ...engine.photometry.colour import XYZ_TO_REC709, chromaticity, cie_lab
from ...engine.reading.printable import printable
from ...engine.scattering.data.tristimulus import weights_of
from ...engine.scattering.summary import NEAR_NORMAL, SideSummary
from .files import Reading, scattering_files

REMEDY = "A plain grey is used until the file is mended and reloaded, or another one is chosen."
"""What is said below a problem with a file."""

SHORTER = ("sides of the plane of incidence differ", "uneven sides")
"""Words about symmetry, and those that panels have room for."""

NAMES = {
    "front_reflection": "Front reflection",
    "back_reflection": "Back reflection",
    "front_transmission": "Front transmission",
    "back_transmission": "Back transmission",
}
"""What a file may tell, for people."""


def describe_file(reading: Reading) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) of the figures of a file: what all sides have in common, then each side."""
    first = next(iter(reading.sides.values()))
    lines = [("Format", reading.file.format)]
    if reading.file.name:
        lines.append(("Name", " ".join(printable(reading.file.name).split())))
    lines += [
        ("Symmetry", _common(reading, lambda side: side.symmetry.replace(*SHORTER))),
        ("Incidence", _common(reading, lambda side: _angles(side.incidences))),
        ("Wavelengths", _common(reading, lambda side: _wavelengths(side.wavelengths))),
    ]
    error = max(side.error for side in reading.sides.values())
    lines.append(("Resampling error", _percent(error) if error else "none stated"))
    shown = []
    for name, side in reading.sides.items():
        if side not in shown:
            shown.append(side)
            lines += _describe_side(name, side, len(reading.sides) > 1 or side is not first)
    return tuple(lines)


def _describe_side(name: str, side: SideSummary, is_named: bool) -> list[tuple[str, str]]:
    what = "reflectance" if name.endswith("reflection") else "transmittance"
    label = f"{name.partition('_')[0]} {what}" if is_named else what
    near = f"{round(float(np.degrees(NEAR_NORMAL)))}°"
    lines = [
        (f"{label.capitalize()} {near}", _percent(side.tristimulus()[1])),
        ("    largest", f"{_percent(side.largest)} at {_degrees(side.steepest)}"),
    ]
    if side.reciprocity is not None:
        lines.append(("    reciprocity off by", _percent(side.reciprocity)))
    return lines


def describe_words(reading: Reading) -> tuple[str, ...]:
    """What the file tells in words."""
    words = (reading.file.description, reading.file.source)
    return tuple(" ".join(text.split()) for text in words if text.strip())


def describe_colour(reading: Reading, illuminant: str) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) of the colour of all light near the normal under an illuminant, against the perfect diffuser."""
    x, y, z = seen = _shown(reading).tristimulus(illuminant)
    if y <= 0.0:
        return (("Y", _percent(0.0)),)
    white = weights_of(np.array([560.0]), illuminant)[0]
    lightness, a, b = cie_lab(seen, white)
    return (
        ("Of", f"{NAMES[_shown_name(reading)].lower()}, {round(float(np.degrees(NEAR_NORMAL)))}°"),
        ("Y", _percent(y)),
        ("x, y", "{:.4f}, {:.4f}".format(*chromaticity([x, y, z]))),
        ("L*, a*, b*", f"{lightness:.1f}, {a + 0.0:.1f}, {b + 0.0:.1f}"),
    )


def swatch(settings) -> tuple[float, float, float]:
    """Linear colour of the file under its illuminant, as far as a screen shows it; black while it is not known."""
    reading = scattering_files.state_of(settings).reading
    if reading is None:
        return (0.0, 0.0, 0.0)
    seen = _shown(reading).tristimulus(settings.illuminant)
    # The eye takes the light for white: the screen's white in its place (von Kries, on X, Y, Z).
    white = weights_of(np.array([560.0]), settings.illuminant)[0]
    screen = weights_of(np.array([560.0]), "D65")[0]
    return tuple(float(v) for v in np.clip(XYZ_TO_REC709 @ (seen / white * screen), 0.0, 1.0))


def _shown_name(reading: Reading) -> str:
    """The side whose colour is told."""
    return next(name for name in NAMES if name in reading.sides)


def _shown(reading: Reading) -> SideSummary:
    return reading.sides[_shown_name(reading)]


def _common(reading: Reading, describe) -> str:
    """What is the same of all sides, or that it differs."""
    told = dict.fromkeys(describe(side) for side in reading.sides.values())
    return next(iter(told)) if len(told) == 1 else "differ by side"


def _angles(incidences) -> str:
    low, high = _degrees(incidences[0]), _degrees(incidences[-1])
    return low if len(incidences) == 1 else f"{low} to {high}, {len(incidences)} angles"


def _wavelengths(wavelengths) -> str:
    if len(wavelengths) == 1:
        return "the same at all"
    return f"{wavelengths[0]:.0f} to {wavelengths[-1]:.0f} nm, {len(wavelengths)} bands"


def _degrees(angle: float) -> str:
    return f"{float(np.degrees(angle)):.3g}°"


def _percent(share: float) -> str:
    return "below 0.01 %" if 0.0 < share < 1e-4 else f"{100.0 * float(share):.3g} %"
