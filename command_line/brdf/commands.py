"""The door of the commands ``lumenray brdf``."""

from ..options import add_group
from . import check, convert, info, library, plot, process

EPILOG = """examples:
  lumenray brdf info paint.bsdf
  lumenray brdf info --json *.xml > materials.json
  lumenray brdf plot paint.bsdf -o paint.png
  lumenray brdf check blinds.xml
  lumenray brdf convert alum_bronze.bsdf alum_bronze.lumbsdf --tolerance 1%
  lumenray brdf process raw.csv sample.lumbsdf --report sample.png
  lumenray brdf library ~/materials

Formats (Zemax, LightTools, WINDOW XML, RGL, MERL, SPEOS, MDL, goniometer tables, our own) are told apart by the content of
a file. Totals are hemispherical, weighed by V(lambda) at equal energy, the direct part included.
"""


def add_command(commands) -> None:
    """Describe the commands to argparse."""
    words = "measured materials: numbers, pictures, checks, conversion, processing"
    add_group(commands, "brdf", words, EPILOG, (info, plot, check, convert, process, library))
