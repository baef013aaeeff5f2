"""Keeps a process that opens other people's files in its place, by means of the Linux kernel.

- Files: Landlock (kernel's ``Documentation/userspace-api/landlock.rst``) leaves the process what it is given, to read or to
  write, and nothing else of the machine. It also keeps it from looking into other processes, and from Linux 6.12 on from
  sending them signals.
- Network and processes: a network of its own with nobody in it, and a tree of processes that ends as a whole
  (``user_namespaces(7)``, ``network_namespaces(7)``, ``pid_namespaces(7)``); where that is not allowed, Landlock at least
  refuses TCP.
- Memory, size of files and processor time: ``setrlimit(2)``.

What is given up is given up for good, for all processes that are begun later, too.
"""

import contextlib
import ctypes
import os
import sys
from dataclasses import dataclass
from pathlib import Path

from ..engine.errors import LumenrayError

LEAST_VERSION = 3
"""Of Landlock: with 2 files can be moved out of folders, with 3 they cannot be cut short either (Linux 6.2)."""

_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446
"""Numbers of the system calls, the same on all architectures."""

_TELL_VERSION = 1
_PATH_BENEATH = 1
_NO_NEW_PRIVILEGES = 38
_NEW_USER, _NEW_NETWORK, _NEW_PROCESSES = 0x10000000, 0x40000000, 0x20000000

_EXECUTE, _WRITE_FILE, _READ_FILE, _READ_FOLDER = 1 << 0, 1 << 1, 1 << 2, 1 << 3
_ALL_BY_VERSION = {3: (1 << 15) - 1, 4: (1 << 15) - 1, 5: (1 << 16) - 1}
"""All rights on files that a version knows; later ones know those of version 5."""

_OF_FILES = _EXECUTE | _WRITE_FILE | _READ_FILE | 1 << 14 | 1 << 15
"""Rights that a plain file can have: the others are of folders."""

_TCP = 0b11
"""To listen and to connect, from version 4 on."""

_OTHERS = 0b11
"""Abstract sockets and signals of other processes, from version 6 on."""

SYSTEM = (
    "/usr",
    "/lib",
    "/lib64",
    "/bin",
    "/etc/ld.so.cache",
    "/etc/localtime",
    "/etc/fonts",
    "/proc",
    "/sys/devices/system",
)
"""What programs read of the machine. Of other processes ``/proc`` tells the confined one nothing that is secret."""

DEVICES = ("/dev/null", "/dev/zero", "/dev/urandom", "/dev/random")


@dataclass(frozen=True)
class Limits:
    """What a process may take.

    Parameters
    ----------
    memory : int    Its own memory, shared libraries not counted. [byte]
    file : int    Each file that it writes. [byte]
    seconds : int    Of all processors together. [s]
    """

    memory: int
    file: int
    seconds: int


class _Ruleset(ctypes.Structure):
    _fields_ = [
        ("files", ctypes.c_uint64),
        ("network", ctypes.c_uint64),
        ("scoped", ctypes.c_uint64),
    ]


class _Beneath(ctypes.Structure):
    _pack_ = 1
    _fields_ = [("allowed", ctypes.c_uint64), ("parent", ctypes.c_int32)]


def landlock_version() -> int:
    """Return the version of Landlock that the kernel has; 0 where there is none."""
    if sys.platform != "linux":
        return 0
    return max(_libc().syscall(_CREATE_RULESET, None, 0, _TELL_VERSION), 0)


def check_kernel() -> None:
    """Refuse a machine on which a process cannot be confined.

    Raises
    ------
    LumenrayError    It has no Landlock, or one that is too old.
    """
    version = landlock_version()
    if version < LEAST_VERSION:
        told = f"Landlock of version {version}" if version else "no Landlock"
        raise LumenrayError(
            f"uploads cannot be opened safely here: this system has {told}, expected {LEAST_VERSION} or newer; use Linux "
            "6.2 or newer with Landlock switched on (lsm=landlock)"
        )


def confine(readable: list[Path], writable: list[Path], limits: Limits) -> None:
    """Give up for good whatever is not named here. It is for this thread and its children: call it before others are there.

    Parameters
    ----------
    readable, writable : list of Path    Files and folders with all that is below; what is not there is left out.

    Raises
    ------
    LumenrayError, OSError    The kernel does not do it; the process must not go on.
    """
    check_kernel()
    _set_limits(limits)
    _restrict_files(readable, writable)


def leave_others() -> bool:
    """Leave the network, and let processes that are begun from now on be a tree of their own; False: not allowed here."""
    owner, group = os.getuid(), os.getgid()
    if _libc().unshare(_NEW_USER | _NEW_NETWORK | _NEW_PROCESSES) != 0:
        return False
    # Without a map of users the process would be nobody, even to itself; where none may be made it has its files still.
    with contextlib.suppress(PermissionError):
        Path("/proc/self/setgroups").write_text("deny")
        Path("/proc/self/uid_map").write_text(f"{owner} {owner} 1")
        Path("/proc/self/gid_map").write_text(f"{group} {group} 1")
    return True


def _set_limits(limits: Limits) -> None:
    import resource

    for kind, value in (
        (resource.RLIMIT_DATA, limits.memory),
        (resource.RLIMIT_FSIZE, limits.file),
        (resource.RLIMIT_CPU, limits.seconds),
        (resource.RLIMIT_CORE, 0),
    ):
        hard = resource.getrlimit(kind)[1]
        most = value if hard == resource.RLIM_INFINITY else min(value, hard)
        resource.setrlimit(kind, (most, most))


def _restrict_files(readable, writable) -> None:
    version = landlock_version()
    everything = _ALL_BY_VERSION[min(version, max(_ALL_BY_VERSION))]
    rules = _Ruleset(everything, _TCP if version >= 4 else 0, _OTHERS if version >= 6 else 0)
    # Older kernels know fewer fields, and refuse longer tables only if what they do not know is not zero.
    libc = _libc()
    ruleset = libc.syscall(_CREATE_RULESET, ctypes.byref(rules), ctypes.sizeof(rules), 0)
    if ruleset < 0:
        raise _fault("landlock_create_ruleset")
    try:
        look = _EXECUTE | _READ_FILE | _READ_FOLDER
        use = _READ_FILE | _WRITE_FILE
        for paths, rights in (
            (map(Path, SYSTEM), look),
            (readable, look),
            (map(Path, DEVICES), use),
            (writable, everything & ~_EXECUTE),
        ):
            for path in paths:
                _allow(ruleset, path, rights)
        if libc.prctl(_NO_NEW_PRIVILEGES, 1, 0, 0, 0) != 0:
            raise _fault("prctl")
        if libc.syscall(_RESTRICT_SELF, ruleset, 0) != 0:
            raise _fault("landlock_restrict_self")
    finally:
        os.close(ruleset)


def _allow(ruleset: int, path: Path, rights: int) -> None:
    try:
        handle = os.open(path, os.O_PATH | os.O_CLOEXEC)
    except FileNotFoundError:
        return
    try:
        beneath = _Beneath(rights if path.is_dir() else rights & _OF_FILES, handle)
        if _libc().syscall(_ADD_RULE, ruleset, _PATH_BENEATH, ctypes.byref(beneath), 0) != 0:
            raise _fault(f"landlock_add_rule for {path}")
    finally:
        os.close(handle)


def _libc():
    return ctypes.CDLL(None, use_errno=True)


def _fault(call: str) -> OSError:
    number = ctypes.get_errno()
    return OSError(number, f"{call}: {os.strerror(number)}")
