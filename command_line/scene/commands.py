"""The group of commands ``lumenray scene``."""

from ..options import add_group
from . import edit, take

EPILOG = """examples:
  lumenray scene take room.glb -o room.blend --content room.json
  lumenray scene edit room.blend --edits edits.json -o dimmed.blend

edits.json has what is to be changed, by name:
  {"lights": {"Spot": {"flux": 900, "dimming": 0.5, "temperature": 3000, "is_on": true}},
   "hidden": ["Chair"], "materials": {"Wall Paint": "wall_white_matt"}}
"""


def add_command(commands) -> None:
    """Describe the group to argparse."""
    add_group(commands, "scene", "what is in a file, and changes of it", EPILOG, (take, edit))
