"""What the settings amount to in other units, as short text for panels. Cheap enough for every redraw."""

import re
import textwrap
from dataclasses import dataclass
from functools import lru_cache

from ..engine.reading.printable import printable
from ..engine.requirements.budget import tell_parts
from ..imports import loaded_when_used
from .bake.tables import UNKNOWN
from .foundation.exposure import white_luminance
from .foundation.report import ConversionReport
from .sync.meshes import MESH_TYPES

with loaded_when_used():
    import numpy as np

    from ..engine.accuracy import stopping
    from ..engine.photometry import spectra
    from ..engine.scene import light as scene_light
    from ..engine.scene import spectrum as scene_spectrum
    from .sync import spectra as sync_spectra
    from .sync.lights import kinds, shaped
    from .sync.nodes import fields

UNITS = {
    "LUMINOUS_FLUX": "lm",
    "LUMINOUS_INTENSITY": "cd",
    "ILLUMINANCE": "lx",
    "LUMINANCE": "cd/m²",
    "RADIANT_FLUX": "W",
}
"""Unit of every quantity of a light; watts of a sun are per square metre."""

NAMES = {
    "LUMINOUS_FLUX": "Luminous Flux",
    "LUMINOUS_INTENSITY": "Intensity",
    "ILLUMINANCE": "Illuminance",
    "LUMINANCE": "Luminance",
}
"""What the amount of a light is called in each quantity."""

SMALL_WORDS = frozenset(
    re.findall(r"\w+", "a an and as at by from in is of on or per the to with cd lm lx mm nm px")
)
"""Words that stay small in a title, and units."""

NEEDS_THE_ENGINE = "the amount in lumens depends on the spectrum and is known when rendering"


@dataclass(frozen=True)
class Description:
    """Lines (label, value) for a panel, and a ``problem`` in one sentence, empty if there is none."""

    lines: tuple[tuple[str, str], ...] = ()
    problem: str = ""


def title_case(label: str) -> str:
    """Return a label as Blender writes those of its own panels; symbols and units stay as they are."""
    words = label.split(" ")
    return " ".join(
        word.capitalize()
        if word.isalpha() and word.islower() and len(word) > 1 and word not in SMALL_WORDS
        else word
        for word in words
    )


def format_number(value: float) -> str:
    """Return at least three significant digits, thousands set apart.

    Powers of ten appear only in very large and very small numbers.
    """
    if value == 0.0:
        return "0"
    size = abs(value)
    if size < 1e-3 or size >= 1e7:
        return f"{value:.2e}"
    digits = max(0, 2 - int(np.floor(np.log10(float(f"{size:.2e}")))))
    text = f"{value:,.{digits}f}" if size >= 1000.0 else f"{value:.{digits}f}"
    # A thin space does not look like a decimal sign in any country.
    return text.replace(",", "\u2009")


def format_estimate(value: float, error: float) -> str:
    """Return a number with its standard error, both to the second significant digit of the error."""
    if not 0.0 < error < UNKNOWN:
        return format_number(value)
    digits = max(0, 1 - int(np.floor(np.log10(error))))
    return f"{value:,.{digits}f} ± {error:,.{digits}f}".replace(",", "\u2009")


def format_amount(value: float, unit: str) -> str:
    """Return a number with its unit."""
    return f"{format_number(value)} {unit}"


def value_unit(light, quantity: str = "") -> str:
    """Return the unit of a quantity, the stated one if none is named."""
    return _name_and_unit(light, quantity or light.lumenray.quantity)[1]


def value_name(light) -> str:
    """Return what a physical light's value is called."""
    return _name_and_unit(light, light.lumenray.quantity)[0]


def _name_and_unit(light, quantity: str) -> tuple[str, str]:
    if quantity == "RADIANT_FLUX":
        return kinds.kind_of(light).radiant
    return NAMES[quantity], UNITS[quantity]


def quantities_of(light) -> tuple[str, ...]:
    """Return the quantities in which a light can be stated."""
    return kinds.kind_of(light).quantities_of(light)


