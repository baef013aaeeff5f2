"""The command ``lumenray rayset reduce``: the intensities of a ray file as a photometric file."""

from ..options import real, whole
from ..output import add_conversion, check_free, percent, say
from ..progress import Bar
from .file import add_assumptions, open_rayset, reduce_pieces, survey_light


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    reduce = tasks.add_parser("reduce", help="write the intensities as a photometric file")
    add_conversion(reduce, "ray file", "the end of its name says the format: .ies, .ldt")
    reduce.add_argument(
        "--step",
        type=real(0.1, 15.0),
        metavar="DEG",
        help="between angles (default: a tenth of the beam's half angle, at most 5)",
    )
    reduce.add_argument(
        "--planes",
        type=whole(1, 720),
        metavar="N",
        help="C-planes (default: 24, or 1 where all are the same but for noise)",
    )
    add_assumptions(reduce)
    reduce.set_defaults(run=run)


def run(options) -> int:
    """Write the intensities of a file; return the exit code."""
    from ...engine.luminaires.distribution import flux
    from ...engine.luminaires.formats.reader import write_luminaire
    from ...engine.raysets.reduction import to_luminaire

    check_free(options, options.output)
    file = open_rayset(options, options.file)
    with Bar(str(options.file)) as bar:
        survey, light = survey_light(file, bar)
        pieces = [(direction, amount) for _, direction, amount in light.pieces()]
    reduced = reduce_pieces(pieces, options.step, options.planes)
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
        told += f", own error {percent(light.cloud.information_error, '.1f')}"
    say(f"written to {options.output} ({told})")
    return 0
