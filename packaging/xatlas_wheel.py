"""A wheel of xatlas for a Python that its authors made none for, compiled from their recorded source."""

import hashlib
import os
import shlex
import shutil
import subprocess
import tempfile
from pathlib import Path

from archive import write_wheel
from binaries import read_library
from project import BuildError
from python_headers import find_headers
from targets import PYTHONS, Target

FLAGS = ["-std=c++17", "-O3", "-DNDEBUG", "-fPIC", "-shared", "-fvisibility=hidden", "-s"]
"""As the source's own build does it; the C++ library goes inside, so that any Linux will do."""

LINKED = ["-static-libstdc++", "-static-libgcc", "-pthread"]

INCLUDES = ("extern/pybind11/include", "extern/xatlas/source/xatlas")

SOURCES = ("src/*.cpp", "extern/xatlas/source/xatlas/xatlas.cpp")


def make(target: Target, pin, source: Path, folder: Path) -> Path:
    """Compile the wheel of a target, or return the one that was made before.

    The compiler is ``CXX`` (default: g++). The wheel's tag tells the glibc that came out of it; for
    2.28 or older, give a compiler that aims lower than its own machine:
    ``CXX="python -m ziglang c++ -target x86_64-linux-gnu.2.28"``.

    Parameters
    ----------
    pin : (name, version)
    source : Path    The recorded source.
    folder : Path    Where wheels and headers are kept.

    Raises
    ------
    BuildError    There is no compiler or there are no headers, or the compiler refuses.
    """
    compiler = shlex.split(os.environ.get("CXX", "g++"))
    if shutil.which(compiler[0]) is None:
        raise BuildError(
            f"a C++ compiler is needed to compile xatlas for {target}: install g++ or set CXX"
        )
    version = PYTHONS[target.python]
    headers = find_headers(version, folder)
    made_of = [source.name, *compiler, *FLAGS, *LINKED, *map(str, headers)]
    kept = folder / f"{target}-{hashlib.sha256(' '.join(made_of).encode()).hexdigest()[:12]}"
    known = next(kept.glob("*.whl"), None)
    if known is not None:
        return known
    kept.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as work:
        subprocess.run(["tar", "--extract", "--file", source, "--directory", work], check=True)
        root = Path(work) / source.name.removesuffix(".tar.gz")
        module = Path(work) / f"xatlas.cpython-{target.python[2:]}-x86_64-linux-gnu.so"
        command = [*compiler, *FLAGS, f"-DVERSION_INFO={pin[1]}"]
        command += [f"-I{path}" for path in (*(root / each for each in INCLUDES), *headers)]
        command += [str(path) for pattern in SOURCES for path in sorted(root.glob(pattern))]
        done = subprocess.run(
            [*command, *LINKED, "-o", str(module)], capture_output=True, text=True, check=False
        )
        if done.returncode:
            raise BuildError(f"xatlas cannot be compiled for {target}: {done.stderr.strip()[:400]}")
        return _write_wheel(kept, target, pin, module, root)


def _write_wheel(folder: Path, target: Target, pin, module: Path, root: Path) -> Path:
    content = module.read_bytes()
    minor = max(read_library(module.name, content).needs.get("GLIBC", (2, 17)), (2, 17))[1]
    tag = f"{target.python}-{target.python}-manylinux_2_{minor}_x86_64"
    info = f"{pin[0]}-{pin[1]}.dist-info"
    files = {
        module.name: content,
        f"{info}/licenses/LICENSE": (root / "LICENSE").read_bytes(),
        f"{info}/licenses/LICENSE.xatlas": (root / "extern/xatlas/LICENSE").read_bytes(),
        f"{info}/licenses/LICENSE.pybind11": (root / "extern/pybind11/LICENSE").read_bytes(),
        f"{info}/METADATA": (root / "PKG-INFO").read_bytes(),
        f"{info}/WHEEL": (
            f"Wheel-Version: 1.0\nGenerator: lumenray\nRoot-Is-Purelib: false\nTag: {tag}\n"
        ).encode(),
    }
    path = folder / f"{pin[0]}-{pin[1]}-{tag}.whl"
    write_wheel(path, files)
    return path
