"""What commands show on a terminal: progress, and nothing of what Blender prints by itself."""

import os
import shutil
import sys


class quiet:
    """Keeps what Blender prints on its own off the terminal."""

    def __enter__(self):
        sys.stdout.flush()
        self._kept = os.dup(1)
        self._null = os.open(os.devnull, os.O_WRONLY)
        os.dup2(self._null, 1)

    def __exit__(self, *_):
        os.dup2(self._kept, 1)
        os.close(self._kept)
        os.close(self._null)


class Bar:
    """Progress on a terminal; silent when nobody watches."""

    def __init__(self, title: str):
        self.title = title
        self.alive = sys.stderr.isatty() and not os.environ.get("CI")

    def __call__(self, progress, _preview=None):
        if not self.alive:
            return
        width = min(30, max(shutil.get_terminal_size().columns - 60, 5))
        full = int(progress.done * width)
        line = f"\r{self.title} [{'#' * full}{'.' * (width - full)}] {int(100 * progress.done):3d} %  {progress.text()}"
        print(
            line[: shutil.get_terminal_size().columns - 1].ljust(
                shutil.get_terminal_size().columns - 1
            ),
            end="",
            file=sys.stderr,
        )

    def close(self):
        """Leave a clean line."""
        if self.alive:
            print(
                "\r" + " " * (shutil.get_terminal_size().columns - 1) + "\r",
                end="",
                file=sys.stderr,
            )
