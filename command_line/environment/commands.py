"""The door of the commands ``lumenray environment``."""

from ..options import add_group
from . import analyse, extract, repair

EPILOG = """examples:
  lumenray environment analyse street.hdr -o street.png
  lumenray environment analyse street.hdr --lux 43000 --json
  lumenray environment extract street.hdr -o clipped.exr --lights lights.json
  lumenray environment repair street.hdr -o mended.exr --ratio 4
  lumenray environment repair yard.hdr -o mended.exr --place Berlin --date 2026-05-20 --half morning --sky 812,140

Pictures are equirectangular, Radiance's (.hdr) or OpenEXR (.exr); their middle lies along +X, their left edge along -X, and
azimuths count from +Y over +X as on a compass. Pixels count from the left and from the top.
"""


def add_command(commands) -> None:
    """Describe the commands to argparse."""
    words = "pictures of the surroundings: what they hold, their sun taken out or mended"
    add_group(commands, "environment", words, EPILOG, (analyse, extract, repair))
