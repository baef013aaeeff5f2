"""Ctrl-C during a bake on the command line: the first one keeps what there is, the second one cancels."""

import signal
import sys

from .output import complain


class Interruption:
    """While it is entered, Ctrl-C is a word to a job; for the main thread.

    Parameters
    ----------
    job : bake.BakeJob
    """

    def __init__(self, job):
        self._job = job
        self._count = 0

    def __enter__(self):
        self._kept = signal.signal(signal.SIGINT, self._hear)
        return self

    def __exit__(self, *_):
        signal.signal(signal.SIGINT, self._kept)

    def _hear(self, *_):
        self._count += 1
        if self._count == 1:
            text = "stopping; the results so far are kept, Ctrl-C again cancels"
            self._job.stop()
        else:
            text = "cancelling"
            self._job.cancel()
        sys.stderr.write("\n")
        complain(text)
