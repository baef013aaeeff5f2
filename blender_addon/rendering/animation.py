"""How long an animation takes yet, by the frames that are done."""

import time
from dataclasses import dataclass

from ...imports import loaded_when_used

with loaded_when_used():
    from ...engine.accuracy import stopping

RECENT = 8
"""Last frames by which the next ones are judged: what the camera sees changes along a way."""


@dataclass(frozen=True)
class Frames:
    """Place of a frame among those of an animation: it is the ``number``-th of ``count``."""

    number: int
    count: int

    @classmethod
    def of(cls, scene) -> "Frames":
        """Of the current frame of a scene."""
        number = (scene.frame_current - scene.frame_start) // scene.frame_step + 1
        count = (scene.frame_end - scene.frame_start) // scene.frame_step + 1
        return cls(number, max(count, number))


class FrameTimes:
    """What the frames of an animation take, with all that is done between them."""

    def __init__(self):
        self._begun: float | None = None
        self._taken: list[float] = []

    def begin(self) -> None:
        """Take note that a frame begins, and with it that the one before has ended."""
        now = time.perf_counter()
        if self._begun is not None:
            self._taken.append(now - self._begun)
        self._begun = now

    def seconds_left(self, frames: Frames, progress: "stopping.Progress") -> float | None:
        """Time until the last frame is done, None before the first one is. [s]

        ``progress``: of the frame that is being made; without a forecast of its own it takes as long as others.
        """
        if not self._taken:
            return None
        # The first one starts the engine and makes its kernels.
        recent = (self._taken[1:] or self._taken)[-RECENT:]
        each = sum(recent) / len(recent)
        own = progress.seconds_left
        if own is None:
            own = max(each - (time.perf_counter() - self._begun), 0.0)
        return own + (frames.count - frames.number) * each

    def describe(self, frames: Frames, progress: "stopping.Progress") -> str:
        """One line for a status bar: the frame, its state, and when all are done."""
        left = self.seconds_left(frames, progress)
        parts = [f"frame {frames.number} of {frames.count}", progress.text()]
        if left is not None:
            parts.append(f"{stopping.format_seconds(left)} left of all frames")
        return ", ".join(parts)
