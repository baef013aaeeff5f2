"""The processes of a cluster: a scheduler, and workers of one Mitsuba each; here, or started beside this one."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

from .. import llvm
from ..errors import BackendError, EngineLost, LumenrayError
from ..worker.process import end_with_parent
from .dask_crew import PATIENCE, load_dask
from .security import Address, Certificates, check_address, make_security

ROOT = Path(__file__).parents[2]

BOOTSTRAP = """
import importlib.util, json, sys
order = json.loads(sys.stdin.buffer.raw.readline())
sys.path[:] = order["search_path"]
spec = importlib.util.spec_from_file_location(
    "lumenray", order["root"] + "/__init__.py", submodule_search_locations=[order["root"]]
)
sys.modules["lumenray"] = importlib.util.module_from_spec(spec)
from lumenray.engine.cluster import hosts
hosts.serve(order)
"""
"""A new interpreter, not a copy of this one: copies of processes with threads, as Dr.Jit and Dask have, may stand still."""

HERE = "127.0.0.1:0"
"""Where what Dask tells by HTTP, without any key, can be read: on the machine itself."""


def run_scheduler(
    address: Address, certificates: Certificates | None, ready=lambda address: None
) -> None:
    """Be a scheduler until interrupted. ``ready``: told the address once it listens.

    Raises
    ------
    LumenrayError    The address may not be used, or cannot be listened at.
    """
    check_address(address, certificates)
    distributed = load_dask()
    security = make_security(address, certificates)

    async def serve() -> None:
        try:
            scheduler = distributed.Scheduler(
                host=address.host,
                port=address.port,
                protocol=address.protocol,
                security=security,
                dashboard=False,
                dashboard_address=HERE,
            )
            async with scheduler:
                ready(scheduler.address)
                await scheduler.finished()
        except (OSError, RuntimeError) as error:
            # Dask says that it has failed to start, and why in the error behind.
            cause = error.__cause__ or error
            raise LumenrayError(f"{address} cannot be listened at ({cause})") from None

    asyncio.run(serve())


def run_worker(
    address: Address,
    certificates: Certificates | None,
    threads: int | None = None,
    ready=lambda address: None,
) -> None:
    """Be a worker of a scheduler until interrupted or until the scheduler is gone.

    Parameters
    ----------
    threads : int or None    Of Dr.Jit; None: one for each processor.
    ready : callable    Told the worker's own address once it can be given work.

    Raises
    ------
    LumenrayError    The address may not be used, nobody answers there, or the engine cannot compute on this machine.
    """
    check_address(address, certificates)
    distributed = load_dask()
    _start_engine(threads)
    security = make_security(address, certificates)

    async def serve(folder: str) -> None:
        try:
            worker = distributed.Worker(
                str(address),
                # Workers talk among each other and with the scheduler; on one machine nobody else may.
                host=address.host if address.is_own_machine else None,
                nthreads=1,
                # Memory is the engine's: Dask would stop at a share of it, or write to disk what has no use there.
                memory_limit=0,
                security=security,
                local_directory=folder,
                dashboard=False,
                dashboard_address=HERE,
                death_timeout=PATIENCE,
            )
            async with worker:
                ready(worker.address)
                await worker.finished()
        except (OSError, RuntimeError, TimeoutError) as error:
            cause = error.__cause__ or error
            raise LumenrayError(f"no scheduler answers at {address} ({cause})") from None

    with tempfile.TemporaryDirectory(
        prefix="lumenray-worker-", ignore_cleanup_errors=True
    ) as folder:
        asyncio.run(serve(folder))


def _start_engine(threads: int | None) -> None:
    from ..transport import backend

    llvm.settle()
    status = backend.status()
    if not status.usable:
        raise BackendError(f"{status.cause}; {status.remedy}")
    if threads is not None:
        import drjit as dr

        dr.set_thread_count(threads)


def serve(order: dict) -> None:
    """Be what a parent process has ordered on standard input, and end with it."""
    # An interrupt at the keyboard is for the parent, which then ends this process.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    if sys.platform != "win32":
        end_with_parent()
    # Whatever a library prints must not get into the answer.
    answers = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    address = Address(**order["address"])
    certificates = order["certificates"]
    if certificates is not None:
        certificates = Certificates(**{name: Path(path) for name, path in certificates.items()})

    def ready(own: str) -> None:
        answers.write(json.dumps({"address": own}) + "\n")
        answers.flush()

    try:
        if order["role"] == "scheduler":
            run_scheduler(address, certificates, ready)
        else:
            run_worker(address, certificates, order["threads"], ready)
    except LumenrayError as error:
        answers.write(json.dumps({"fault": str(error)}) + "\n")
        answers.flush()


@dataclass
class Host:
    """A process of a cluster that this one has started."""

    process: subprocess.Popen
    address: str

    @property
    def pid(self) -> int:
        """Of the process."""
        return self.process.pid

    @property
    def is_running(self) -> bool:
        """Whether it has not ended."""
        return self.process.poll() is None

    def end(self) -> None:
        """End it now, also where it is stopped."""
        self.process.kill()
        self.process.wait()
        self.process.stdin.close()
        self.process.stdout.close()


class LocalCluster:
    """A scheduler and workers on this machine, for trying and for tests; gone at the end of the block.

    Parameters
    ----------
    workers : int
    port : int    0: a free one.
    threads : int or None    Of each worker; None: the processors shared out.
    """

    def __init__(self, workers: int, port: int = 0, threads: int | None = None):
        self._count, self._port = workers, port
        self._threads = threads or max((os.cpu_count() or 1) // max(workers, 1), 1)
        self.scheduler: Host | None = None
        self.workers: list[Host] = []

    @property
    def address(self) -> Address:
        """Of the scheduler."""
        host, _, port = self.scheduler.address.rpartition("/")[2].rpartition(":")
        return Address("tcp", host, int(port))

    def __enter__(self) -> "LocalCluster":
        try:
            self.scheduler = _start("scheduler", Address("tcp", "127.0.0.1", self._port), None)
            for _ in range(self._count):
                self.add_worker()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_) -> None:
        for host in (*self.workers, *([self.scheduler] if self.scheduler else [])):
            host.end()
        self.workers, self.scheduler = [], None

    def add_worker(self) -> Host:
        """Start one more worker and wait until it can be given work.

        Raises
        ------
        EngineLost    It cannot be started; the text says why.
        """
        host = _start("worker", self.address, self._threads)
        self.workers.append(host)
        return host


def _start(role: str, address: Address, threads: int | None) -> Host:
    order = {
        "role": role,
        "root": str(ROOT),
        "search_path": list(sys.path),
        "address": vars(address),
        "certificates": None,
        "threads": threads,
    }
    try:
        process = subprocess.Popen(  # noqa: S603 - this very Python and our own text
            [sys.executable, "-I", "-X", "utf8", "-c", BOOTSTRAP],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            bufsize=0,
        )
    except OSError as error:
        raise EngineLost(f"a {role} cannot be started: {error}; free memory") from error
    process.stdin.write(json.dumps(order).encode() + b"\n")
    line = process.stdout.readline()
    told = json.loads(line) if line else {"fault": "it ended by itself"}
    host = Host(process, told.get("address", ""))
    if "fault" in told:
        host.end()
        raise EngineLost(f"a {role} cannot be started: {told['fault']}")
    return host
