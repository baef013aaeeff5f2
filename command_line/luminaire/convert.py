"""The command ``lumenray luminaire convert``: a photometric file written in another format."""

from ..output import add_conversion, check_free, say


def add_command(tasks) -> None:
    """Describe the command to argparse."""
    convert = tasks.add_parser("convert", help="write a photometric file in another format")
    add_conversion(convert, "photometric file", "the end of its name says the format: .ies, .ldt")
    convert.set_defaults(run=run)


def run(options) -> int:
    """Write a file in another format; return the exit code."""
    from ...engine.luminaires.formats.reader import read_luminaire, write_luminaire

    check_free(options, options.output)
    file = read_luminaire(options.file)
    remarks = write_luminaire(file, options.output)
    for path, found in ((options.file, file.remarks), (options.output, remarks)):
        for remark in found:
            say(f"{path}: {remark}")
    say(f"written to {options.output}")
    return 0
