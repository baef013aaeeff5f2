"""Image textures as pure data."""

from collections.abc import Callable
from dataclasses import dataclass, field, fields, is_dataclass, replace
from typing import NamedTuple

import numpy as np


def _identity() -> np.ndarray:
    return np.eye(3)


@dataclass(frozen=True, eq=False)
class Pixels:
    """Numbers of a picture, sent once for all materials and worlds that show it.

    Parameters
    ----------
    id : str    Names the content: equal ids have equal values. `ImageTexture.pixels` may hold it in their place.
    values : (height, width, 3) or (height, width, 1) float32 array    As in `ImageTexture`; they must not change.
    """

    id: str
    values: np.ndarray

    def __post_init__(self):
        if self.values.flags.writeable:
            values = self.values.view()
            values.flags.writeable = False
            object.__setattr__(self, "values", values)


class Tile(NamedTuple):
    """One picture of several that lie side by side, each on a unit square of its own.

    Parameters
    ----------
    column, line : int    Where its square begins in u and v.
    width, height : int    [pixel]
    """

    column: int
    line: int
    width: int
    height: int


@dataclass(frozen=True, eq=False)
class ImageTexture:
    """A picture laid over a surface by one of its UV maps.

    Parameters
    ----------
    pixels : (height, width, 3) or (height, width, 1) float32 array, or str
        Linear Rec. 709 values (three channels) or plain numbers (one channel). Row 0 is the *bottom* row (v = 0). On the
        way to a scene it may be the id of a `Pixels`; in a scene it is always the array.
    uv_map : str    Name of the mesh's UV map; empty for the mesh's default map.
    transform : (3, 3) float64 array    Homogeneous matrix applied to (u, v, 1) before the look-up.
    interpolation : str    ``linear`` or ``closest``.
    extension : str    Outside 0..1: ``repeat``, ``extend`` (edge pixels go on) or ``mirror``.
    name : str    For reports.
    tiles : tuple of Tile
        Pictures side by side in place of one: ``pixels`` are then (1, n, c), those of one tile after the other row by row,
        and a last one that stands where no tile is. Each tile goes on by the extension at its own edges.
    """

    pixels: np.ndarray | str
    uv_map: str = ""
    transform: np.ndarray = field(default_factory=_identity)
    interpolation: str = "linear"
    extension: str = "repeat"
    name: str = ""
    tiles: tuple[Tile, ...] = ()

    def __post_init__(self):
        # What comes from another process is made of plain tuples.
        object.__setattr__(self, "tiles", tuple(Tile(*tile) for tile in self.tiles))

    def mean(self) -> np.ndarray:
        """Return the mean of the pixels; what stands where no tile is does not count. (c,)"""
        pixels = self.pixels[:, :-1] if self.tiles else self.pixels
        return pixels.mean(axis=(0, 1), dtype=np.float64)

    def is_same(self, other) -> bool:
        """Tell whether another picture shows the very same array, which cannot change, in the same way."""
        return self is other or (
            isinstance(other, ImageTexture)
            and self.pixels is other.pixels
            and not self.pixels.flags.writeable
            and np.array_equal(self.transform, other.transform)
            and (self.uv_map, self.interpolation, self.extension, self.tiles)
            == (other.uv_map, other.interpolation, other.extension, other.tiles)
        )


def replace_pixels(value, change: Callable):
    """Return an item with ``change(pixels)`` in place of the pixels of all its pictures; itself if nothing changes."""
    if isinstance(value, ImageTexture):
        pixels = change(value.pixels)
        return value if pixels is value.pixels else replace(value, pixels=pixels)
    if isinstance(value, dict):
        made = {key: replace_pixels(entry, change) for key, entry in value.items()}
        return made if any(made[key] is not value[key] for key in made) else value
    if not is_dataclass(value):
        return value
    made = {}
    for entry in fields(value):
        old = getattr(value, entry.name)
        new = replace_pixels(old, change)
        if new is not old:
            made[entry.name] = new
    return replace(value, **made) if made else value
