"""Tells those who wait for news of a user's jobs that there are some; across threads."""

import asyncio
import threading
from contextlib import contextmanager, suppress


class Changes:
    """Who waits, and for whose jobs. Until `attach`, nobody can."""

    def __init__(self):
        self._loop: asyncio.AbstractEventLoop | None = None
        self._lock = threading.Lock()
        self._waiting: dict[str, set[asyncio.Event]] = {}

    def attach(self, loop: asyncio.AbstractEventLoop) -> None:
        """State the loop on which they wait."""
        self._loop = loop

    @contextmanager
    def listen(self, user: str):
        """Give an event that is set at each change, on the loop."""
        event = asyncio.Event()
        with self._lock:
            self._waiting.setdefault(user, set()).add(event)
        try:
            yield event
        finally:
            with self._lock:
                self._waiting[user].discard(event)
                if not self._waiting[user]:
                    del self._waiting[user]

    def tell(self, user: str) -> None:
        """Say that something of a user has changed; from any thread."""
        with self._lock:
            events = tuple(self._waiting.get(user, ()))
        for event in events:
            # A loop that has been closed has nobody who waits.
            with suppress(RuntimeError):
                self._loop.call_soon_threadsafe(event.set)
