"""Blocks of shared memory that carry arrays from one process to the other, without a name that could be left behind.

Linux: an anonymous file whose descriptor is passed on. macOS: a shared-memory object that loses its name before anything
is in it. Windows: a named section that ends with its last handle. So a process that is killed leaves nothing.
"""

import errno
import mmap
import os
import secrets
import sys
from dataclasses import dataclass

import numpy as np

if sys.platform != "win32":
    import fcntl

COPIED_BELOW = 1 << 20
"""Smaller blocks are copied: a mapping holds a file descriptor, and a scene is made of many small edits. [byte]"""

LARGEST = 1 << 40
"""No block is larger. [byte]"""

IS_TAKEN_AT_ONCE = sys.platform == "linux"
"""Whether the sender may close a block that is still on its way; elsewhere it waits for the receiver's word."""

Part = tuple[int, np.ndarray]
"""Offset in the block [byte] and a contiguous array that is to lie there."""

if sys.platform == "linux":
    _SEALS = fcntl.F_SEAL_SHRINK | fcntl.F_SEAL_GROW | fcntl.F_SEAL_WRITE

_SHORT = {errno.ENOMEM, errno.ENOSPC}


@dataclass
class Block:
    """The sender's end. ``handle``: file descriptor, or -1 where ``name`` and ``mapping`` stand for it. ``size`` [byte]."""

    size: int
    handle: int = -1
    name: str = ""
    mapping: mmap.mmap | None = None

    def close(self) -> None:
        """Let go; what the receiver has mapped stays."""
        if self.handle >= 0:
            os.close(self.handle)
            self.handle = -1
        if self.mapping is not None:
            self.mapping.close()
            self.mapping = None


def make(parts: list[Part], size: int) -> Block:
    """Fill a new block of ``size`` bytes.

    Raises
    ------
    MemoryError    There is no room for it.
    """
    maker = {"linux": make_anonymous, "win32": make_section}.get(sys.platform, make_unlinked)
    try:
        return maker(parts, size)
    except OSError as error:
        if error.errno in _SHORT:
            raise MemoryError(f"no room for {size} bytes of shared memory") from error
        raise


def make_anonymous(parts: list[Part], size: int) -> Block:
    """Linux: a sealed file in memory. It is written, not mapped, so that short memory is an error and no signal."""
    handle = os.memfd_create("lumenray", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
    try:
        os.ftruncate(handle, size)
        for offset, array in parts:
            _write(handle, array, offset)
        fcntl.fcntl(handle, fcntl.F_ADD_SEALS, _SEALS)
    except BaseException:
        os.close(handle)
        raise
    return Block(size, handle)


def make_unlinked(parts: list[Part], size: int) -> Block:
    """Unix other than Linux: a shared-memory object without a name."""
    import _posixshmem

    name = f"/lumenray{secrets.token_hex(8)}"
    handle = _posixshmem.shm_open(name, os.O_CREAT | os.O_EXCL | os.O_RDWR, mode=0o600)
    try:
        _posixshmem.shm_unlink(name)
        os.ftruncate(handle, size)
        with mmap.mmap(handle, size) as mapping:
            _fill(mapping, parts)
    except BaseException:
        os.close(handle)
        raise
    return Block(size, handle)


def make_section(parts: list[Part], size: int) -> Block:
    """Windows: a section under a random name."""
    name = f"lumenray{secrets.token_hex(16)}"
    mapping = mmap.mmap(-1, size, tagname=name)
    _fill(mapping, parts)
    return Block(size, name=name, mapping=mapping)


def open_handle(handle: int, size: int):
    """Take over a descriptor and return the block's bytes, read-only and alive as long as anything refers to them.

    Raises
    ------
    ValueError    It is not what it claims to be.
    MemoryError    There is no room to map it.
    """
    try:
        _check(handle, size)
        if sys.platform == "linux" and size < COPIED_BELOW:
            return _read(handle, size)
        return _map(handle, size)
    finally:
        os.close(handle)


def open_section(name: str, size: int):
    """Windows: return the block's bytes, as `open_handle` does."""
    if not 0 < size <= LARGEST:
        raise ValueError(f"a block cannot have {size} bytes")
    return _lend(mmap.mmap(-1, size, tagname=name, access=mmap.ACCESS_READ), size)


def _check(handle: int, size: int) -> None:
    if not 0 < size <= LARGEST or os.fstat(handle).st_size < size:
        raise ValueError(f"a block does not have the {size} bytes that it says")
    # A file that could still shrink would end the process that reads it.
    if sys.platform == "linux":
        try:
            seals = fcntl.fcntl(handle, fcntl.F_GET_SEALS)
        except OSError as error:
            raise ValueError("a block is no memory") from error
        if not seals & fcntl.F_SEAL_SHRINK:
            raise ValueError("a block is not sealed")


def _map(handle: int, size: int):
    # Before Python 3.13 the mapping keeps a descriptor of its own.
    options = {"trackfd": False} if sys.version_info >= (3, 13) else {}
    try:
        mapping = mmap.mmap(handle, size, access=mmap.ACCESS_READ, **options)
    except OSError as error:
        if error.errno in _SHORT:
            raise MemoryError(f"no room to map {size} bytes of shared memory") from error
        raise
    return _lend(mapping, size)


def _lend(mapping: mmap.mmap, size: int):
    if size >= COPIED_BELOW:
        return mapping
    with mapping:
        return mapping[:size]


def _write(handle: int, array: np.ndarray, offset: int) -> None:
    data = memoryview(array.reshape(-1).view(np.uint8))
    while data:
        count = os.pwrite(handle, data[: 1 << 30], offset)
        data, offset = data[count:], offset + count


def _read(handle: int, size: int) -> bytes:
    pieces, offset = [], 0
    while offset < size:
        piece = os.pread(handle, size - offset, offset)
        if not piece:
            raise ValueError(f"a block does not have the {size} bytes that it says")
        pieces.append(piece)
        offset += len(piece)
    return b"".join(pieces)


def _fill(mapping: mmap.mmap, parts: list[Part]) -> None:
    for offset, array in parts:
        data = array.reshape(-1).view(np.uint8)
        mapping[offset : offset + len(data)] = memoryview(data)
