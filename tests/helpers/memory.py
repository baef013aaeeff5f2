"""Memory of this process."""

import resource
import sys


def peak_memory() -> int:
    """Most memory that this process ever held. [byte]"""
    unit = 1 if sys.platform == "darwin" else 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * unit
