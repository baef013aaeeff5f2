"""Numbers that are none or out of all proportion, refused with the item and the field that hold them."""

from dataclasses import fields, is_dataclass
from enum import Enum

import numpy as np

from ..errors import SceneError
from .camera import Camera
from .distribution import Opening
from .light import (
    CieSky,
    CloudySky,
    ImageWorld,
    Light,
    Luminaire,
    Output,
    PerezSky,
    PlacedLight,
    UniformWorld,
)
from .material import Material, TabulatedPane
from .mesh import Geometry, Mesh, Placement
from .modelling import Modelling
from .sensor import SensorSet
from .texture import ImageTexture

PLAIN = (str, int, type(None), Enum)
"""Kinds of values that are always usable here."""

FARTHEST = 1e7
"""Distance from the world's origin up to which things are computed: a thing farther away would leave no digits for the
others, whose places are known to a part in 2 ** 24 of the scene's size. [m]"""

LARGEST_AMOUNT = 1e25
"""Largest amount of light of a single source, whatever its unit; with more, single precision overflows."""

DEEPEST_MIX = 24
"""How many mixtures may lie in each other; the time that a kernel takes to compile grows with the square of it."""


def check_item(item) -> None:
    """Refuse an item of a scene, a camera or a surface in which a number is not finite or out of proportion.

    Pixels of pictures are left out: a measured sky may hold infinite ones, and what they count as is decided where they are
    used. So are the tables of panes, which are checked there for more than this.

    Parameters
    ----------
    item : dataclass    Nested ones, arrays, sequences and dictionaries are gone through.

    Raises
    ------
    SceneError    Names the item, the field and the value; of an array its first bad row.
    """
    for fault in _faults(item, ""):
        raise SceneError(f"{_title(item)}{fault}")
    if isinstance(item, PlacedLight):
        check_reach(_title(item), item.place - item.reach, item.place + item.reach)
    if isinstance(item, Light | Modelling) and item.fault:
        raise SceneError(f"{_title(item)}: {item.fault}")
    if isinstance(item, Camera):
        place = np.asarray(item.frame)[:3, 3]
        check_reach(_title(item), place, place)
    if amount_of(item) > LARGEST_AMOUNT:
        raise SceneError(
            f"{_title(item)}: its amount of light is {amount_of(item):.3g}, expected at most {LARGEST_AMOUNT:g}"
        )
    if isinstance(item, Material):
        depth = item.surface.depth
        if depth > DEEPEST_MIX:
            raise SceneError(
                f"{_title(item)}: {depth} mixtures lie in each other, expected at most {DEEPEST_MIX}"
            )


def check_reach(title: str, low, high) -> None:
    """Refuse something that lies too far away, or reaches there, by its bounds. (3,), (3,) [m]

    Raises
    ------
    SceneError    Names it and how far it reaches.
    """
    reach = float(np.abs([low, high]).max())
    if not reach <= FARTHEST:
        raise SceneError(
            f"{title} reaches {reach:.3g} m from the world's origin, expected at most {FARTHEST:g} m"
        )


def amount_of(item) -> float:
    """Return how much light an item states, in its own unit; 0 of what gives none."""
    match item:
        case Material():
            return 0.0 if item.emission is None else item.emission.luminance
        case UniformWorld():
            return item.luminance
    output = getattr(item, "output", None)
    return 0.0 if output is None else output.value


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
        case UniformWorld() | ImageWorld() | CieSky() | CloudySky() | PerezSky():
            return "the world"
        case Luminaire():
            return f"luminaire '{item.name}'"
    kind, name = type(item).__name__, getattr(item, "name", None)
    return f"the {kind.lower()}" if name is None else f"light '{name}'"


def _faults(value, path: str):
    """Yield what is to be said of every number that is not finite, of an array once."""
    match value:
        case float() | np.floating() if not np.isfinite(value):
            yield f": {path} is {value}, not a finite number"
        case np.ndarray() if value.dtype.kind == "f" and not is_finite(value):
            yield f": {path}{_first_bad(value)}, not a finite number"
        case Output() if not np.isfinite(value.value):
            yield f": {path}.value is {value.value}, not a finite number of at least 0"
        case Opening() if not np.isfinite(value.size).all():
            place = int(np.flatnonzero(~np.isfinite(value.size))[0])
            yield (
                f" has an opening ({value.shape}) with a size of {value.size[place]} m along {'xyz'[place]}, expected a "
                "finite number"
            )
        case dict():
            for key, entry in value.items():
                yield from _faults(entry, f"{path}['{key}']")
        case tuple() | list():
            for place, entry in enumerate(value):
                yield from _faults(entry, f"{path}[{place}]")
        case TabulatedPane():
            return
        case _ if is_dataclass(value):
            for entry in fields(value):
                inner = getattr(value, entry.name)
                is_picture = isinstance(value, ImageTexture) and entry.name == "pixels"
                if not (isinstance(inner, PLAIN) or is_picture):
                    yield from _faults(inner, f"{path}.{entry.name}" if path else entry.name)


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


def _first_bad(array: np.ndarray) -> str:
    """Place and text of the first row of an array that is not finite."""
    if array.ndim == 0:
        return f" is {array}"
    rows = array.reshape(len(array), -1)
    row = int(np.flatnonzero(~np.isfinite(rows).all(axis=1))[0])
    text = np.array2string(array[row], separator=", ", precision=6).replace("\n", "")
    return f"[{row}] is {text}"
