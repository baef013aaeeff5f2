"""The judgement of a zip that was built: by reading it, and by Blender itself."""

import importlib.util
import os
import shlex
import subprocess
import sys
from pathlib import Path

from checks import check_zip
from project import BuildError


def judge_zip(path: Path, version: str) -> str:
    """Have a zip checked; return a line about it, or raise `BuildError`."""
    check_zip(path, version)
    judges = " and by ".join(filter(None, ("reading it", ask_blender(path))))
    return f"{path}  {path.stat().st_size / 1e6:.0f} MB, checked by {judges}"


def ask_blender(path: Path) -> str:
    """Let Blender judge a zip: the one that the variable LUMENRAY_JUDGE names, else the scripts of its Python module.

    Returns
    -------
    str    Who judged it; empty where there is no Blender.

    Raises
    ------
    BuildError    It is refused.
    """
    blender = os.environ.get("LUMENRAY_JUDGE")
    if blender:
        who, command = "Blender", [*shlex.split(blender), "--command", "extension"]
    elif script := _find_script():
        who, command = "the scripts of Blender's Python module", [sys.executable, str(script)]
    else:
        return ""
    done = subprocess.run(
        [*command, "validate", str(path)], capture_output=True, text=True, check=False
    )
    if done.returncode:
        raise BuildError(f"Blender refuses {path.name}:\n{done.stdout}{done.stderr}")
    return who


def _find_script() -> Path | None:
    """Return Blender's command for extensions, which needs no Blender to run."""
    module = importlib.util.find_spec("bpy")
    if module is None or module.origin is None:
        return None
    folder = Path(module.origin).parent
    return next(folder.glob("*/scripts/addons_core/bl_pkg/cli/blender_ext.py"), None)
