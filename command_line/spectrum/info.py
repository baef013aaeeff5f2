"""The command ``lumenray spectrum info``: what spectra hold, and what is odd about them."""

from dataclasses import asdict

from ..file_list import add_files, tell_each
from ..options import whole
from ..output import percent, remarks, sheet

ENDINGS = (".spdx", ".csv", ".txt", ".sp", ".ti3", ".ccss")
"""Of the names that are taken from a folder."""


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    info = tasks.add_parser("info", help="what spectra hold, and what is odd about them")
    add_files(info, "file of a spectrum", "*.spdx")
    add_column(info)
    info.set_defaults(run=run)


def add_column(parser) -> None:
    """Let a command say which column of a file it is about."""
    parser.add_argument(
        "--column",
        type=whole(),
        metavar="N",
        help="which column of values or sample, from 1 (default: the first, with a warning if there are others)",
    )


def run(options) -> int:
    """Tell about files; return the exit code."""
    from ...engine.formats.spd import read_spectrum

    return tell_each(
        options, ENDINGS, lambda name: describe(read_spectrum(name, options.column)), tell
    )


def describe(file) -> dict:
    """Row of a spectrum for JSON: numbers with their unit in the key, None where one has no meaning."""
    import numpy as np

    from ...engine.analysis.spectrum_figures import find_figures
    from ...engine.photometry.alpha_opic import RECEPTORS

    nm, values = file.table.wavelengths, file.table.values
    figures = asdict(find_figures(file.table))
    return {
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
        "colour_rendering_ra": figures["rendering"],
        "fidelity_rf": figures["fidelity"],
        "gamut_rg": figures["gamut"],
        "daylight_efficacy_ratios": dict(
            zip(RECEPTORS, figures["daylight_ratios"] or (), strict=False)
        ),
        "warnings": [str(remark) for remark in file.remarks],
    }


def tell(row: dict) -> str:
    """Text for people about a row of `describe`."""
    return sheet(row["file"], [*_lines(row), *remarks(row)])


def _lines(row):
    """Labels and lines about a spectrum."""
    yield "format", row["format"]
    if row["columns"] > 1:
        name = f" ('{row['column_names'][row['column'] - 1]}')" if row["column_names"] else ""
        yield "column", f"{row['column']} of {row['columns']}{name}"
    low, high = row["wavelength_nm"]
    step = row["largest_step_nm"]
    yield "wavelengths", f"{row['rows']}, {low:g} to {high:g} nm, at most {step:g} nm apart"
    yield "values", "{:g} to {:g}".format(*row["value"])
    if row["peak_nm"] is not None:
        yield "peak, centroid", f"{row['peak_nm']:g} nm, {row['centroid_nm']:.4g} nm"
        shares = (row[f"{name}_share"] for name in ("ultraviolet", "visible", "infrared"))
        words = zip(("below 380 nm", "visible", "above 780 nm"), shares, strict=True)
        yield "power", ", ".join(f"{percent(share)} {word}" for word, share in words)
        yield "as a light", _light_words(row)
        yield "colour rendering", _rendering_words(row)
        yield "melanopic", _melanopic_words(row)
    if row["luminous_reflectance_d65"] is not None:
        yield "as a reflectance", f"{percent(row['luminous_reflectance_d65'], '.2f')} under D65"


def _rendering_words(row) -> str:
    if row["colour_rendering_ra"] is None:
        return ""
    words = (("Ra", "colour_rendering_ra"), ("Rf", "fidelity_rf"), ("Rg", "gamut_rg"))
    return ", ".join(f"{name} {row[key]:.1f}" for name, key in words)


def _melanopic_words(row) -> str:
    ratios = row["daylight_efficacy_ratios"]
    return f"100 lx act as {100.0 * ratios['melanopic']:.4g} lx of daylight (D65)" if ratios else ""


def _light_words(row) -> str:
    if row["chromaticity_xy"] is None:
        return "nothing visible"
    words = [f"{row['efficacy_lm_per_w']:.4g} lm/W"]
    words.append("x {:.4f}, y {:.4f}".format(*row["chromaticity_xy"]))
    if row["colour_temperature_k"] is not None:
        words.append(f"{row['colour_temperature_k']:.0f} K, Duv {row['duv']:+.4f}")
    return ", ".join(words)
