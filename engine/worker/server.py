"""The engine's side: takes orders at once, does them in order and by urgency, and sends what comes of them.

One thread reads. The main thread computes, because Mitsuba belongs to one: a job hands over at its pauses between launches,
so that live views go on beside it and more urgent jobs are done inside it.
"""

import gc
import importlib
import os
import sys
import threading
import time
import traceback
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from .. import VERSION
from ..errors import BackendError, Cancelled, CodecError, LumenrayError
from . import faults, process
from .channel import Channel, Message

JOBS = {
    "status": 0,
    "explain": 0,
    "list_workers": 0,
    "render": 1,
    "write_spectral": 1,
    "mix_maps": 1,
    "compute_paint": 1,
    "compute_ink": 3,
    "compute_cloth": 3,
    "measure": 2,
    "measure_sensors": 2,
    "find_daylight": 3,
    "find_lumels": 3,
    "bake_objects": 3,
}
"""Jobs that are answered, and how urgent they are: the lower, the sooner."""

CHANGES = ("apply", "join", "watch", "unwatch", "close")
"""Orders that take no time to speak of and are not answered."""

LEAST_URGENT = 1 << 30

PROGRESS_INTERVAL = 0.1
"""Shortest time between two messages on the progress of a job. [s]"""

COLLECT_WHEN_IDLE, COLLECT_WHEN_BUSY = 0.5, 10.0
"""Time without work after which garbage is collected, and time between two collections in steady work. [s]"""

FAILED = 3
"""Exit code when the line carried nonsense or the engine's own messages failed."""


@dataclass(eq=False)
class Order:
    """Something to do for a session."""

    kind: str
    number: int
    session: str
    body: object
    fault: Exception | None = None
    preview_interval: float | None = None
    is_cancelled: bool = False
    is_answered: bool = False
    is_reporting: bool = False
    next_report: float = 0.0
    next_preview: float = 0.0

    @property
    def urgency(self) -> int:
        """The lower, the sooner."""
        return JOBS[self.kind]


@dataclass(eq=False)
class Desk:
    """What the server keeps for a session: its orders in the order they came, and its live view."""

    name: str
    session: object = None
    orders: deque = field(default_factory=deque)
    is_busy: bool = False
    trouble: Exception | None = None
    view_number: int = 0
    view_failed: bool = False
    is_showing: bool = False
    frame: tuple | None = None


