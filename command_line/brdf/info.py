"""The command ``lumenray brdf info``: what scattering files hold, and what is odd about them."""

from ..file_list import add_files, tell_each
from ..output import percent, remarks, sheet
from .file import add_tolerance, open_scattering, totals_of


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    info = tasks.add_parser("info", help="what scattering files hold, and what is odd about them")
    add_files(info, "scattering file", "*.xml")
    add_tolerance(info)
    info.set_defaults(run=run)


def run(options) -> int:
    """Tell about files; return the exit code."""
    from ...engine.scattering.file_names import ENDINGS

    return tell_each(options, ENDINGS, lambda name: describe(open_scattering(options, name)), tell)


def describe(file) -> dict:
    """Row of a scattering file for JSON.

    Reflectance and transmittance are of the front, at the angles of ``incidence_deg`` and averaged over the azimuth of
    incidence; where a file has only the back they are of that. ``sides`` has them all.
    """
    import numpy as np

    from ...engine.scattering.data.evaluation import incidences_of, measure_reciprocity, symmetry_of

    sides = {}
    for side, scatter in file.sides.items():
        sides[side] = {
            "symmetry": symmetry_of(scatter),
            "incidence_deg": np.degrees(incidences_of(scatter)),
            "total": totals_of(scatter),
            "direct": bool(getattr(scatter, "direct", None) is not None and scatter.direct.any()),
            "stated_error": getattr(scatter, "error", 0.0) or None,
            "values": int(scatter.values.size),
        }
    first = next(iter(file.sides.values()))
    incidences = np.degrees(file.incidences) if len(file.incidences) else None
    chosen = {
        kind: next((s for s in (f"front_{kind}", f"back_{kind}") if s in file.sides), None)
        for kind in ("reflection", "transmission")
    }
    if incidences is None:
        incidences = np.degrees(incidences_of(first))
    totals = {
        kind: None if side is None else totals_of(file.sides[side], np.radians(incidences))
        for kind, side in chosen.items()
    }
    residual = None
    reflection = chosen["reflection"]
    if reflection is not None:
        residual = measure_reciprocity(file.sides[reflection])
    elif {"front_transmission", "back_transmission"} <= set(file.sides):
        residual = measure_reciprocity(
            file.sides["front_transmission"], file.sides["back_transmission"]
        )
    return {
        "format": file.format,
        "name": file.name,
        "symmetry": symmetry_of(first),
        "wavelengths_nm": first.wavelengths,
        "incidence_deg": incidences,
        "hemispherical_reflectance": totals["reflection"],
        "hemispherical_transmittance": totals["transmission"],
        "reciprocity_residual": None if residual is None else residual.residual,
        "reciprocity_beside_peaks": None if residual is None else residual.scattered,
        "sides": sides,
        "warnings": [str(remark) for remark in file.remarks],
    }


def tell(row: dict) -> str:
    """Text for people about a row of `describe`."""
    nm, residual = row["wavelengths_nm"], row["reciprocity_residual"]
    reciprocity = residual is not None and (
        f"residual {percent(residual)}, beside peaks {percent(row['reciprocity_beside_peaks'])}"
    )
    return sheet(
        row["file"],
        [
            ("format", row["format"]),
            ("name", row["name"]),
            ("symmetry", row["symmetry"]),
            ("wavelengths", f"{len(nm)}, {nm[0]:g} to {nm[-1]:g} nm" if nm[1:] else "neutral"),
            ("incidence", " ".join(f"{angle:g}" for angle in row["incidence_deg"]) + " deg"),
            ("reflectance", _shares(row["hemispherical_reflectance"])),
            ("transmittance", _shares(row["hemispherical_transmittance"])),
            *(("side", _side_words(side, own)) for side, own in row["sides"].items()),
            ("reciprocity", reciprocity or None),
            *remarks(row),
        ],
    )


def _shares(shares) -> str | None:
    return shares and " ".join(f"{100 * share:.2f}" for share in shares) + " %"


def _side_words(side: str, own: dict) -> str:
    text = f"{side.replace('_', ' ')}, {own['values']:_} values".replace("_", " ")
    if own["stated_error"]:
        text += f", resampled with an error of {percent(own['stated_error'], '.2g')}"
    return text + ", with a direct part" * own["direct"]
