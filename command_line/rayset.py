"""The commands ``lumenray rayset``: ray files told, drawn, reduced to photometric files and converted, without Blender."""

import argparse
import json
import math
import shutil
import sys
from pathlib import Path

from ..engine.errors import FileFormatError, LumenrayError
from .luminaire import say

LARGEST_PICTURE = 2048
"""Longest side of a panel. [pixel]"""

PLANES = 24
"""C-planes of sources that are not the same all around."""

EPILOG = """examples:
  lumenray rayset info led.ray
  lumenray rayset info --json *.ray > raysets.json
  lumenray rayset plot led.tm25ray -o led.png
  lumenray rayset reduce led.dat led.ies
  lumenray rayset convert led.dis led.tm25ray
  lumenray rayset convert led.ray many.dat --generate 1000000
  lumenray rayset prepare led.ray

Formats (IES TM-25, Zemax, LightTools, SPEOS, ASAP, TracePro and other text) are told apart by the content of a file.
Photometric files have the direction +z of the rays as their gamma = 0.
"""


def add_commands(commands) -> None:
    """Describe the commands, below argparse's sub-parsers ``commands``."""
    rayset = commands.add_parser(
        "rayset",
        help="ray files: numbers, pictures, photometric files, conversion",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    tasks = rayset.add_subparsers(dest="task", required=True, metavar="TASK")

    info = tasks.add_parser("info", help="what ray files hold, and what is odd about them")
    info.add_argument("files", nargs="+", metavar="FILE", help="ray file")
    info.add_argument("--json", action="store_true", help="a JSON list instead of text")

    plot = tasks.add_parser("plot", help="draw starting points, luminances and intensities")
    plot.add_argument("file", type=Path, metavar="FILE", help="ray file")
    plot.add_argument(
        "-o", "--output", required=True, type=Path, metavar="OUT.png", help="picture to write"
    )
    plot.add_argument("--dark", action="store_true", help="light lines on a dark ground")
    plot.add_argument(
        "--size", type=int, default=512, metavar="N", help="side of a panel (default: 512)"
    )

    reduce = tasks.add_parser("reduce", help="write the intensities as a photometric file")
    reduce.add_argument("file", type=Path, metavar="IN", help="ray file")
    reduce.add_argument(
        "output", type=Path, metavar="OUT", help="the end of its name says the format: .ies, .ldt"
    )
    reduce.add_argument(
        "--step",
        type=float,
        metavar="DEG",
        help="between angles (default: a tenth of the beam's half angle, at most 5)",
    )
    reduce.add_argument(
        "--planes",
        type=int,
        metavar="N",
        help="C-planes (default: 24, or 1 where all are the same but for noise)",
    )
    reduce.add_argument("--force", action="store_true", help="replace OUT if it is there")

    convert = tasks.add_parser("convert", help="write the rays in another format")
    convert.add_argument("file", type=Path, metavar="IN", help="ray file")
    convert.add_argument(
        "output",
        type=Path,
        metavar="OUT",
        help="the end of its name says the format: .tm25ray, .dat (Zemax binary)",
    )
    convert.add_argument(
        "--generate",
        type=int,
        metavar="N",
        help="write N rays generated from those of the file instead of them",
    )
    convert.add_argument("--force", action="store_true", help="replace OUT if it is there")

    prepare = tasks.add_parser(
        "prepare", help="keep beside a ray file what scenes need of it, and tell how exact it is"
    )
    prepare.add_argument("files", nargs="+", type=Path, metavar="FILE", help="ray file")
    prepare.add_argument("--json", action="store_true", help="a JSON list instead of text")

    for task in (info, plot, reduce, convert, prepare):
        task.add_argument(
            "--unit",
            choices=("m", "cm", "mm", "inch", "foot", "um"),
            default="mm",
            help="length unit of texts that do not tell theirs (default: mm)",
        )
        task.add_argument(
            "--lumens", action="store_true", help="texts that do not tell have rays in lumens"
        )


def run(options) -> int:
    """Run the chosen command; 1 if a file was refused.

    Raises
    ------
    LumenrayError    The one file of the command cannot be read or written.
    """
    tasks = {
        "info": _info,
        "plot": _plot,
        "reduce": _reduce,
        "convert": _convert,
        "prepare": _prepare,
    }
    return tasks[options.task](options)


def _open(options, path):
    """Head of a ray file."""
    from ..engine.raysets.reader import read_rayset
    from ..engine.raysets.record import LUMINOUS, RADIANT
    from ..engine.raysets.text import Assumed

    return read_rayset(path, Assumed(options.unit, LUMINOUS if options.lumens else RADIANT))


class ShareBar:
    """Share that is done, on a terminal; silent when nobody watches."""

    def __init__(self, title: str):
        self.title = title
        self.is_shown = sys.stderr.isatty()

    def __call__(self, share: float) -> None:
        if self.is_shown:
            text = f"{self.title} {100 * share:3.0f} %"
            sys.stderr.write(f"\r{text:<60}")
            sys.stderr.flush()

    def __enter__(self) -> "ShareBar":
        return self

    def __exit__(self, *_):
        if self.is_shown:
            width = shutil.get_terminal_size().columns - 1
            sys.stderr.write("\r" + " " * width + "\r")


# ---- numbers ----


def _info(options) -> int:
    from ..engine.raysets.survey import survey_rays

    rows = []
    for name in options.files:
        try:
            file = _open(options, name)
            with ShareBar(name) as bar:
                row = describe(name, file, survey_rays(file, bar))
        except FileFormatError as error:
            row = {"file": name, "error": str(error)}
        rows.append(row)
        if not options.json:
            say(tell(row) + "\n")
    if options.json:
        say(json.dumps(rows, indent=2, allow_nan=False))
    return int(any("error" in row for row in rows))


def describe(name: str, file, survey) -> dict:
    """Row of a ray file for JSON.

    Parameters
    ----------
    name : str
    file : RayFile
    survey : Survey

    Returns
    -------
    dict    Numbers with their unit in the key; a flux that is not known is left out.
    """
    row = {"file": name, "format": file.format, "rays": survey.rays}
    for key, value in (
        ("luminous_flux_lm", survey.luminous_flux),
        ("radiant_flux_w", survey.radiant_flux),
    ):
        if value is not None:
            row[key] = _number(value)
    spectrum = None
    if survey.spectrum is not None:
        wavelengths, values = survey.spectrum
        seen = values > 0.0
        spectrum = {
            "wavelength_nm": [_number(value) for value in wavelengths[seen]],
            "relative_power": [_number(value) for value in values[seen]],
        }
    return row | {
        "quantity": file.quantity,
        "bounds_m": [[_number(value) for value in corner] for corner in survey.bounds],
        "centroid_m": [_number(value) for value in survey.centroid],
        "mean_direction": [_number(value) for value in survey.axis],
        "wavelengths_nm": None
        if survey.wavelengths is None
        else [_number(value) for value in survey.wavelengths],
        "spectrum": spectrum,
        "metadata": dict(file.metadata),
        "warnings": [str(remark) for remark in survey.remarks],
    }


def _number(value) -> float | None:
    """Seven digits; None for what is no number."""
    value = float(value)
    return float(f"{value:.7g}") if math.isfinite(value) else None


def tell(row: dict) -> str:
    """Text for people about a row of `describe`."""
    lines = [row["file"]]

    def add(label, text):
        lines.append(f"  {label:<18}{text}")

    if "error" in row:
        text = row["error"]
        add(
            "refused",
            text[len(row["file"]) :].lstrip(" ,:") if text.startswith(row["file"]) else text,
        )
        return "\n".join(lines)
    add("format", row["format"])
    add("rays", f"{row['rays']:,}".replace(",", " "))
    fluxes = [
        f"{row[key]:.6g} {unit}"
        for key, unit in (("luminous_flux_lm", "lm"), ("radiant_flux_w", "W"))
        if key in row
    ]
    add("flux", ", ".join(fluxes))
    low, high = row["bounds_m"]
    size = [1e3 * (b - a) for a, b in zip(low, high, strict=True)]
    add("extent", " x ".join(f"{side:.4g}" for side in size) + " mm (x, y, z)")
    for label, key in (("from", low), ("to", high), ("centroid", row["centroid_m"])):
        add(label, ", ".join(f"{1e3 * value:.4g}" for value in key) + " mm")
    add("mean direction", ", ".join(f"{value:.4g}" for value in row["mean_direction"]))
    add("spectrum", _spectrum_words(row))
    for i, (key, value) in enumerate(row["metadata"].items()):
        add("metadata" if i == 0 else "", f"{key}: {' / '.join(value.splitlines())}")
    for i, warning in enumerate(row["warnings"]):
        add("warnings" if i == 0 else "", warning)
    return "\n".join(lines)


def _spectrum_words(row) -> str:
    if row["spectrum"] is None:
        return "not stated"
    wavelengths = row["spectrum"]["wavelength_nm"]
    span = f"{wavelengths[0]:g} to {wavelengths[-1]:g} nm" if len(wavelengths) > 1 else ""
    if row["wavelengths_nm"] is not None:
        return f"a wavelength for each ray, {span or f'{wavelengths[0]:g} nm'}"
    return f"one for all, {span}" if span else f"{wavelengths[0]:g} nm"


# ---- pictures, photometric files, conversion ----


def _light(options, file, bar):
    """Survey of a file, and its light."""
    from ..engine.raysets.light import light_of
    from ..engine.raysets.survey import survey_rays

    survey = survey_rays(file, lambda share: bar(0.2 * share))
    return survey, light_of(file, survey, progress=lambda share: bar(0.2 + 0.8 * share))


def _plot(options) -> int:
    from ..engine.analysis.rayset_picture import draw_rayset
    from ..engine.raysets.reduction import to_luminaire, view_rays

    if not 64 <= options.size <= LARGEST_PICTURE:
        raise LumenrayError(f"panels of {options.size} pixels, expected 64 to {LARGEST_PICTURE}")
    file = _open(options, options.file)
    with ShareBar(str(options.file)) as bar:
        survey, light = _light(options, file, bar)
        pieces = list(light.pieces())
    reduced = _reduce_pieces([(direction, flux) for _, direction, flux in pieces])
    low, high = survey.bounds
    extent = max(float((high - low).max()), 1e-6)
    image = view_rays(pieces, (0.0, 0.0, 1.0), 0.5 * (low + high), 1.2 * extent)
    sides = tuple(float(side) for side in high - low)
    position, direction, _ = pieces[0]
    title = f"{options.file.name}: {survey.rays:,} rays".replace(",", " ")
    if survey.luminous_flux is not None:
        title += f", {survey.luminous_flux:.4g} lm"
    picture = draw_rayset(
        position,
        direction,
        image,
        to_luminaire(reduced, sides, {}),
        title,
        options.size,
        options.dark,
    )
    _save(picture, options.output)
    return 0


def _reduce_pieces(pieces: list, step: float | None = None, planes: int | None = None):
    """Reduce rays on a grid that suits them where none is given."""
    from ..engine.raysets.reduction import choose_step, is_rotational, reduce_rays

    step = choose_step(pieces) if step is None else step
    reduced = reduce_rays(pieces, step, PLANES if planes is None else planes)
    if planes is None and is_rotational(reduced):
        return reduce_rays(pieces, step, 1)
    return reduced


def _save(picture, path: Path) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        picture.save(path)
    except OSError as error:
        raise FileFormatError(path, f"cannot be written ({error.strerror})") from None
    except ValueError:
        raise FileFormatError(path, "expected a name that ends in .png") from None
    say(f"written to {path}")


def _reduce(options) -> int:
    from ..engine.luminaires.distribution import flux
    from ..engine.luminaires.formats.reader import write_luminaire
    from ..engine.raysets.reduction import to_luminaire

    _check_free(options)
    if options.step is not None and not 0.1 <= options.step <= 15.0:
        raise LumenrayError(f"a step of {options.step:g} degrees, expected 0.1 to 15")
    if options.planes is not None and not 1 <= options.planes <= 720:
        raise LumenrayError(f"{options.planes} planes, expected 1 to 720")
    file = _open(options, options.file)
    with ShareBar(str(options.file)) as bar:
        survey, light = _light(options, file, bar)
        pieces = [(direction, amount) for _, direction, amount in light.pieces()]
    reduced = _reduce_pieces(pieces, options.step, options.planes)
    low, high = survey.bounds
    luminaire = to_luminaire(
        reduced,
        tuple(float(side) for side in high - low),
        {"TEST": f"reduced from the {survey.rays} rays of {options.file.name}"},
        spectrum=survey.spectrum if survey.spectrum and len(survey.spectrum[0]) > 1 else None,
    )
    for remark in (*survey.remarks, *write_luminaire(luminaire, options.output)):
        say(f"{options.output}: {remark}")
    planes = len(reduced.distribution.azimuth)
    told = f"{flux(reduced.distribution):.6g} lm, {'rotational' if planes == 1 else f'{planes - 1} planes'}"
    if light.cloud is not None:
        told += f", information error {100 * light.cloud.information_error:.1f} %"
    say(f"written to {options.output} ({told})")
    return 0


def _convert(options) -> int:
    from ..engine.raysets.reader import read_rays
    from ..engine.raysets.survey import survey_rays
    from ..engine.raysets.writers import write_tm25, write_zemax

    _check_free(options)
    ending = options.output.suffix.lower()
    if ending not in {".tm25ray", ".dat"}:
        raise FileFormatError(
            options.output, f"'{ending}' is no format that is written, expected .tm25ray or .dat"
        )
    file = _open(options, options.file)
    with ShareBar(str(options.file)) as bar:
        survey = survey_rays(file, lambda share: bar(0.5 * share))
        if options.generate is None:
            pieces = read_rays(file, progress=lambda share: bar(0.5 + 0.5 * share))
            factor = survey.factor
        else:
            pieces, factor = _generate(options, file, survey, bar), 1.0
        # A file that fails half-way leaves nothing behind, and not the old one spoilt.
        part = options.output.with_name(f".{options.output.name}.part")
        try:
            if ending == ".dat":
                count = write_zemax(
                    part, pieces, file.quantity, f"from {options.file.name}", factor
                )
            else:
                spectrum = None if survey.wavelengths is not None else survey.spectrum
                spectrum = spectrum if spectrum is not None and len(spectrum[0]) > 1 else None
                count = write_tm25(part, pieces, file.quantity, spectrum, file.metadata, factor)
            part.replace(options.output)
        except OSError as error:
            raise FileFormatError(options.output, f"cannot be written ({error.strerror})") from None
        finally:
            part.unlink(missing_ok=True)
    for remark in survey.remarks:
        say(f"{options.file}: {remark}")
    if len(file.spectra) > 1 or (ending == ".dat" and file.spectra):
        kept = "their mean is kept" if ending != ".dat" else "none is kept"
        say(f"{options.output}: has no place for the spectra of {options.file}; {kept}")
    say(f"written to {options.output} ({count} rays)")
    return 0


def _generate(options, file, survey, bar):
    """Yield generated rays in the file's own quantity."""
    import numpy as np

    from ..engine.raysets.cloud import hold_rays, make_cloud
    from ..engine.raysets.record import Rays

    if options.generate < 1:
        raise LumenrayError(f"{options.generate} rays, expected at least 1")
    cloud = make_cloud(
        hold_rays(file),
        survey.weight * survey.factor,
        progress=lambda share: bar(0.5 + 0.3 * share),
    )
    rng = np.random.default_rng(0)
    left = options.generate
    while left:
        count = min(left, 1 << 18)
        drawn = cloud.draw(count, rng)
        colour = {}
        if drawn.colour is not None and survey.wavelengths is not None:
            colour = {"wavelength": drawn.colour}
        yield Rays(
            drawn.position.astype(np.float32),
            drawn.direction.astype(np.float32),
            (drawn.flux * (count / options.generate)).astype(np.float32),
            **colour,
        )
        left -= count
        bar(0.8 + 0.2 * (1.0 - left / options.generate))


def _check_free(options) -> None:
    if options.output.exists() and not options.force:
        raise LumenrayError(f"{options.output} is there already; --force replaces it")


# ---- preparation for scenes ----


def _prepare(options) -> int:
    from ..engine.raysets.emission import Wish
    from ..engine.raysets.index import index_path, obtain_light
    from ..engine.raysets.record import LUMINOUS, RADIANT
    from ..engine.raysets.text import Assumed

    wish = Wish(assumed=Assumed(options.unit, LUMINOUS if options.lumens else RADIANT))
    rows, failed = [], 0
    for path in options.files:
        try:
            with ShareBar(str(path)) as bar:
                light = obtain_light(path, wish, is_kept=True, progress=bar)
        except LumenrayError as error:
            rows.append({"file": str(path), "error": str(error)})
            failed = 1
            continue
        rows.append({"file": str(path), **_prepared_row(light), "index": str(index_path(path))})
    if options.json:
        say(json.dumps(rows, indent=2))
    else:
        say("\n\n".join(_prepared_text(row) for row in rows))
    return failed


def _prepared_row(light) -> dict:
    """What is to be known of a prepared light, in JSON's terms."""
    emission = light.emission
    return {
        "rays": light.rays,
        "rays_held": len(emission.threshold),
        "body": light.body,
        "is_rotational": emission.axis is not None,
        "size_m": emission.size,
        "information_error": emission.information_error,
        "near_m": emission.near,
        "far_field": [
            {"distance_m": float(distance), "error": float(error)}
            for distance, error in zip(emission.far_distances, emission.far_errors, strict=True)
        ],
        "warnings": [str(remark) for remark in light.remarks],
    }


def _prepared_text(row: dict) -> str:
    if "error" in row:
        return f"{row['file']}: refused: {row['error']}"
    lines = [
        row["file"],
        f"  rays held        {row['rays_held']} of {row['rays']}",
        f"  they start from  {row['body']}{', even about its axis' if row['is_rotational'] else ''}",
        f"  set's own error  {100 * row['information_error']:.2g} % of the light in a 192nd part of it",
    ]
    for entry in row["far_field"]:
        distance = entry["distance_m"]
        lines.append(
            f"  as a point       wrong by {100 * entry['error']:.2g} % at {1e3 * distance:.3g} mm"
            f" ({distance / row['size_m']:g} sizes)"
        )
    lines.append(f"  as rays          within {1e3 * row['near_m']:.3g} mm, as a point beyond")
    lines += [f"  warning          {warning}" for warning in row["warnings"]]
    return "\n".join([*lines, f"  kept in          {row['index']}"])
