"""The door of the commands ``lumenray spectrum``."""

from ..options import add_group
from . import info, plot

EPILOG = """examples:
  lumenray spectrum info lamp.spdx reflectance.csv
  lumenray spectrum info --json lamps.csv --column 3
  lumenray spectrum plot lamp.spdx -o lamp.png

Files are text or CSV with wavelengths in nm and one or more columns of values, CGATS text of instruments (.txt, .sp of
ArgyllCMS; --column chooses the sample), or IES TM-27 (.spdx). Efficacy counts all radiation in the file, ultraviolet and
infrared included.
"""


def add_command(commands) -> None:
    """Describe the commands to argparse."""
    words = "files of spectra: numbers, pictures"
    add_group(commands, "spectrum", words, EPILOG, (info, plot))