def describe_light(light, settings, lengths=(1.0, 1.0, 1.0), metres: float = 1.0) -> Description:
    """Say what a light emits in other units.

    Parameters
    ----------
    light : bpy.types.Light
    settings : LumenraySceneSettings    For the meaning of Blender's watts.
    lengths : (3,) sequence    Scale of the light's object along its axes. [-]
    metres : float    Length of a Blender unit. [m]
    """
    kind, place = kinds.kind_of(light), kinds.Place("", "", np.diag([*lengths, 1.0]), metres)
    output, problem = _stated_output(light, kind, place, settings)
    if output is None:
        return Description(problem=problem)
    reading = kind.read(kind.make(light, place, output))
    if reading is None:
        return Description(problem="the light has no size, so that it has no luminance")
    if light.type == "SPOT" and kinds.is_scaled_unevenly(place.lengths):
        reading = shaped.read_ellipse(reading, output.quantity, light, place.lengths)
    named = (
        ("Luminous flux", reading.flux, "lm"),
        ("Axial intensity", reading.intensity, "cd"),
        (kind.place_of_illuminance, reading.illuminance, "lx"),
        ("Luminance", reading.luminance, "cd/m²"),
    )
    lines = [
        (name, format_amount(amount, unit)) for name, amount, unit in named if amount is not None
    ]
    return Description(tuple(lines), problem)


def describe_lamp(source, scene) -> Description:
    """`describe_light` for a light object in its scene."""
    unit = scene.unit_settings
    metres = unit.scale_length if unit.system != "NONE" else 1.0
    return describe_light(source.data, scene.lumenray, source.matrix_world.to_scale(), metres)


def describe_exposure(settings) -> str:
    """Say which luminance becomes 1.0 in the picture."""
    white = white_luminance(settings)
    if white is None:
        return "White is found from each picture: brightness cannot be compared"
    return f"{format_amount(white, 'cd/m²')} becomes 1.0"


def is_bakeable(source) -> bool:
    """Whether an object, or None, has a surface that can be baked."""
    return source is not None and source.type in MESH_TYPES


def describe_selection(context) -> tuple[int, str]:
    """Count the selected objects that can be baked, and say it."""
    count = sum(is_bakeable(source) for source in context.selected_objects)
    if count == 0:
        return 0, "Select the objects to bake"
    return count, "1 object selected" if count == 1 else f"{count} objects selected"


def format_error(error: float) -> str:
    """Return a relative standard error in per cent; one of too few samples is not known."""
    return f"{100.0 * error:.2g} %" if error < UNKNOWN else "not known"


def format_bound(bound: float) -> str:
    """Return the largest relative error by what is left out."""
    return f"at most {100.0 * bound:.2g} %" if bound else "none, exact"


def describe_job(job) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) about the bake that runs."""
    return (
        ("Now", job.stage or "starting"),
        ("Samples", f"{job.samples}" if job.samples else "–"),
        ("Error", f"{100.0 * job.error:.2f} %" if job.error > 0.0 else "–"),
        ("Time left", job.left or "not known yet"),
    )


def describe_result(row) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) about one lux map."""
    lines = [
        ("Mean", f"{format_estimate(row.mean, row.mean_error)} {row.unit}"),
        ("Smallest", format_amount(row.minimum, row.unit)),
        ("95 % range", _range(row.minimum_low, row.minimum_high, row.unit)),
        ("Largest", format_amount(row.maximum, row.unit)),
        ("95 % range", _range(row.maximum_low, row.maximum_high, row.unit)),
        ("Uniformity", f"{row.uniformity:.2f}" if row.mean > 0.0 else "–"),
        ("95 % range", _range(row.uniformity_low, row.uniformity_high, "")),
        ("Error per lumel", format_error(row.relative_error)),
        ("Samples", f"{row.samples}"),
        ("Lumels", f"{row.lumels:,}".replace(",", "\u2009")),
        ("Lumels per m", f"{row.density:.3g}"),
    ]
    if 0.0 < row.bias_error < UNKNOWN:
        lines.append(("Bias", f"{format_estimate(row.bias, row.bias_error)} {row.unit}"))
    if row.invalid:
        lines.append(("Inside solids", f"{row.invalid} lumels, filled"))
    if row.is_smoothed:
        lines.append(("Smoothed", "after the error was known"))
    return tuple(lines)


def _range(low: float, high: float, unit: str) -> str:
    """Range that holds a true extreme in 95 % of cases at least; without a unit it is a ratio."""
    if high >= UNKNOWN:
        return "not known"
    if not unit:
        return f"{low:.2f} to {high:.2f}"
    return f"{format_number(low)} to {format_amount(high, unit)}"


