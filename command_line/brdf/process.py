"""The command ``lumenray brdf process``: a table of a raw measurement."""

from pathlib import Path

from ..output import add_conversion, check_free, percent, save_picture, say


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    process = tasks.add_parser("process", help="make a table of a raw measurement")
    add_conversion(process, "raw measurement", "table to write, .lumbsdf")
    process.add_argument(
        "--report", type=Path, metavar="OUT.png", help="cuts before and after as a picture"
    )
    process.set_defaults(run=run)


def run(options) -> int:
    """Make a table of a measurement; return the exit code."""
    from ...engine.analysis.scattering_picture import draw_before_after
    from ...engine.scattering.data.record import ScatteringFile
    from ...engine.scattering.data.store import write_store
    from ...engine.scattering.measuring.processing import process_measurement
    from ...engine.scattering.measuring.raw_measurement import read_raw_measurement
    from ...engine.scattering.readers.reader import read_content

    check_free(options, options.output, options.report)
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
        f"residual {percent(made.residual, '.2g')}, statistical error {percent(made.statistical_error, '.2g')}, calibration "
        f"{percent(made.calibration_error, '.2g')}, reciprocity {percent(made.reciprocity, '.2g')}, "
        f"{percent(made.missing, '.3g')} of the directions filled"
    )
    say(f"written to {options.output} ({options.output.stat().st_size:,} bytes)")
    if options.report is not None:
        save_picture(draw_before_after(made), options.report)
    return 0
