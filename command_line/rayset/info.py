"""The command ``lumenray rayset info``: what ray files hold, and what is odd about them."""

from ..file_list import add_files, tell_each
from ..output import remarks, sheet
from ..progress import Bar
from .file import add_assumptions, open_rayset


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    info = tasks.add_parser("info", help="what ray files hold, and what is odd about them")
    add_files(info, "ray file", "*.tm25ray")
    add_assumptions(info)
    info.set_defaults(run=run)


def run(options) -> int:
    """Tell about files; return the exit code."""
    from ...engine.raysets.file_names import ENDINGS
    from ...engine.raysets.survey import survey_rays

    def read(name):
        file = open_rayset(options, name)
        with Bar(name) as bar:
            return describe(file, survey_rays(file, bar.share))

    return tell_each(options, ENDINGS, read, tell)


def describe(file, survey) -> dict:
    """Row of a ray file for JSON.

    Parameters
    ----------
    file : RayFile
    survey : Survey

    Returns
    -------
    dict    Numbers with their unit in the key; a flux that is not known is left out.
    """
    row = {"format": file.format, "rays": survey.rays}
    for key, value in (
        ("luminous_flux_lm", survey.luminous_flux),
        ("radiant_flux_w", survey.radiant_flux),
    ):
        if value is not None:
            row[key] = float(value)
    spectrum = None
    if survey.spectrum is not None:
        wavelengths, values = survey.spectrum
        seen = values > 0.0
        spectrum = {"wavelength_nm": wavelengths[seen], "relative_power": values[seen]}
    return row | {
        "quantity": file.quantity,
        "bounds_m": survey.bounds,
        "centroid_m": survey.centroid,
        "mean_direction": survey.axis,
        "wavelengths_nm": survey.wavelengths,
        "spectrum": spectrum,
        "metadata": dict(file.metadata),
        "warnings": [str(remark) for remark in survey.remarks],
    }


def tell(row: dict) -> str:
    """Text for people about a row of `describe`."""

    def millimetres(place):
        return ", ".join(f"{1e3 * value:.4g}" for value in place) + " mm"

    low, high = row["bounds_m"]
    size = " x ".join(f"{1e3 * (b - a):.4g}" for a, b in zip(low, high, strict=True))
    fluxes = [
        f"{row[key]:.6g} {unit}"
        for key, unit in (("luminous_flux_lm", "lm"), ("radiant_flux_w", "W"))
        if key in row
    ]
    return sheet(
        row["file"],
        [
            ("format", row["format"]),
            ("rays", f"{row['rays']:,}".replace(",", " ")),
            ("flux", ", ".join(fluxes)),
            ("extent", f"{size} mm (x, y, z)"),
            ("from", millimetres(low)),
            ("to", millimetres(high)),
            ("centroid", millimetres(row["centroid_m"])),
            ("mean direction", ", ".join(f"{value:.4g}" for value in row["mean_direction"])),
            ("spectrum", _spectrum_words(row)),
            *remarks(row),
        ],
    )


def _spectrum_words(row) -> str:
    if row["spectrum"] is None:
        return "not stated"
    wavelengths = row["spectrum"]["wavelength_nm"]
    span = f"{wavelengths[0]:g} to {wavelengths[-1]:g} nm" if len(wavelengths) > 1 else ""
    if row["wavelengths_nm"] is not None:
        return f"a wavelength for each ray, {span or f'{wavelengths[0]:g} nm'}"
    return f"one for all, {span}" if span else f"{wavelengths[0]:g} nm"
