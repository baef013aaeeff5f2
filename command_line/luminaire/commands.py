"""The door of the commands ``lumenray luminaire``, which need neither Blender nor Mitsuba.

Only the making of asset libraries needs both.
"""

from ..options import add_group
from . import convert, info, library, plot, ugr

EPILOG = """examples:
  lumenray luminaire info downlight.ies
  lumenray luminaire info --json catalogue/ "more/*.ldt" > luminaires.json
  lumenray luminaire plot downlight.ies -o downlight.png
  lumenray luminaire ugr downlight.ldt
  lumenray luminaire convert street.ldt street.ies
  lumenray luminaire library ~/luminaires

Angles are the luminaire's own: gamma from its downward axis, C counter-clockwise seen from above.
"""


def add_command(commands) -> None:
    """Describe the commands to argparse."""
    words = "photometric files: numbers, polar diagram, glare, conversion"
    add_group(commands, "luminaire", words, EPILOG, (info, plot, ugr, convert, library))
