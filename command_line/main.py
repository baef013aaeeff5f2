"""The command ``lumenray``: pictures, lux maps and sensor readings of a .blend file, and photometric files; no window."""

import os
import sys

from ..engine import VERSION
from ..engine.errors import LumenrayError
from . import (
    bake,
    benchmark,
    demo,
    difference,
    explain,
    glare,
    goniometer,
    measure,
    mix,
    observe,
    probe,
    render,
    report,
    requirements,
    road,
    sensitivity,
    validate,
)
from .brdf import commands as brdf
from .daylight import command as daylight
from .environment import commands as environment
from .luminaire import commands as luminaire
from .options import Parser
from .output import complain
from .rayset import commands as rayset
from .sky import commands as sky
from .spectrum import commands as spectrum

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
  lumenray sky info --place Berlin --time 2026-06-21T12:00
  lumenray environment analyse street.hdr
  lumenray glare fisheye.exr
  lumenray road street.ldt --width 7 --lanes 2 --spacing 30 --height 8 --require road.m4

All answers are in photometric units (lx, cd/m2) and carry their standard error. The same seed gives the same answer.
"""


def build_parser() -> Parser:
    """Describe the command line."""
    parser = Parser(
        prog="lumenray",
        description="Lighting of Blender scenes in real units, with a stated error.",
        epilog=EPILOG,
    )
    parser.add_argument("--version", action="version", version=f"lumenray {VERSION}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for command in (
        render, bake, mix, measure, observe, difference, goniometer, daylight, explain, sensitivity, luminaire, rayset, brdf,
        spectrum, sky, environment, glare, report, requirements, road, probe, validate, demo, benchmark,
    ):  # fmt: skip
        command.add_command(commands)
    return parser


def main(arguments=None) -> int:
    """Run the command; 0 on success, 1 with one line on standard error on any failure, else see `assumptions.CODES`."""
    options = build_parser().parse_args(arguments)
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
