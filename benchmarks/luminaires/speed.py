"""How fast intensities are looked up: many directions at once against one at a time, in one run."""

import bisect
import ctypes
import math
import time
from contextlib import contextmanager
from pathlib import Path

import drjit as dr
import mitsuba as mi
import numpy as np

from ...engine.arrays import upload
from ...engine.luminaires.coordinates import directions
from ...engine.luminaires.distribution import flux, intensity
from ...engine.luminaires.emitters.tables import DistributionTables
from ...engine.scene.distribution import IntensityDistribution
from ...engine.transport import backend

MANY = 1 << 22
"""Directions of one call, looked up at once."""

ROUNDS = 7
"""How often each is timed; the shortest time counts, for other programs only make it longer."""

SECONDS = 0.3
"""Time that one at a time is tried for. [s]"""

BOUND = 20.0
"""How many times as fast many at once have to be."""

LANES = "_Z21jit_llvm_vector_widthv"
CPU = "_Z19jit_llvm_target_cpuv"
FEATURES = "_Z24jit_llvm_target_featuresv"
SET_TARGET = "_Z19jit_llvm_set_targetPKcS0_j"
"""Dr.Jit's own functions for the target of its compiler, as Linux and macOS name them."""

WAYS = {
    "vectorised": "all lanes, all threads",
    "one thread": "all lanes, one thread",
    "one lane": "the same kernel compiled for one lane, one thread",
    "plain Python": "a function of floats and lists, one direction a call",
    "NumPy": "the double precision reference, one direction a call",
}
"""Ways of looking up, and what they are."""


def run(say=None) -> list[dict]:
    """Measure all ways on all distributions.

    Returns
    -------
    list of dict    ``title``, ``grid`` [azimuths, polars], ``rates`` [directions/s by way; None: cannot be had here],
        ``lanes``, ``threads``, ``deviation``: largest one from the double precision reference, of the peak.
    """
    say = say or (lambda _line: None)
    backend.start(spectral=False)
    is_cuda = mi.variant().startswith("cuda")
    rows = []
    for title, distribution in distributions().items():
        row = measure(distribution, is_cuda)
        grid = [len(distribution.azimuth), len(distribution.polar)]
        rows.append({"title": title, "grid": grid, "device": "GPU" if is_cuda else "CPU", **row})
        rate = row["rates"]["vectorised"]
        say(f"{title}: {rate / 1e6:.0f} M directions/s, {ratios(rows[-1])}")
    return rows


def ratios(row: dict) -> str:
    """Say how many times as fast the first way is as each of the others."""
    first = row["rates"]["vectorised"]
    others = {way: rate for way, rate in row["rates"].items() if rate and way != "vectorised"}
    return ", ".join(f"x {times(first / rate)} over {way}" for way, rate in others.items())


def times(ratio: float) -> str:
    """Return a ratio as text, of three digits or more."""
    return f"{ratio:.3g}" if ratio < 999.5 else f"{ratio:.0f}"


