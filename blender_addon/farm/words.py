"""What a task is told behind ``--`` on Blender's command line: a folder, then words NAME=VALUE."""

import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from ...engine.errors import LumenrayError

MOST_FRAMES = 1_000_000
"""Of a task: more are a slip of the pen."""


@dataclass(frozen=True)
class Words:
    """A task's words. ``parts``: values of those that may be repeated."""

    folder: Path
    values: dict = field(default_factory=dict)
    parts: tuple[str, ...] = ()


def read_words(readers: dict[str, Callable], arguments: list[str] | None = None) -> Words:
    """Read the words of this process.

    Parameters
    ----------
    readers : dict    By name, what reads a value, raising ValueError; ``part`` may come more than once.
    arguments : list of str or None    All of Blender's; None: those of this process.

    Raises
    ------
    LumenrayError    A word is missing, unknown or not understood.
    """
    arguments = sys.argv if arguments is None else arguments
    words = arguments[arguments.index("--") + 1 :] if "--" in arguments else []
    if not words:
        raise LumenrayError("the farm's task names no folder behind --")
    values, parts = {}, []
    for word in words[1:]:
        name, _, text = word.partition("=")
        if name not in readers:
            raise LumenrayError(
                f"the farm's task has {word!r}, expected one of {', '.join(readers)}"
            )
        try:
            value = readers[name](text)
        except ValueError as error:
            raise LumenrayError(f"the farm's task has {word!r}: {error}") from None
        if name == "part":
            parts.append(value)
        else:
            values[name] = value
    return Words(Path(words[0]), values, tuple(parts))


def read_frames(text: str) -> tuple[int, ...]:
    """Read frames as Blender's command line has them, such as ``1..10,12``.

    Raises
    ------
    ValueError    They are not understood, or too many.
    """
    frames = []
    for piece in text.split(","):
        first, dots, last = piece.partition("..")
        ends = int(first), int(last) if dots else int(first)
        if len(frames) + ends[1] - ends[0] >= MOST_FRAMES:
            raise ValueError(f"more than {MOST_FRAMES} frames")
        frames += range(ends[0], ends[1] + 1)
    return tuple(frames)
