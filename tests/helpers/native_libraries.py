"""Native libraries for tests: real ones of this environment, and a small one of macOS made byte by byte."""

import struct
from pathlib import Path

LC_LOAD_DYLIB, LC_BUILD_VERSION = 0xC, 0x32
ARM64, DYLIB = 0x0100000C, 6


def elf() -> bytes:
    """A real module for Linux on x86-64, which asks for libstdc++.so.6 among others."""
    import xatlas

    return Path(xatlas.__file__).read_bytes()


def pe() -> bytes:
    """A real program for Windows on x86-64, which asks for KERNEL32.dll among others."""
    import setuptools

    return (Path(setuptools.__file__).parent / "cli-64.exe").read_bytes()


def mach_o(imports, oldest=(11, 0)) -> bytes:
    """A library for macOS on arm64 that does nothing but ask for others."""
    commands = [struct.pack("<6I", LC_BUILD_VERSION, 24, 1, oldest[0] << 16 | oldest[1] << 8, 0, 0)]
    for name in imports:
        text = name.encode() + b"\0"
        text += b"\0" * (-len(text) % 8)
        commands.append(struct.pack("<6I", LC_LOAD_DYLIB, 24 + len(text), 24, 0, 0, 0) + text)
    body = b"".join(commands)
    head = struct.pack("<8I", 0xFEEDFACF, ARM64, 0, DYLIB, len(commands), len(body), 0, 0)
    return head + body
