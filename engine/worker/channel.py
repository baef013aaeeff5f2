"""The line between Blender and the engine: both ends have proved that they know the same secret, both may talk at once.

A message is a small table, the head, and one value, the body. Only bytes are sent: nothing that is received can run.
"""

import itertools
import os
import queue
import socket
import struct
import sys
import threading
import traceback
from dataclasses import dataclass
from multiprocessing.connection import answer_challenge, deliver_challenge

from ..errors import CodecError, LumenrayError
from . import codec, memory

LONGEST = 1 << 28
"""No message's text is longer. [byte]"""

_PLAIN, _WITH_BLOCK, _TAKEN = range(3)

_FRAME = struct.Struct("<BQQH")
"""What a message begins with: its kind, size and number of its block, length of the block's name."""


@dataclass(frozen=True)
class Message:
    """What came. ``fault`` tells why the body could not be had."""

    head: dict
    body: object = None
    fault: Exception | None = None


def prove(connection, key: bytes, is_host: bool) -> None:
    """Let both ends show that they know the key.

    Raises
    ------
    multiprocessing.AuthenticationError    The other end does not.
    """
    if is_host:
        deliver_challenge(connection, key)
        answer_challenge(connection, key)
    else:
        answer_challenge(connection, key)
        deliver_challenge(connection, key)


class Channel:
    """One end of the line.

    Sending never waits, since a thread of its own does it: so two ends that send much at the same time do not block each
    other, and a reader can answer.
    """

    def __init__(self, connection):
        self._connection = connection
        self._socket = None
        if sys.platform != "win32":
            self._socket = socket.socket(fileno=os.dup(connection.fileno()))
        self._kept: dict[int, memory.Block] = {}
        self._numbers = itertools.count(1)
        self._queue: queue.SimpleQueue = queue.SimpleQueue()
        self._lock = threading.Lock()
        self._is_open = True
        self._writer = threading.Thread(target=self._write, name="lumenray-send", daemon=True)
        self._writer.start()

    def send(self, head: dict, body=None) -> None:
        """Send a message; on a line that has ended it goes nowhere, which the reading side reports.

        Raises
        ------
        CodecError    The body cannot be sent.
        MemoryError    There is no room for its arrays.
        """
        tree, parts, size = codec.encode(body)
        text = codec.to_text([head, tree])
        if len(text) > LONGEST or size > memory.LARGEST:
            raise CodecError(f"a message of {len(text) + size} bytes is too long to be sent")
        block = memory.make(parts, size) if parts else None
        self._put(text, block)

    def receive(self, seconds: float) -> Message | None:
        """Wait for a message, no longer than this; None when none came. [s]

        Raises
        ------
        EOFError    The line has ended.
        CodecError    What came is no message.
        """
        try:
            if not self._connection.poll(seconds):
                return None
            data = self._connection.recv_bytes(LONGEST + 1024)
            return self._open(data)
        except OSError as error:
            raise EOFError(str(error)) from error

    def close(self) -> None:
        """Send what waits and let go of everything; the other end should be gone or reading."""
        with self._lock:
            self._is_open = False
            self._queue.put(None)
        self._writer.join()
        self._connection.close()
        if self._socket is not None:
            self._socket.close()

    # ---- private ----

    def _put(self, text: bytes, block: memory.Block | None, taken: int = 0) -> None:
        with self._lock:
            if self._is_open:
                self._queue.put((text, block, taken))
            elif block is not None:
                block.close()

    def _write(self) -> None:
        try:
            while (item := self._queue.get()) is not None:
                self._write_one(*item)
        except OSError:
            # The other end is gone: the reader meets the end of the line and tells why.
            pass
        except Exception:
            traceback.print_exc()
            raise
        finally:
            self._discard()

    def _write_one(self, text: bytes, block: memory.Block | None, taken: int) -> None:
        if block is None:
            kind = _TAKEN if taken else _PLAIN
            self._connection.send_bytes(_FRAME.pack(kind, 0, taken, 0) + text)
            return
        number = next(self._numbers)
        name = block.name.encode()
        frame = _FRAME.pack(_WITH_BLOCK, block.size, number, len(name))
        try:
            if not memory.IS_TAKEN_AT_ONCE:
                self._kept[number] = block
            self._connection.send_bytes(frame + name + text)
            if block.handle >= 0:
                socket.send_fds(self._socket, [b"\0"], [block.handle])
        finally:
            if memory.IS_TAKEN_AT_ONCE:
                block.close()

    def _discard(self) -> None:
        """Close the blocks that will not be sent or asked for any more."""
        with self._lock:
            self._is_open = False
            while not self._queue.empty():
                item = self._queue.get()
                if item is not None and item[1] is not None:
                    item[1].close()
            kept, self._kept = list(self._kept.values()), {}
        for block in kept:
            block.close()

    def _open(self, data: bytes) -> Message | None:
        if len(data) < _FRAME.size:
            raise CodecError("a message is cut short")
        kind, size, number, length = _FRAME.unpack_from(data)
        if kind == _TAKEN:
            block = self._kept.pop(number, None)
            if block is not None:
                block.close()
            return None
        rest = data[_FRAME.size :]
        block, fault = b"", None
        if kind == _WITH_BLOCK:
            block, fault = self._take(rest[:length].decode("ascii", "replace"), size)
            if not memory.IS_TAKEN_AT_ONCE:
                self._put(b"", None, number)
        message = codec.from_text(rest[length:])
        if not (isinstance(message, list) and len(message) == 2 and isinstance(message[0], dict)):
            raise CodecError("a message has no head")
        if fault is not None:
            return Message(message[0], None, fault)
        try:
            return Message(message[0], codec.decode(message[1], block))
        except (LumenrayError, MemoryError) as error:
            return Message(message[0], None, error)

    def _take(self, name: str, size: int):
        """Return a block's bytes and why they could not be had."""
        try:
            if name:
                return memory.open_section(name, size), None
            return memory.open_handle(self._receive_handle(), size), None
        except ValueError as error:
            return b"", CodecError(f"a message's arrays cannot be read: {error}")
        except MemoryError as error:
            return b"", error

    def _receive_handle(self) -> int:
        flags = getattr(socket, "MSG_CMSG_CLOEXEC", 0)
        data, handles, _, _ = socket.recv_fds(self._socket, 1, 1, flags)
        if not data:
            raise EOFError
        if not handles:
            raise ValueError("the process has too many files open")
        os.set_inheritable(handles[0], False)
        return handles[0]
