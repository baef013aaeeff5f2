"""The command ``lumenray``: pictures, lux maps and sensor readings of a .blend file, and photometric files; no window."""

import os
import sys
from importlib import import_module

from ..engine import VERSION
from ..engine.errors import LumenrayError
from .options import Parser
from .output import complain

MODULES = {
    "render": "render",
    "bake": "bake",
    "mix": "mix",
    "measure": "measure",
    "observe": "observe",
    "difference": "difference",
    "goniometer": "goniometer",
    "daylight": "daylight.command",
    "explain": "explain",
    "sensitivity": "sensitivity",
    "luminaire": "luminaire.commands",
    "rayset": "rayset.commands",
    "brdf": "brdf.commands",
    "paint": "paint.commands",
    "cloth": "cloth.commands",
    "ink": "ink.commands",
    "spectrum": "spectrum.commands",
    "sky": "sky.commands",
    "environment": "environment.commands",
    "glare": "glare",
    "report": "report",
    "requirements": "requirements",
    "scene": "scene.commands",
    "road": "road",
    "probe": "probe",
    "serve": "serve",
    "cluster": "cluster.commands",
    "validate": "validate",
    "demo": "demo",
    "benchmark": "benchmark",
}
"""Modules of the commands, in the order in which they are told. A command loads no other's code."""

EPILOG = """examples:
  lumenray render office.blend -o office.exr --samples 128
  lumenray bake office.blend -o lux --objects "Floor,Desk Top A" --lumels-per-m 20 --error 1%
  lumenray bake office.blend -o lux --error-lx 5 --time 600 --layers groups --gltf office.glb
  lumenray measure office.blend -o sensors.csv --plans plans
  lumenray report office.blend -o report.html --pdf report.pdf
  lumenray measure office.blend --sensors grid.csv -o readings.csv --error 0.5%
  lumenray daylight office.blend --weather town.epw --floor Floor -o daylight
  lumenray explain office.blend
  lumenray luminaire info downlight.ies
  lumenray rayset info led.ray
  lumenray brdf info paint.bsdf
  lumenray paint plot colour_travel -o colour_travel.png
  lumenray ink compute cyan_fine --draft
  lumenray sky info --place Berlin --time 2026-06-21T12:00
  lumenray environment analyse street.hdr
  lumenray glare fisheye.exr
  lumenray cluster local -n 2
  lumenray road street.ldt --width 7 --lanes 2 --spacing 30 --height 8 --require road.m4

All answers are in photometric units (lx, cd/m2) and carry their standard error. The same seed gives the same answer.
"""


def build_parser(wanted: str | None = None) -> Parser:
    """Describe the command line: all of it, or the part of one command.

    Parameters
    ----------
    wanted : str or None    What stands first on the command line.
    """
    parser = Parser(
        prog="lumenray",
        description="Lighting of Blender scenes in real units, with a stated error.",
        epilog=EPILOG,
    )
    parser.add_argument("--version", action="version", version=f"lumenray {VERSION}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name in [wanted] if wanted in MODULES else MODULES:
        import_module(f".{MODULES[name]}", __package__).add_command(commands)
    return parser


def main(arguments=None) -> int:
    """Run the command; 0 on success, 1 with one line on standard error on any failure, else see `assumptions.CODES`."""
    arguments = sys.argv[1:] if arguments is None else arguments
    options = build_parser(next(iter(arguments), None)).parse_args(arguments)
    try:
        return options.run(options)
    except LumenrayError as error:
        complain(error)
    except KeyboardInterrupt:
        complain("stopped")
    except MemoryError:
        complain("there is not enough memory for this")
    except OSError as error:
        # Who reads the output may have had enough of it.
        if not isinstance(error, BrokenPipeError):
            complain(f"{error.filename or 'the output'} cannot be used ({error.strerror})")
        if error.filename is None:
            _forget_output()
    return 1


def _forget_output() -> None:
    """Let nothing be said at the end of what could not be written."""
    os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


if __name__ == "__main__":
    sys.exit(main())