def describe_bake(baked) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) about the last bake of a scene as a whole."""
    lines = [
        ("Mean of all", format_amount(baked.mean, "lx")),
        ("Error of all", format_error(baked.relative_error)),
        ("Pages", f"{baked.pages}"),
        ("Time", stopping.format_seconds(baked.seconds)),
    ]
    parts = tell_parts(_unbounded(baked.relative_error), baked.simplified)
    lines += [("Made of", parts)] if parts else []
    if baked.shrink < 0.999:
        lines.append(("Density lowered", f"to {100.0 * baked.shrink:.0f} %"))
    if baked.seam_pairs:
        noise = format_amount(baked.seam_noise, "lx")
        lines.append(("Steps at seams", f"{format_amount(baked.seam_after, 'lx')} (noise {noise})"))
    return tuple(lines)


def _unbounded(error: float) -> float:
    """An error that is kept in a file, infinite where it is not known."""
    return error if error < UNKNOWN else np.inf


def describe_edit(status) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) about the last edit that a view (`viewport.Status`) showed and the state of its picture."""
    error = f"{100.0 * status.error:.2g} %" if status.error < 1e6 else "–"
    return (
        ("Last edit", status.changed or "nothing"),
        ("Samples", str(status.samples) if status.samples else "coarse"),
        ("Picture error", error),
    )


def describe_timing(status) -> tuple[tuple[str, str], ...]:
    """Lines (label, value) about what an edit cost, for those who work on the engine."""
    total = status.walk + status.transfer + status.commit + status.first_sample
    return (
        ("Sent", f"{status.sent} item{'' if status.sent == 1 else 's'}"),
        ("Engine", status.action or "–"),
        ("Scene walk", _milliseconds(status.walk)),
        ("Transfer", _milliseconds(status.transfer)),
        ("Commit", _milliseconds(status.commit)),
        ("First sample", _milliseconds(status.first_sample)),
        ("Together", _milliseconds(total)),
    )


def _milliseconds(seconds: float) -> str:
    return f"{1e3 * seconds:.1f} ms" if seconds < 1.0 else f"{seconds:.2f} s"


def describe_counts(severities) -> str:
    """Say how many rows of each severity a report holds, by the severities' names."""
    counts = {"ERROR": 0, "WARNING": 0, "INFO": 0}
    for severity in severities:
        counts[severity] += 1
    names = {"ERROR": "error", "WARNING": "warning", "INFO": "note"}
    parts = [
        f"{count} {names[key]}{'' if count == 1 else 's'}" for key, count in counts.items() if count
    ]
    return ", ".join(parts)


def wrap(text: str, width: float, scale: float = 1.0) -> list[str]:
    """Break text into lines for a region. ``width`` [pixel]; ``scale``: the interface's own scale."""
    characters = int((width / max(scale, 0.1) - 40.0) / 6.6)
    return textwrap.wrap(printable(text), max(characters, 16)) or [""]


def _stated_output(
    light, kind: "kinds.Kind", place: "kinds.Place", settings
) -> "tuple[scene_light.Output | None, str]":
    """Return what a light gives in a photometric quantity, or None, and a problem."""
    own = light.lumenray
    if not own.use_physical:
        return _blender_output(light, kind, place, settings.efficacy)
    if own.quantity not in kind.quantities:
        allowed = ", ".join(UNITS[name] for name in kind.quantities)
        called = light.type.lower()
        return None, f"this quantity is not defined for a {called} light; choose one of {allowed}"
    if own.quantity != "RADIANT_FLUX":
        return scene_light.Output(scene_light.Quantity[own.quantity], own.value), ""
    if own.spectrum == "FILE":
        return None, NEEDS_THE_ENGINE
    spectrum = sync_spectra.convert_spectrum(own, _colour(light), ConversionReport(), light.name)
    if isinstance(spectrum, scene_spectrum.Rgb):
        return None, NEEDS_THE_ENGINE
    return scene_light.Output(kind.whole, own.value * _efficacy(spectrum)), ""


def _blender_output(
    light, kind: "kinds.Kind", place: "kinds.Place", efficacy: float
) -> "tuple[scene_light.Output | None, str]":
    """Return what Blender's own watts mean, and what of the light is left out of it."""
    amount = light.energy * 2.0 ** getattr(light, "exposure", 0.0) * efficacy
    amount *= float(fields.luminance(_colour(light))[0])
    problem = "the light's own nodes come on top" if getattr(light, "use_nodes", False) else ""
    if kinds.is_spread_out(light):
        return None, "not normalised by its size: the amount is known when rendering"
    return scene_light.Output(*kind.amount(light, place, amount)), problem


def _colour(light) -> "np.ndarray":
    colour = np.array(light.color, dtype=np.float64)
    if getattr(light, "use_temperature", False):
        colour = colour * np.array(light.temperature_color)
    return colour


@lru_cache(maxsize=64)
def _efficacy(spectrum) -> float:
    return spectra.efficacy(spectrum)
