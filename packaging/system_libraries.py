"""What a native library may ask of its system: the libraries that are there, and how new it may want them to be."""

import re

from targets import Target

LINUX = {
    # The C and C++ libraries, which every program on a Linux desktop uses.
    "ld-linux-x86-64.so.2", "libc.so.6", "libdl.so.2", "libgcc_s.so.1", "libm.so.6", "libpthread.so.0",
    "librt.so.1", "libstdc++.so.6", "libutil.so.1",
    # Part of the manylinux policy, and asked for by every desktop.
    "libz.so.1",
    # Of the compiler's runtime, as libstdc++ is. Dr.Jit's threads ask for it; a bare system may need the package libatomic1.
    "libatomic.so.1",
}  # fmt: skip
"""By the policy of manylinux_2_28, those that are asked for."""

WINDOWS = {
    # Windows itself.
    "advapi32.dll", "bcrypt.dll", "cfgmgr32.dll", "dbghelp.dll", "gdi32.dll", "iphlpapi.dll", "kernel32.dll", "ntdll.dll",
    "ole32.dll", "oleaut32.dll", "pdh.dll", "powrprof.dll", "psapi.dll", "shell32.dll", "shlwapi.dll", "user32.dll",
    "version.dll", "wintrust.dll", "ws2_32.dll",
    # The Visual C++ runtime. Blender brings it in blender.crt beside its program; most other programs install it into
    # the system. Without it not even Blender's own python.exe starts.
    "msvcp140.dll", "vcruntime140.dll", "vcruntime140_1.dll",
}  # fmt: skip
"""In lower case: Windows does not tell cases apart."""

WINDOWS_PATTERN = r"api-ms-win-[a-z0-9-]+\.dll"
"""Interfaces of Windows and of its C runtime, which is part of Windows 10."""

MACOS_PATTERN = (
    r"/usr/lib/(libSystem\.B|libc\+\+\.1|libobjc\.A|libz\.1|libbz2\.1\.0)\.dylib"
    r"|/System/Library/Frameworks/(Accelerate|CoreFoundation|Foundation|IOKit|Metal|MetalPerformanceShaders)"
    r"\.framework/.*"
)
"""Libraries and frameworks that macOS has in every version since 11."""

LIMITS = {
    "GLIBC": (2, 28),
    # Of GCC 8, which is as old as glibc 2.28.
    "GLIBCXX": (3, 4, 25),
    "CXXABI": (1, 3, 11),
    "GCC": (7, 0, 0),
    "macOS": (11, 0),
    "Windows": (6, 3),
    # As is told of blender.crt in Blender 4.2 to 5.0; 5.1 is said to bring 14.44.
    "MSVCP140": (14, 29),
}
"""The oldest systems that Blender 4.2 itself runs on: glibc 2.28, macOS 11, Windows 8.1 (6.3); its C++ runtime."""

MACHINES = {"linux-x64": "x86_64", "windows-x64": "x86_64", "macos-arm64": "arm64"}
"""Processors as libraries name them."""

KINDS = {"linux-x64": "ELF", "windows-x64": "PE", "macos-arm64": "Mach-O"}
"""Formats of the libraries of a platform."""


def is_of_system(library: str, target: Target) -> bool:
    """Tell whether the system, or Blender with its Python, brings a library that is asked for."""
    if target.platform == "linux-x64":
        return library in LINUX
    if target.platform == "macos-arm64":
        return re.fullmatch(MACOS_PATTERN, library) is not None
    name = library.lower()
    return (
        name in WINDOWS
        # Blender has both beside its program; the second serves extension modules for many versions of Python.
        or name in (f"python{target.python[2:]}.dll", "python3.dll")
        or re.fullmatch(WINDOWS_PATTERN, name) is not None
    )