class Server:
    """Serves one line until it ends, which ends the process."""

    def __init__(self, channel: Channel, make_session: Callable, parent: int):
        self._channel = channel
        self._make_session = make_session
        self._desks: dict[str, Desk] = {}
        self._stack: list[Order] = []
        self._lock = threading.RLock()
        self._news = threading.Event()
        self._parent = parent
        self._is_refining = False
        self._next_slice = 0.0
        self._next_collection = 0.0

    def serve(self) -> None:
        """Say hello and work; never returns."""
        self._channel.send({"kind": "hello", "pid": os.getpid(), "version": VERSION})
        # Garbage may hold Dr.Jit's objects. Python frees it on the thread that happens to make the next object, so also on
        # the one that reads while this one makes a kernel, and Dr.Jit ends the process when that happens.
        gc.disable()
        threading.Thread(target=self._read, name="lumenray-read", daemon=True).start()
        while True:
            self._news.clear()
            if self._step():
                self._collect()
            elif not self._news.wait(COLLECT_WHEN_IDLE):
                gc.collect()
                self._news.wait()

    # ---- the reading thread ----

    def _read(self) -> None:
        try:
            while True:
                message = self._channel.receive(1.0)
                if message is not None:
                    self._hear(message)
                elif process.is_orphan(self._parent):
                    os._exit(0)
        except EOFError:
            # The parent is gone or wants no more; what is computed has no reader.
            os._exit(0)
        except BaseException:
            traceback.print_exc()
            sys.stderr.flush()
            os._exit(FAILED)

    def _hear(self, message: Message) -> None:
        head = message.head
        kind, number = head.get("kind"), head.get("number", 0)
        if kind == "ping":
            self._channel.send({"kind": "pong"})
        elif kind == "quit":
            os._exit(0)
        elif kind == "cancel":
            self._cancel(number)
        elif kind == "stop":
            self._stop(number)
        elif kind == "seen":
            self._note_seen(head)
        elif kind in JOBS or kind in CHANGES:
            self._queue(
                Order(
                    kind,
                    number,
                    head["session"],
                    message.body,
                    message.fault,
                    head.get("preview_interval"),
                )
            )
        else:
            raise CodecError(f"an unknown order came: {kind}")

    def _queue(self, order: Order) -> None:
        with self._lock:
            desk = self._desks.setdefault(order.session, Desk(order.session))
            if order.kind == "watch":
                # Only the newest view is worth computing.
                waiting = [other for other in desk.orders if other.kind == "watch"]
                for other in waiting:
                    desk.orders.remove(other)
            desk.orders.append(order)
        self._news.set()

    def _cancel(self, number: int) -> None:
        with self._lock:
            for desk in self._desks.values():
                for order in desk.orders:
                    if order.number == number and order.kind in JOBS:
                        desk.orders.remove(order)
                        self._fail(order, Cancelled("cancelled"))
                        return
            for order in self._stack:
                if order.number != number:
                    continue
                order.is_cancelled = True
                if order is not self._stack[-1]:
                    # It rests below a more urgent one, for which the user need not wait.
                    self._fail(order, Cancelled("cancelled"))
                elif self._desks[order.session].session is not None:
                    self._desks[order.session].session.cancel()

    def _stop(self, number: int) -> None:
        """Let a bake end with what it has; one that has not begun has nothing."""
        with self._lock:
            if not any(order.number == number for order in self._stack):
                self._cancel(number)
                return
            for order in self._stack:
                session = self._desks[order.session].session
                if order.number == number and order.kind == "bake_objects" and session is not None:
                    session.stop()

    def _note_seen(self, head: dict) -> None:
        """Send on what was held back until the other end had dealt with the last of its kind."""
        with self._lock:
            for order in self._stack:
                if order.number == head.get("number"):
                    order.is_reporting = False
            desk = self._desks.get(head.get("session"))
            if desk is None:
                return
            desk.is_showing = False
            if desk.frame is not None:
                self._send_frame(desk, *desk.frame)

    # ---- the main thread ----

    def _collect(self) -> None:
        """Free garbage where it does no harm: what is young every time, everything now and then."""
        now = time.perf_counter()
        if now < self._next_collection:
            gc.collect(1)
            return
        gc.collect()
        self._next_collection = now + COLLECT_WHEN_BUSY

    def _step(self) -> bool:
        """Do the next thing; tell whether there was one."""
        done = self._change()
        order = self._pick(LEAST_URGENT)
        if order is not None:
            self._work(order)
            return True
        return self._refine() or done

    def _pause(self) -> None:
        """Let live views and more urgent jobs have their turn; a job calls this between its launches."""
        if self._is_refining or not self._stack:
            return
        order = self._stack[-1]
        _stop_if_cancelled(order)
        self._change()
        while (other := self._pick(order.urgency)) is not None:
            self._work(other)
        start = time.perf_counter()
        if start >= self._next_slice and self._refine():
            # The job gets as much time as the view took.
            end = time.perf_counter()
            self._next_slice = end + (end - start)
        _stop_if_cancelled(order)

    def _change(self) -> bool:
        """Do all changes that are not behind a job of their own session; tell whether there were any."""
        done = False
        while True:
            with self._lock:
                found = next(
                    (
                        desk
                        for desk in self._desks.values()
                        if desk.orders and not desk.is_busy and desk.orders[0].kind in CHANGES
                    ),
                    None,
                )
                if found is None:
                    return done
                order = found.orders.popleft()
            self._change_one(found, order)
            done = True

    def _change_one(self, desk: Desk, order: Order) -> None:
        if order.kind == "close":
            self._close(desk)
            return
        desk.view_failed = False
        try:
            session, body = self._session(desk), _body_of(order)
            if order.kind == "apply":
                session.apply(body)
            elif order.kind == "join":
                session.join(body)
            elif order.kind == "watch":
                desk.view_number = order.number
                session.watch(*body)
            else:
                desk.view_number = order.number
                session.unwatch()
        except Exception as error:
            desk.view_failed = True
            told = faults.describe(error, order.kind)
            if order.kind == "apply":
                # Nobody waits for a change, so the next job that somebody waits for brings it up.
                desk.trouble = faults.rebuild(*told)
                self._tell("refused", told, session=desk.name)
            self._tell("view_error", told, session=desk.name, number=desk.view_number)

    def _close(self, desk: Desk) -> None:
        with self._lock:
            fresh = Desk(desk.name, orders=desk.orders)
            if fresh.orders:
                self._desks[desk.name] = fresh
            else:
                del self._desks[desk.name]
        close = getattr(desk.session, "close", None)
        if close is not None:
            close()
        desk.session = None
        _free_memory()

    def _session(self, desk: Desk):
        if desk.session is None:
            desk.session = self._make_session(self._pause)
        return desk.session

    def _pick(self, below: int) -> Order | None:
        """Take the most urgent job that is more urgent than ``below``; equal ones in the order they came."""
        with self._lock:
            ready = [
                desk.orders[0]
                for desk in self._desks.values()
                if desk.orders and not desk.is_busy and desk.orders[0].kind in JOBS
            ]
            order = min(ready, key=lambda each: (each.urgency, each.number), default=None)
            if order is None or order.urgency >= below:
                return None
            desk = self._desks[order.session]
            desk.orders.popleft()
            desk.is_busy = True
            self._stack.append(order)
            self._tell_stack()
        return order

    def _work(self, order: Order) -> None:
        desk = self._desks[order.session]
        value, fault = None, None
        try:
            value = self._compute(order, desk)
        except Exception as error:
            fault = error
        with self._lock:
            self._stack.pop()
            desk.is_busy = False
        if fault is None:
            self._answer(order, value)
        else:
            self._fail(order, fault)
        with self._lock:
            self._tell_stack()

    def _compute(self, order: Order, desk: Desk):
        body = _body_of(order)
        if order.kind == "status":
            from ..transport import backend

            return backend.status()
        if desk.trouble is not None:
            trouble, desk.trouble = desk.trouble, None
            raise trouble
        session = self._session(desk)
        _stop_if_cancelled(order)
        arguments, options = body

        def report(state, preview=None):
            self._report(order, state, preview)

        return getattr(session, order.kind)(*arguments, **options, progress=report)

    def _report(self, order: Order, state, preview) -> None:
        _stop_if_cancelled(order)
        now = time.perf_counter()
        if order.is_reporting or now < order.next_report:
            return
        order.next_report = now + PROGRESS_INTERVAL
        picture = None
        if preview is not None and order.preview_interval is not None and now >= order.next_preview:
            picture = preview()
            order.next_preview = time.perf_counter() + order.preview_interval
        order.is_reporting = True
        self._channel.send({"kind": "progress", "number": order.number}, (state, picture))

    def _refine(self) -> bool:
        """Work on one live view for a moment; tell whether one wanted it. They take turns."""
        with self._lock:
            desks = list(self._desks.values())
        for desk in desks:
            if desk.session is None or desk.is_busy or desk.view_failed:
                continue
            try:
                if not desk.session.has_view_work:
                    continue
                self._is_refining = True
                frame = desk.session.refine()
            except Exception as error:
                desk.view_failed = True
                told = faults.describe(error, "live view")
                self._tell("view_error", told, session=desk.name, number=desk.view_number)
                return True
            finally:
                self._is_refining = False
            with self._lock:
                if self._desks.get(desk.name) is desk:
                    # To the end of the row.
                    self._desks[desk.name] = self._desks.pop(desk.name)
                    if frame is not None:
                        self._send_frame(desk, desk.view_number, frame)
            return True
        return False

    def _send_frame(self, desk: Desk, number: int, frame) -> None:
        """Send a frame; while one is on its way, only the newest waits."""
        if desk.is_showing:
            desk.frame = (number, frame)
            return
        desk.frame = None
        desk.is_showing = True
        try:
            self._channel.send({"kind": "frame", "session": desk.name, "number": number}, frame)
        except (LumenrayError, MemoryError) as error:
            desk.is_showing = False
            desk.view_failed = True
            told = faults.describe(error, "live view")
            self._tell("view_error", told, session=desk.name, number=number)

    def _answer(self, order: Order, value) -> None:
        if order.is_answered:
            return
        try:
            self._channel.send({"kind": "answer", "number": order.number}, value)
        except (LumenrayError, MemoryError) as error:
            self._fail(order, error)

    def _fail(self, order: Order, error: Exception) -> None:
        if order.is_answered:
            return
        order.is_answered = True
        told = faults.describe(error, order.kind.partition("_")[0])
        # What could not be loaded may be there for a new process, and this one has it in part.
        is_last = isinstance(error, BackendError)
        self._tell("error", told, number=order.number, is_last=is_last)
        if faults.is_of_memory(error):
            _free_memory(error)

    def _tell(self, kind: str, told: tuple[str, str, dict], **more) -> None:
        name, text, attributes = told
        head = {"kind": kind, "class": name, "text": text, "attributes": attributes, **more}
        self._channel.send(head)

    def _tell_stack(self) -> None:
        self._channel.send({"kind": "stack", "numbers": [each.number for each in self._stack]})


def _free_memory(error: BaseException | None = None) -> None:
    """Give back what a fault and libraries keep, so that the next job, or another program, finds room."""
    # What the functions that it came through were at work on lives as long as it does.
    cause = error
    while cause is not None:
        traceback.clear_frames(cause.__traceback__)
        cause = cause.__cause__ or cause.__context__
    gc.collect()
    if "drjit" in sys.modules:
        import drjit

        drjit.flush_malloc_cache()


def _body_of(order: Order):
    if order.fault is not None:
        raise order.fault
    return order.body


def _stop_if_cancelled(order: Order) -> None:
    if order.is_cancelled:
        raise Cancelled("cancelled")


def main(order: dict) -> None:
    """Run the engine in this process, as the parent ordered on standard input."""
    connection = process.settle(order)
    Server(Channel(connection), _factory(order["factory"]), order["parent"]).serve()


def _factory(name: str | None) -> Callable:
    """Return what makes a session: the engine's own, or ``module:callable``."""
    if name is None:
        from ..session import Session

        return lambda pause: Session(interrupt=pause)
    module, _, attribute = name.partition(":")
    return getattr(importlib.import_module(module), attribute)
