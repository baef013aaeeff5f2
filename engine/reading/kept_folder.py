"""Where what was computed is kept for this user, so that it is not computed again."""

import os
import sys
from pathlib import Path


def kept_folder(name: str) -> Path:
    """Return the folder of a kind of results; ``LUMENRAY_<NAME>_CACHE`` in the environment names another.

    Parameters
    ----------
    name : str    Of the kind, in the singular and in lower case.
    """
    other = os.environ.get(f"LUMENRAY_{name.upper()}_CACHE")
    if other is not None:
        return Path(other)
    if sys.platform == "win32":
        base = Path(os.environ.get("LOCALAPPDATA", Path.home()))
    else:
        base = Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache"))
    return base / "lumenray" / f"{name}s"
