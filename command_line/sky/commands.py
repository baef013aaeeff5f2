"""The door of the commands ``lumenray sky``."""

from ..options import add_group
from . import info, plot

EPILOG = """examples:
  lumenray sky info --place Berlin --time 2026-06-21T12:00
  lumenray sky info --latitude -33.87 --longitude 151.21 --zone Australia/Sydney --time 2026-12-21T12:00
  lumenray sky info --weather berlin.epw
  lumenray sky plot --place Berlin --time 2026-06-21T10:00 --cie 12 -o clear.png
  lumenray sky plot --weather berlin.epw --time 2026-03-20T14:30 -o hour.png
  lumenray sky plot --measured scan.sky -o scan.png

Places are cities of the library or coordinates, positive to the north and to the east. Times are those of the place's
clocks, with daylight saving time where the zone has it; a weather file's are standard time unless --zone is given. Weather
files are EPW or WEA.
"""


def add_command(commands) -> None:
    """Describe the commands to argparse."""
    words = "sun, skies and weather files: numbers, pictures"
    add_group(commands, "sky", words, EPILOG, (info, plot))
