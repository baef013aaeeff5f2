"""Cases, each a function from a bench to findings, registered under its number."""

from collections.abc import Callable
from dataclasses import dataclass

from ..bench import Bench, Findings


@dataclass(frozen=True)
class Case:
    """A validation case.

    Parameters
    ----------
    id : str    Such as ``C05``.
    title : str
    family : str    What ``--family`` chooses by: direct, photometry, glass, interreflection, daylight, specular,
        stability, spectral or glare.
    run : callable    From a `Bench` to an iterator of findings, one for each of the bench's groups of the case.
    quick : tuple of str    Ids of the groups that make up the quick subset.
    """

    id: str
    title: str
    family: str
    run: Callable[[Bench], Findings]
    quick: tuple[str, ...] = ()


CASES: dict[str, Case] = {}
"""By id, as they are registered."""


def case(key: str, title: str, family: str, quick: tuple[str, ...] = ()):
    """Register the decorated function as a case."""

    def register(run):
        CASES[key] = Case(key, title, family, run, quick)
        return run

    return register
