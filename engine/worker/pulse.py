"""Signs of life of the engine's process: whether it has fallen silent, and whether it hangs.

Times count only while this process runs itself, so that a sleep of the host is no fault.
"""

import time

from .process import Process

HUNG_AFTER = 10.0
"""Silence after which a process that does not compute either counts as hung. [s]"""

HUNG_AFTER_UNSEEN = 120.0
"""The same where the system does not tell whether it computes, or while it waits for a disk. [s]"""

TICK = 0.25
"""Time between two looks at the process. [s]"""

ASK_AFTER = 1.0
"""Silence after which the process is asked for a word. [s]"""


class Pulse:
    """Watches a process.

    Parameters
    ----------
    process : Process
    hung_after : float    As `HUNG_AFTER`. [s]
    """

    def __init__(self, process: Process, hung_after: float):
        self.silence = 0.0
        self._process, self._hung_after = process, hung_after
        self._looked = time.monotonic()
        self._stillness, self._work, self._is_asked = 0.0, -1, False

    def hear(self) -> None:
        """Take note of a word from the process."""
        self.silence, self._is_asked = 0.0, False

    def look(self) -> float:
        """Let time pass; returns how much of it counts, 0 where the last look was less than `TICK` ago. [s]"""
        now = time.monotonic()
        passed = now - self._looked
        if passed < TICK:
            return 0.0
        self._looked = now
        passed = min(passed, 4.0 * TICK)
        self.silence += passed
        return passed

    def wants_word(self) -> bool:
        """Whether the process has to be asked for a word now; told once for each silence."""
        asks = self.silence > ASK_AFTER and not self._is_asked
        self._is_asked |= asks
        return asks

    def is_hung(self, passed: float) -> bool:
        """Whether the process is given up after a look that let so much time pass. [s]

        Native code may keep it from answering for long, but then it uses the processor.
        """
        watched_from = min(0.5 * self._hung_after, 2.0)
        if self.silence < watched_from:
            self._stillness = 0.0
            return False
        work = self._process.work()
        if work is None:
            return self.silence > HUNG_AFTER_UNSEEN
        ticks, state = work
        if ticks != self._work:
            self._work, self._stillness = ticks, 0.0
        self._stillness += passed
        patience = HUNG_AFTER_UNSEEN if state == "D" else self._hung_after
        return self.silence > patience and self._stillness > patience - watched_from
