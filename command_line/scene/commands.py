"""The group of commands ``lumenray scene``."""

from ..options import add_group
from . import edit, take

EPILOG = """examples:
  lumenray scene take room.glb -o room.blend --content room.json
  lumenray scene edit room.blend --edits edits.json -o dimmed.blend

edits.json has what is to be changed, by name:
  {"lights": {"Spot": {"flux": 900, "dimming": 0.5, "spectrum": "LED-B3", "is_on": true}, "Lamp": {"temperature": 3000}},
   "hidden": ["Chair"], "materials": {"Wall Paint": "wall_white_matt", "Door": {"scene": "Oak"}}}
A spectrum is an illuminant of the CIE by its name, or a file as 'lumenray spectrum info' reads them:
  {"file": "lamp.csv", "text": "380 0.1\\n381 0.12\\n...", "column": 1}
Its text is written into a folder beside OUT.blend, OUT.spectra.
"""


def add_command(commands) -> None:
    """Describe the group to argparse."""
    add_group(commands, "scene", "what is in a file, and changes of it", EPILOG, (take, edit))
