"""Cycles as an instrument: Blender's Python module in a process of its own."""

import secrets
import subprocess
import sys
from importlib import util
from multiprocessing.connection import Client, Connection
from pathlib import Path
from weakref import finalize

import numpy as np

from ..bench import CannotStateError, Query, Readings
from .contents import check_query, extent, scattered, sort_items
from .cycles_scene import describe

SERVER = Path(__file__).with_name("blender_server.py")

PATIENCE = 300.0
"""Longest that one query may take. [s]"""

LEAST_SIDE, MOST_SIDE = 4, 64
"""Each sensor is a square of that many patches along a side, which are measured apart; their spread gives the error."""

LEAST_SAMPLES, MOST_SAMPLES = 16, 1024
"""For a patch: Cycles adds them up in single precision, and rounding shows beyond."""

RECEIVER = 5e-5
"""Side of the square. [m], or share of the scene's size if that is less"""

LIFT = 2e-6
"""How far sensors are lifted off the surface that they may lie on, in the same way."""

ROUNDING = 4e-7
"""What is added to both, as a share of the largest coordinate: Cycles' single precision."""

LONGEST = 0.99
"""Largest share of scattered light that paths are shortened for."""

WIDEST = 200.0
"""Distance between sensors beyond which each is asked for alone, for Cycles' single precision. [m]"""


class Cycles:
    """Cycles with all its limits set to their most accurate.

    Parameters
    ----------
    paths : int    About how many paths a query may take, all sensors together.

    Raises
    ------
    CannotStateError    The package `bpy` is missing.
    """

    name = "Cycles"

    def __init__(self, paths: int = 1_000_000):
        if util.find_spec("bpy") is None:
            raise CannotStateError("bpy is not installed (run 'make setup')")
        self.paths = paths
        self._link: Connection | None = None
        self._close = None

    def measure(self, items, query: Query, seed: int) -> Readings:
        """Return illuminances with errors from the spread of the patches."""
        check_query(query)
        positions = np.asarray(query.positions, dtype=np.float64)
        if len(positions) > 1 and np.linalg.norm(np.ptp(positions, axis=0)) > WIDEST:
            parts = [slice(k, k + 1) for k in range(len(positions))]
        else:
            parts = [slice(None)]
        contents = sort_items(items)
        normals = query.normals / np.linalg.norm(query.normals, axis=1, keepdims=True)
        values, errors = np.empty(len(positions)), np.empty(len(positions))
        for part in parts:
            values[part], errors[part] = self._measure(
                contents, positions[part], normals[part], query.reflections == 0, seed, len(parts)
            )
        return Readings(values, errors)

    def close(self) -> None:
        """End the process."""
        if self._close is not None:
            self._close()
        self._link = self._close = None

    def _measure(self, contents, positions, normals, direct: bool, seed: int, queries: int):
        middle, size = extent(contents, positions)
        unit = min(1.0, size) if size > 0.0 else 1.0
        moved = (positions - middle) / unit
        rounding = ROUNDING * np.abs(moved).max()
        if contents.parts:
            moved += (LIFT + rounding) * normals
        request = describe(contents, middle, unit)
        # Paths get longer the more is reflected.
        share = self.paths / (len(positions) * _path_cost(contents, direct) * queries)
        side = int(np.clip(np.sqrt(share / MOST_SAMPLES), LEAST_SIDE, MOST_SIDE))
        request |= {
            "positions": moved,
            "normals": normals,
            "receiver": RECEIVER + 4.0 * rounding,
            "side": side,
            "samples": int(np.clip(share / side**2, LEAST_SAMPLES, MOST_SAMPLES)),
            "seed": seed,
            "direct": direct,
        }
        made = self._ask(request)
        return made.mean(axis=1), made.std(axis=1, ddof=1) / side

    def _ask(self, request: dict) -> np.ndarray:
        if self._link is None:
            self._start()
        try:
            self._link.send(request)
            if not self._link.poll(PATIENCE):
                self.close()
                raise CannotStateError(f"Cycles took longer than {PATIENCE:g} s")
            answer = self._link.recv()
        except (EOFError, OSError) as error:
            self.close()
            raise CannotStateError(f"Blender's process ended ({error!r})") from None
        if isinstance(answer, str):
            raise CannotStateError(f"Blender refuses: {answer}")
        return answer

    def _start(self) -> None:
        key = secrets.token_bytes(16)
        # Without -P its folder would be searched first, and Blender's add-on is called cycles too.
        process = subprocess.Popen(
            [sys.executable, "-P", str(SERVER)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        process.stdin.write(f"{key.hex()}\n".encode())
        process.stdin.close()
        address = process.stdout.readline().decode().strip()
        process.stdout.close()
        if not address:
            raise CannotStateError(f"Blender's process ended at once (exit code {process.wait()})")
        self._link = Client(address, authkey=key)
        self._close = finalize(self, _end, self._link, process)


def _path_cost(contents, direct: bool) -> float:
    """Length of the paths over that of those that end at once."""
    shares = [scattered(part.material.surface) for part in contents.parts]
    most = 0.0 if direct else min(max(shares, default=0.0), LONGEST)
    return 0.5 + 0.5 / (1.0 - most)


def _end(link: Connection, process: subprocess.Popen) -> None:
    link.close()
    process.kill()
    process.wait()
