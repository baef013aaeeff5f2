"""Pixels of Blender images as they were read last, so that edits around an image do not read it again.

With them are kept the coordinates that textures are drawn at, for the sake of what was drawn.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ....engine.scene.memo import held_bytes
from ....engine.scene.texture import Tile
from .pixels import is_mixed_encoded, mixing_loss, read_pixels
from .tiled import read_tiles, tile_state

LARGEST = 1 << 30
"""Most bytes that are kept from one walk to the next, what was made of the pixels included. [byte]"""

SMALL = 1 << 16
"""Images below this size are always read: that is quick, and no script can write to them unseen. [byte]"""

_MOVING = {"SEQUENCE", "MOVIE"}


@dataclass(frozen=True, eq=False)
class Reading:
    """What `read_pixels` gave, as arrays that cannot be written to.

    Parameters
    ----------
    colour : (height, width, 3) float32 array
    alpha : (height, width, 1) float32 array
    notes : tuple of (str, str)    What it had to say, message and remedy.
    state : tuple    Of the image.
    is_own : bool    Whether Blender has no pixels of its own of it, and we could read it.
    loss : float    What Cycles' mixing of encoded values takes from the mean of the colour. [-]
    tiles : tuple of Tile    As of `ImageTexture`, whose arrays the colour and the alpha then are.
    missing : tuple of str    Tiles that could not be read, as messages.
    """

    colour: np.ndarray
    alpha: np.ndarray
    notes: tuple[tuple[str, str], ...] = ()
    state: tuple = ()
    is_own: bool = False
    loss: float = 0.0
    tiles: tuple[Tile, ...] = ()
    missing: tuple[str, ...] = ()

    @property
    def bytes(self) -> int:
        """Memory that is held because of it. [byte]"""
        return held_bytes(self.colour) + held_bytes(self.alpha)


class ImageCache:
    """Readings by the image's session uid and by what is wanted of its alpha, the latest used last."""

    def __init__(self):
        self._readings: dict[tuple, Reading] = {}
        self._tiles: dict[int, np.ndarray] = {}

    def tile(self, side: int) -> np.ndarray:
        """Return the coordinates (u, v, 0) of the pixels of a unit tile, (side, side, 3), as an array that is kept."""
        if side not in self._tiles:
            middles = ((np.arange(side) + 0.5) / side).astype(np.float32)
            u, v = np.meshgrid(middles, middles)
            tile = np.stack([u, v, np.zeros_like(u)], axis=-1)
            tile.flags.writeable = False
            self._tiles[side] = tile
        return self._tiles[side]

    def read(self, image, is_straight: bool, note: Callable[[str, str], None]) -> Reading | None:
        """Read an image as `read_pixels` does; what is noted is noted again when it is read no more."""
        if image is None:
            return None
        return self._read(image, is_straight, note, _read)

    def read_tiles(self, image, is_straight: bool, note) -> Reading | None:
        """Read an image with all its tiles, as `read`."""
        if image is None or image.source != "TILED":
            return self.read(image, is_straight, note)
        return self._read(image, is_straight, note, _read_tiles)

    def _read(self, image, is_straight, note, how) -> Reading | None:
        key = (image.session_uid, is_straight, how)
        known = self._readings.pop(key, None)
        # Blender drops the buffer of an image that it reloads, and tags only what uses it. Asking for more loads it.
        is_loaded = image.has_data or (known is not None and known.is_own)
        state = _state_of(image)
        if known is None or not is_loaded or known.state != state:
            known = how(image, is_straight, note)
        if known is None:
            return None
        if image.source not in _MOVING and known.colour.nbytes >= SMALL:
            self._readings[key] = known
        for message, remedy in known.notes:
            note(message, remedy)
        return known

    def forget(self, tagged: set[int]) -> None:
        """Forget images that may have changed, by session uid."""
        self._readings = {key: kept for key, kept in self._readings.items() if key[0] not in tagged}

    def clear(self) -> None:
        """Forget all of them."""
        self._readings, self._tiles = {}, {}

    def sweep(self, used: set[int]) -> None:
        """Forget what nothing uses any more, and what has not been used for longest where memory is short."""
        kept, left = [], LARGEST
        for key, reading in reversed(list(self._readings.items())):
            if key[0] in used and reading.bytes <= left:
                left -= reading.bytes
                kept.append((key, reading))
        self._readings = dict(reversed(kept))
        for side, tile in list(self._tiles.items()):
            left -= held_bytes(tile)
            if left < 0:
                del self._tiles[side]


def _read(image, is_straight: bool, note: Callable[[str, str], None]) -> Reading | None:
    notes: list[tuple[str, str]] = []
    pixels = read_pixels(image, is_straight, lambda *words: notes.append(words))
    if pixels is None:
        for words in notes:
            note(*words)
        return None
    colour = np.ascontiguousarray(pixels[..., :3])
    alpha = pixels[..., 3:]
    if alpha.min() == alpha.max():
        alpha = np.broadcast_to(alpha[0, 0].copy(), alpha.shape)
    else:
        alpha = alpha.copy()
        alpha.flags.writeable = False
    colour.flags.writeable = False
    loss = mixing_loss(colour) if is_mixed_encoded(image) else 0.0
    return Reading(colour, alpha, tuple(notes), _state_of(image), not image.has_data, loss)


def _read_tiles(image, is_straight: bool, note) -> Reading:
    notes: list[tuple[str, str]] = []
    made = read_tiles(image, is_straight, lambda *words: notes.append(words))
    for part in (made.colour, made.alpha):
        part.flags.writeable = False
    return Reading(
        made.colour,
        made.alpha,
        tuple(dict.fromkeys(notes)),
        _state_of(image),
        True,
        made.loss,
        made.tiles,
        made.missing,
    )


def _state_of(image) -> tuple:
    """Everything that the pixels and what is said about them depend on, as far as Blender tells."""
    return (
        image.name,
        image.source,
        image.type,
        image.filepath,
        _file_of(image),
        tuple(image.size),
        image.channels,
        image.is_float,
        image.is_dirty,
        image.alpha_mode,
        image.colorspace_settings.name,
        image.generated_type,
        tuple(image.generated_color),
        tile_state(image) if image.source == "TILED" else (),
    )


def _file_of(image) -> tuple:
    """Date and size of an image's file, () if there is none."""
    if image.source != "FILE" or not image.filepath or image.packed_file is not None:
        return ()
    try:
        found = Path(bpy.path.abspath(image.filepath, library=image.library)).stat()
    except (OSError, ValueError):
        return ()
    return (found.st_mtime_ns, found.st_size)
