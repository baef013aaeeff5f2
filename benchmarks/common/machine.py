"""The machine that a benchmark ran on, how busy others kept it, and how steadily it works."""

import hashlib
import os
import platform
import time
from concurrent.futures import ThreadPoolExecutor
from importlib import metadata
from pathlib import Path

from ...engine import VERSION

PIECE = 1 << 22
"""Bytes that are worked on at once. [byte]"""

STARTS = 20
"""Stretches of work that are looked at, each beginning somewhere else."""


class OtherLoad:
    """How busy other processes keep the machine from now on. ``pid``: of a worker of ours, which does not count."""

    def __init__(self, pid: int | None = None):
        self._pid = pid
        self._start = self._now()

    def share(self) -> float | None:
        """Processor time of others over all there was, 0 to 1; None where the system does not tell."""
        if self._start is None:
            return None
        passed, busy, own = (b - a for a, b in zip(self._start, self._now(), strict=True))
        return round(max(busy - own, 0.0) / max(passed, 1e-9), 3)

    def _now(self) -> tuple[float, float, float] | None:
        """Time of all cores, their busy time, and that of our processes. [s]"""
        whole = Path("/proc/stat")
        if not whole.exists():
            return None
        tick = os.sysconf("SC_CLK_TCK")
        times = [int(word) / tick for word in whole.read_text().split("\n")[0].split()[1:9]]
        # Programs that we ran and waited for are ours too.
        own = sum(os.times()[:4])
        if self._pid is not None:
            worker = Path(f"/proc/{self._pid}/stat")
            if not worker.exists():
                return None
            fields = worker.read_text().rpartition(")")[2].split()
            own += (int(fields[11]) + int(fields[12])) / tick
        # Idle, and waiting for disks.
        return sum(times), sum(times) - times[3] - times[4], own


def measure_unsteadiness(seconds: float, share: float = 0.1) -> float:
    """How well the time of even work can be foretold on this machine.

    Parameters
    ----------
    seconds : float    How long the work takes; twice as long is measured. [s]
    share : float    Part of it from which the whole is foretold. [-]

    Returns
    -------
    float    Median relative error. [-]
    """
    end = time.perf_counter() + 2.0 * seconds
    data = bytes(PIECE)

    def work(_number: int) -> list[float]:
        stamps = []
        while time.perf_counter() < end:
            hashlib.sha256(data).digest()
            stamps.append(time.perf_counter())
        return stamps

    count = os.cpu_count() or 1
    with ThreadPoolExecutor(count) as pool:
        stamps = sorted(stamp for made in pool.map(work, range(count)) for stamp in made)
    return foretell(stamps, share)


def foretell(stamps: list[float], share: float) -> float:
    """Median relative error with which half of all pieces of work are foretold from a share of these; see above."""
    whole = max((len(stamps) - 1) // 2, 1)
    early = max(round(share * whole), 1)
    errors = []
    for number in range(STARTS):
        first = number * (len(stamps) - 1 - whole) // (STARTS - 1)
        begin = stamps[first]
        took = stamps[first + whole] - begin
        errors.append(abs((stamps[first + early] - begin) * whole / early / took - 1.0))
    return sorted(errors)[len(errors) // 2]


def describe_machine() -> dict:
    """What times depend on."""
    return {
        "cpu": _cpu_model(),
        "cores": os.cpu_count(),
        "memory_gib": round(_memory() / 2**30, 1),
        "system": f"{platform.system()} {platform.machine()}",
        "python": platform.python_version(),
        "mitsuba": metadata.version("mitsuba"),
        "lumenray": VERSION,
    }


def _cpu_model() -> str:
    path = Path("/proc/cpuinfo")
    lines = path.read_text(encoding="utf-8").splitlines() if path.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "unknown"


def _memory() -> int:
    """Main memory. [byte]"""
    if not hasattr(os, "sysconf"):
        return 0
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
