"""The commands ``lumenray brdf``: scattering files told, drawn, checked and converted, raw measurements made tables of."""

import argparse
import json
import math
from dataclasses import replace
from pathlib import Path

from ..engine.errors import FileFormatError, LumenrayError
from . import material_library as material_command
from .luminaire import say

GOOD_RECIPROCITY = 0.1
"""Residual up to which a measurement is taken for good. [-]"""

ENERGY_ROUNDING = 0.01
"""By which a total may exceed 1: what instruments and integration leave open. [-]"""

STATED_TOLERANCE = 0.02
"""By which totals may differ from what the file itself states. [-]"""

STEEP_INCIDENCE = 45.0
"""Data for less than this angle of incidence tell little of a room, where most light comes from the side. [deg]"""

ENDINGS = (".lumbsdf", ".bsdf")

LARGEST_PICTURE = 4096

EPILOG = """examples:
  lumenray brdf info paint.bsdf
  lumenray brdf info --json *.xml > materials.json
  lumenray brdf plot paint.bsdf -o paint.png
  lumenray brdf check blinds.xml
  lumenray brdf convert alum_bronze.bsdf alum_bronze.lumbsdf --tolerance 0.01
  lumenray brdf process raw.csv sample.lumbsdf --report sample.png
  lumenray brdf library ~/materials

Formats (Zemax, LightTools, WINDOW XML, RGL, MERL, SPEOS, MDL, goniometer tables, our own) are told apart by the content of
a file. Totals are hemispherical, weighed by V(lambda) at equal energy, the direct part included.
"""


