"""Cycles in a process of its own, which holds Blender's Python module."""

import secrets
import subprocess
import sys
from importlib import util
from multiprocessing.connection import Client
from pathlib import Path

from ...validation.bench import CannotStateError
from ...validation.peers.cycles import SERVER as BUILDER

SERVER = Path(__file__).with_name("cycles_server.py")


class CyclesProcess:
    """The process. `close` ends it.

    Parameters
    ----------
    task : Path    Module that answers requests, see `cycles_server`.
    patience : float    Longest that one request may take. [s]

    Raises
    ------
    CannotStateError    The package `bpy` is missing, or the process does not start.
    """

    def __init__(self, task: Path, patience: float):
        if util.find_spec("bpy") is None:
            raise CannotStateError("bpy is not installed (run 'make setup')")
        self._patience = patience
        # Without -P its folder would be searched first, and Blender's add-on is called cycles too.
        self._process = subprocess.Popen(
            [sys.executable, "-P", str(SERVER)],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        key = secrets.token_bytes(16)
        self._process.stdin.write(f"{key.hex()}\n{BUILDER}\n{task}\n".encode())
        self._process.stdin.close()
        address = self._process.stdout.readline().decode().strip()
        self._process.stdout.close()
        if not address:
            code = self._process.wait()
            raise CannotStateError(f"Blender's process ended at once (exit code {code})")
        self._link = Client(address, authkey=key)

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._process.pid

    def ask(self, request: dict):
        """Send a request and return its answer.

        Raises
        ------
        CannotStateError    Blender refuses it, ends over it or takes too long.
        """
        self._link.send(request)
        if not self._link.poll(self._patience):
            raise CannotStateError(f"Cycles took longer than {self._patience:g} s")
        try:
            answer = self._link.recv()
        except (EOFError, OSError) as error:
            raise CannotStateError(f"Blender's process ended ({error!r})") from None
        if isinstance(answer, str):
            raise CannotStateError(f"Blender refuses: {answer}")
        return answer

    def close(self) -> None:
        """End the process."""
        self._link.close()
        self._process.kill()
        self._process.wait()
