"""Mitsuba, Dr.Jit and a device: found, tried and explained before anything is computed."""

import logging
import mmap
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from .. import llvm
from ..errors import BackendError
from .device_check import check_variant
from .devices import DEVICES, Device, absence, chosen_device

log = logging.getLogger(__name__)

MITSUBA_VERSION = "3.9.1"
"""The Mitsuba release this engine is written for."""

ROOM = 3 << 27
"""Address space that Mitsuba, LLVM and a first small job take. [byte]"""

UNLOADABLE = (
    # Its libraries lock in a way that Blender's own older runtime does not know.
    "install Microsoft's current Visual C++ Redistributable (x64); if that does not help, reinstall Lumenray with the "
    "zip made for this Blender version"
    if sys.platform == "win32"
    else "reinstall Lumenray with the zip made for this platform and Blender version"
)
"""What helps where Mitsuba is there but does not load."""


@dataclass(frozen=True)
class BackendStatus:
    """What was found: ``usable`` or not, one sentence ``cause`` and one ``remedy``.

    ``device`` is the key of the device that is used, ``found`` says in words what each of those that were looked at
    is and how fast it met rays, or what is wrong with it.
    """

    usable: bool
    cause: str
    remedy: str = ""
    device: str = ""
    found: tuple[str, ...] = ()


def status() -> BackendStatus:
    """Tell whether the engine can run, by a small job on the device that it would take."""
    devices, trouble = _candidates()
    if trouble is not None:
        return trouble
    import mitsuba

    found = []
    for device in devices:
        variant = device.variant(spectral=False)
        try:
            check = check_variant(variant)
        except (ImportError, RuntimeError) as error:
            found.append(f"{device.label}: {error}")
            continue
        name = device.describe()
        if check.fault:
            found.append(f"{name}: {check.fault}")
            continue
        found.append(f"{name}: {check.speed / 1e6:.0f} million rays a second")
        return BackendStatus(
            True, f"Mitsuba {mitsuba.__version__} on {name}", "", device.key, tuple(found)
        )
    return BackendStatus(False, "; ".join(found), _remedy(), found=tuple(found))


def _candidates() -> tuple[list[Device], BackendStatus | None]:
    """Return the devices that may be taken, the best first; without any, what is wrong."""
    trouble = _missing_mitsuba()
    if trouble is not None:
        return [], trouble
    key = chosen_device()
    if key and key not in DEVICES:
        return [], BackendStatus(
            False, f"there is no device '{key}'", f"choose one of auto, {', '.join(DEVICES)}"
        )
    wanted = [DEVICES[key]] if key else list(DEVICES.values())
    present = [device for device in wanted if _is_present(device)]
    if not present:
        return [], BackendStatus(False, *absence(wanted[-1]))
    trusted = [device for device in present if device.is_trusted]
    return trusted or present, None


def _missing_mitsuba() -> BackendStatus | None:
    """Load Dr.Jit and Mitsuba; say what is wrong with them, None where nothing is."""
    if "drjit" not in sys.modules and not _has_room():
        return BackendStatus(
            False,
            f"there are no {ROOM >> 20} MiB of memory left for the engine's libraries",
            "raise the engine's memory limit or close other programs",
        )
    error = _load()
    if error is not None:
        return BackendStatus(False, f"Mitsuba cannot be loaded: {_first_cause(error)}", UNLOADABLE)
    import mitsuba

    if mitsuba.__version__ != MITSUBA_VERSION:
        return BackendStatus(
            False,
            f"Mitsuba {mitsuba.__version__} was found at {Path(mitsuba.__file__).parent}, "
            f"Lumenray needs {MITSUBA_VERSION}",
            "remove the other Mitsuba from Python's path",
        )
    return None


def _has_room() -> bool:
    """Tell whether libraries can be loaded whole: what is loaded in part crashes or hangs later, and blames others."""
    try:
        mmap.mmap(-1, ROOM).close()
    except OSError:
        return False
    return True


@cache
def _load() -> Exception | None:
    """Import Dr.Jit and Mitsuba, once; return what went wrong.

    It is kept, and with it what was loaded in part: Dr.Jit's own thread may hold a lock while it waits for Python, and who
    frees Dr.Jit then waits for that lock for ever. A second import would end the process.
    """
    llvm.settle()
    try:
        import drjit  # noqa: F401
        import mitsuba  # noqa: F401
    except Exception as error:
        # Dr.Jit itself makes a NameError of a library that does not load.
        return error
    return None


def _first_cause(error: BaseException) -> str:
    while error.__context__ is not None:
        error = error.__context__
    return str(error) or type(error).__name__


def _is_present(device: Device) -> bool:
    # Dr.Jit would take whatever LLVM it finds by itself, of any version.
    return device.is_present() and (device.key != "cpu" or llvm.find_library() is not None)


def _remedy() -> str:
    if chosen_device() in {"", "cpu"}:
        return llvm.REMEDY
    return "choose Automatic or another device"


def start(spectral: bool) -> str:
    """Activate the Mitsuba variant for the kind of transport and return its name.

    The user's choice of device counts (`devices.CHOICE`); without one, the first trusted one that gives right answers
    is taken, where there is none another one, once for the whole process.

    Raises
    ------
    BackendError    Mitsuba or the device is missing, or the device computes wrongly; the message holds the remedy.
    """
    variant = _device(chosen_device()).variant(spectral)
    mitsuba = sys.modules["mitsuba"]
    if mitsuba.variant() != variant:
        try:
            mitsuba.set_variant(variant)
        except (ImportError, RuntimeError) as error:
            raise BackendError(
                f"the engine cannot start ({variant}: {error}); {_remedy()}"
            ) from error
        mitsuba.set_log_level(mitsuba.LogLevel.Warn)
    return variant


@cache
def _device(choice: str) -> Device:
    """Return the device of this process."""
    devices, trouble = _candidates()
    if trouble is not None:
        raise BackendError(f"{trouble.cause}; {trouble.remedy}")
    for device in devices:
        # The processor is what everything is tested on.
        if device.key == "cpu":
            return device
        fault = _fault(device)
        if not fault:
            return device
    raise BackendError(f"{device.label} is not used: {fault}; {_remedy()}")


def _fault(device: Device) -> str:
    """Try a device; say what is wrong with it."""
    try:
        fault = check_variant(device.variant(spectral=False)).fault
    except (ImportError, RuntimeError) as error:
        fault = str(error)
    if fault:
        log.warning("%s is not used: %s", device.label, fault)
    return fault
