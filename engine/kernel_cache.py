"""The folder where Dr.Jit keeps compiled kernels: those that are new tell people what they wait for."""

import os
import sys
import tempfile
import time
from pathlib import Path

ENDING = ".bin"

LOOK = 1.0
"""Time between two looks into the folder. [s]"""


def kernel_folder() -> Path:
    """Return where Dr.Jit keeps kernels for later."""
    chosen = os.environ.get("DRJIT_CACHE_DIR")
    if chosen:
        return Path(chosen)
    if sys.platform == "win32":
        return Path(tempfile.gettempdir()) / "drjit"
    return Path.home() / ".drjit"


class NewKernels:
    """Kernels that have come into the folder since this was made, whoever compiled them."""

    def __init__(self):
        self._known = _names()
        self._looked = time.monotonic()
        self.count = 0

    def look(self) -> bool:
        """Count them, at most once a second; tell whether there are more than before."""
        if time.monotonic() - self._looked < LOOK:
            return False
        before, self.count = self.count, len(_names() - self._known)
        self._looked = time.monotonic()
        return self.count > before

    @property
    def words(self) -> str:
        """What there is to say of them."""
        return f"compiling kernels, {self.count} so far, which are kept for next time"


def _names() -> frozenset[str]:
    try:
        return frozenset(path.name for path in kernel_folder().glob(f"*{ENDING}"))
    except OSError:
        # There is none yet, or it cannot be read: then nothing is told.
        return frozenset()
