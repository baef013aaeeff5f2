"""LLVM for Dr.Jit: the shared library that Lumenray ships, for platforms on which Dr.Jit needs one."""

from pathlib import Path

LIBRARY = Path(__file__).parent / "lib" / "@LIBRARY@"
"""Path of the library. Nothing is loaded by importing this module."""

VERSION = "@VERSION@"
"""Version of LLVM."""
