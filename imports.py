"""Imports that wait: enabling the extension loads what Blender has to know of it, the rest is loaded when it is used."""

import builtins
import sys
from contextlib import contextmanager
from importlib import import_module
from importlib.util import resolve_name
from types import SimpleNamespace


class _Waiting:
    """Stands for a module among the names of another, until something of it is asked for."""

    # Without a dictionary of its own: that of the module is found like all else.
    __slots__ = ("_holder", "_name")

    def __init__(self, name: str, holder: dict):
        object.__setattr__(self, "_name", name)
        object.__setattr__(self, "_holder", holder)

    def __getattr__(self, name: str):
        return getattr(_load(self), name)

    def __setattr__(self, name: str, value):
        setattr(_load(self), name, value)

    def __repr__(self):
        return f"<{self._name}, imported when it is used>"


def _load(waiting: _Waiting):
    """Import the module that something stands for, and put it in its place."""
    module = import_module(waiting._name)
    holder = waiting._holder
    for key in [key for key, held in list(holder.items()) if held is waiting]:
        holder[key] = module
    return module


@contextmanager
def loaded_when_used():
    """Within it, ``import module`` and ``from package import module`` bind names without importing anything.

    A module that Blender needs when the extension is enabled (of panels, operators, properties, handlers) imports in
    such a block what only its functions use. The first attribute that is asked of such a name imports the module, by
    Python's own import with its locks, so in whatever thread that happens, and puts it in the place of the name. Only
    modules can be imported so, not what is in them, and annotations that name something of them are strings: else they
    are loaded at once.

    The statements remain what editors, linters and import contracts read. Python 3.15 has them as ``lazy import``
    (PEP 810), which this can become.
    """
    # Of the module whose statements these are: behind this generator and the context manager around it.
    caller = sys._getframe(2).f_globals
    import_now = builtins.__import__

    def wait(name, globals=None, locals=None, fromlist=(), level=0):  # noqa: A002
        if globals is not caller:
            return import_now(name, globals, locals, fromlist, level)
        package = resolve_name("." * level + name, caller["__package__"]) if level else name
        if not fromlist:
            return _Waiting(package, caller)
        return SimpleNamespace(**{each: _Waiting(f"{package}.{each}", caller) for each in fromlist})

    builtins.__import__ = wait
    try:
        yield
    finally:
        builtins.__import__ = import_now
