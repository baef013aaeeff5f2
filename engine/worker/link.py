"""Blender's hold on one engine process, from its start to its end: calls under way, live views, signs of life."""

import atexit
import itertools
import multiprocessing
import os
import threading
import time
import traceback
import weakref
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

from .. import VERSION
from ..accuracy.stopping import Progress
from ..errors import CodecError, EngineLost, LumenrayError
from ..kernel_cache import NewKernels
from . import faults
from .channel import Channel, Message
from .process import Process
from .pulse import TICK, Pulse

CANCEL_PATIENCE = 20.0
"""How long a job may take to obey a cancel. [s]"""

POLL = 0.05
"""Time between two looks of a waiting caller. [s]"""

LOG_LINES = 50
"""Lines of the engine's output that are kept."""

JOB_NAMES = {
    "status": "check",
    "explain": "choice of models",
    "list_workers": "question for workers",
    "render": "render",
    "write_spectral": "writing of a spectral picture",
    "mix_maps": "mixing of maps",
    "compute_paint": "computation of a paint",
    "measure": "measurement",
    "measure_sensors": "measurement",
    "find_daylight": "daylight of the year",
    "find_lumels": "layout of maps",
    "bake_objects": "bake",
    "compute_ink": "computation of a pigment layer",
    "compute_cloth": "computation of a cloth",
}
"""What people call the jobs, all of them: others wait for any."""


@dataclass(eq=False)
class Call:
    """A job that somebody waits for, or has given up.

    ``news``: progress that the caller has not seen; ``patience``: how long it may take to obey a cancel. [s]
    """

    number: int
    kind: str
    session: str
    start: float
    patience: float
    done: float = 0.0
    news: tuple | None = None
    value: object = None
    error: LumenrayError | None = None
    is_done: bool = False
    cancel_age: float | None = None


@dataclass(eq=False)
class View:
    """State of a session's live view as far as it has been heard of."""

    first_number: int = 0
    newest_number: int = 0
    frame: object = None
    error: str | None = None
    is_watched: bool = False
    is_final: bool = False
    applied: int = 0


_LINKS: weakref.WeakSet = weakref.WeakSet()
"""All that have a process, for the end of the program."""


