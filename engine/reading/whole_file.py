"""Files that are written whole or not at all: a full disk, a lost connection or a kill leaves the old one as it was."""

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from secrets import token_hex
from typing import IO

from ..errors import FileFormatError


@contextmanager
def write_whole(path, encoding: str | None = None, *, is_synced: bool = False) -> Iterator[IO]:
    """Open a file whose content takes the place of an old one when all of it is there; its folder is made if need be.

    A link stays one, and a file keeps its permissions. What is no plain file, such as ``/dev/stdout``, is written to.

    Parameters
    ----------
    path : str or Path
    encoding : str or None    Of a text, whose line ends stay as they are; None: bytes are written.
    is_synced : bool    Whether to wait until it is on the disk, so that it outlasts a loss of power.

    Raises
    ------
    FileFormatError    It cannot be written; nothing is left behind.
    """
    path, part = Path(path), None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.exists() and not path.is_file() and not path.is_dir():
            with _open(path, "w", encoding) as file:
                yield file
            return
        target = Path(os.path.realpath(path))
        # The ending stays, as it tells some writers what to write; no other writer has the name.
        part = target.with_name(f".part-{token_hex(4)}-{target.name[-40:]}")
        with _open(part, "x", encoding) as file:
            yield file
            if is_synced:
                file.flush()
                os.fsync(file.fileno())
        if target.exists():
            shutil.copymode(target, part)
        part.replace(target)
    except OSError as error:
        raise FileFormatError(path, f"cannot be written ({error.strerror or error})") from None
    finally:
        if part is not None:
            with suppress(OSError):
                part.unlink()


def _open(path: Path, mode: str, encoding: str | None) -> IO:
    if encoding is None:
        return path.open(f"{mode}b")
    return path.open(mode, encoding=encoding, newline="")
