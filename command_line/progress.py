"""Progress of commands on a terminal; silent when nobody watches."""

import json
import math
import os
import shutil
import sys

from ..engine.reading.printable import printable

LISTENER = "LUMENRAY_PROGRESS"
"""Variable that names the descriptor of a program that wants to hear of progress, as lines of JSON."""


class Bar:
    """Bar that is wiped away at the end.

    Parameters
    ----------
    title : str    What goes on.
    """

    def __init__(self, title: str):
        self._title = printable(title)
        self._is_shown = sys.stderr.isatty() and not os.environ.get("CI")
        listener = os.environ.get(LISTENER)
        self._listener = None if listener is None else int(listener)

    def __call__(self, progress, _preview=None) -> None:
        """Show the state of a job, a `Progress`."""
        self.share(progress.done, progress.text())
        if self._listener is not None:
            self._tell(progress)

    def share(self, share: float, text: str = "") -> None:
        """Show which share is done."""
        width = min(30, max(shutil.get_terminal_size().columns - 60, 5))
        full = "#" * int(share * width)
        self._write(f"{self._title} [{full:.<{width}}] {int(100 * share):3d} %  {text}")

    def _tell(self, progress) -> None:
        error = progress.relative_error
        told = {
            "title": self._title,
            "text": printable(progress.text()),
            "share": progress.done,
            "relative_error": error if math.isfinite(error) else None,
            "seconds_left": progress.seconds_left,
        }
        try:
            os.write(self._listener, json.dumps(told).encode() + b"\n")
        except BrokenPipeError:
            # Nobody listens any more, which is no reason to end.
            self._listener = None

    def __enter__(self) -> "Bar":
        return self

    def __exit__(self, *_):
        self._write("")
        if self._is_shown:
            sys.stderr.write("\r")

    def _write(self, line: str) -> None:
        if self._is_shown:
            room = shutil.get_terminal_size().columns - 1
            sys.stderr.write(f"\r{line[:room]:<{room}}")
            sys.stderr.flush()
