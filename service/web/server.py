"""The door of the service: it opens the folder, begins the jobs and answers until it is ended."""

import contextlib
import ipaddress
import os
from dataclasses import dataclass
from pathlib import Path

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from ...engine.errors import LumenrayError
from ..arrivals import Arrivals
from ..changes import Changes
from ..confinement import check_kernel
from ..database import Database
from ..folders import Folders
from ..supervisor import Supervisor
from .app import Service, make_app

HEAD_PATIENCE = 10.0
"""How long the head of a request may take to come. [s]"""

READ_PATIENCE = 60.0
"""How long a client may leave an answer that waits for it unread, of which at least 48 kB fit into the line then. [s]"""

LARGEST_HEAD = 16 << 10
"""[byte]"""

MOST_CONNECTIONS = 500


@dataclass(frozen=True)
class Address:
    """Where the service answers.

    Parameters
    ----------
    host : str    Numbers of an interface of this machine.
    port : int    0: any that is free.
    certificate, key : Path or None    Of TLS, as PEM files.
    is_behind_proxy : bool    Whether something before it speaks TLS.
    """

    host: str = "127.0.0.1"
    port: int = 8080
    certificate: Path | None = None
    key: Path | None = None
    is_behind_proxy: bool = False


class PatientProtocol(H11Protocol):
    """HTTP that does not wait for ever for the head of a request, nor for who does not read what was answered.

    So clients that do nothing, or next to nothing, cannot take all connections.
    """

    _timer = None
    _reading = None

    def connection_made(self, transport):
        """A client is there."""
        super().connection_made(transport)
        self._await_head()

    def data_received(self, data):
        """Something has come."""
        super().data_received(data)
        if self.cycle is None or self.cycle.response_complete:
            self._await_head()
        else:
            self._stop_waiting()

    def connection_lost(self, exc):
        """The client is gone."""
        self._stop_waiting()
        self._stop_reading()
        super().connection_lost(exc)

    def pause_writing(self):
        """The line to the client is full."""
        super().pause_writing()
        if self._reading is None:
            self._reading = self.loop.call_later(READ_PATIENCE, self.transport.abort)

    def resume_writing(self):
        """The client has read."""
        self._stop_reading()
        super().resume_writing()

    def _stop_reading(self) -> None:
        if self._reading is not None:
            self._reading.cancel()
            self._reading = None

    def _await_head(self) -> None:
        if self._timer is None:
            self._timer = self.loop.call_later(HEAD_PATIENCE, self.transport.abort)

    def _stop_waiting(self) -> None:
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None


@contextlib.contextmanager
def open_folder(root: Path):
    """Open the folder of a service, for this process alone; give its `Folders` and its `Database`.

    Raises
    ------
    LumenrayError    Another service is using it, or it is none of ours.
    """
    folders = Folders(root)
    with folders.lock.open("a") as lock:
        _take(lock, root)
        database = Database(folders.database)
        try:
            yield folders, database
        finally:
            database.close()


def check_address(address: Address) -> None:
    """Refuse to let tokens and scenes go over a network for all to read.

    Raises
    ------
    LumenrayError    The address is none, or is reached from other machines without TLS.
    """
    try:
        host = ipaddress.ip_address(address.host)
    except ValueError:
        raise LumenrayError(
            f"--host: expected an address such as 127.0.0.1 or 0.0.0.0, found '{address.host}'"
        ) from None
    if not (host.is_loopback or address.certificate or address.is_behind_proxy):
        raise LumenrayError(
            f"{host} is reached from other machines: state --certificate and --key, or say --behind-proxy where something "
            "else speaks TLS"
        )


def serve(root: Path, address: Address, count: int, seconds: float, say) -> None:
    """Answer until an interrupt or a termination.

    Parameters
    ----------
    root : Path    Folder of the service.
    address : Address
    count : int    Jobs at once.
    seconds : float    After which a job is ended. [s]
    say : callable    Told where the service is, once it answers.

    Raises
    ------
    LumenrayError    The folder, the address or the machine does not allow it.
    """
    check_kernel()
    check_address(address)
    with open_folder(root) as (folders, database):
        changes = Changes()
        supervisor = Supervisor(database, folders, changes, count, seconds)
        arrivals = Arrivals(database, folders)
        app = make_app(Service(database, folders, changes, supervisor, arrivals))
        server = _Server(_configure(app, address), say)
        supervisor.start()
        try:
            server.run()
        finally:
            supervisor.close()
        if not server.has_started:
            raise LumenrayError(
                f"{address.host}:{address.port} cannot be used; another program may be there, choose another --port"
            )


class _Server(uvicorn.Server):
    def __init__(self, config: uvicorn.Config, say):
        super().__init__(config)
        self._say = say
        self.has_started = False

    async def startup(self, sockets=None) -> None:
        with contextlib.suppress(SystemExit):
            await super().startup(sockets)
        if not self.started:
            self.should_exit = True
            return
        self.has_started = True
        host, port = self.servers[0].sockets[0].getsockname()[:2]
        scheme = "https" if self.config.is_ssl else "http"
        self._say(f"{scheme}://{f'[{host}]' if ':' in host else host}:{port}")


def _configure(app, address: Address) -> uvicorn.Config:
    return uvicorn.Config(
        app,
        host=address.host,
        port=address.port,
        http=PatientProtocol,
        loop="asyncio",
        ws="none",
        log_level="warning",
        access_log=False,
        server_header=False,
        proxy_headers=False,
        limit_concurrency=MOST_CONNECTIONS,
        h11_max_incomplete_event_size=LARGEST_HEAD,
        timeout_graceful_shutdown=5,
        ssl_certfile=address.certificate,
        ssl_keyfile=address.key,
    )


def _take(lock, root: Path) -> None:
    if os.name != "posix":
        raise LumenrayError("the service needs Linux: elsewhere uploads cannot be opened safely")
    import fcntl

    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise LumenrayError(f"{root}: another service is using this folder") from None
