"""What panels say of a luminaire: its file's figures, and the way to its flux, as short text.

Cheap enough for every redraw: the figures of a file are found once.
"""

import math
from functools import lru_cache

import numpy as np

from ...engine.errors import LumenrayError
from ...engine.luminaires.amount import Amount
from ...engine.luminaires.formats.record import RADIANT, LuminaireFile
from ...engine.luminaires.summary import Summary, summarise
from ...engine.reading.printable import printable
from ...engine.scene.distribution import Opening
from ..foundation.units import format_lengths
from ..readout import Description, format_amount, format_number
from .convert import find_amount, states_spectrum
from .files import Reading, photometric_files

SYMMETRIES = {
    "rotational": "rotational",
    "quadrant": "both planes",
    "C0-C180": "C0-C180",
    "C90-C270": "C90-C270",
    "none": "none",
}
"""Names of the symmetries."""

REMEDY = "The light is left out until the file is mended and reloaded, or another one is chosen."
"""What is said below a problem with a file."""


def reading_used(settings) -> Reading | None:
    """Return the file that something shines by, None if it does not or the file cannot be used."""
    return photometric_files.state_of(settings).reading if settings.use_file else None


@lru_cache(maxsize=128)
def summary_of(reading: Reading) -> Summary:
    """Return the figures of a file, found once for every content."""
    return summarise(reading.file)


def describe_output(settings, reading, source) -> Description:
    """Say how the flux of a luminaire comes about, every factor with its effect.

    Parameters
    ----------
    settings : LuminaireSettings
    reading : Reading
    source : bpy.types.Object or None    Whose tilt counts; none hangs upright.
    """
    matrix = np.eye(4) if source is None else source.matrix_world
    try:
        amount = find_amount(settings, reading, matrix)
    except LumenrayError as error:
        return Description(problem=str(error))
    if reading.file.quantity == RADIANT and settings.amount != "LUMENS":
        return _describe_watts(settings, reading, source, amount)
    return Description(describe_amount(amount))


def _describe_watts(settings, reading, source, amount: Amount) -> Description:
    """Say how much a radiant luminaire shines, and whether anything of it is visible."""
    factor = math.prod(step.factor for step in amount.steps())
    lines = (("Radiant flux", format_amount(reading.flux * factor, "W")),)
    if settings.spectrum_source == "FILE":
        return Description(lines, reading.lamp_spectrum.reason)
    if states_spectrum(source, settings):
        return Description(lines, "how much of it is visible, its spectrum tells when rendering")
    return Description(lines, "its colour is no spectrum: it lights nothing visible")


def describe_file(reading: Reading) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) of all figures of a file."""
    file, summary = reading.file, summary_of(reading)
    return (
        ("Format", file.format),
        ("Symmetry", f"type {file.photometric_type}, {SYMMETRIES[file.symmetry]}"),
        *describe_flux(file, summary),
        *describe_shape(file, summary),
        *describe_opening(file.opening),
    )


def describe_briefly(reading: Reading) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) of the figures that tell files apart."""
    summary, units = summary_of(reading), reading.file.units
    return (
        ("Flux of the file", format_amount(summary.total_flux, units.flux)),
        ("Peak", format_amount(summary.peak, units.intensity)),
        ("Beam (50 %)", _angles(summary.beam_angles)),
    )


def describe_flux(file: LuminaireFile, summary: Summary) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) about the amount of light: what the file sums up to beside what it states."""
    unit = file.units.flux
    lines = [(f"{file.quantity.capitalize()} flux", format_amount(summary.total_flux, unit))]
    if file.quantity == RADIANT and file.spectrum is None:
        lines.append(("Visible light", "none without a spectrum"))
    if file.is_absolute:
        lines.append(("Photometry", "absolute"))
    if file.stated_flux:
        lines.append(("Lamps", format_amount(file.stated_flux, unit)))
    if summary.light_output_ratio is not None:
        ratio = _percent(summary.light_output_ratio)
        # A stated ratio that the intensities do not sum up to is worth seeing.
        if file.light_output_ratio and _differ(file.light_output_ratio, summary.light_output_ratio):
            ratio += f" (stated {_percent(file.light_output_ratio)})"
        lines.append(("Output ratio", ratio))
    if file.watts:
        lines.append(("Power", format_amount(file.watts, "W")))
    if summary.efficacy is not None:
        lines.append(("Efficacy", format_amount(summary.efficacy, f"{unit}/W")))
    return tuple(lines)


def describe_shape(file: LuminaireFile, summary: Summary) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) about where the light goes."""
    return (
        ("Peak", format_amount(summary.peak, file.units.intensity)),
        ("Direction", _direction(file, summary)),
        ("Beam (50 %)", _angles(summary.beam_angles)),
        ("Field (10 %)", _angles(summary.field_angles)),
        ("CIE flux code", describe_flux_code(summary)),
    )


def describe_words(file: LuminaireFile) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) of what the file tells in words, empty entries left out."""
    return tuple(
        (
            printable(key).strip("_").replace("_", " ").capitalize(),
            " ".join(printable(text).split()),
        )
        for key, text in file.metadata.items()
        if text.strip()
    )


def describe_flux_code(summary: Summary) -> str:
    """Return the five numbers of the CIE flux code, in percent."""
    return " ".join(f"{100.0 * share:.0f}" for share in summary.flux_codes)


def describe_opening(opening: Opening) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) about shape and size of a luminous opening, lengths that are 0 left out."""
    if opening.shape == "point":
        return (("Opening", "point"),)
    size, name = [length for length in opening.size if length > 0.0], opening.shape
    if opening.shape in {"ellipse", "ellipsoid"} and np.ptp(size) < 1e-6:
        name, size = {"ellipse": "disk", "ellipsoid": "sphere"}[opening.shape], size[:1]
    return (("Opening", name), ("Size", format_lengths(size, 10.0)))


def describe_amount(amount: Amount) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) from what the flux starts with to what the luminaire gives, each factor with its effect."""
    first, *factors = amount.steps()
    lines = [(first.label, format_amount(first.luminous_flux, "lm"))]
    lines += [
        (f"{step.label} × {format_number(step.factor)}", format_amount(step.luminous_flux, "lm"))
        for step in factors
        if step.factor != 1.0
    ]
    return (*lines, ("Gives", format_amount(amount.luminous_flux, "lm")))


def _percent(share: float) -> str:
    return f"{100.0 * share:.1f} %"


def _differ(one: float, other: float) -> bool:
    return abs(one - other) > 0.01 * max(one, other)


def _degrees(angle: float | None) -> str:
    return "–" if angle is None else f"{angle:.3g}°"


def _angles(angles) -> str:
    """One angle where both planes have the same, else both."""
    across, along = (_degrees(angle) for angle in angles)
    return across if across == along else f"{across} × {along}"


def _direction(file, summary) -> str:
    if summary.peak_angles is not None:
        return "H {} V {}".format(*(_degrees(angle) for angle in summary.peak_angles))
    azimuth, gamma = summary.peak_direction
    is_around = file.symmetry == "rotational" or math.isclose(gamma % 180.0, 0.0, abs_tol=1e-6)
    return f"γ {_degrees(gamma)}" if is_around else f"C {_degrees(azimuth)}, γ {_degrees(gamma)}"
