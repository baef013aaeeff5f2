"""What follows from an array alone, kept by the array's identity for as long as the array lives.

Pictures have millions of numbers, and every edit asks the same of them again. Only read-only arrays are remembered: what may
be written to says nothing about tomorrow.
"""

import weakref
from collections.abc import Callable, Hashable

import numpy as np

_known: dict[int, tuple[weakref.ref, dict]] = {}


def recall(array: np.ndarray, name: Hashable, make: Callable):
    """Return ``make(array)``, computed once under its name for an array that cannot be written to."""
    if array.flags.writeable:
        return make(array)
    kept = _of(array)
    if name not in kept:
        kept[name] = _owned(make(array), array)
    return kept[name]


def recall_latest(array: np.ndarray, name: Hashable, others, parameters, make: Callable):
    """Return ``make()``, computed anew when the parameters or the other arrays are not those of the last time.

    Parameters
    ----------
    array : (...) array    First of the arrays that the value follows from; the value lives as long as it does.
    name : hashable    What is asked for; only its latest value is kept.
    others : sequence of arrays    The other arrays.
    parameters : object    Everything else, to be compared.
    make : callable    Its value, if a tuple, may begin with an array.
    """
    if any(each.flags.writeable for each in (array, *others)):
        return make()
    kept = _of(array)
    known = kept.get(name)
    if (
        known is not None
        and known[0] == parameters
        and len(known[1]) == len(others)
        and all(ref() is other for ref, other in zip(known[1], others, strict=True))
    ):
        return known[2]
    value = make()
    if isinstance(value, tuple) and value and isinstance(value[0], np.ndarray):
        value = (_owned(value[0], array, *others), *value[1:])
    kept[name] = (parameters, tuple(map(weakref.ref, others)), value)
    return value


def held_bytes(array: np.ndarray) -> int:
    """Return the bytes of an array and of all arrays that are kept because of it."""
    known = _known.get(id(array))
    values = list(known[1].values()) if known is not None and known[0]() is array else []
    return array.nbytes + sum(_bytes_of(value) for value in values)


def _bytes_of(value) -> int:
    if isinstance(value, np.ndarray):
        return held_bytes(value)
    return sum(map(_bytes_of, value)) if isinstance(value, tuple) else 0


def _of(array: np.ndarray) -> dict:
    key = id(array)
    known = _known.get(key)
    if known is None or known[0]() is not array:

        def forget(ref, known=_known):
            # At the end of the process the module's own names may be gone before the last array is.
            if key in known and known[key][0] is ref:
                del known[key]

        known = _known[key] = (weakref.ref(array, forget), {})
    return known[1]


def _owned(value, *sources):
    """Make an array fit to be kept: read-only, and none that keeps its own sources alive."""
    if not isinstance(value, np.ndarray):
        return value
    if any(np.may_share_memory(value, source) for source in sources):
        value = value.copy()
    value.flags.writeable = False
    return value
