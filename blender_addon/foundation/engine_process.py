"""The one worker of this Blender: started when it is needed, ended with the file, the extension or Blender."""

import atexit
from pathlib import Path

from bpy.app.handlers import persistent

from ...engine.worker.client import RemoteSession, Worker
from .handlers import leave, listen
from .preferences import device, memory_limit

ROOT = Path(__file__).resolve().parents[2]
"""Folder of the package, which has other names inside Blender."""

_worker = Worker(ROOT)


def open_session(name: str) -> RemoteSession:
    """Return the engine's session of a name, an empty one if it is new. Starts the worker if need be.

    Raises
    ------
    EngineLost    The worker cannot be started; the text says why.
    """
    if not _worker.is_alive:
        _worker.memory_limit = memory_limit()
        if device():
            _worker.device = device()
        _worker.start()
    return _worker.session(name)


def note_device(key: str) -> None:
    """Take the device that the probe found to work when the engine starts next; empty: try them then."""
    _worker.device = key


def is_running() -> bool:
    """Tell whether there is a process."""
    return _worker.is_alive


def pid() -> int | None:
    """Return the number of the process, None without one."""
    return _worker.pid


def why_lost() -> str | None:
    """Say why the last process is gone; None while one serves, and before the first."""
    return _worker.lost if not _worker.is_alive else None


def close() -> None:
    """End the process and all its sessions."""
    _worker.close()


@persistent
def _end_with_file(*_):
    close()


_HANDLERS = {"load_pre": _end_with_file}


def attach():
    """Tie the worker to the file and to Blender."""
    listen(_HANDLERS)
    atexit.register(close)


def detach():
    """End the worker for good."""
    leave(_HANDLERS)
    atexit.unregister(close)
    close()
