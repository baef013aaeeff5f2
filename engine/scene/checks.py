"""Numbers that are none, refused with the item and the field that hold them."""

from dataclasses import fields, is_dataclass

import numpy as np

from ..errors import SceneError
from .distribution import Opening
from .light import CieSky, ImageWorld, Luminaire, Output, UniformWorld
from .material import Material, TabulatedPane
from .mesh import Geometry, Mesh, Placement
from .sensor import SensorSet
from .texture import ImageTexture

OWN_CHECKS = (Opening, TabulatedPane)
"""What is checked where it is used, with words of its own that name field and owner too."""


def check_item(item) -> None:
    """Refuse an item of a scene, a camera or a rule in which a number is not finite.

    Pixels of pictures are left out: a measured sky may hold infinite ones, and what they count as is decided where they are
    used.

    Parameters
    ----------
    item : dataclass    Nested ones, arrays, sequences and dictionaries are gone through.

    Raises
    ------
    SceneError    Names the item, the field and the value; of an array its first bad row.
    """
    for path, value, expected in _bad_numbers(item, ""):
        raise SceneError(f"{_title(item)}: {path} is {value}, not {expected}")


def _title(item) -> str:
    """Kind of an item for people, with its name."""
    match item:
        case Mesh() | Placement():
            return f"object '{item.name}'"
        case Geometry():
            return f"geometry '{item.id}'"
        case Material():
            return f"material '{item.name}'"
        case SensorSet():
            return f"sensors '{item.name}'"
        case UniformWorld() | ImageWorld() | CieSky():
            return "the world"
        case Luminaire():
            return f"luminaire '{item.name}'"
    kind, name = type(item).__name__, getattr(item, "name", None)
    return f"the {kind}" if name is None else f"light '{name}'"


def _bad_numbers(value, path: str):
    """Yield path, text and expectation of what is not finite, the first of every array."""
    if isinstance(value, np.ndarray):
        if value.dtype.kind == "f" and not is_finite(value):
            yield (*_first_bad(value, path), "a finite number")
    elif isinstance(value, float | np.floating):
        if not np.isfinite(value):
            yield path, str(value), "a finite number"
    elif isinstance(value, dict):
        for key, entry in value.items():
            yield from _bad_numbers(entry, f"{path}['{key}']")
    elif isinstance(value, tuple | list):
        for place, entry in enumerate(value):
            yield from _bad_numbers(entry, f"{path}[{place}]")
    elif is_dataclass(value) and not isinstance(value, OWN_CHECKS):
        for entry in fields(value):
            if isinstance(value, ImageTexture) and entry.name == "pixels":
                continue
            inner = f"{path}.{entry.name}" if path else entry.name
            for place, text, expected in _bad_numbers(getattr(value, entry.name), inner):
                is_amount = isinstance(value, Output) and entry.name == "value"
                yield place, text, f"{expected} of at least 0" if is_amount else expected


def is_finite(array: np.ndarray) -> bool:
    """Tell whether all numbers of an array are finite.

    The sum of the squares is finite only then, and is known in a fraction of the time that a test of each takes; where
    squares overflow, each is tested.
    """
    if array.flags.c_contiguous:
        flat = array.reshape(-1)
        with np.errstate(over="ignore", invalid="ignore"):
            if np.isfinite(np.dot(flat, flat)):
                return True
    return bool(np.isfinite(array).all())


def _first_bad(array: np.ndarray, path: str) -> tuple[str, str]:
    """Path and text of the first row of an array that is not finite."""
    if array.ndim == 0:
        return path, str(array)
    rows = array.reshape(len(array), -1)
    row = int(np.flatnonzero(~np.isfinite(rows).all(axis=1))[0])
    text = np.array2string(array[row], separator=", ", precision=6).replace("\n", "")
    return f"{path}[{row}]", text
