"""Images of several tiles (UDIM): pixels of all tiles, one after the other.

Blender hands out the pixels of the first tile alone, so that each is read as an image of its own, from its file or from the
one that is packed.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ....engine.scene.texture import Tile
from .pixels import is_mixed_encoded, mixing_loss, read_pixels

LARGEST = 1 << 27
"""Pixels of all tiles of an image that are kept, and of one tile that is read; finer ones are made coarser."""

FIRST, COLUMNS = 1001, 10
"""Number of the tile at the origin, and how many lie in a line."""

ELSEWHERE = (1.0, 0.0, 1.0)
"""What Cycles shows where no tile is. [-]"""

_PLACES = re.compile("<(UDIM|UVTILE)>")


@dataclass(frozen=True, eq=False)
class Tiles:
    """Pixels of an image's tiles, as of `ImageTexture.tiles`.

    Parameters
    ----------
    colour : (1, n, 3) float32 array
    alpha : (1, n, 1) float32 array
    tiles : tuple of Tile
    loss : float    As of `Reading`. [-]
    missing : tuple of str    What could not be read, as messages.
    """

    colour: np.ndarray
    alpha: np.ndarray
    tiles: tuple[Tile, ...]
    loss: float
    missing: tuple[str, ...]


def read_tiles(image, is_straight: bool, note: Callable[[str, str], None]) -> Tiles:
    """Read all tiles of an image as `pixels.read_pixels` does; tiles that cannot be read are left out.

    Parameters
    ----------
    image : bpy.types.Image    Of the source TILED.
    is_straight, note    As of `read_pixels`.
    """
    if image.is_dirty:
        note(f"Image {image.name!r} is edited and not saved", "its tiles are those of its files")
    parts: dict[Tile, np.ndarray] = {}
    missing, loss, factor = [], [], 1
    for tile in image.tiles:
        pixels = _read_tile(image, tile.number, is_straight, note)
        if pixels is None:
            missing.append(f"Tile {tile.number} of image {image.name!r} cannot be read")
            continue
        if is_mixed_encoded(image):
            loss.append((pixels.shape[0] * pixels.shape[1], mixing_loss(pixels[..., :3])))
        line, column = divmod(tile.number - FIRST, COLUMNS)
        parts[_tile_of(column, line, pixels)] = _coarsened(pixels, factor)
        while sum(part.shape[0] * part.shape[1] for part in parts.values()) > LARGEST:
            factor *= 2
            parts = {key: _coarsened(part, 2) for key, part in parts.items()}
    if factor > 1:
        note(
            f"The tiles of image {image.name!r} have more than {LARGEST} pixels",
            f"the mean of {factor} x {factor} of them is used",
        )
    elsewhere = np.array([[*ELSEWHERE, 1.0]], np.float32)
    whole = np.concatenate([*(part.reshape(-1, 4) for part in parts.values()), elsewhere])
    return Tiles(
        np.ascontiguousarray(whole[None, :, :3]),
        np.ascontiguousarray(whole[None, :, 3:]),
        tuple(_tile_of(*key[:2], part) for key, part in parts.items()),
        float(np.average([each[1] for each in loss], weights=[each[0] for each in loss]))
        if loss
        else 0.0,
        tuple(missing),
    )


def tile_state(image) -> tuple:
    """Return what the pixels of an image's tiles follow from, beside the image itself."""
    packed = {each.tile_number: each.packed_file.size for each in image.packed_files}
    found = []
    for tile in image.tiles:
        stamp = (packed.get(tile.number, 0),)
        if tile.number not in packed:
            try:
                file = _path_of(image, tile.number).stat()
                stamp = (file.st_mtime_ns, file.st_size)
            except (OSError, ValueError):
                stamp = ()
        found.append((tile.number, stamp))
    return tuple(found)


def _read_tile(image, number: int, is_straight: bool, note) -> np.ndarray | None:
    """Return the pixels of one tile, (height, width, 4); None: it cannot be read."""
    packed = next((each for each in image.packed_files if each.tile_number == number), None)
    if packed is None and not _path_of(image, number).is_file():
        return None
    # Images of data of their own leave the user's as they are; nothing may hold on to them when those go.
    with bpy.data.temp_data() as data:
        return _read_apart(image, number, packed, data, is_straight, note)


def _read_apart(image, number: int, packed, data, is_straight: bool, note) -> np.ndarray | None:
    if packed is None:
        made = data.images.load(str(_path_of(image, number)))
    else:
        content = bytes(packed.packed_file.data)
        made = data.images.new(image.name, 1, 1)
        made.pack(data=content, data_len=len(content))
        made.source = "FILE"
    made.colorspace_settings.name = image.colorspace_settings.name
    made.alpha_mode = image.alpha_mode
    width, height = made.size
    if width * height > LARGEST:
        note(
            f"Tile {number} of image {image.name!r} has {width} x {height} pixels",
            f"it is left out, as it is more than {LARGEST}",
        )
        return None
    return read_pixels(made, is_straight, note)


def _path_of(image, number: int) -> Path:
    """Return where the file of a tile is."""
    line, column = divmod(number - FIRST, COLUMNS)
    places = {"UDIM": str(number), "UVTILE": f"u{column + 1}_v{line + 1}"}
    path = bpy.path.abspath(image.filepath, library=image.library)
    return Path(_PLACES.sub(lambda found: places[found[1]], path))


def _tile_of(column: int, line: int, pixels: np.ndarray) -> Tile:
    return Tile(column, line, pixels.shape[1], pixels.shape[0])


def _coarsened(pixels: np.ndarray, factor: int) -> np.ndarray:
    """Return means of blocks of pixels; of what is left over at the edges those that are there."""
    if factor == 1:
        return pixels
    for axis in (0, 1):
        starts = np.arange(0, pixels.shape[axis], factor)
        sizes = np.diff([*starts, pixels.shape[axis]]).astype(np.float32)
        sums = np.add.reduceat(pixels, starts, axis=axis)
        pixels = sums / np.expand_dims(sizes, [k for k in range(3) if k != axis])
    return pixels
