"""A process of its own that lets Open Image Denoise filter one picture: Blender has another version of it in its own.

Run by path, it knows nothing of the package. Standard input brings one line with the order, then a numpy archive with
``color`` and perhaps the guides ``albedo`` and ``normal``, each (h, w, 3) float32; standard output takes the archive with
the ``result``. What goes wrong is one line on standard error.

The order names the ``filter``: ``RT`` for pictures, ``RTLightmap`` for maps of light on surfaces; whether it
``has_noisy_guides``, which are then filtered by themselves first; and whether it ``is_modest``.
"""

import ctypes
import io
import json
import os
import sys
from pathlib import Path

CPU = 1
"""The kind of device: processors only, so that the same picture looks the same on every computer."""

FLOAT3 = 3
"""Format of a pixel: three floats."""

BALANCED, HIGH = 5, 6
"""Qualities: how large the network is. The large one takes guides without noise."""

MODESTY = 10
"""By how much a modest task is nicer than others, where the system knows that."""

DEVICE, FILTER, TEXT = ctypes.c_void_p, ctypes.c_void_p, ctypes.c_char_p

SIGNATURES = {
    "oidnNewDevice": (DEVICE, ctypes.c_int),
    "oidnSetDeviceBool": (None, DEVICE, TEXT, ctypes.c_bool),
    "oidnCommitDevice": (None, DEVICE),
    "oidnGetDeviceError": (ctypes.c_int, DEVICE, ctypes.POINTER(TEXT)),
    "oidnReleaseDevice": (None, DEVICE),
    "oidnNewFilter": (FILTER, DEVICE, TEXT),
    "oidnSetSharedFilterImage": (
        None,
        FILTER,
        TEXT,
        ctypes.c_void_p,
        ctypes.c_int,
        *[ctypes.c_size_t] * 5,
    ),
    "oidnSetFilterBool": (None, FILTER, TEXT, ctypes.c_bool),
    "oidnSetFilterInt": (None, FILTER, TEXT, ctypes.c_int),
    "oidnSetFilterFloat": (None, FILTER, TEXT, ctypes.c_float),
    "oidnCommitFilter": (None, FILTER),
    "oidnExecuteFilter": (None, FILTER),
    "oidnReleaseFilter": (None, FILTER),
}
"""What a function returns and takes, of those of Open Image Denoise 2 that are used."""


def main() -> str:
    """Filter one picture; return what went wrong, or nothing."""
    order = json.loads(sys.stdin.buffer.readline())
    sys.path[:] = order["search_path"]
    import numpy as np

    # Whatever the library prints must not get into the answer.
    answer = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    with np.load(io.BytesIO(sys.stdin.buffer.read()), allow_pickle=False) as held:
        images = {name: np.ascontiguousarray(held[name], dtype=np.float32) for name in held}
    oidn = load(Path(order["library"]))
    if order["is_modest"] and hasattr(os, "nice"):
        os.nice(MODESTY)
    images["output"] = np.empty_like(images["color"])
    fault = denoise(oidn, order, images)
    if not fault:
        np.savez(answer, result=images["output"])
    return fault


def load(library: Path):
    """Load the library, and with it those beside it."""
    if sys.platform == "win32":
        os.add_dll_directory(str(library.parent))
        # Its devices are looked for among what is loaded.
        ctypes.CDLL(str(library.with_name("OpenImageDenoise_device_cpu.dll")))
    functions = ctypes.CDLL(str(library))
    for name, (result, *arguments) in SIGNATURES.items():
        function = getattr(functions, name)
        function.restype, function.argtypes = result, arguments
    return functions


def denoise(oidn, order: dict, images: dict) -> str:
    """Filter ``color`` into ``output`` with the help of the other images; return what went wrong, or nothing."""
    device = oidn.oidnNewDevice(CPU)
    # Other programs, and other renders, have a right to the processors too.
    oidn.oidnSetDeviceBool(device, b"setAffinity", False)
    oidn.oidnCommitDevice(device)
    kind, quality = order["filter"].encode(), BALANCED if order["is_modest"] else HIGH
    guides = [name for name in images if name not in ("color", "output")]
    if order["has_noisy_guides"]:
        for name in guides:
            clean = images[name].copy()
            _execute(oidn, device, kind, quality, {name: images[name], "output": clean}, [])
            images[name] = clean
    switches = [b"hdr"] if kind == b"RT" else []
    if guides and not order["is_modest"]:
        switches.append(b"cleanAux")
    _execute(oidn, device, kind, quality, images, switches)
    message = TEXT()
    code = oidn.oidnGetDeviceError(device, ctypes.byref(message))
    fault = (message.value or b"").decode(errors="replace") or f"error {code}"
    oidn.oidnReleaseDevice(device)
    return fault if code else ""


def _execute(oidn, device, kind: bytes, quality: int, images: dict, switches: list) -> None:
    """Run one filter."""
    task = oidn.oidnNewFilter(device, kind)
    height, width = images["output"].shape[:2]
    for name, pixels in images.items():
        oidn.oidnSetSharedFilterImage(
            task, name.encode(), pixels.ctypes.data, FLOAT3, width, height, 0, 0, 0
        )
    oidn.oidnSetFilterInt(task, b"quality", quality)
    for switch in switches:
        oidn.oidnSetFilterBool(task, switch, True)
    if "color" in images:
        # The picture is exposed already.
        oidn.oidnSetFilterFloat(task, b"inputScale", 1.0)
    oidn.oidnCommitFilter(task)
    oidn.oidnExecuteFilter(task)
    oidn.oidnReleaseFilter(task)


if __name__ == "__main__":
    sys.exit(main() or 0)
