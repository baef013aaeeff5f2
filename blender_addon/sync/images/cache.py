"""Pixels of Blender images as they were read last, so that edits around an image do not read it again."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ....engine.scene.memo import held_bytes
from .pixels import is_mixed_encoded, mixing_loss, read_pixels

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
    is_own : bool    Whether Blender could not read it, and we could.
    loss : float    What Cycles' mixing of encoded values takes from the mean of the colour. [-]
    """

    colour: np.ndarray
    alpha: np.ndarray
    notes: tuple[tuple[str, str], ...] = ()
    state: tuple = ()
    is_own: bool = False
    loss: float = 0.0

    @property
    def bytes(self) -> int:
        """Memory that is held because of it. [byte]"""
        return held_bytes(self.colour) + held_bytes(self.alpha)


class ImageCache:
    """Readings by the image's session uid and by what is wanted of its alpha, the latest used last."""

    def __init__(self):
        self._readings: dict[tuple[int, bool], Reading] = {}

    def read(self, image, is_straight: bool, note: Callable[[str, str], None]) -> Reading | None:
        """Read an image as `read_pixels` does; what is noted is noted again when it is read no more."""
        if image is None:
            return None
        key = (image.session_uid, is_straight)
        known = self._readings.pop(key, None)
        # Blender drops the buffer of an image that it reloads, and tags only what uses it. Asking for more loads it.
        is_loaded = image.has_data or (known is not None and known.is_own)
        state = _state_of(image)
        if known is None or not is_loaded or known.state != state:
            known = _read(image, is_straight, note)
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
        self._readings = {}

    def sweep(self, used: set[int]) -> None:
        """Forget what nothing uses any more, and what has not been used for longest where memory is short."""
        kept, left = [], LARGEST
        for key, reading in reversed(list(self._readings.items())):
            if key[0] in used and reading.bytes <= left:
                left -= reading.bytes
                kept.append((key, reading))
        self._readings = dict(reversed(kept))


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