def measure(distribution: IntensityDistribution, is_cuda: bool) -> dict:
    """Return rates of all ways for one distribution."""
    rng = np.random.default_rng(1)
    wanted = rng.normal(size=(MANY, 3))
    wanted /= np.linalg.norm(wanted, axis=1, keepdims=True)
    threads, lanes = dr.thread_count(), _lanes()
    rates: dict[str, float | None] = dict.fromkeys(WAYS)
    rates["vectorised"], values = _rate_of_many(distribution, wanted)
    reference = intensity(distribution, wanted[:100_000]) / flux(distribution)
    deviation = np.abs(values[:100_000] - reference).max() / reference.max()
    if not is_cuda:
        with _threads(1):
            rates["one thread"], _ = _rate_of_many(distribution, wanted)
            with _one_lane() as is_possible:
                if is_possible:
                    rates["one lane"], _ = _rate_of_many(distribution, wanted[: MANY // 8])
    rates["plain Python"] = _rate_of_one(_plain_function(distribution), wanted.tolist())
    rates["NumPy"] = _rate_of_one(lambda d: intensity(distribution, d), list(wanted))
    return {"rates": rates, "lanes": lanes, "threads": threads, "deviation": float(deviation)}


def distributions() -> dict[str, IntensityDistribution]:
    """A small, a usual and a large table, smooth with some structure."""
    return {
        "rotational downlight": _made(np.zeros(1), np.arange(0.0, 90.1, 1.0)),
        "office luminaire": _made(np.arange(0.0, 360.1, 15.0), np.arange(0.0, 180.1, 5.0)),
        "measured, uneven": _made(
            np.arange(0.0, 360.1, 2.5), np.r_[0.0:30.0:0.5, 30.0:90.0:1.0, 90.0:180.1:5.0]
        ),
    }


def _made(azimuth, polar) -> IntensityDistribution:
    azimuth, polar = np.deg2rad(azimuth), np.deg2rad(polar)
    d = directions(azimuth[:, None], polar[None, :])
    values = 1.5 + np.cos(3.0 * d[..., 0]) + 0.4 * np.sin(5.0 * d[..., 1]) - d[..., 2]
    return IntensityDistribution(azimuth, polar, np.maximum(values, 0.0))


# ---- ways ----


def _rate_of_many(distribution, wanted) -> tuple[float, np.ndarray]:
    """Directions per second of one kernel that reads directions and writes values, and the values [1/sr]."""
    tables = DistributionTables()
    number = dr.opaque(mi.UInt32, tables.commit([distribution])[0])
    direction = mi.Vector3f(*(upload(mi.Float, wanted[:, k]) for k in range(3)))
    dr.eval(direction, number)
    best = math.inf
    for _ in range(ROUNDS):
        dr.sync_thread()
        start = time.perf_counter()
        values = tables.density(number, direction)
        dr.eval(values)
        dr.sync_thread()
        best = min(best, time.perf_counter() - start)
    return len(wanted) / best, np.array(values, dtype=np.float64)


def _rate_of_one(function, wanted: list) -> float:
    """Directions per second of a function that takes one."""
    best, count = 0.0, 200
    for _ in range(ROUNDS):
        start = time.perf_counter()
        for direction in wanted[:count]:
            function(direction)
        seconds = time.perf_counter() - start
        best = max(best, count / seconds)
        count = min(int(best * SECONDS / ROUNDS) + 1, len(wanted))
    return best


def _plain_function(distribution: IntensityDistribution):
    """Bilinear look-up of one direction with nothing but floats and lists."""
    azimuths, polars = distribution.azimuth.tolist(), distribution.polar.tolist()
    table = distribution.intensity.tolist()
    turn, first, last_row = 2.0 * math.pi, azimuths[0], len(polars) - 2
    last_column = len(azimuths) - 2

    def look_up(direction):
        x, y, z = direction
        polar = math.atan2(math.hypot(x, y), -z)
        if not polars[0] <= polar <= polars[-1]:
            return 0.0
        row = min(bisect.bisect_right(polars, polar) - 1, last_row)
        v = (polar - polars[row]) / (polars[row + 1] - polars[row])
        if last_column < 0:
            return table[0][row] * (1.0 - v) + table[0][row + 1] * v
        azimuth = first + (math.atan2(y, x) - first) % turn
        if azimuth > azimuths[-1]:
            return 0.0
        column = min(bisect.bisect_right(azimuths, azimuth) - 1, last_column)
        u = (azimuth - azimuths[column]) / (azimuths[column + 1] - azimuths[column])
        low, high = table[column], table[column + 1]
        return (low[row] * (1.0 - v) + low[row + 1] * v) * (1.0 - u) + (
            high[row] * (1.0 - v) + high[row + 1] * v
        ) * u

    return look_up


# ---- the compiler's target ----


@contextmanager
def _threads(count: int):
    before = dr.thread_count()
    dr.set_thread_count(count)
    try:
        yield
    finally:
        dr.set_thread_count(before)


@contextmanager
def _one_lane():
    """Let kernels be compiled for single numbers; tells whether that is possible here."""
    core = _core()
    if core is None:
        yield False
        return
    cpu, features, lanes = core[CPU](), core[FEATURES](), core[LANES]()
    core[SET_TARGET](cpu, features, 1)
    try:
        # Several numbers read at once need more lanes than one.
        with dr.scoped_set_flag(dr.JitFlag.PacketOps, False):
            yield True
    finally:
        core[SET_TARGET](cpu, features, lanes)


def _lanes() -> int | None:
    core = _core()
    return None if core is None else int(core[LANES]())


def _core() -> dict | None:
    """Functions of Dr.Jit's library by name; None where they are called otherwise."""
    for path in Path(dr.__file__).parent.glob("libdrjit-core.*"):
        library = ctypes.CDLL(str(path))
        if all(hasattr(library, name) for name in (LANES, CPU, FEATURES, SET_TARGET)):
            made = {name: library[name] for name in (LANES, CPU, FEATURES, SET_TARGET)}
            made[LANES].restype = ctypes.c_uint
            made[CPU].restype = made[FEATURES].restype = ctypes.c_char_p
            made[SET_TARGET].argtypes = (ctypes.c_char_p, ctypes.c_char_p, ctypes.c_uint)
            made[SET_TARGET].restype = None
            return made
    return None