def add_commands(commands) -> None:
    """Describe the commands, below argparse's sub-parsers ``commands``."""
    brdf = commands.add_parser(
        "brdf",
        help="measured materials: numbers, pictures, checks, conversion, processing",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    tasks = brdf.add_subparsers(dest="task", required=True, metavar="TASK")

    info = tasks.add_parser("info", help="what scattering files hold, and what is odd about them")
    info.add_argument("files", nargs="+", metavar="FILE", help="scattering file")
    info.add_argument("--json", action="store_true", help="a JSON list instead of text")

    plot = tasks.add_parser("plot", help="draw cuts in the plane of incidence, or totals by angle")
    plot.add_argument("file", type=Path, metavar="FILE", help="scattering file")
    plot.add_argument(
        "-o", "--output", required=True, type=Path, metavar="OUT.png", help="picture to write"
    )
    plot.add_argument(
        "--totals", action="store_true", help="reflectance and transmittance by angle"
    )
    plot.add_argument(
        "--side", choices=("front", "back"), default="front", help="that light comes to"
    )
    plot.add_argument(
        "--incidences",
        type=_angles,
        default=(0.0, 15.0, 30.0, 45.0, 60.0, 75.0),
        metavar="DEG,DEG",
        help="of the cuts (default: 0,15,30,45,60,75)",
    )
    plot.add_argument(
        "--rotation", type=float, default=0.0, metavar="DEG", help="azimuth of incidence"
    )
    plot.add_argument("--dark", action="store_true", help="light lines on a dark ground")
    plot.add_argument("--size", type=int, default=800, metavar="N", help="width (default: 800)")

    check = tasks.add_parser("check", help="energy, reciprocity, stated totals; 1 if one is bad")
    check.add_argument("files", nargs="+", metavar="FILE", help="scattering file")
    check.add_argument("--json", action="store_true", help="a JSON list instead of text")

    convert = tasks.add_parser("convert", help="write a file as our table, or as an RGL file")
    convert.add_argument("file", type=Path, metavar="IN", help="scattering file")
    convert.add_argument(
        "output", type=Path, metavar="OUT", help="the end of its name says: .lumbsdf or .bsdf (RGL)"
    )
    convert.add_argument(
        "--reciprocal", action="store_true", help="make tables of reflection reciprocal"
    )
    convert.add_argument(
        "--limit", action="store_true", help="scale down what would make light from nothing"
    )
    convert.add_argument("--force", action="store_true", help="replace OUT if it is there")

    process = tasks.add_parser("process", help="make a table of a raw measurement")
    process.add_argument("file", type=Path, metavar="RAW.csv", help="raw measurement")
    process.add_argument("output", type=Path, metavar="OUT.lumbsdf", help="table to write")
    process.add_argument(
        "--report", type=Path, metavar="OUT.png", help="cuts before and after as a picture"
    )
    process.add_argument("--force", action="store_true", help="replace OUT if it is there")

    material_command.add_to(tasks, "library", None)

    for task in (info, plot, check, convert):
        task.add_argument(
            "--tolerance",
            type=float,
            metavar="E",
            help="error allowed where data have to be resampled, were before, or are written as RGL; what misses it is "
            "refused (default: 0.02, and what misses it tells by how much)",
        )


def _angles(text: str) -> tuple[float, ...]:
    try:
        angles = tuple(float(part) for part in text.split(","))
    except ValueError:
        angles = ()
    if not 1 <= len(angles) <= 12 or not all(0.0 <= angle < 90.0 for angle in angles):
        raise argparse.ArgumentTypeError(
            f"'{text}', expected up to twelve angles from 0 to below 90, such as 0,30,60"
        )
    return angles


def run(options) -> int:
    """Run the chosen command; 1 if a file was refused, or is bad.

    Raises
    ------
    LumenrayError    The one file of the command cannot be read or written.
    """
    tasks = {
        "info": _info,
        "plot": _plot,
        "check": _check,
        "convert": _convert,
        "process": _process,
        "library": material_command.run,
    }
    return tasks[options.task](options)


def _open(options, path):
    from ..engine.scattering.readers.reader import Wish, read_scattering

    if options.tolerance is None:
        return read_scattering(path)
    if not 1e-3 <= options.tolerance <= 0.5:
        raise LumenrayError(f"a tolerance of {options.tolerance:g}, expected 0.001 to 0.5")
    return read_scattering(path, Wish(options.tolerance, is_strict=True))


# ---- numbers ----


def _info(options) -> int:
    rows = []
    for name in options.files:
        try:
            row = describe(name, _open(options, name))
        except FileFormatError as error:
            row = {"file": name, "error": str(error)}
        rows.append(row)
        if not options.json:
            say(tell(row) + "\n")
    if options.json:
        say(json.dumps(rows, indent=2, allow_nan=False))
    return int(any("error" in row for row in rows))


def describe(name: str, file) -> dict:
    """Row of a scattering file for JSON.

    Reflectance and transmittance are of the front, at the angles of ``incidence_deg`` and averaged over the azimuth of
    incidence; where a file has only the back they are of that. ``sides`` has them all.
    """
    import numpy as np

    from ..engine.scattering.data.evaluation import incidences_of, measure_reciprocity, symmetry_of

    sides = {}
    for side, scatter in file.sides.items():
        sides[side] = {
            "symmetry": symmetry_of(scatter),
            "incidence_deg": _numbers(np.degrees(incidences_of(scatter))),
            "total": _numbers(_totals(scatter)),
            "direct": bool(getattr(scatter, "direct", None) is not None and scatter.direct.any()),
            "stated_error": _number(getattr(scatter, "error", 0.0)) or None,
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
        kind: None if side is None else _numbers(_totals(file.sides[side], np.radians(incidences)))
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
        "file": name,
        "format": file.format,
        "name": file.name,
        "symmetry": symmetry_of(first),
        "wavelengths_nm": _numbers(first.wavelengths),
        "incidence_deg": _numbers(incidences),
        "hemispherical_reflectance": totals["reflection"],
        "hemispherical_transmittance": totals["transmission"],
        "reciprocity_residual": None if residual is None else _number(residual.residual),
        "reciprocity_beside_peaks": None if residual is None else _number(residual.scattered),
        "sides": sides,
        "warnings": [str(remark) for remark in file.remarks],
    }


def _totals(scatter, incidences=None):
    """Totals at angles of incidence, weighed by V(lambda) and averaged over the azimuth. (s,)"""
    import numpy as np

    from ..engine.analysis.scattering_picture import luminous_mean
    from ..engine.scattering.data.evaluation import incidences_of, is_isotropic, totals
    from ..engine.scattering.data.table import rotations_around
    from ..engine.scene.scattering import ScatterTable

    if is_isotropic(scatter):
        rotations = np.zeros(1)
    elif isinstance(scatter, ScatterTable):
        rotations = rotations_around(scatter)
    else:
        # Twice as many as the finest Klems ring has patches, so that each counts alike.
        rotations = np.arange(48) * np.pi / 24.0
    incidences = incidences_of(scatter) if incidences is None else incidences
    made = luminous_mean(scatter.wavelengths, totals(scatter, incidences, rotations))
    # Rotations may lie unevenly; between them totals are linear.
    gaps = np.diff(rotations, append=rotations[0] + 2.0 * np.pi)
    return np.average(made, axis=0, weights=gaps + np.roll(gaps, 1))


def _numbers(values) -> list:
    return [_number(value) for value in values]


def _number(value) -> float | None:
    """Six digits; None for what is no number."""
    value = float(value)
    return float(f"{value:.6g}") if math.isfinite(value) else None


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
    if row["name"]:
        add("name", row["name"])
    add("symmetry", row["symmetry"])
    nm = row["wavelengths_nm"]
    add("wavelengths", "neutral" if len(nm) == 1 else f"{len(nm)}, {nm[0]:g} to {nm[-1]:g} nm")
    add("incidence", " ".join(f"{angle:g}" for angle in row["incidence_deg"]) + " deg")
    for label, key in (
        ("reflectance", "hemispherical_reflectance"),
        ("transmittance", "hemispherical_transmittance"),
    ):
        if row[key] is not None:
            add(label, " ".join(f"{value:.4f}" for value in row[key]))
    for side, own in row["sides"].items():
        text = side.replace("_", " ")
        text += f", {own['values']:,} values".replace(",", " ").replace("  ", ", ", 1)
        if own["stated_error"]:
            text += f", resampled with an error of {100 * own['stated_error']:.2g} %"
        if own["direct"]:
            text += ", with a direct part"
        add("side", text)
    if row["reciprocity_residual"] is not None:
        text = f"residual {100 * row['reciprocity_residual']:.3g} %"
        add("reciprocity", f"{text}, beside peaks {100 * row['reciprocity_beside_peaks']:.3g} %")
    for i, warning in enumerate(row["warnings"]):
        add("warnings" if i == 0 else "", warning)
    return "\n".join(lines)


# ---- checks ----


def _check(options) -> int:
    rows = []
    for name in options.files:
        try:
            row = {"file": name, "checks": judge(_open(options, name))}
        except FileFormatError as error:
            row = {"file": name, "error": str(error)}
        rows.append(row)
        if not options.json:
            say(_tell_checks(row))
    if options.json:
        say(json.dumps(rows, indent=2, allow_nan=False))
    bad = any("error" in row or not all(c["good"] for c in row["checks"]) for row in rows)
    return int(bad)


def judge(file) -> list[dict]:
    """Check a file: rows with ``what``, ``good`` and ``text``."""
    import numpy as np

    from ..engine.scattering.data.evaluation import incidences_of, measure_reciprocity
    from ..engine.scattering.data.surface import excess_of

    made = []

    def add(what, good, text):
        made.append({"what": what, "good": bool(good), "text": text})

    for side in ("front", "back"):
        parts = [file.sides.get(f"{side}_{kind}") for kind in ("reflection", "transmission")]
        if any(part is not None for part in parts):
            excess = excess_of(*parts)
            text = f"{side}: at most {excess:.4f} of the light leaves again"
            if excess > 1.0 + ENERGY_ROUNDING:
                text += "; values look like luminance factors or per cent, or are badly calibrated"
            add("energy", excess <= 1.0 + ENERGY_ROUNDING, text)
    for side in ("front", "back"):
        scatter = file.sides.get(f"{side}_reflection")
        if scatter is not None:
            found = measure_reciprocity(scatter)
            add(
                "reciprocity",
                found.worst <= GOOD_RECIPROCITY,
                f"{side}: {_tell_reciprocity(found)}",
            )
    both = [file.sides.get(f"{side}_transmission") for side in ("front", "back")]
    if all(part is not None for part in both):
        found = measure_reciprocity(*both)
        text = f"transmission of both sides: {_tell_reciprocity(found)}"
        add("reciprocity", found.worst <= GOOD_RECIPROCITY, text)
    for side, stated in file.stated.items():
        if np.isfinite(stated).any():
            worst, incidence = _off_by(file, side, stated)
            text = (
                f"{side.replace('_', ' ')}: the file's values are at most {worst:.4f} from the totals that it states "
                f"(at {np.degrees(incidence):.3g} deg)"
            )
            add("stated totals", worst <= STATED_TOLERANCE, text)
    for side, scatter in file.sides.items():
        last = float(np.degrees(incidences_of(scatter)[-1]))
        text = f"{side.replace('_', ' ')}: data up to {last:.4g} deg; beyond, the last hold"
        add("incidences", last >= STEEP_INCIDENCE, text)
    return made


def _tell_reciprocity(found) -> str:
    return (
        f"residual {found.residual:.4f}, beside peaks {found.scattered:.4f}, largest difference {found.largest:.4f} of "
        "the largest value"
    )


def _off_by(file, side: str, stated) -> tuple[float, float]:
    """Largest difference of stated totals from those of the values as they stand in the file [-], and its incidence [rad].

    Readers bring values to stated totals; what these were before, the factors tell.
    """
    import numpy as np

    known = np.isfinite(stated)
    places = file.incidences[known]
    factors = file.factors.get(side)
    if factors is None:
        differences = np.abs(_totals(file.sides[side], file.incidences) - stated)[known]
    else:
        told = np.interp([place for place, _ in factors], places, stated[known])
        differences = np.abs(told * (1.0 - 1.0 / np.array([factor for _, factor in factors])))
        places = np.array([place for place, _ in factors])
    worst = int(np.argmax(differences)) if len(differences) else 0
    return (float(differences[worst]), float(places[worst])) if len(differences) else (0.0, 0.0)


def _tell_checks(row: dict) -> str:
    if "error" in row:
        return tell(row)
    lines = [row["file"]]
    for check in row["checks"]:
        lines.append(f"  {'good' if check['good'] else 'BAD':<6}{check['what']:<16}{check['text']}")
    return "\n".join(lines) + "\n"


# ---- pictures, conversion, processing ----


def _plot(options) -> int:
    from ..engine.analysis.scattering_picture import draw_albedo_chart, draw_polar_cuts

    if not 240 <= options.size <= LARGEST_PICTURE:
        raise LumenrayError(f"a width of {options.size} pixels, expected 240 to {LARGEST_PICTURE}")
    file = _open(options, options.file)
    size = (options.size, options.size * 3 // 4)
    if options.totals:
        picture = draw_albedo_chart(file, size=size, dark=options.dark)
    else:
        if not any(side.startswith(options.side) for side in file.sides):
            raise FileFormatError(
                options.file, f"has no data for light that comes to the {options.side}"
            )
        picture = draw_polar_cuts(
            file,
            options.incidences,
            options.side,
            size=size,
            dark=options.dark,
            rotation=math.radians(options.rotation),
        )
    _save(picture, options.output)
    return 0


def _save(picture, path: Path) -> None:
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        picture.save(path)
    except OSError as error:
        raise FileFormatError(path, f"cannot be written ({error.strerror})") from None
    except ValueError:
        raise FileFormatError(path, "expected a name that ends in .png") from None
    say(f"written to {path}")


def _check_free(options) -> None:
    if options.output.exists() and not options.force:
        raise FileFormatError(options.output, "is there already; --force replaces it")


def _convert(options) -> int:
    from ..engine.scattering.data.store import write_store
    from ..engine.scattering.data.surface import make_reciprocal
    from ..engine.scene.scattering import ScatterTable

    _check_free(options)
    ending = options.output.suffix.lower()
    if ending not in ENDINGS:
        raise FileFormatError(
            options.output,
            f"'{ending}' is no format that is written, expected {' or '.join(ENDINGS)}",
        )
    file = _open(options, options.file)
    for remark in file.remarks:
        say(f"{options.file}: {remark}")
    if options.reciprocal:
        made: dict[int, object] = {}
        for side, scatter in file.sides.items():
            if side.endswith("reflection") and isinstance(scatter, ScatterTable):
                made.setdefault(id(scatter), make_reciprocal(scatter))
        file = replace(file, sides={s: made.get(id(x), x) for s, x in file.sides.items()})
    if options.limit:
        file = _limit(file)
    if ending == ".bsdf":
        _write_rgl(options, file)
    else:
        write_store(options.output, file)
    say(f"written to {options.output} ({options.output.stat().st_size:,} bytes)")
    return 0


def _limit(file):
    from ..engine.scattering.data.surface import usable
    from ..engine.scene.material import Measured

    used = usable(Measured(**file.sides))
    return replace(file, sides={side: getattr(used, side) for side in file.sides})


def _write_rgl(options, file) -> None:
    """Write the front's reflection as an RGL file, and tell its error; refuse one that is larger than was asked for."""
    from ..engine.scattering.data.evaluation import is_isotropic
    from ..engine.scattering.readers.reader import Wish
    from ..engine.scattering.tensor_writer import make_tensor_file

    path, scatter = options.output, file.sides.get("front_reflection")
    if scatter is None or not is_isotropic(scatter) or getattr(scatter, "direct", None) is not None:
        raise FileFormatError(
            path, "RGL files hold an isotropic reflection without a direct part; write .lumbsdf"
        )
    wish = Wish() if options.tolerance is None else Wish(options.tolerance, is_strict=True)
    data, error = make_tensor_file(scatter, wish.tolerance)
    if wish.is_strict and error > wish.tolerance:
        raise FileFormatError(
            path,
            f"would have an error of {error:.3g} against {options.file}, more than the {wish.tolerance:.3g} that are "
            "allowed, on the finest grid that RGL files are given; write .lumbsdf",
        )
    try:
        path.write_bytes(data)
    except OSError as failure:
        raise FileFormatError(path, f"cannot be written ({failure.strerror})") from None
    told = f"{path}: its error against {options.file} is {100 * error:.2g} %"
    if error > wish.tolerance:
        told += f", more than the {100 * wish.tolerance:.2g} % that are allowed"
    say(told)


def _process(options) -> int:
    from ..engine.analysis.scattering_picture import draw_before_after
    from ..engine.scattering.data.record import ScatteringFile
    from ..engine.scattering.data.store import write_store
    from ..engine.scattering.measuring.processing import process_measurement
    from ..engine.scattering.measuring.raw_measurement import read_raw_measurement
    from ..engine.scattering.readers.reader import read_content

    _check_free(options)
    data = read_content(options.file)
    made = process_measurement(read_raw_measurement(data, options.file))
    for remark in made.remarks:
        say(f"{options.file}: {remark}")
    file = ScatteringFile(
        options.output,
        "processed measurement",
        {"front_reflection": made.table},
        options.file.stem,
        source=f"processed from {options.file.name}",
        remarks=made.remarks,
    )
    write_store(options.output, file)
    say(
        f"residual {100 * made.residual:.2g} %, statistical error {100 * made.statistical_error:.2g} %, calibration "
        f"{100 * made.calibration_error:.2g} %, reciprocity {100 * made.reciprocity:.2g} %, "
        f"{100 * made.missing:.3g} % of the directions filled"
    )
    say(f"written to {options.output} ({options.output.stat().st_size:,} bytes)")
    if options.report is not None:
        _save(draw_before_after(made), options.report)
    return 0
