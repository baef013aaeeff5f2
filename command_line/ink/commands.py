"""The door of the commands ``lumenray ink``."""

from ..options import add_group
from . import compute, plot

EPILOG = """examples:
  lumenray ink compute cyan_fine --draft
  lumenray ink compute mine.json -o mine.lumbsdf --realisations 8 --jobs 4
  lumenray ink plot magenta_coarse -o magenta.png

FILE is a composition (JSON, the guide tells its form) or the name of one that ships. What was solved is kept, and a job that
was ended goes on where it was.
"""


def add_command(commands) -> None:
    """Describe the commands to argparse."""
    words = "dense pigment layers by the wave equation: tables, colours, spectra"
    add_group(commands, "ink", words, EPILOG, (compute, plot))
