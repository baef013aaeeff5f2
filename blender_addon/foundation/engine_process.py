"""The one worker of this Blender: started when it is needed, ended with the file, the extension or Blender."""

import atexit
from dataclasses import dataclass
from pathlib import Path

from bpy.app.handlers import persistent

from ...imports import loaded_when_used
from .cluster_place import place_of
from .handlers import leave, listen
from .preferences import device, memory_limit

with loaded_when_used():
    from ...engine.worker import client

ROOT = Path(__file__).resolve().parents[2]
"""Folder of the package, which has other names inside Blender."""

SESSIONS = "lumenray.engine.cluster.shared_session:make_session"
"""What makes the sessions of the worker: such as can have a cluster compute."""


@dataclass
class _State:
    """The worker once there was a session, and the device that its next process is started for; empty: try them then."""

    worker: "client.Worker | None" = None
    device: str = ""


_state = _State()


def open_session(name: str, scene=None) -> "client.RemoteSession":
    """Return the engine's session of a name, an empty one if it is new. Starts the worker if need be.

    ``scene``: whose jobs these are, so that the cluster does them if the scene wants that; None: they stay here.

    Raises
    ------
    EngineLost    The worker cannot be started; the text says why.
    LumenrayError    As of `place_of`.
    """
    place = None if scene is None else place_of(scene)
    if _state.worker is None:
        _state.worker = client.Worker(ROOT, factory=SESSIONS)
    if not _state.worker.is_alive:
        _state.worker.memory_limit = memory_limit()
        _state.worker.device = device() or _state.device
        _state.worker.start()
    session = _state.worker.session(name)
    session.join(place)
    return session


def note_device(key: str) -> None:
    """Take the device that the probe found to work when the engine starts next; empty: try them then."""
    _state.device = key


def is_running() -> bool:
    """Tell whether there is a process."""
    return _state.worker is not None and _state.worker.is_alive


def pid() -> int | None:
    """Return the number of the process, None without one."""
    return None if _state.worker is None else _state.worker.pid


def why_lost() -> str | None:
    """Say why the last process is gone; None while one serves, and before the first."""
    if _state.worker is None or _state.worker.is_alive:
        return None
    return _state.worker.lost


def close() -> None:
    """End the process and all its sessions."""
    if _state.worker is not None:
        _state.worker.close()


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
