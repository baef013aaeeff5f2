"""Spectra that the user chose in the property groups."""

import math
from functools import lru_cache

import bpy

from ...engine.errors import FileFormatError, LumenrayError, SceneError
from ...engine.photometry.spectra import efficacy, efficacy_of_all, luminous_weight
from ...engine.scene.spectrum import Blackbody, Daylight, Illuminant, Rgb, Spectrum, Tabulated
from ...imports import loaded_when_used
from ..foundation.report import ConversionReport

with loaded_when_used():
    from ...engine.formats import spd
    from ...engine.sky import sunlight

FIRST_COLUMN = 1
"""Column of values that is read where none can be chosen."""

DAYLIGHT_RANGE = (4000.0, 25000.0)
"""Correlated colour temperatures for which CIE 15 defines daylight. [K]"""


BEYOND = 0.01
"""Share of a lamp's power beyond the wavelengths that count that is told. [-]"""


def light_spectrum(rgb) -> Spectrum:
    """Return the spectrum of a light by its linear colour, whose amount does not count.

    Blender's white is D65; any other colour is scaled so that its largest component is 1.
    """
    red, green, blue = (max(float(value), 0.0) for value in rgb)
    largest = max(red, green, blue)
    if largest - min(red, green, blue) <= 1e-6 * largest:
        return Illuminant("D65")
    return Rgb(red / largest, green / largest, blue / largest)


def convert_spectrum(settings, rgb, report: ConversionReport, datablock: str) -> Spectrum:
    """Return the spectrum of something luminous.

    Parameters
    ----------
    settings : SpectrumSettings    A light's or a material's property group.
    rgb : (3,) sequence    Linear colour for ``RGB``.
    report : ConversionReport    Where departures go.
    datablock : str    Name of the light or material, for the report.

    Returns
    -------
    Spectrum    Relative; the amount of light is stated elsewhere.

    Raises
    ------
    LumenrayError    Its file cannot be read or holds no light: any other spectrum would be a guess.
    """
    if settings.spectrum == "ILLUMINANT":
        return Illuminant(settings.illuminant)
    if settings.spectrum == "BLACKBODY":
        return Blackbody(settings.colour_temperature)
    if settings.spectrum == "DAYLIGHT":
        return _daylight(settings.colour_temperature, report, datablock)
    if settings.spectrum == "SUNLIGHT":
        return _sunlight(math.degrees(settings.sun_elevation), settings.turbidity)
    if settings.spectrum == "FILE":
        made = _open_file(
            settings,
            "spectrum_file",
            lambda path: spd.read_spectrum(path, settings.spectrum_column or None),
            "spectrum file",
        )
        table = _tell_remarks(made, report.warn, datablock)
        if not table.values.max() > 0.0:
            raise FileFormatError(table.name, "the spectrum has no value above 0")
        return table
    return light_spectrum(rgb)


@lru_cache(maxsize=64)
def _sunlight(elevation: float, turbidity: float) -> Tabulated:
    return sunlight.sunlight_spectrum(elevation, turbidity)


def check_visible(table: Tabulated, is_radiant: bool, name: str, report: ConversionReport) -> None:
    """Refuse a lamp's table that holds no visible light, and tell of watts that do not count.

    Parameters
    ----------
    table : Tabulated
    is_radiant : bool    Whether the amount is stated in watts.
    name, report : str, ConversionReport    Whose it is, and where it is told.

    Raises
    ------
    SceneError
    """
    if luminous_weight(table) <= 0.0:
        raise SceneError(f"the spectrum {table.name} holds no visible light")
    beyond = 1.0 - efficacy_of_all(table) / efficacy(table)
    if is_radiant and beyond > BEYOND:
        report.warn(
            name,
            f"{beyond:.3g} of the power of its spectrum {table.name} lies beyond 360 to 830 nm",
            "the watts are those within",
        )


def _daylight(temperature, report, datablock):
    low, high = DAYLIGHT_RANGE
    held = min(max(temperature, low), high)
    if held != temperature:
        report.warn(
            datablock,
            f"CIE daylight is not defined at {temperature:.0f} K",
            f"{held:.0f} K is used",
        )
    return Daylight(held)


def _read_first_column(path) -> "spd.SpectrumFile":
    return spd.read_spectrum(path, FIRST_COLUMN)


def read_file(
    settings,
    name,
    report,
    datablock,
    remedy,
    read=_read_first_column,
    kind="spectrum file",
):
    """Read the spectrum, or what else it is, whose path is in a property; None, and a row of the report, if it fails.

    What is odd about a spectrum gets rows too, and that it has other columns a warning: another one is another material.

    Parameters
    ----------
    settings : bpy.types.PropertyGroup    Owner of the path.
    name : str    Name of the property.
    report, datablock : ConversionReport, str    Where failures go.
    remedy : str    What is used instead, for the report.
    read : callable    From the path to what is in the file.
    kind : str    What kind of file it is, for the report.
    """
    try:
        made = _open_file(settings, name, read, kind)
    except LumenrayError as error:
        report.miss(datablock, str(error), remedy)
        return None
    if isinstance(made, spd.SpectrumFile) and made.columns > 1:
        chosen = f" ('{made.names[0][:40]}')" if made.names else ""
        report.warn(
            datablock,
            f"{made.path.name} has {made.columns} {made.spectra}, of which the first one{chosen} is taken",
            "no other one can be chosen here; if another is meant, put it into a file of its own",
        )
    return _tell_remarks(made, report.info, datablock)


def _open_file(settings, name, read, kind):
    path = getattr(settings, name)
    if not path:
        raise LumenrayError(f"No {kind} is chosen")
    path = bpy.path.abspath(path, library=settings.id_data.library)
    try:
        made = read(path)
    except (LumenrayError, OSError, ValueError) as error:
        if path in str(error):
            raise LumenrayError(str(error)) from None
        raise FileFormatError(path, str(error)) from None
    return made


def _tell_remarks(made, note, datablock):
    """What a file holds; what is odd about a spectrum goes to ``note``."""
    if not isinstance(made, spd.SpectrumFile):
        return made
    for remark in made.remarks:
        note(datablock, f"{made.path.name}: {remark}", "it is read so")
    return made.table
