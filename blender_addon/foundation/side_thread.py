"""A thread beside Blender's own that does one thing after the other, and that panels may give work to while they are drawn.

Blender notes for all threads together whether Python may write its data, forbids it while a panel is drawn, and puts back
what it was before. A picture of a material that begins to be rendered in between puts back later what it found then, so that
no operator and no other add-on may write any more. It begins when whoever draws lets go of the interpreter, as happens where
one of the standard library's threads is started: that waits until the thread runs.
"""

import _thread
import contextlib
import threading
from collections.abc import Callable
from concurrent.futures import Future
from queue import Empty, SimpleQueue


class SideThread:
    """The thread; it is begun by the first work.

    Parameters
    ----------
    name : str    For those who look at threads.
    """

    def __init__(self, name: str):
        self._name = name
        self._work: SimpleQueue = SimpleQueue()
        self._ended = threading.Event()
        self._has_begun = False

    def submit(self, function: Callable, *arguments) -> Future:
        """Have a function called after all that was submitted before; the future has what it returns or raises."""
        future = Future()
        self._work.put((future, function, arguments))
        if not self._has_begun:
            self._has_begun = True
            _thread.start_new_thread(self._run, ())
        return future

    def shutdown(self) -> None:
        """Cancel what has not begun, and wait until the rest has ended. Nothing may be submitted any more."""
        with contextlib.suppress(Empty):
            while True:
                self._work.get_nowait()[0].cancel()
        self._work.put(None)
        if self._has_begun:
            self._ended.wait()

    def _run(self) -> None:
        threading.current_thread().name = self._name
        while (entry := self._work.get()) is not None:
            future, function, arguments = entry
            if not future.set_running_or_notify_cancel():
                continue
            try:
                future.set_result(function(*arguments))
            except BaseException as error:
                future.set_exception(error)
            # Nothing is kept alive until there is more to do.
            del future, function, arguments, entry
        self._ended.set()
