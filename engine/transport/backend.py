"""Mitsuba and LLVM: found, checked and explained before anything is computed."""

import glob
import logging
import os
import re
import sys
from dataclasses import dataclass
from pathlib import Path

from ..errors import BackendError

log = logging.getLogger(__name__)

LLVM_PATTERNS = {
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
"""Where a libLLVM usually lies, by `sys.platform`."""

OLDEST_LLVM = 17
"""Dr.Jit 1.5 refuses LLVM before 15; 15 and 16 cannot translate `llvm.maximum` and end the process (seen with AVX-512)."""

LLVM_REMEDY = {
    "linux": "install it with 'sudo apt install libllvm19' (or your distribution's LLVM 17 or newer)",
    "darwin": "install it with 'brew install llvm'",
    "win32": "install LLVM for Windows from the LLVM project's releases",
}

MITSUBA_VERSION = "3.9.1"
"""The Mitsuba release this engine is written for."""


@dataclass(frozen=True)
class BackendStatus:
    """What was found: ``usable`` or not, one sentence ``cause`` and one ``remedy``."""

    usable: bool
    cause: str
    remedy: str = ""


def find_llvm() -> str | None:
    """Return the path of a usable libLLVM: the environment's choice first, then the newest of the usual places."""
    chosen = os.environ.get("DRJIT_LIBLLVM_PATH")
    if chosen:
        return chosen if Path(chosen).exists() else None
    found = [path for path in _installed() if _major(path) >= OLDEST_LLVM]
    return max(found, key=_major, default=None)


def _installed() -> list[str]:
    found = []
    for pattern in LLVM_PATTERNS.get(sys.platform, ()):
        found.extend(glob.glob(pattern))
    return found


def _major(path: str) -> int:
    """Major version of a library by its name or folder; unnumbered ones count as current."""
    named = re.search(r"LLVM(?:\.so\.|-)(\d+)", Path(path).name) or re.search(
        r"llvm[-@](\d+)", path
    )
    return int(named.group(1)) if named else OLDEST_LLVM


def status() -> BackendStatus:
    """Tell whether the engine can run, without starting it."""
    library = find_llvm()
    if library:
        # Dr.Jit looks once, when it starts, and would take any version.
        os.environ["DRJIT_LIBLLVM_PATH"] = library
    try:
        import drjit  # noqa: F401
        import mitsuba
    except (ImportError, OSError) as error:
        return BackendStatus(
            False,
            f"Mitsuba cannot be loaded: {error}",
            "reinstall Lumenray with the zip made for this platform and Blender version",
        )
    if mitsuba.__version__ != MITSUBA_VERSION:
        return BackendStatus(
            False,
            f"Mitsuba {mitsuba.__version__} was found at {Path(mitsuba.__file__).parent}, "
            f"Lumenray needs {MITSUBA_VERSION}",
            "remove the other Mitsuba from Python's path",
        )
    if library is None and not _has_cuda():
        return BackendStatus(
            False,
            _missing_llvm(),
            LLVM_REMEDY.get(sys.platform, "install LLVM 17 or newer")
            + ", or set DRJIT_LIBLLVM_PATH to the library, then restart",
        )
    return BackendStatus(True, f"Mitsuba {mitsuba.__version__}, LLVM at {library or '-'}")


def _missing_llvm() -> str:
    chosen = os.environ.get("DRJIT_LIBLLVM_PATH")
    if chosen:
        return f"DRJIT_LIBLLVM_PATH names '{chosen}', which does not exist"
    old = sorted({_major(path) for path in _installed()})
    if old:
        return f"only LLVM {', '.join(map(str, old))} was found, version {OLDEST_LLVM} or newer is needed"
    return "LLVM was not found"


def _has_cuda() -> bool:
    import drjit as dr

    return dr.has_backend(dr.JitBackend.CUDA)


def start(spectral: bool) -> str:
    """Activate the Mitsuba variant for the kind of transport and return its name.

    CUDA is used when a device is there, else LLVM.

    Raises
    ------
    BackendError    Mitsuba or LLVM is missing; the message holds the remedy.
    """
    kind = "spectral" if spectral else "mono"
    mitsuba = sys.modules.get("mitsuba")
    if mitsuba is not None and mitsuba.variant() in (f"cuda_ad_{kind}", f"llvm_ad_{kind}"):
        return mitsuba.variant()
    state = status()
    if not state.usable:
        raise BackendError(f"{state.cause}; {state.remedy}")
    import mitsuba as mi

    names = [f"cuda_ad_{kind}"] if _has_cuda() else []
    names.append(f"llvm_ad_{kind}")
    problems = []
    for name in names:
        try:
            if mi.variant() != name:
                mi.set_variant(name)
        except (ImportError, RuntimeError) as error:
            problems.append(f"{name}: {error}")
            continue
        mi.set_log_level(mi.LogLevel.Warn)
        return name
    remedy = LLVM_REMEDY.get(sys.platform, "install LLVM 17 or newer")
    raise BackendError(f"the engine cannot start ({'; '.join(problems)}); {remedy}")
