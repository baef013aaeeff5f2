"""Runs of the command `lumenray`."""

from lumenray.command_line.main import main


def run_command(name, capsys, *arguments):
    """Return exit code, standard output and standard error of a command."""
    code = main([name, *map(str, arguments)])
    printed = capsys.readouterr()
    return code, printed.out, printed.err
