"""What kernels run on: CUDA, Metal, or the CPU through LLVM; which are there, and what they are called."""

import ctypes
import os
import platform
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from .. import llvm

CHOICE = "LUMENRAY_DEVICE"
"""Environment variable with the user's choice: a key of `DEVICES`, or nothing for the first trusted one that works."""


@dataclass(frozen=True)
class Device:
    """A kind of device.

    ``key`` is the user's word for it, ``prefix`` begins its Mitsuba variants. ``traces_many``: whether a kernel can trace
    several Mitsuba scenes; ``is_trusted``: whether all jobs were seen to be right there; others are taken when asked for.
    """

    key: str
    label: str
    prefix: str
    backend: str
    traces_many: bool = False
    is_trusted: bool = False

    def is_present(self) -> bool:
        """Tell whether Dr.Jit can use it here and Mitsuba has its variants."""
        import drjit as dr
        import mitsuba as mi

        return f"{self.prefix}_mono" in mi.variants() and dr.has_backend(
            getattr(dr.JitBackend, self.backend)
        )

    def variant(self, spectral: bool) -> str:
        """Return the Mitsuba variant for a kind of transport."""
        return f"{self.prefix}_{'spectral' if spectral else 'mono'}"

    def describe(self) -> str:
        """Name the hardware in words, such as "Apple M2, Metal" or "AMD EPYC, 2 threads, LLVM 23.1"."""
        return _DESCRIPTIONS[self.key]()


DEVICES = {
    device.key: device
    for device in (
        Device("cuda", "NVIDIA GPU (CUDA)", "cuda_ad", "CUDA"),
        Device("metal", "Apple GPU (Metal)", "metal_ad", "Metal"),
        Device("cpu", "CPU (LLVM)", "llvm_ad", "LLVM", traces_many=True, is_trusted=True),
    )
}
"""All kinds, by the user's word, the preferred ones first."""


def chosen_device() -> str:
    """Return the key of the user's choice, empty where the first that works is to be taken."""
    key = os.environ.get(CHOICE, "").strip().lower()
    return "" if key in {"", "auto"} else key


def of_variant(variant: str) -> Device:
    """Return the device that a Mitsuba variant runs on."""
    return next(device for device in DEVICES.values() if variant.startswith(device.prefix))


def _describe_cuda() -> str:
    import drjit as dr

    name, driver = _ask_driver()
    capability = dr.detail.cuda_compute_capability()
    return f"{name or 'NVIDIA GPU'}, {driver or 'CUDA'}, compute capability {capability}"


def _ask_driver() -> tuple[str, str]:
    """Ask the driver's own library for the device's name and the driver's version, empty where it does not tell."""
    library = "nvml.dll" if sys.platform == "win32" else "libnvidia-ml.so.1"
    try:
        nvml = ctypes.CDLL(library)
    except OSError:
        return "", ""
    if nvml.nvmlInit_v2():
        return "", ""
    try:
        device, text = ctypes.c_void_p(), ctypes.create_string_buffer(96)
        name = driver = ""
        if not nvml.nvmlDeviceGetHandleByIndex_v2(0, ctypes.byref(device)) and not (
            nvml.nvmlDeviceGetName(device, text, len(text))
        ):
            name = text.value.decode(errors="replace")
        if not nvml.nvmlSystemGetDriverVersion(text, len(text)):
            driver = f"driver {text.value.decode(errors='replace')}"
        return name, driver
    finally:
        nvml.nvmlShutdown()


def _describe_metal() -> str:
    return f"{_processor()}, Metal"


def _describe_cpu() -> str:
    import drjit as dr

    version = ".".join(str(part) for part in dr.detail.llvm_version()[:2])
    return f"{_processor()}, {dr.thread_count()} threads, LLVM {version}"


def _processor() -> str:
    """Return the processor's name as the system has it."""
    if sys.platform == "darwin":
        done = subprocess.run(
            ["/usr/sbin/sysctl", "-n", "machdep.cpu.brand_string"],
            capture_output=True,
            text=True,
            check=False,
        )
        return done.stdout.strip() or "Apple"
    if sys.platform == "linux":
        with Path("/proc/cpuinfo").open(encoding="utf-8", errors="replace") as lines:
            for line in lines:
                if line.startswith("model name"):
                    return line.partition(":")[2].strip()
    return platform.processor() or "CPU"


_DESCRIPTIONS = {"cuda": _describe_cuda, "metal": _describe_metal, "cpu": _describe_cpu}


def absence(device: Device) -> tuple[str, str]:
    """Say why a device that was chosen cannot be used, and the remedy."""
    if device.key == "cpu":
        return llvm.describe_absence(), llvm.REMEDY
    return f"no {device.label} that Mitsuba can use is there", "choose Automatic or another device"
