"""How a fault is stated and put into the engine: as a change of its own text or of a constant.

So the engine needs no hooks for faults, and a statement that no longer fits it says so instead of changing nothing.
"""

import importlib
import inspect
import pkgutil
import sys
import textwrap
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from unittest.mock import patch

from lumenray import engine as engine_package


@dataclass(frozen=True)
class Rewrite:
    """A line of a function or method, changed.

    Parameters
    ----------
    target : str    Such as ``transport.paths:trace`` or ``transport.textures:TextureMaker.spectrum``, in the engine.
    old, new : str    Text of the target, which holds it exactly once, and what stands there instead.
    """

    target: str
    old: str
    new: str

    @property
    def text(self) -> tuple[str, str]:
        """Before and after, for people."""
        return self.old, self.new

    def make(self, owner, original):
        """Return the changed function; it works in the original's module."""
        function = inspect.unwrap(original)
        source = textwrap.dedent(inspect.getsource(function))
        if (count := source.count(self.old)) != 1:
            raise ValueError(
                f"{self.target} holds '{self.old}' {count} times, expected once: state the fault anew"
            )
        made: dict[str, object] = {}
        code = compile(source.replace(self.old, self.new), f"<fault in {self.target}>", "exec")
        exec(code, function.__globals__, made)  # noqa: S102 - the text stands below
        return made[function.__name__]


@dataclass(frozen=True)
class Replace:
    """A constant of a module, replaced.

    Parameters
    ----------
    target : str    As of `Rewrite`.
    new : str    Expression in the names of its module.
    """

    target: str
    new: str

    @property
    def text(self) -> tuple[str, str]:
        """Before and after, for people."""
        return self.target.rpartition(":")[2], self.new

    def make(self, owner, original):
        """Return the new value."""
        return eval(self.new, vars(owner))  # noqa: S307 - the text stands below


@dataclass(frozen=True)
class Mutation:
    """A fault of physics.

    Parameters
    ----------
    name : str
    what : str    Half a sentence for people.
    changes : tuple of Rewrite or Replace
    likely : tuple of str    Groups of the quick subset that are asked first.
    """

    name: str
    what: str
    changes: tuple[Rewrite | Replace, ...]
    likely: tuple[str, ...]

    @contextmanager
    def injected(self) -> Iterator[None]:
        """Have the fault in this process; nothing may have been computed in it before, nor be computed afterwards.

        Raises
        ------
        ValueError    The engine's text is another than the fault says.
        """
        modules = _engine_modules()
        with ExitStack() as stack:
            for change in self.changes:
                owner, name, original = locate(change.target)
                made = change.make(owner, original)
                # Other modules may have imported it by its name.
                others = [m for m in modules if m is not owner and vars(m).get(name) is original]
                for place in [owner, *others]:
                    stack.enter_context(patch.object(place, name, made))
            yield


def locate(target: str) -> tuple[object, str, object]:
    """Return the module or class that has a target, the target's name there, and what it is now."""
    module, _, path = target.partition(":")
    owner = importlib.import_module(f"{engine_package.__name__}.{module}")
    *outer, name = path.split(".")
    for part in outer:
        owner = getattr(owner, part)
    return owner, name, getattr(owner, name)


def _engine_modules() -> list:
    """Import the whole engine, and return every module of the program: none is to come later with the fault in it."""
    for found in pkgutil.walk_packages(engine_package.__path__, f"{engine_package.__name__}."):
        importlib.import_module(found.name)
    root = engine_package.__name__.rpartition(".")[0]
    return [module for key, module in sys.modules.items() if key.startswith(f"{root}.")]
