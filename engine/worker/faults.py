"""What went wrong, in words: errors on their way between the processes, and the ways in which a process ends."""

import signal
import traceback

from .. import errors
from ..errors import EngineFault, LumenrayError

AGAIN = "start again: the scene is sent anew, nothing is lost"

LESS = "lower the density, the size of the picture or the largest map, or raise the engine's memory limit"

SHORT_OF_MEMORY = f"the engine ran out of memory; {LESS}"

_MEMORY_SIGNS = (
    "bad_alloc",
    "out of memory",
    "cannot allocate",
    "unable to allocate",
    "std::length_error",
)
"""What libraries say when memory is short, in lower case."""

_CLASSES = {
    name: kind
    for name, kind in vars(errors).items()
    if isinstance(kind, type) and issubclass(kind, LumenrayError)
}


def describe(error: Exception, job: str) -> tuple[str, str, dict]:
    """Return class, text and further attributes of an error; one that is not meant for people is put into words.

    Parameters
    ----------
    error : Exception
    job : str    What the engine was at, such as ``bake``.
    """
    if isinstance(error, LumenrayError):
        more = {key: value for key, value in vars(error).items() if _is_plain(value)}
        return type(error).__name__, str(error), more
    # The whole story is for the log.
    traceback.print_exception(error)
    if is_of_memory(error):
        return "EngineFault", SHORT_OF_MEMORY, {}
    said = " ".join(str(error).split()) or "no reason given"
    text = (
        f"the engine failed at the {job} ({type(error).__name__}: {said}); "
        "try again, and report it with the engine's log if it comes back"
    )
    return "EngineFault", text, {}


def rebuild(name: str, text: str, more: dict) -> LumenrayError:
    """Return the error that `describe` described."""
    kind = _CLASSES.get(name, EngineFault)
    error = kind.__new__(kind)
    error.args = (text,)
    vars(error).update({key: value for key, value in more.items() if _is_plain(value)})
    return error


def is_of_memory(error: Exception) -> bool:
    """Tell whether an error means that memory is short."""
    return isinstance(error, MemoryError) or speaks_of_memory(str(error))


def speaks_of_memory(text: str) -> bool:
    """Tell whether a library's words mean that memory is short."""
    text = text.lower()
    return any(sign in text for sign in _MEMORY_SIGNS)


def describe_end(code: int | None, log: tuple[str, ...]) -> str:
    """Say how the engine's process ended and what to do.

    Parameters
    ----------
    code : int or None    Its exit code; a negative one is the signal that ended it.
    log : tuple of str    The last lines that it wrote.
    """
    if code == -getattr(signal, "SIGKILL", 9):
        return f"the engine was ended from outside (SIGKILL), as a system does when memory is short; {AGAIN}"
    if speaks_of_memory("\n".join(log)):
        return f"{SHORT_OF_MEMORY}; {AGAIN}"
    said = _last_words(log)
    said = f", its last words: {said}" if said else ""
    if code is not None and code < 0:
        # Native libraries seldom check whether they got the memory they asked for.
        return (
            f"the engine crashed ({_signal_name(-code)}{said}), because memory is short or a library failed; "
            f"if it comes back, {LESS}; {AGAIN}"
        )
    number = "unknown" if code is None else f"{code:#x}" if code > 255 else str(code)
    return f"the engine ended by itself (exit code {number}{said}); {AGAIN}"


def _last_words(log: tuple[str, ...]) -> str:
    """Return the last line that was written before Python told where it crashed."""
    before = []
    for line in log:
        if line.startswith("Fatal Python error"):
            break
        before.append(line.strip())
    return next((line[:200] for line in reversed(before) if line), "")


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"


def _is_plain(value) -> bool:
    return value is None or isinstance(value, bool | int | float | str)
