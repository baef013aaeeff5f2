"""The door of the commands ``lumenray luminaire``, which need neither Blender nor Mitsuba.

Only the making of asset libraries needs both, and the schedule of a scene Blender.
"""

from ..options import add_group
from . import convert, info, library, plot, schedule, ugr

EPILOG = """examples:
  lumenray luminaire info downlight.ies
  lumenray luminaire info --json catalogue/ "more/*.ldt" > luminaires.json
  lumenray luminaire plot downlight.ies -o downlight.png
  lumenray luminaire ugr downlight.ldt
  lumenray luminaire convert street.ldt street.ies
  lumenray luminaire schedule office.blend --area 48 --lux 512
  lumenray luminaire library ~/luminaires

Angles are the luminaire's own: gamma from its downward axis, C counter-clockwise seen from above.
"""


def add_command(commands) -> None:
    """Describe the commands to argparse."""
    words = "photometric files: numbers, polar diagram, glare, conversion"
    add_group(commands, "luminaire", words, EPILOG, (info, plot, ugr, schedule, convert, library))
