"""The command ``lumenray brdf convert``: a scattering file as our table, or as an RGL file."""

from dataclasses import replace

from ...engine.errors import FileFormatError
from ..output import add_conversion, check_free, percent, say
from .file import add_tolerance, open_scattering

ENDINGS = (".lumbsdf", ".bsdf")


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    convert = tasks.add_parser("convert", help="write a file as our table, or as an RGL file")
    add_conversion(convert, "scattering file", "the end of its name says: .lumbsdf or .bsdf (RGL)")
    convert.add_argument(
        "--reciprocal", action="store_true", help="make tables of reflection reciprocal"
    )
    convert.add_argument(
        "--limit", action="store_true", help="scale down what would make light from nothing"
    )
    add_tolerance(convert)
    convert.set_defaults(run=run)


def run(options) -> int:
    """Write a file in another format; return the exit code."""
    from ...engine.scattering.data.store import write_store
    from ...engine.scattering.data.surface import make_reciprocal
    from ...engine.scene.scattering import ScatterTable

    check_free(options, options.output)
    ending = options.output.suffix.lower()
    if ending not in ENDINGS:
        raise FileFormatError(
            options.output,
            f"'{ending}' is no format that is written, expected {' or '.join(ENDINGS)}",
        )
    file = open_scattering(options, options.file)
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
    from ...engine.scattering.data.surface import usable
    from ...engine.scene.material import Measured

    used = usable(Measured(**file.sides))
    return replace(file, sides={side: getattr(used, side) for side in file.sides})


def _write_rgl(options, file) -> None:
    """Write the front's reflection as an RGL file, and tell its error; refuse one that is larger than was asked for."""
    from ...engine.reading.whole_file import write_whole
    from ...engine.scattering.readers.reader import Wish
    from ...engine.scattering.tensor_writer import make_tensor_file

    path, scatter = options.output, file.sides.get("front_reflection")
    if scatter is None or not scatter.is_isotropic or getattr(scatter, "direct", None) is not None:
        raise FileFormatError(
            path, "RGL files hold an isotropic reflection without a direct part; write .lumbsdf"
        )
    wish = Wish() if options.tolerance is None else Wish(options.tolerance, is_strict=True)
    data, error = make_tensor_file(scatter, wish.tolerance)
    if wish.is_strict and error > wish.tolerance:
        raise FileFormatError(
            path,
            f"would have an error of {percent(error)} against {options.file}, more than the {percent(wish.tolerance)} that "
            "are allowed, on the finest grid that RGL files are given; write .lumbsdf",
        )
    with write_whole(path) as stream:
        stream.write(data)
    told = f"{path}: its error against {options.file} is {percent(error, '.2g')}"
    if error > wish.tolerance:
        told += f", more than the {percent(wish.tolerance, '.2g')} that are allowed"
    say(told)
