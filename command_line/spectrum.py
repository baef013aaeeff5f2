"""The commands ``lumenray spectrum``: files of spectra told and drawn, without Blender and Mitsuba."""

import argparse
import json
import math
from dataclasses import asdict
from pathlib import Path

from ..engine.errors import FileFormatError, LumenrayError
from .luminaire import LARGEST_PICTURE, say

EPILOG = """examples:
  lumenray spectrum info lamp.spdx reflectance.csv
  lumenray spectrum info --json lamps.csv --column 3
  lumenray spectrum plot lamp.spdx -o lamp.png

Files are text or CSV with wavelengths in nm and one or more columns of values, or IES TM-27 (.spdx). Efficacy counts all
radiation in the file, ultraviolet and infrared included.
"""


def add_commands(commands, read_size) -> None:
    """Describe the commands.

    Parameters
    ----------
    commands : argparse's sub-parsers    To which ``spectrum`` is added.
    read_size : callable    From text such as 640x400 to (width, height).
    """
    spectrum = commands.add_parser(
        "spectrum",
        help="files of spectra: numbers, pictures",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    tasks = spectrum.add_subparsers(dest="task", required=True, metavar="TASK")

    info = tasks.add_parser("info", help="what spectra hold, and what is odd about them")
    info.add_argument("files", nargs="+", metavar="FILE", help="file of a spectrum")
    info.add_argument("--json", action="store_true", help="a JSON list instead of text")

    plot = tasks.add_parser("plot", help="draw a spectrum")
    plot.add_argument("files", nargs=1, metavar="FILE", help="file of a spectrum")
    plot.add_argument(
        "-o", "--output", required=True, type=Path, metavar="OUT.png", help="picture to write"
    )
    plot.add_argument("--dark", action="store_true", help="light lines on a dark ground")
    plot.add_argument(
        "--size", type=read_size, default=(640, 480), metavar="WxH", help="default: 640x480"
    )

    for task in (info, plot):
        task.add_argument(
            "--column",
            type=int,
            metavar="N",
            help="which column of values, from 1 (default: the first, with a warning if there are others)",
        )


def run(options) -> int:
    """Run the chosen command; 1 if a file was refused.

    Raises
    ------
    LumenrayError    The one file of the command cannot be read or written.
    """
    return {"info": _info, "plot": _plot}[options.task](options)


def _info(options) -> int:
    from ..engine.formats.spd import read_spectrum

    rows = []
    for name in options.files:
        try:
            row = describe(name, read_spectrum(name, options.column))
        except FileFormatError as error:
            row = {"file": name, "error": str(error)}
        rows.append(row)
        if not options.json:
            say(tell(row) + "\n")
    if options.json:
        say(json.dumps(rows, indent=2, allow_nan=False))
    return int(any("error" in row for row in rows))


def describe(name: str, file) -> dict:
    """Row of a spectrum for JSON: numbers with their unit in the key, None where one has no meaning."""
    import numpy as np

    from ..engine.analysis.spectrum_figures import find_figures

    nm, values = file.table.wavelengths, file.table.values
    figures = asdict(find_figures(file.table))
    row = {
        "file": name,
        "format": file.format,
        "column": file.column,
        "columns": file.columns,
        "column_names": list(file.names),
        "rows": len(nm),
        "wavelength_nm": [float(nm[0]), float(nm[-1])],
        "largest_step_nm": float(np.diff(nm).max()),
        "value": [float(values.min()), float(values.max())],
        "peak_nm": figures["peak"],
        "centroid_nm": figures["centroid"],
        "ultraviolet_share": figures["ultraviolet"],
        "visible_share": figures["visible"],
        "infrared_share": figures["infrared"],
        "efficacy_lm_per_w": figures["efficacy"],
        "chromaticity_xy": figures["chromaticity"],
        "colour_temperature_k": figures["temperature"],
        "duv": figures["duv"],
        "luminous_reflectance_d65": figures["reflectance"],
        "warnings": [str(remark) for remark in file.remarks],
    }
    return {key: _rounded(value) for key, value in row.items()}


def _rounded(value):
    """Seven digits."""
    if isinstance(value, list | tuple):
        return [_rounded(each) for each in value]
    if isinstance(value, float):
        return float(f"{value:.7g}") if math.isfinite(value) else None
    return value


def tell(row: dict) -> str:
    """Text for people about a row of `describe`."""
    lines = [row["file"]]

    def add(label, text):
        lines.append(f"  {label:<18}{text}")

    if "error" in row:
        text = row["error"]
        own = text.startswith(row["file"])
        add("refused", text[len(row["file"]) :].lstrip(" ,:") if own else text)
        return "\n".join(lines)
    add("format", row["format"])
    if row["columns"] > 1:
        name = f" ('{row['column_names'][row['column'] - 1]}')" if row["column_names"] else ""
        add("column", f"{row['column']} of {row['columns']}{name}")
    low, high = row["wavelength_nm"]
    step = row["largest_step_nm"]
    add("wavelengths", f"{row['rows']}, {low:g} to {high:g} nm, at most {step:g} nm apart")
    add("values", "{:g} to {:g}".format(*row["value"]))
    if row["peak_nm"] is not None:
        add("peak, centroid", f"{row['peak_nm']:g} nm, {row['centroid_nm']:.4g} nm")
        shares = (row[f"{name}_share"] for name in ("ultraviolet", "visible", "infrared"))
        words = zip(("below 380 nm", "visible", "above 780 nm"), shares, strict=True)
        add("power", ", ".join(f"{100 * share:.3g} % {word}" for word, share in words))
        add("as a light", _light_words(row))
    if row["luminous_reflectance_d65"] is not None:
        add("as a reflectance", f"{row['luminous_reflectance_d65']:.4f} under D65")
    for i, warning in enumerate(row["warnings"]):
        add("warnings" if i == 0 else "", warning)
    return "\n".join(lines)


def _light_words(row) -> str:
    if row["chromaticity_xy"] is None:
        return "nothing visible"
    words = [f"{row['efficacy_lm_per_w']:.4g} lm/W"]
    words.append("x {:.4f}, y {:.4f}".format(*row["chromaticity_xy"]))
    if row["colour_temperature_k"] is not None:
        words.append(f"{row['colour_temperature_k']:.0f} K, Duv {row['duv']:+.4f}")
    return ", ".join(words)


def _plot(options) -> int:
    from ..engine.analysis.spectrum_picture import draw_spectrum
    from ..engine.formats.spd import read_spectrum

    if max(options.size) > LARGEST_PICTURE:
        raise LumenrayError(
            f"a picture of {options.size[0]}x{options.size[1]} is too large, "
            f"expected at most {LARGEST_PICTURE}x{LARGEST_PICTURE}"
        )
    file = read_spectrum(options.files[0], options.column)
    for remark in file.remarks:
        say(f"{file.path}: {remark}")
    picture = draw_spectrum(file, options.size, options.dark)
    try:
        options.output.parent.mkdir(parents=True, exist_ok=True)
        picture.save(options.output)
    except OSError as error:
        raise FileFormatError(options.output, f"cannot be written ({error.strerror})") from None
    except ValueError:
        raise FileFormatError(options.output, "expected a name that ends in .png") from None
    say(f"written to {options.output}")
    return 0
