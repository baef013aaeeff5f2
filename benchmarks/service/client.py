"""Users of a service on this machine: requests that are said again until they are answered, with the time each took."""

import contextlib
import http.client
import json
import re
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from ...engine.errors import LumenrayError

ROOT = "/api/v1"

PATIENCE = 60.0
"""How long an answer is waited for, and a service that has ended. [s]"""

PAUSE = 0.05
"""Before a request is said again. [s]"""

CALL = "import sys; from lumenray.command_line.main import main; sys.exit(main())"


class Server:
    """A service in a process of its own, which can be killed and started again.

    Parameters
    ----------
    folder : Path    Of the service.
    count : int    Jobs at once.
    """

    def __init__(self, folder: Path, count: int):
        self._folder = folder
        self._count = count
        self._process: subprocess.Popen | None = None
        self.port = 0

    def add_user(self, name: str) -> str:
        """Take in a user; returns the token. The service must not run."""
        made = subprocess.run(
            [sys.executable, "-c", CALL, "serve", str(self._folder), "--add-user", name, "--most-jobs", "1000"],
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        return made.stdout.strip()

    def start(self) -> None:
        """Start it, at the port of before if it ran."""
        command = [sys.executable, "-c", CALL, "serve", str(self._folder)]
        command += ["--port", str(self.port), "--jobs", str(self._count)]
        self._process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True
        )
        found = re.search(r":(\d+);", self._process.stdout.readline())
        if found is None:
            raise LumenrayError("the service does not start")
        self.port = int(found[1])

    def kill(self) -> None:
        """End it without a word."""
        self._process.kill()
        self._process.wait()
        self._process.stdout.close()

    def stop(self) -> None:
        """Ask it to end."""
        self._process.terminate()
        self._process.wait()
        self._process.stdout.close()


class Client:
    """One user.

    Parameters
    ----------
    server : Server
    token : str
    """

    def __init__(self, server: Server, token: str):
        self._server = server
        self._headers = {"Authorization": f"Bearer {token}"}
        self._lines = threading.local()
        self.times: list[float] = []
        """Of reads that were answered. [s]"""

    def get(self, path: str) -> dict:
        """Read something, and keep how long it took."""
        return self._say("GET", path, None, {}, is_timed=True)

    def send(self, method: str, path: str, value=None, request: str | None = None) -> dict:
        """Change something; ``request`` is the name under which it is said again."""
        body = value if isinstance(value, bytes) else json.dumps(value).encode()
        headers = {} if request is None else {"Idempotency-Key": request}
        return self._say(method, path, body, headers, is_timed=False)

    def _say(self, method: str, path: str, body, headers: dict, is_timed: bool) -> dict:
        end = time.monotonic() + PATIENCE
        while True:
            begin = time.perf_counter()
            try:
                status, content = self._ask(method, path, body, headers)
            except (OSError, http.client.HTTPException):
                self._drop()
                if time.monotonic() > end:
                    raise LumenrayError("the service does not answer") from None
                time.sleep(PAUSE)
                continue
            if status >= 400:
                raise LumenrayError(f"{method} {path}: {status} {content[:200]!r}")
            if is_timed:
                self.times.append(time.perf_counter() - begin)
            return json.loads(content) if content else {}

    def _ask(self, method: str, path: str, body, headers: dict) -> tuple[int, bytes]:
        line = getattr(self._lines, "line", None)
        if line is None:
            line = http.client.HTTPConnection("127.0.0.1", self._server.port, timeout=PATIENCE)
            self._lines.line = line
        line.request(method, ROOT + path, body, self._headers | headers)
        answer = line.getresponse()
        return answer.status, answer.read()

    def _drop(self) -> None:
        line = getattr(self._lines, "line", None)
        if line is not None:
            line.close()
            self._lines.line = None


@contextlib.contextmanager
def make_server(count: int):
    """A service in a new folder, not yet started; what is left of it is removed in the end."""
    with tempfile.TemporaryDirectory() as name:
        yield Server(Path(name) / "service", count), Path(name) / "service"
