"""The commands ``lumenray luminaire``: photometric files told, drawn and converted, without Blender and Mitsuba.

Only the making of asset libraries needs both.
"""

import argparse
import glob
import json
import math
import re
import sys
from pathlib import Path

from ..engine.errors import FileFormatError, LumenrayError
from ..engine.luminaires.formats.record import LUMINOUS, UNITS
from ..engine.reading.printable import printable
from . import luminaire_library as library_command

SUFFIXES = (".ies", ".ldt", ".xml")
"""Ends of the names that are taken from a folder."""

LARGEST_PICTURE = 4096
"""Longest side of a diagram. [pixel]"""

EPILOG = """examples:
  lumenray luminaire info downlight.ies
  lumenray luminaire info --json catalogue/ "more/*.ldt" > luminaires.json
  lumenray luminaire plot downlight.ies -o downlight.png
  lumenray luminaire convert street.ldt street.ies
  lumenray luminaire library ~/luminaires

Angles are the luminaire's own: gamma from its downward axis, C counter-clockwise seen from above.
"""


def add_commands(commands, read_size) -> None:
    """Describe the commands.

    Parameters
    ----------
    commands : argparse's sub-parsers    To which ``luminaire`` is added.
    read_size : callable    From text such as 640x400 to (width, height).
    """
    luminaire = commands.add_parser(
        "luminaire",
        help="photometric files: numbers, polar diagram, conversion",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    tasks = luminaire.add_subparsers(dest="task", required=True, metavar="TASK")

    info = tasks.add_parser("info", help="what photometric files say, and what is odd about them")
    info.add_argument(
        "files",
        nargs="+",
        metavar="FILE",
        help="IES, EULUMDAT or TM-33 file, a folder of them, or a pattern such as '*.ldt'",
    )
    info.add_argument("--json", action="store_true", help="a JSON list instead of text")

    plot = tasks.add_parser("plot", help="draw the polar diagram")
    plot.add_argument("file", type=Path, metavar="FILE", help="photometric file")
    plot.add_argument(
        "-o", "--output", required=True, type=Path, metavar="OUT.png", help="picture to write"
    )
    plot.add_argument(
        "--kind",
        choices=("auto", "polar", "cartesian"),
        default="auto",
        help="kind of diagram (default: cartesian for narrow beams, else polar)",
    )
    plot.add_argument("--dark", action="store_true", help="light lines on a dark ground")
    plot.add_argument("--per-klm", action="store_true", help="in cd for 1000 lm instead of cd")
    plot.add_argument(
        "--size", type=read_size, default=(512, 512), metavar="WxH", help="default: 512x512"
    )

    convert = tasks.add_parser("convert", help="write a photometric file in another format")
    convert.add_argument("file", type=Path, metavar="IN", help="photometric file")
    convert.add_argument(
        "output", type=Path, metavar="OUT", help="the end of its name says the format: .ies, .ldt"
    )
    convert.add_argument("--force", action="store_true", help="replace OUT if it is there")

    library = tasks.add_parser(
        "library", help="make a Blender asset library of a folder of photometric files"
    )
    library_command.add_options(library)


def run(options) -> int:
    """Run the chosen command; 1 if a file was refused.

    Raises
    ------
    LumenrayError    The one file of the command cannot be read or written.
    """
    tasks = {"info": _info, "plot": _plot, "convert": _convert, "library": library_command.run}
    return tasks[options.task](options)


def _info(options) -> int:
    from ..engine.luminaires.formats.reader import read_luminaire

    rows = []
    for name in _expand(options.files):
        try:
            file = read_luminaire(name)
        except FileFormatError as error:
            rows.append({"file": name, "error": str(error)})
            text = f"{name}\n  refused             {_without_path(error)}"
        else:
            rows.append(describe(name, file))
            text = tell(rows[-1])
        if not options.json:
            say(text + "\n")
    if options.json:
        say(json.dumps(rows, indent=2, allow_nan=False))
    return int(any("error" in row for row in rows))


def _expand(names) -> list[str]:
    """Files of folders and patterns; a name that is neither stays, so that its absence is told."""
    files = []
    for name in names:
        path = Path(name)
        if path.is_dir():
            inside = [p for p in path.rglob("*") if p.suffix.lower() in SUFFIXES and p.is_file()]
            files += sorted(map(str, inside))
        elif not path.exists() and glob.has_magic(name):
            files += sorted(glob.glob(name, recursive=True)) or [name]
        else:
            files.append(name)
    if not files:
        raise LumenrayError(
            f"{', '.join(names)}: no photometric file in it, expected names that end in {', '.join(SUFFIXES)}"
        )
    return files


def _without_path(error: FileFormatError) -> str:
    text = str(error)
    return text[len(error.path) :].lstrip(" ,:") if text.startswith(error.path) else text


def say(text: str) -> None:
    """Write to the terminal, with question marks for what it cannot show, and no commands to it from a file."""
    encoding = sys.stdout.encoding or "utf-8"
    sys.stdout.write(printable(text).encode(encoding, "replace").decode(encoding) + "\n")


# ---- numbers ----


def describe(name: str, file) -> dict:
    """Row of a photometric file for JSON.

    Parameters
    ----------
    name : str
    file : LuminaireFile

    Returns
    -------
    dict    Numbers with their unit in the key; null (None) where the file does not say enough. Shares of the flux code
        are in percent, as it is written.
    """
    from ..engine.luminaires.lamp_spectrum import choose_spectrum
    from ..engine.luminaires.summary import GLARE_ANGLES, PLANES, ZONES, summarise

    summary = summarise(file)
    luminance = None
    if summary.luminance is not None:
        luminance = {
            f"C{plane:g}": {
                f"{gamma:g}": value for gamma, value in zip(GLARE_ANGLES, row, strict=True)
            }
            for plane, row in zip(PLANES, summary.luminance.tolist(), strict=True)
        }
    units = file.units
    flux = "lm" if file.quantity == LUMINOUS else "w"
    edges = [round(math.degrees(edge)) for edge in ZONES]
    row = {
        "file": name,
        "format": file.format,
        "photometric_type": file.photometric_type,
        "symmetry": file.symmetry,
        "is_absolute": file.is_absolute,
        "quantity": file.quantity,
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
        "cie_flux_codes": (100.0 * summary.flux_codes).tolist(),
        f"zonal_flux_{flux}": {
            f"{low}-{high}": value
            for low, high, value in zip(edges, edges[1:], summary.zonal_flux.tolist(), strict=False)
        },
        f"{_mean_name(file)}_{_key(units.luminance)}": luminance,
        "opening_shape": file.opening.shape,
        "opening_axis": file.opening.axis,
        "opening_m": file.opening.size,
        "stored_planes": len(file.stored_azimuths),
        "stored_angles": len(file.stored_polars),
        "tilt_factors": None
        if file.tilt is None
        else {
            f"{a:g}": f for a, f in zip(file.tilt.angles, file.tilt.factors.tolist(), strict=True)
        },
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
    return _clean(row)


def visible_flux(file, watts: float) -> float:
    """Lumens of a radiant file: by its spectrum, and none without one."""
    from ..engine.photometry.spectra import efficacy_of_table

    return 0.0 if file.spectrum is None else watts * efficacy_of_table(*file.spectrum)


def _mean_name(file) -> str:
    return "luminance" if file.quantity == LUMINOUS else "radiance"


def _key(unit: str) -> str:
    """A unit in the key of a JSON object."""
    return re.sub(r"[()]", "", unit).replace("/", "_per_").replace(" ", "_").lower()


def _clean(value):
    """Numbers to seven digits, NaN and infinity to None, tuples to lists."""
    if isinstance(value, dict):
        return {key: _clean(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_clean(item) for item in value]
    if isinstance(value, float):
        return float(f"{value:.7g}") if math.isfinite(value) else None
    return value


def tell(row: dict) -> str:
    """Text for people about a row of `describe`."""
    lines, units = [row["file"]], UNITS[row["quantity"]]
    flux, is_luminous = units.flux.lower(), row["quantity"] == LUMINOUS

    def add(label, text):
        if text:
            lines.append(f"  {label:<20}{text}")

    add("format", f"{row['format']}, type {row['photometric_type']}, symmetry {row['symmetry']}")
    planes = row["stored_planes"]
    add("stored", f"{planes} plane{'s' if planes > 1 else ''} of {row['stored_angles']} angles")
    add(f"{row['quantity']} flux", _flux_words(row))
    if not is_luminous:
        add("visible light", _visible_words(row))
    share = row["downward_fraction"]
    if share is not None:
        stated = _stated(row["stated_downward_fraction"])
        add(
            "down, up",
            f"{_figure(row[f'downward_flux_{flux}'])} {units.flux}, {_figure(row[f'upward_flux_{flux}'])} {units.flux}; "
            f"downward {100 * share:.1f} %{stated}",
        )
    efficacy = row[f"efficacy_{flux}_per_w"]
    if efficacy is not None:
        told = (
            f"{efficacy:.1f} lm/W" if is_luminous else f"{100 * efficacy:.2g} % of it as radiation"
        )
        add("power", f"{row['watts']:g} W, {told}")
    c, gamma = row["peak_direction_deg"]
    peak = f"{_figure(row[f'peak_{_key(units.intensity)}'])} {units.intensity} at C {c:g}, gamma {gamma:g} deg"
    if row["peak_hv_deg"] is not None:
        peak += " (H {:g}, V {:g} deg)".format(*row["peak_hv_deg"])
    add("peak", peak)
    add("beam angle (50 %)", _spread_words(row["beam_angle_deg"]))
    add("field angle (10 %)", _spread_words(row["field_angle_deg"]))
    add("CIE flux code", " ".join(f"{code:.0f}" for code in row["cie_flux_codes"]))
    zones = [f"{zone}: {_figure(value)}" for zone, value in row[f"zonal_flux_{flux}"].items()]
    for i in range(0, len(zones), 6):
        add(f"zonal flux [{units.flux}]" if i == 0 else "", ", ".join(zones[i : i + 6]))
    add("opening", _opening_words(row))
    mean = "luminance" if is_luminous else "radiance"
    for plane, values in (row[f"{mean}_{_key(units.luminance)}"] or {}).items():
        told = ", ".join(
            f"{gamma} deg: {'edge on' if value is None else _figure(value)}"
            for gamma, value in values.items()
        )
        add(f"{mean} {plane}", f"{told} {units.luminance}")
    if row["tilt_factors"]:
        add("tilt factors", ", ".join(f"{a} deg: {f:g}" for a, f in row["tilt_factors"].items()))
    for i, lamp in enumerate(row["lamps"]):
        add("lamps" if i == 0 else "", _lamp_words(lamp))
    add("spectrum", row["spectrum"])
    for i, (key, value) in enumerate(row["metadata"].items()):
        add("metadata" if i == 0 else "", f"{key}: {' / '.join(value.splitlines())}")
    for i, warning in enumerate(row["warnings"]):
        add("warnings" if i == 0 else "", warning)
    return "\n".join(lines)


def _figure(value: float) -> str:
    """Four digits, or all before the point."""
    return f"{value:.0f}" if value >= 1000.0 else f"{value:.4g}"


def _stated(share: float | None) -> str:
    return "" if share is None else f" (stated {100 * share:.1f} %)"


def _flux_words(row) -> str:
    unit = UNITS[row["quantity"]].flux
    key = unit.lower()
    text = f"{_figure(row['{}_flux_{}'.format(row['quantity'], key)])} {unit}"
    if row["light_output_ratio"] is None:
        return f"{text}, absolute photometry" if row["is_absolute"] else text
    stated = _stated(row["stated_light_output_ratio"])
    share = f"{100 * row['light_output_ratio']:.1f} %{stated}"
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


# ---- picture and conversion ----


def _plot(options) -> int:
    from ..engine.analysis.polar_diagram import draw_polar_diagram
    from ..engine.luminaires.formats.reader import read_luminaire

    if max(options.size) > LARGEST_PICTURE:
        raise LumenrayError(
            f"a picture of {options.size[0]}x{options.size[1]} is too large, "
            f"expected at most {LARGEST_PICTURE}x{LARGEST_PICTURE}"
        )
    file = read_luminaire(options.file)
    picture = draw_polar_diagram(file, options.size, options.dark, options.kind, options.per_klm)
    try:
        options.output.parent.mkdir(parents=True, exist_ok=True)
        picture.save(options.output)
    except OSError as error:
        raise FileFormatError(options.output, f"cannot be written ({error.strerror})") from None
    except ValueError:
        raise FileFormatError(options.output, "expected a name that ends in .png") from None
    say(f"written to {options.output}")
    return 0


def _convert(options) -> int:
    from ..engine.luminaires.formats.reader import read_luminaire, write_luminaire

    if options.output.exists() and not options.force:
        raise LumenrayError(f"{options.output} is there already; --force replaces it")
    file = read_luminaire(options.file)
    remarks = write_luminaire(file, options.output)
    for path, found in ((options.file, file.remarks), (options.output, remarks)):
        for remark in found:
            say(f"{path}: {remark}")
    say(f"written to {options.output}")
    return 0
