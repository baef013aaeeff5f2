"""LLVM, with which Dr.Jit compiles kernels for the CPU: where its library lies."""

import ctypes
import glob
import importlib.util
import os
import re
import sys
from pathlib import Path

BUNDLE = "lumenray_llvm"
"""Package that holds the library which is shipped (`packaging/llvm_wheel.py`)."""

SYSTEM_PATTERNS = {
    "linux": (
        "/usr/lib/*/libLLVM*.so*",
        "/usr/lib/llvm-*/lib/libLLVM*.so*",
        "/usr/lib64/libLLVM*.so*",
        "/usr/local/lib/libLLVM*.so*",
    ),
    "darwin": (
        "/opt/homebrew/opt/llvm*/lib/libLLVM*.dylib",
        "/usr/local/opt/llvm*/lib/libLLVM*.dylib",
    ),
    "win32": ("C:/Program Files/LLVM/bin/LLVM-C.dll",),
}
"""Where a system's libLLVM usually lies, by `sys.platform`."""

OLDEST = 17
"""Dr.Jit 1.5 refuses LLVM before 15; 15 and 16 cannot translate `llvm.maximum` and end the process (seen with AVX-512)."""

REMEDY = {
    "linux": "install Lumenray with the zip for this platform, which brings LLVM, or install libllvm19",
    "darwin": "install LLVM with 'brew install llvm'",
    "win32": "install Lumenray with the zip for this platform, which brings LLVM",
}.get(sys.platform, f"install LLVM {OLDEST} or newer") + (
    "; or set DRJIT_LIBLLVM_PATH to the library, then restart"
)
"""What helps where there is none."""


def find_library() -> str | None:
    """Return the path of a libLLVM that Dr.Jit can use, None without one.

    The environment's choice comes first, then the one that is shipped, then the system's newest.
    """
    chosen = os.environ.get("DRJIT_LIBLLVM_PATH")
    if chosen:
        return chosen if Path(chosen).exists() else None
    bundled = bundled_library()
    if bundled is not None and _loads(bundled):
        return bundled
    found = [path for path in _system_libraries() if major_version(path) >= OLDEST]
    return max(found, key=major_version, default=None)


def settle() -> str | None:
    """Let Dr.Jit use the library that `find_library` finds, and return its path.

    Dr.Jit looks once, when it is imported, and would take a system's library of any version and not see the one that
    is shipped. So this comes before whatever imports Dr.Jit or Mitsuba first.
    """
    library = find_library()
    if library:
        os.environ["DRJIT_LIBLLVM_PATH"] = library
    return library


def bundled_library() -> str | None:
    """Return the path of the library that is shipped, None where it is not installed."""
    found = importlib.util.find_spec(BUNDLE)
    if found is None:
        return None
    return str(importlib.import_module(BUNDLE).LIBRARY)


def _loads(path: str) -> bool:
    """Tell whether the system loads a library: what it needs itself may be missing."""
    try:
        ctypes.CDLL(path)
    except OSError:
        return False
    return True


def _system_libraries() -> list[str]:
    found = []
    for pattern in SYSTEM_PATTERNS.get(sys.platform, ()):
        found.extend(glob.glob(pattern))
    return found


def major_version(path: str) -> int:
    """Major version of a library by its name or folder; unnumbered ones count as current."""
    named = re.search(r"LLVM(?:\.so\.|-)(\d+)", Path(path).name) or re.search(
        r"llvm[-@](\d+)", path
    )
    return int(named.group(1)) if named else OLDEST


def describe_absence() -> str:
    """Say in a few words why Dr.Jit has none."""
    library = find_library()
    if library is not None:
        return f"Dr.Jit cannot use the LLVM library '{library}'"
    chosen = os.environ.get("DRJIT_LIBLLVM_PATH")
    if chosen:
        return f"DRJIT_LIBLLVM_PATH names '{chosen}', which does not exist"
    bundled = bundled_library()
    if bundled is not None:
        return f"the LLVM that Lumenray brings cannot be loaded here ({bundled})"
    old = sorted({major_version(path) for path in _system_libraries()})
    if old:
        return (
            f"only LLVM {', '.join(map(str, old))} was found, version {OLDEST} or newer is needed"
        )
    return "LLVM was not found"
