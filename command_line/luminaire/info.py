"""The command ``lumenray luminaire info``: what photometric files say, and what is odd about them."""

import math
import re

from ...engine.luminaires.formats.record import LUMINOUS, UNITS
from ..file_list import add_files, tell_each
from ..output import percent, remarks, sheet

ENDINGS = (".ies", ".ldt", ".xml")
"""Ends of the names that are taken from a folder."""


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    info = tasks.add_parser("info", help="what photometric files say, and what is odd about them")
    add_files(info, "IES, EULUMDAT or TM-33 file", "*.ldt")
    info.set_defaults(run=run)


def run(options) -> int:
    """Tell about files; return the exit code."""
    from ...engine.luminaires.formats.reader import read_luminaire

    return tell_each(options, ENDINGS, lambda name: describe(read_luminaire(name)), tell)


def describe(file) -> dict:
    """Row of a photometric file for JSON.

    Parameters
    ----------
    file : LuminaireFile

    Returns
    -------
    dict    Numbers with their unit in the key; None where the file does not say enough. Shares of the flux code
        are in percent, as it is written.
    """
    from ...engine.luminaires.lamp_spectrum import choose_spectrum
    from ...engine.luminaires.summary import summarise

    summary = summarise(file)
    row = {
        "format": file.format,
        "photometric_type": file.photometric_type,
        "symmetry": file.symmetry,
        "is_absolute": file.is_absolute,
        "quantity": file.quantity,
        **_light_row(file, summary),
        "opening_shape": file.opening.shape,
        "opening_axis": file.opening.axis,
        "opening_m": file.opening.size,
        "stored_planes": len(file.stored_azimuths),
        "stored_angles": len(file.stored_polars),
        "tilt_factors": file.tilt and _by_angle("", file.tilt.angles, file.tilt.factors),
        "lamps": [
            {
                "count": lamp.count,
                "name": lamp.name,
                "luminous_flux_lm": lamp.luminous_flux,
                "watts": lamp.watts,
                "colour": lamp.colour,
                "colour_temperature_k": lamp.colour_temperature,
                "colour_rendering": lamp.colour_rendering,
            }
            for lamp in file.lamps
        ],
        "spectrum": choose_spectrum(file).reason,
        "metadata": dict(file.metadata),
        "warnings": [str(remark) for remark in file.remarks],
    }
    if file.quantity != LUMINOUS:
        # Radiant files have no lumens but by their spectrum; who looks for them is told so.
        row["luminous_flux_lm"] = visible_flux(file, summary.total_flux)
    return row


def _light_row(file, summary) -> dict:
    """Amounts and angles of the light."""
    from ...engine.luminaires.summary import GLARE_ANGLES, PLANES, ZONES

    units, flux = file.units, file.units.flux.lower()
    luminance = summary.luminance
    if luminance is not None:
        rows = [_by_angle("", GLARE_ANGLES, row) for row in luminance]
        luminance = _by_angle("C", PLANES, rows)
    edges = [round(math.degrees(edge)) for edge in ZONES]
    zones = [f"{low}-{high}" for low, high in zip(edges, edges[1:], strict=False)]
    return {
        f"{file.quantity}_flux_{flux}": summary.total_flux,
        f"stated_flux_{flux}": file.stated_flux,
        f"downward_flux_{flux}": summary.downward_flux,
        f"upward_flux_{flux}": summary.upward_flux,
        "downward_fraction": summary.downward_fraction,
        "stated_downward_fraction": file.downward_fraction,
        "light_output_ratio": summary.light_output_ratio,
        "stated_light_output_ratio": file.light_output_ratio,
        "watts": file.watts,
        f"efficacy_{flux}_per_w": summary.efficacy,
        f"peak_{_key(units.intensity)}": summary.peak,
        "peak_direction_deg": summary.peak_direction,
        "peak_hv_deg": summary.peak_angles,
        "beam_angle_deg": summary.beam_angles,
        "field_angle_deg": summary.field_angles,
        "cie_flux_codes": 100.0 * summary.flux_codes,
        f"zonal_flux_{flux}": dict(zip(zones, summary.zonal_flux, strict=False)),
        f"{_mean_name(file.quantity)}_{_key(units.luminance)}": luminance,
    }


def _by_angle(sign: str, angles, values) -> dict:
    return {f"{sign}{angle:g}": value for angle, value in zip(angles, values, strict=True)}


def visible_flux(file, watts: float) -> float:
    """Lumens of a radiant file: by its spectrum, and none without one."""
    from ...engine.photometry.spectra import efficacy_of_table

    return 0.0 if file.spectrum is None else watts * efficacy_of_table(*file.spectrum)


def _mean_name(quantity: str) -> str:
    return "luminance" if quantity == LUMINOUS else "radiance"


def _key(unit: str) -> str:
    """A unit in the key of a JSON object."""
    return re.sub(r"[()]", "", unit).replace("/", "_per_").replace(" ", "_").lower()


def tell(row: dict) -> str:
    """Text for people about a row of `describe`."""
    return sheet(row["file"], [*_light_lines(row), *_file_lines(row), *remarks(row)])


