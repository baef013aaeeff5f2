"""Exceptions that carry one clear sentence for the user."""


class LumenrayError(Exception):
    """Base of all errors that are meant for people; the text is one sentence that says what to do."""


class BackendError(LumenrayError):
    """Mitsuba or LLVM is missing or does not work."""


class SceneError(LumenrayError):
    """The scene cannot be computed as it is."""


class FileFormatError(LumenrayError):
    """A file cannot be read: names file and line, what was found and what was expected; ``fault`` leaves out the file."""

    def __init__(self, path, message, line=None):
        place = f"{path}, line {line}" if line is not None else str(path)
        super().__init__(f"{place}: {message}")
        self.path = str(path)
        self.line = line
        self.fault = message if line is None else f"line {line}: {message}"


class Cancelled(LumenrayError):  # noqa: N818 - not a fault
    """The user stopped the job."""


class EngineFault(LumenrayError):  # noqa: N818 - says where the fault lies
    """The engine met an error of its own, or its machine's; the worker goes on."""


class EngineLost(LumenrayError):  # noqa: N818 - a state rather than a fault
    """The engine's process ended, hung or was closed; a new one has to be started."""


class CodecError(LumenrayError):
    """A message between Blender and the engine cannot be written or understood."""
