"""Tells those who wait for news of a user's jobs that there are some; across threads."""

import asyncio
import threading
from contextlib import contextmanager, suppress


class Changes:
    """Who waits, and for whose jobs."""

    def __init__(self):
        self._lock = threading.Lock()
        self._waiting: dict[str, set[tuple[asyncio.AbstractEventLoop, asyncio.Event]]] = {}

    @contextmanager
    def listen(self, user: str):
        """Give an event that is set at each change, on the loop that runs here."""
        waiter = asyncio.get_running_loop(), asyncio.Event()
        with self._lock:
            self._waiting.setdefault(user, set()).add(waiter)
        try:
            yield waiter[1]
        finally:
            with self._lock:
                self._waiting[user].discard(waiter)
                if not self._waiting[user]:
                    del self._waiting[user]

    def tell(self, user: str) -> None:
        """Say that something of a user has changed; from any thread."""
        with self._lock:
            waiting = tuple(self._waiting.get(user, ()))
        for loop, event in waiting:
            # On a loop that has been closed nobody waits any more.
            with suppress(RuntimeError):
                loop.call_soon_threadsafe(event.set)
