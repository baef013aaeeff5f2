"""The engine's process: how it is started, tied to its parent, reached and watched."""

import faulthandler
import json
import os
import secrets
import signal
import socket
import subprocess
import sys
from multiprocessing.connection import Client, Listener
from pathlib import Path

from ..errors import EngineLost
from ..transport.devices import CHOICE
from . import channel

if sys.platform != "win32":
    import fcntl
    import resource
    from multiprocessing.connection import Connection

NICENESS = 5
"""How much the engine stands back for other programs, Blender above all."""

BOOTSTRAP = """
import importlib.util, json, sys
order = json.loads(sys.stdin.buffer.raw.readline())
root, sys.path[:] = order["root"], order["search_path"]
spec = importlib.util.spec_from_file_location(
    "lumenray", root + "/__init__.py", submodule_search_locations=[root]
)
sys.modules["lumenray"] = importlib.util.module_from_spec(spec)
from lumenray.engine.worker import server
server.main(order)
"""
"""Inside Blender the package has another name, so the new process finds it by its folder."""


class Process:
    """The parent's hold on the process. Standard input stays open: its end tells the process that the parent is gone."""

    def __init__(
        self,
        root: Path,
        search_path: list[str],
        memory_limit: int | None,
        device: str,
        factory: str | None,
    ):
        self._key = secrets.token_bytes(32)
        self._listener = self._ours = theirs = None
        order = {
            "root": str(root),
            "search_path": search_path,
            "memory_limit": memory_limit,
            "device": device,
            "factory": factory,
            "parent": os.getpid(),
            "key": self._key.hex(),
        }
        if sys.platform == "win32":
            self._listener = Listener(family="AF_PIPE")
            order["address"] = self._listener.address
        else:
            self._ours, theirs = socket.socketpair()
            order["handle"] = theirs.fileno()
        try:
            self._process = self._start(order, theirs)
        except OSError as error:
            self._let_go()
            raise EngineLost(
                f"the engine cannot be started: {error}; free memory or reinstall Blender"
            ) from error
        finally:
            if theirs is not None:
                theirs.close()
        self.pid = self._process.pid
        self.output = self._process.stdout

    def connect(self):
        """Return the connection, after both ends have proved themselves.

        Raises
        ------
        EOFError, OSError, multiprocessing.AuthenticationError    The process ended or is another one.
        """
        if self._listener is not None:
            connection = self._listener.accept()
        else:
            connection = Connection(self._ours.detach())
        self._let_go()
        try:
            channel.prove(connection, self._key, is_host=True)
        except BaseException:
            connection.close()
            raise
        return connection

    def is_running(self) -> bool:
        """Tell whether the process has not ended."""
        return self._process.poll() is None

    def kill(self) -> None:
        """End the process now."""
        self._process.kill()
        if self._listener is not None:
            self._release_listener()

    def wait(self, seconds: float) -> int | None:
        """Return the exit code; None while it runs after so many seconds. [s]"""
        try:
            return self._process.wait(seconds)
        except subprocess.TimeoutExpired:
            return None

    def close(self) -> None:
        """Let go of an ended process."""
        self._let_go()
        self._process.stdin.close()

    def work(self) -> tuple[int, str] | None:
        """Return processor time so far, in clock ticks, and the state letter; None where the system does not tell."""
        if sys.platform != "linux":
            return None
        try:
            text = Path(f"/proc/{self.pid}/stat").read_text(encoding="ascii", errors="replace")
        except OSError:
            return None
        rest = text.rpartition(")")[2].split()
        return int(rest[11]) + int(rest[12]), rest[0]

    def _start(self, order: dict, theirs) -> subprocess.Popen:
        process = subprocess.Popen(  # noqa: S603 - Blender's own Python and our own text
            [sys.executable, "-I", "-X", "utf8", "-c", BOOTSTRAP],
            stdin=subprocess.PIPE,
            # All that is printed goes to the log: the line has a file of its own.
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            bufsize=0,
            pass_fds=() if theirs is None else (theirs.fileno(),),
            creationflags=getattr(subprocess, "CREATE_NO_WINDOW", 0),
        )
        try:
            # The key goes neither into the arguments nor into the environment, which others can read.
            process.stdin.write(json.dumps(order).encode() + b"\n")
        except BaseException:
            process.kill()
            process.wait()
            process.stdin.close()
            process.stdout.close()
            raise
        return process

    def _let_go(self) -> None:
        if self._listener is not None:
            self._listener.close()
            self._listener = None
        if self._ours is not None:
            self._ours.close()
            self._ours = None

    def _release_listener(self) -> None:
        """Wake a thread that waits for a process that will not come."""
        try:
            Client(self._listener.address, family="AF_PIPE").close()
        except OSError:
            # Nobody waits any more.
            return


def settle(order: dict):
    """Set up the new process as its parent ordered, and return its connection."""
    faulthandler.enable()
    # An interrupt at the keyboard is for the parent.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if order["device"]:
        os.environ[CHOICE] = order["device"]
    if sys.platform == "win32":
        connection = Client(order["address"], family="AF_PIPE")
    else:
        end_with_parent()
        # The engine takes all processors; the window goes first.
        os.nice(NICENESS)
        if order["memory_limit"]:
            hard = resource.getrlimit(resource.RLIMIT_AS)[1]
            resource.setrlimit(resource.RLIMIT_AS, (order["memory_limit"], hard))
        # Large meshes stay mapped, and each mapping may hold a descriptor.
        hard = resource.getrlimit(resource.RLIMIT_NOFILE)[1]
        resource.setrlimit(resource.RLIMIT_NOFILE, (hard, hard))
        os.set_inheritable(order["handle"], False)
        connection = Connection(order["handle"])
    channel.prove(connection, bytes.fromhex(order["key"]), is_host=False)
    return connection


def is_orphan(parent: int) -> bool:
    """Tell whether the parent of that number is gone; on Windows the line's end alone tells."""
    return sys.platform != "win32" and os.getppid() != parent


def end_with_parent() -> None:
    """Let the system end this process when standard input ends, whatever native code is at.

    The reading thread notices the parent's end too, but only when it gets its turn.
    """
    if hasattr(fcntl, "F_SETSIG"):
        # Linux: a stopped process heeds no other signal.
        fcntl.fcntl(0, fcntl.F_SETSIG, signal.SIGKILL)
    else:
        signal.signal(signal.SIGIO, signal.SIG_DFL)
    fcntl.fcntl(0, fcntl.F_SETOWN, os.getpid())
    fcntl.fcntl(0, fcntl.F_SETFL, fcntl.fcntl(0, fcntl.F_GETFL) | os.O_ASYNC)
