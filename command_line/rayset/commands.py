"""The door of the commands ``lumenray rayset``."""

from ..options import add_group
from . import convert, info, plot, prepare, reduce

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


def add_command(commands) -> None:
    """Describe the commands to argparse."""
    words = "ray files: numbers, pictures, photometric files, conversion"
    add_group(commands, "rayset", words, EPILOG, (info, plot, reduce, convert, prepare))
