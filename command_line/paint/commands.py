"""The door of the commands ``lumenray paint``."""

from ..options import add_group
from . import compute, fit, plot

EPILOG = """examples:
  lumenray paint compute violet_pearl -o violet.lumbsdf
  lumenray paint compute mine.json --constituents makers.json -o mine.lumbsdf --fine
  lumenray paint plot colour_travel -o colour_travel.png
  lumenray paint fit start.json --lab readings.csv -o found.json
  lumenray paint fit start.json --brdf carpaint.bsdf --look-for layers/0/flakes/0/tilt_deg:1:15 -o found.json

FILE is a composition (JSON, the guide tells its form) or the name of one that ships.
"""


def add_command(commands) -> None:
    """Describe the commands to argparse."""
    words = "effect paints from their composition: tables, colours, compositions from readings"
    add_group(commands, "paint", words, EPILOG, (compute, plot, fit))