class Link:
    """One process and all that is under way with it; ends once and for all with the process."""

    def __init__(self, process: Process, hung_after: float, cancel_patience: float):
        self._process = process
        self._hung_after = hung_after
        self._cancel_patience = cancel_patience
        self._channel: Channel | None = None
        self._lock = threading.RLock()
        self._changed = threading.Condition(self._lock)
        self._numbers = itertools.count(1)
        self._calls: dict[int, Call] = {}
        self._views: dict[str, View] = {}
        self._stack: list[int] = []
        self._log: deque[str] = deque(maxlen=LOG_LINES)
        self._reason: str | None = None
        self._lost: str | None = None
        self._is_ready = False
        self._drain_thread = threading.Thread(target=self._drain, name="lumenray-log", daemon=True)
        self._read_thread = threading.Thread(target=self._read, name="lumenray-read", daemon=True)
        _LINKS.add(self)
        self._drain_thread.start()
        self._read_thread.start()

    @property
    def pid(self) -> int:
        """Of the engine's process."""
        return self._process.pid

    @property
    def lost(self) -> str | None:
        """Why the process is gone; None while it serves."""
        return self._lost or self._reason

    def log(self) -> tuple[str, ...]:
        """Return the last lines that the process wrote."""
        return tuple(self._log)

    def wait_until_ready(self, seconds: float) -> None:
        """Wait for the first word. [s]

        Raises
        ------
        EngineLost    It did not come.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._is_ready or self._lost is not None, seconds)
            is_late = not self._is_ready and self._lost is None
        if is_late:
            self.lose(
                f"the engine did not start within {seconds:.0f} s and was ended; "
                "try again when the computer is less busy"
            )
            self._read_thread.join(5.0)
        self.check()

    def check(self) -> None:
        """Raise `EngineLost` when the process is gone."""
        if self.lost is not None:
            raise EngineLost(self.lost)

    def view(self, session: str) -> View:
        """Return the state of a session's live view."""
        with self._lock:
            return self._views.setdefault(session, View())

    def take_frame(self, session: str):
        """Return the newest frame of a session's live view, once."""
        with self._lock:
            view = self.view(session)
            frame, view.frame = view.frame, None
        return frame

    def apply(self, session: str, delta) -> None:
        """Send a delta and count it. Raises as `post`."""
        with self._lock:
            self.post("apply", session, delta)
            view = self.view(session)
            view.applied += 1
            view.is_final, view.error = False, None

    def watch(self, session: str, body) -> None:
        """Send the wish for a live view. Raises as `post`."""
        with self._lock:
            number = self.post("watch", session, body)
            view = self.view(session)
            view.newest_number = number
            view.is_watched, view.is_final, view.error = True, False, None

    def unwatch(self, session: str) -> None:
        """Send the wish to end a live view, and forget its frames."""
        with self._lock:
            view = self.view(session)
            view.is_watched, view.frame, view.error = False, None, None
            if self.lost is None:
                view.first_number = self.post("unwatch", session)

    def close_session(self, session: str) -> None:
        """Let the worker forget a session, whose name may be given to another. Raises as `post`."""
        with self._lock:
            # What of the old one is still on its way is not for the new one.
            self._views[session] = View(first_number=self.post("close", session))

    def post(self, kind: str, session: str, body=None) -> int:
        """Send an order that is not answered; returns its number.

        Raises
        ------
        EngineLost    The process is gone.
        CodecError    The order cannot be sent.
        """
        with self._lock:
            self.check()
            number = next(self._numbers)
            self._channel.send({"kind": kind, "number": number, "session": session}, body)
        return number

    def call(
        self, kind: str, session: str, body=None, patience: float | None = None, **more
    ) -> Call:
        """Send an order that is answered. ``patience``: how long it may take to obey a cancel; None: as all jobs. [s]

        Raises
        ------
        EngineLost    The process is gone.
        CodecError    The order cannot be sent.
        """
        with self._lock:
            self.check()
            patience = self._cancel_patience if patience is None else patience
            call = Call(next(self._numbers), kind, session, time.monotonic(), patience)
            head = {"kind": kind, "number": call.number, "session": session, **more}
            self._channel.send(head, body)
            self._calls[call.number] = call
        return call

    def cancel(self, call: Call) -> None:
        """Ask a job to end."""
        with self._lock:
            if call.is_done or call.cancel_age is not None or self.lost is not None:
                return
            call.cancel_age = 0.0
            self._channel.send({"kind": "cancel", "number": call.number})

    def stop_session(self, session: str) -> None:
        """Ask the bakes of a session to end with what they have."""
        with self._lock:
            if self.lost is not None:
                return
            for call in self._calls.values():
                if call.session == session and call.kind == "bake_objects" and not call.is_done:
                    self._channel.send({"kind": "stop", "number": call.number})

    def cancel_session(self, session: str) -> None:
        """Ask all jobs of a session to end."""
        with self._lock:
            for call in [each for each in self._calls.values() if each.session == session]:
                self.cancel(call)

    def wait(
        self,
        call: Call,
        progress: Callable | None = None,
        idle: Callable[[], None] | None = None,
        seconds: float | None = None,
    ):
        """Wait on the caller's thread for the answer, no longer than given; calls ``progress`` and ``idle`` from there.

        Parameters
        ----------
        call : Call
        progress : callable or None    ``progress(Progress, preview)``.
        idle : callable or None    Called many times a second.
        seconds : float or None    The longest wait. [s]

        Raises
        ------
        EngineLost    The process is gone, or did not answer in time.
        LumenrayError    What the job says.
        """
        said = None
        kernels = None if progress is None else NewKernels()
        end = None if seconds is None else time.monotonic() + seconds
        try:
            while True:
                with self._changed:
                    if not call.is_done and call.news is None:
                        self._changed.wait(POLL)
                    news, call.news = call.news, None
                    waiting = self._waiting_for(call)
                if progress is not None and not call.is_done:
                    if waiting not in (None, said):
                        progress(_resting(call, waiting), None)
                    if news is not None:
                        progress(*news)
                    elif waiting is None and kernels.look():
                        progress(_resting(call, kernels.words), None)
                    said = waiting
                if call.is_done:
                    break
                if idle is not None:
                    idle()
                _check_time(end, seconds)
        except BaseException:
            # Whoever waited has gone: the job has no one to answer to.
            self.cancel(call)
            raise
        if call.error is not None:
            raise call.error
        return call.value

    def lose(self, reason: str) -> None:
        """Give the process up and end it; the first reason counts."""
        with self._lock:
            if self._reason is None and self._lost is None:
                self._reason = reason
        self._process.kill()

    def end(self, seconds: float) -> None:
        """End the process, by word or, after so many seconds, by force; returns when nothing is left of it. [s]"""
        with self._lock:
            if self._lost is None and self._reason is None:
                self._reason = f"the engine was closed; {faults.AGAIN}"
                if self._channel is not None:
                    self._channel.send({"kind": "quit"})
        self._read_thread.join(seconds)
        if self._read_thread.is_alive():
            self._process.kill()
            self._read_thread.join(10.0)

    # ---- the reading thread ----

    def _read(self) -> None:
        cause = None
        try:
            self._channel = Channel(self._process.connect())
            pulse = Pulse(self._process, self._hung_after)
            while True:
                message = self._channel.receive(TICK)
                if message is not None:
                    pulse.hear()
                    self._hear(message)
                self._look_after(pulse)
        except (EOFError, OSError):
            # The process has ended; how, its exit code tells.
            pass
        except multiprocessing.AuthenticationError:
            cause = f"a process that is not the engine answered; {faults.AGAIN}"
        except CodecError as error:
            cause = f"the engine's answer cannot be understood ({error}); {faults.AGAIN}"
        except Exception as error:
            traceback.print_exc()
            cause = (
                f"the line to the engine failed ({type(error).__name__}: {error}); {faults.AGAIN}"
            )
        finally:
            self._finish(cause)

    def _finish(self, cause: str | None) -> None:
        """Reap the process and tell everybody who waits."""
        if cause is None:
            self._process.wait(2.0)
        if self._process.is_running():
            self._process.kill()
        code = self._process.wait(10.0)
        self._drain_thread.join(2.0)
        with self._changed:
            self._lost = self._reason or cause or faults.describe_end(code, self.log())
            for call in self._calls.values():
                call.error, call.is_done = EngineLost(self._lost), True
            self._calls.clear()
            self._changed.notify_all()
        if self._channel is not None:
            self._channel.close()
        self._process.close()
        if not self._drain_thread.is_alive():
            self._process.output.close()

    def _drain(self) -> None:
        """Keep the last lines that the process writes."""
        rest = b""
        while piece := self._process.output.read(1 << 12):
            *lines, rest = (rest + piece).split(b"\n")
            self._log.extend(line.decode("utf-8", "replace")[:500] for line in lines)
            rest = rest[-500:]
        if rest:
            self._log.append(rest.decode("utf-8", "replace"))

    def _hear(self, message: Message) -> None:
        head = message.head
        kind = head.get("kind")
        with self._changed:
            if kind in {"answer", "error"}:
                self._end_call(head, message)
            elif kind == "progress":
                self._note_progress(head["number"], message.body)
            elif kind == "stack":
                self._stack = list(head["numbers"])
            elif kind == "frame":
                self._show(head, message)
            elif kind == "view_error":
                view = self.view(head["session"])
                if head["number"] >= view.first_number:
                    view.error = head["text"]
            elif kind == "refused":
                self.view(head["session"]).applied -= 1
            elif kind == "hello":
                self._greet(head)
            elif kind != "pong":
                raise CodecError(f"an unknown message came: {kind}")
            self._changed.notify_all()

    def _greet(self, head: dict) -> None:
        if head["version"] != VERSION:
            raise CodecError(f"it is of version {head['version']}, {VERSION} is needed")
        self._is_ready = True

    def _end_call(self, head: dict, message: Message) -> None:
        call = self._calls.pop(head["number"], None)
        if call is None:
            return
        if head["kind"] == "error":
            call.error = faults.rebuild(head["class"], head["text"], head["attributes"])
            if head["is_last"]:
                self.lose(f"{head['text']}; {faults.AGAIN}")
        elif message.fault is not None:
            call.error = faults.rebuild(*faults.describe(message.fault, JOB_NAMES[call.kind]))
        call.value = message.body
        call.is_done = True

    def _note_progress(self, number: int, body) -> None:
        self._channel.send({"kind": "seen", "number": number})
        call = self._calls.get(number)
        if call is None or body is None:
            return
        state, picture = body
        call.done = state.done
        if picture is None and call.news is not None and call.news[1] is not None:
            # A picture that the caller has not seen yet must not be lost to a bare number.
            call.news = (state, call.news[1])
        else:
            call.news = (state, None if picture is None else lambda: picture)

    def _show(self, head: dict, message: Message) -> None:
        self._channel.send({"kind": "seen", "session": head["session"]})
        view = self.view(head["session"])
        if head["number"] < view.first_number or not view.is_watched:
            return
        if message.fault is not None:
            view.error = faults.describe(message.fault, "live view")[1]
            return
        view.frame, view.error = message.body, None
        # A frame that was on its way when the view or the scene changed is not the last one.
        is_newest = head["number"] >= view.newest_number and view.frame.revision >= view.applied
        view.is_final = view.frame.is_final and is_newest

    def _waiting_for(self, call: Call) -> str | None:
        """Say what a job waits for; None when it is its turn."""
        if not self._stack or self._stack[-1] == call.number:
            return None
        other = self._calls.get(self._stack[-1])
        if other is None:
            return None
        word = "paused for" if call.number in self._stack else "waiting for"
        return f"{word} the {JOB_NAMES[other.kind]}, {100.0 * other.done:.0f} %"

    def _look_after(self, pulse: Pulse) -> None:
        """Look after the process: signs of life, cancels that are not obeyed."""
        passed = pulse.look()
        if passed == 0.0:
            return
        if pulse.wants_word():
            self._channel.send({"kind": "ping"})
        if pulse.is_hung(passed):
            self.lose(
                f"the engine did not answer for {pulse.silence:.0f} s and was ended; {faults.AGAIN}"
            )
        with self._lock:
            for call in self._calls.values():
                if call.cancel_age is not None:
                    call.cancel_age += passed
                    if call.cancel_age > call.patience:
                        self.lose(
                            f"the {JOB_NAMES[call.kind]} did not stop within {call.patience:.0f} s "
                            f"of being cancelled, so the engine was ended; {faults.AGAIN}"
                        )


def _check_time(end: float | None, seconds: float | None) -> None:
    if end is not None and time.monotonic() > end:
        raise EngineLost(f"the engine did not answer within {seconds:.0f} s")


def _resting(call: Call, text: str) -> Progress:
    """Progress of a job that does not get on."""
    return Progress(call.done, 0, float("inf"), time.monotonic() - call.start, None, text)


def _end_all() -> None:
    for link in list(_LINKS):
        link.end(1.0)


atexit.register(_end_all)
if hasattr(os, "register_at_fork"):
    # A copy of this process has none of the threads and must not end what belongs to the original.
    os.register_at_fork(after_in_child=_LINKS.clear)
