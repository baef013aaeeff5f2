"""Asks services over HTTP: without a line between, and over one of this machine."""

import asyncio
import contextlib
import threading
import time

import httpx
import uvicorn

from lumenray.service import accounts
from lumenray.service.arrivals import Arrivals
from lumenray.service.web.app import Service, make_app
from lumenray.service.web.server import LARGEST_HEAD, PatientProtocol


class Client:
    """Asks the app as one user, without a line between."""

    def __init__(self, served, user):
        arrivals = Arrivals(served.database, served.folders)
        service = Service(
            served.database, served.folders, served.changes, served.supervisor, arrivals
        )
        self.app = make_app(service)
        token = accounts.add_token(served.database, user)
        self.headers = {"Authorization": f"Bearer {token}"}

    def ask(self, method, path, headers=None, **body):
        """The answer to a request."""
        return asyncio.run(self.ask_soon(method, path, headers, **body))

    async def ask_soon(self, method, path, headers=None, **body):
        """The answer to a request, beside others."""
        transport = httpx.ASGITransport(self.app)
        async with httpx.AsyncClient(transport=transport, base_url="http://service") as client:
            return await client.request(method, path, headers=headers or self.headers, **body)


@contextlib.contextmanager
def listening(app):
    """Address at which an app answers as the service does."""
    config = uvicorn.Config(
        app, port=0, http=PatientProtocol, log_level="warning", h11_max_incomplete_event_size=LARGEST_HEAD
    )  # fmt: skip
    server = uvicorn.Server(config)
    thread = threading.Thread(target=server.run)
    thread.start()
    while not server.started:
        time.sleep(0.01)
    try:
        yield server.servers[0].sockets[0].getsockname()
    finally:
        server.should_exit = True
        thread.join()
