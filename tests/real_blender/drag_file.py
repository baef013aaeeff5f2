"""Drag a file from outside onto a window and drop it there, as a file manager does: ``drag_file.py PATH X Y``.

It speaks the protocol by which programs under X11 hand over what is dragged. X, Y: place on the screen. [pixel] It ends with
0 as soon as the window has taken the file, with a sentence and 1 where it does not.

References
----------
J. Lindal et al.: Drag-and-Drop Protocol for the X Window System (XDND), version 5, 2002.
"""

import ctypes
import sys
import time
from pathlib import Path

LONGEST = 30.0
"""How long the window may take for an answer. [s]"""

VERSION = 5

PROPERTY_CHANGE, SELECTION_REQUEST, SELECTION_NOTIFY, CLIENT_MESSAGE = 28, 30, 31, 33
"""Numbers of events. (Xlib, X.h)"""

Long, Number = ctypes.c_long, ctypes.c_ulong


class ClientMessage(ctypes.Structure):
    """XClientMessageEvent."""

    _fields_ = [
        ("type", ctypes.c_int),
        ("serial", Number),
        ("send_event", ctypes.c_int),
        ("display", ctypes.c_void_p),
        ("window", Number),
        ("message_type", Number),
        ("format", ctypes.c_int),
        ("data", Long * 5),
    ]


class SelectionRequest(ctypes.Structure):
    """XSelectionRequestEvent."""

    _fields_ = [
        ("type", ctypes.c_int),
        ("serial", Number),
        ("send_event", ctypes.c_int),
        ("display", ctypes.c_void_p),
        ("owner", Number),
        ("requestor", Number),
        ("selection", Number),
        ("target", Number),
        ("property", Number),
        ("time", Number),
    ]


class Selection(ctypes.Structure):
    """XSelectionEvent."""

    _fields_ = [
        ("type", ctypes.c_int),
        ("serial", Number),
        ("send_event", ctypes.c_int),
        ("display", ctypes.c_void_p),
        ("requestor", Number),
        ("selection", Number),
        ("target", Number),
        ("property", Number),
        ("time", Number),
    ]


class Event(ctypes.Union):
    """XEvent."""

    _fields_ = [
        ("type", ctypes.c_int),
        ("message", ClientMessage),
        ("request", SelectionRequest),
        ("selection", Selection),
        ("pad", Long * 24),
    ]


class RefusedError(Exception):
    """The window does not take the file; the text says why."""


class Source:
    """Where the file is dragged from: a window of our own, which nobody sees."""

    def __init__(self):
        x = self.x = ctypes.CDLL("libX11.so.6")
        x.XOpenDisplay.restype = ctypes.c_void_p
        for name in ("XInternAtom", "XDefaultRootWindow", "XCreateSimpleWindow"):
            getattr(x, name).restype = Number
        opened = x.XOpenDisplay(None)
        if not opened:
            raise RefusedError("there is no display")
        self.display = ctypes.c_void_p(opened)
        self.root = Number(x.XDefaultRootWindow(self.display))
        self.window = Number(x.XCreateSimpleWindow(self.display, self.root, 0, 0, 1, 1, 0, 0, 0))

    def atom(self, name: str) -> int:
        """Return the number of a name."""
        return self.x.XInternAtom(self.display, name.encode(), 0)

    def find_target(self) -> int:
        """Return the uppermost window that takes what is dropped.

        Raises
        ------
        RefusedError    There is none.
        """
        root, parent, count = Number(), Number(), ctypes.c_uint()
        children = ctypes.POINTER(Number)()
        self.x.XQueryTree(
            self.display,
            self.root,
            *map(ctypes.byref, (root, parent, children, count)),
        )
        aware = self.atom("XdndAware")
        for child in reversed(children[: count.value]):
            number = ctypes.c_int()
            self.x.XListProperties.restype = ctypes.POINTER(Number)
            names = self.x.XListProperties(self.display, Number(child), ctypes.byref(number))
            if number.value and aware in names[: number.value]:
                return child
        raise RefusedError("no window takes what is dropped")

    def send(self, target: int, name: str, *data: int) -> None:
        """Send a message of the protocol."""
        event = Event()
        event.message = ClientMessage(
            CLIENT_MESSAGE, 0, 1, self.display, target, self.atom(name), 32
        )
        event.message.data[0] = self.window.value
        for place, value in enumerate(data, start=1):
            event.message.data[place] = value
        self.x.XSendEvent(self.display, Number(target), 0, Long(0), ctypes.byref(event))
        self.x.XFlush(self.display)

    def wait_for(self, name: str, text: bytes) -> ClientMessage:
        """Wait for a message, and give out the file's address when it is asked for.

        Raises
        ------
        RefusedError    It does not come.
        """
        wanted, begin, event = self.atom(name), time.monotonic(), Event()
        while time.monotonic() - begin < LONGEST:
            if not self.x.XPending(self.display):
                time.sleep(0.01)
                continue
            self.x.XNextEvent(self.display, ctypes.byref(event))
            if event.type == SELECTION_REQUEST:
                self._give(event.request, text)
            elif event.type == CLIENT_MESSAGE and event.message.message_type == wanted:
                return event.message
        raise RefusedError(f"the window has not answered with {name} for {LONGEST:.0f} s")

    def _give(self, request: SelectionRequest, text: bytes) -> None:
        self.x.XChangeProperty(
            self.display,
            Number(request.requestor),
            Number(request.property),
            Number(request.target),
            8,
            0,
            text,
            len(text),
        )
        event = Event()
        event.selection = Selection(
            SELECTION_NOTIFY,
            0,
            1,
            self.display,
            request.requestor,
            request.selection,
            request.target,
            request.property,
            request.time,
        )
        self.x.XSendEvent(self.display, Number(request.requestor), 0, Long(0), ctypes.byref(event))
        self.x.XFlush(self.display)


def drop(path: Path, x: int, y: int) -> None:
    """Drag a file to a place on the screen and let it go.

    Raises
    ------
    RefusedError    It is not taken.
    """
    source, text = Source(), (path.absolute().as_uri() + "\r\n").encode()
    target = source.find_target()
    kind, copy = source.atom("text/uri-list"), source.atom("XdndActionCopy")
    selection = Number(source.atom("XdndSelection"))
    source.x.XSetSelectionOwner(source.display, selection, source.window, Number(0))
    source.send(target, "XdndEnter", VERSION << 24, kind)
    # On its way the window says whether it would take it.
    for step in range(8, -1, -1):
        source.send(target, "XdndPosition", 0, (x - step) << 16 | (y - step), 0, copy)
        status = source.wait_for("XdndStatus", text)
    if not status.data[1] & 1:
        raise RefusedError("the window does not want the file")
    source.send(target, "XdndDrop", 0, 0)
    source.wait_for("XdndFinished", text)


if __name__ == "__main__":
    try:
        drop(Path(sys.argv[1]), int(sys.argv[2]), int(sys.argv[3]))
    except RefusedError as refusal:
        sys.exit(str(refusal))