def _light_lines(row):
    """Labels and lines about the light."""
    units, is_luminous = UNITS[row["quantity"]], row["quantity"] == LUMINOUS
    unit, key = units.flux, units.flux.lower()
    planes = row["stored_planes"]
    yield "format", f"{row['format']}, type {row['photometric_type']}, symmetry {row['symmetry']}"
    yield "stored", f"{planes} plane{'s' if planes > 1 else ''} of {row['stored_angles']} angles"
    yield f"{row['quantity']} flux", _flux_words(row)
    if not is_luminous:
        yield "visible light", _visible_words(row)
    share = row["downward_fraction"]
    if share is not None:
        down, up = (_figure(row[f"{way}ward_flux_{key}"]) for way in ("down", "up"))
        stated = _stated(row["stated_downward_fraction"])
        yield "down, up", f"{down} {unit}, {up} {unit}; downward {percent(share, '.1f')}{stated}"
    efficacy = row[f"efficacy_{key}_per_w"]
    if efficacy is not None:
        as_light, as_radiation = (
            f"{efficacy:.1f} lm/W",
            f"{percent(efficacy, '.2g')} of it as radiation",
        )
        yield "power", f"{row['watts']:g} W, {as_light if is_luminous else as_radiation}"
    c, gamma = row["peak_direction_deg"]
    peak = f"{_figure(row[f'peak_{_key(units.intensity)}'])} {units.intensity} at C {c:g}, gamma {gamma:g} deg"
    if row["peak_hv_deg"] is not None:
        peak += " (H {:g}, V {:g} deg)".format(*row["peak_hv_deg"])
    yield "peak", peak
    yield "beam angle (50 %)", _spread_words(row["beam_angle_deg"])
    yield "field angle (10 %)", _spread_words(row["field_angle_deg"])
    yield "CIE flux code", " ".join(f"{code:.0f}" for code in row["cie_flux_codes"])
    zones = [f"{zone}: {_figure(value)}" for zone, value in row[f"zonal_flux_{key}"].items()]
    yield f"zonal flux [{unit}]", [", ".join(zones[i : i + 6]) for i in range(0, len(zones), 6)]


def _file_lines(row):
    """Labels and lines about the luminous opening, the lamps and their spectrum."""
    units, mean = UNITS[row["quantity"]], _mean_name(row["quantity"])
    yield "opening", _opening_words(row)
    for plane, values in (row[f"{mean}_{_key(units.luminance)}"] or {}).items():
        told = ", ".join(
            f"{gamma} deg: {'edge on' if value is None else _figure(value)}"
            for gamma, value in values.items()
        )
        yield f"{mean} {plane}", f"{told} {units.luminance}"
    if row["tilt_factors"]:
        told = ", ".join(f"{angle} deg: {f:g}" for angle, f in row["tilt_factors"].items())
        yield "tilt factors", told
    yield "lamps", [_lamp_words(lamp) for lamp in row["lamps"]]
    yield "spectrum", row["spectrum"]


def _figure(value: float) -> str:
    """Four digits, or all before the point."""
    return f"{value:.0f}" if value >= 1000.0 else f"{value:.4g}"


def _stated(share: float | None) -> str:
    return "" if share is None else f" (stated {percent(share, '.1f')})"


def _flux_words(row) -> str:
    unit = UNITS[row["quantity"]].flux
    key = unit.lower()
    text = f"{_figure(row['{}_flux_{}'.format(row['quantity'], key)])} {unit}"
    if row["light_output_ratio"] is None:
        return f"{text}, absolute photometry" if row["is_absolute"] else text
    stated = _stated(row["stated_light_output_ratio"])
    share = f"{percent(row['light_output_ratio'], '.1f')}{stated}"
    stated_flux = _figure(row[f"stated_flux_{key}"])
    return f"{text} of {stated_flux} {unit} of the lamps: light output ratio {share}"


def _visible_words(row) -> str:
    lumens = row["luminous_flux_lm"]
    return (
        f"{_figure(lumens)} lm by its spectrum" if lumens > 0.0 else "none: it states no spectrum"
    )


def _spread_words(angles) -> str:
    told = ["no light" if angle is None else f"{angle:.1f} deg" for angle in angles]
    return f"C0-C180 {told[0]}, C90-C270 {told[1]}"


def _opening_words(row) -> str:
    if row["opening_shape"] == "point":
        return "point"
    size = " x ".join(f"{side:.4g}" for side in row["opening_m"])
    words = {"rectangle": "facing", "ellipse": "facing", "cylinder": "along"}
    shape = row["opening_shape"]
    if shape in words:
        shape = f"{shape} {words[shape]} {row['opening_axis']}"
    return f"{shape}, {size} m (x, y, z)"


def _lamp_words(lamp) -> str:
    parts = [f"{lamp['count']} x {lamp['name'] or 'lamp'}" if lamp["count"] else lamp["name"]]
    if lamp["luminous_flux_lm"] is not None:
        parts.append(f"{_figure(lamp['luminous_flux_lm'])} lm")
    if lamp["watts"] is not None:
        parts.append(f"{lamp['watts']:g} W")
    parts += [lamp["colour"], lamp["colour_rendering"]]
    return ", ".join(" ".join(part.split()) for part in parts if part.strip())
