"""The door of the commands ``lumenray cloth``."""

from ..options import add_group
from . import close_up, compute, fit, mesh, plot

EPILOG = """examples:
  lumenray cloth compute cotton -o cotton.lumbsdf
  lumenray cloth compute screen_5 --json
  lumenray cloth plot polyester_satin -o satin.png
  lumenray cloth fit --openness 5% --transmittance 14% --reflectance 55% -o screen.json
  lumenray cloth close-up red_cotton -o threads.png
  lumenray cloth mesh wool -o wool.obj --repeats 4

FILE is a composition (JSON, the guide tells its form) or the name of one that ships.
"""


def add_command(commands) -> None:
    """Describe the commands to argparse."""
    words = "cloths from their yarns and weave: tables, numbers of data sheets, close-ups, meshes"
    add_group(commands, "cloth", words, EPILOG, (compute, plot, fit, close_up, mesh))
