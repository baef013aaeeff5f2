"""Pictures on the device, as Mitsuba's textures or rows of a table: each is made once and kept while a material uses it."""

from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...materials.picture_table import PictureTable, Texels
from ...scene.texture import ImageTexture
from ..requirements import spread

LARGE = 1 << 22
"""Textures of pictures with more numbers than this are kept in half precision."""

ROW = "row"
"""Begins the keys of rows, which are those of textures otherwise."""

_WRAPS = {"repeat": "repeat", "extend": "clamp", "mirror": "mirror"}


@dataclass(frozen=True, eq=False)
class _Made:
    """A texture with the array that it was made of, which keeps the array's id taken."""

    pixels: np.ndarray
    texture: object
    channels: int
    is_half: bool


@dataclass(frozen=True, eq=False)
class _Laid:
    """A row of the table with the array that its texels were made of, which keeps the array's id taken."""

    pixels: np.ndarray
    row: int


class Bitmaps:
    """Textures and rows by the identity of a picture's array and the way it is laid.

    ``asked`` holds the keys of what was asked for; whoever wants to know empties it before. ``table`` holds the rows; it
    waits for its `commit`.
    """

    def __init__(self):
        self.asked: set[tuple] = set()
        self.table = PictureTable()
        self._made: dict[tuple, _Made] = {}
        self._rows: dict[tuple, _Laid] = {}

    def __len__(self) -> int:
        """Number of textures and rows that are kept."""
        return len(self._made) + len(self._rows)

    def texture(self, picture: ImageTexture, largest: float = 1.0, power: float | None = None):
        """Return the texture of a picture.

        Parameters
        ----------
        picture : ImageTexture
        largest : float    Values are held within 0 and this.
        power : float or None    For plain numbers: the channels' mean is raised to it. None: a colour.
        """
        if picture.pixels.flags.writeable:
            return _load(picture, _values(picture, largest, power))
        key = key_of(picture, largest, power)
        self.asked.add(key)
        if key not in self._made:
            alike = (made for other, made in self._made.items() if other[0] == key[0])
            self._made[key] = self._make(picture, key, next(alike, None))
        return self._made[key].texture

    def row(self, picture: ImageTexture) -> int:
        """Return the row of a picture in ``table``: a reflectance within 0 and 1."""
        pixels = picture.pixels
        if pixels.flags.writeable:
            # Its numbers may become others under the same name.
            pixels = pixels.copy()
            picture = replace(picture, pixels=pixels)
        key = (ROW, *key_of(picture))
        self.asked.add(key)
        if key not in self._rows:
            name = key[1]
            if not self.table.holds(name):
                self.table.put(name, _texels(picture))
            row = self.table.lay(
                name, picture.transform, picture.interpolation == "closest", picture.extension
            )
            self._rows[key] = _Laid(pixels, row)
        return self._rows[key].row

    def keep(self, keys: set[tuple]) -> None:
        """Forget all others; Mitsuba frees a texture with the last surface that uses it."""
        for key in [key for key in self._made if key not in keys]:
            del self._made[key]
        for key in [key for key in self._rows if key not in keys]:
            self.table.drop(self._rows.pop(key).row)

    def _make(self, picture: ImageTexture, key: tuple, alike: _Made | None) -> _Made:
        if alike is None:
            values = _values(picture, *key[0][1:])
            made = _load(picture, values)
            return _Made(picture.pixels, made, values.shape[2], values.size > LARGE)
        # The same numbers laid in another way: they are shared, for making them takes seconds.
        small = np.zeros((2, 2, alike.channels), dtype=np.float32)
        made = _load(picture, small, alike.is_half)
        parameters = mi.traverse(made)
        parameters["data"] = mi.traverse(alike.texture)["data"]
        parameters.update()
        return replace(alike, texture=made)


def key_of(picture: ImageTexture, largest: float = 1.0, power: float | None = None) -> tuple:
    """Name a texture: same key, same texture, while the array lives."""
    transform = np.asarray(picture.transform, dtype=np.float64).tobytes()
    how = (picture.interpolation, picture.extension, transform)
    return ((id(picture.pixels), float(largest), power), *how)


def _values(picture: ImageTexture, largest: float, power: float | None) -> np.ndarray:
    pixels = picture.pixels
    if power is not None:
        pixels = np.clip(pixels.mean(axis=2, keepdims=True), 0.0, 1.0) ** power
    pixels = np.clip(np.nan_to_num(pixels), 0.0, largest).astype(np.float32)
    if pixels.shape[2] == 3 and spread(pixels) <= 1e-6:
        pixels = pixels[:, :, :1]
    return pixels


def _texels(picture: ImageTexture) -> Texels:
    """Numbers of a picture as Mitsuba's texture has them, or their luminances in photometric variants."""
    values = mi.traverse(_load(picture, _values(picture, 1.0, None), is_half=False))["data"]
    height, width, channels = values.shape
    flat = values.array
    if channels == 3 and mi.is_monochromatic:
        index = dr.arange(mi.UInt32, height * width)
        flat, channels = mi.luminance(dr.gather(mi.Color3f, flat, index)), 1
    return Texels(flat, width, height, channels)


def _load(picture: ImageTexture, pixels: np.ndarray, is_half: bool | None = None):
    is_half = pixels.size > LARGE if is_half is None else is_half
    return mi.load_dict(
        {
            "type": "bitmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(pixels)),
            # Three channels are upsampled spectrally by Mitsuba (`srgb_model`).
            "raw": pixels.shape[2] == 1,
            "format": "fp16" if is_half else "variant",
            "filter_type": "nearest" if picture.interpolation == "closest" else "bilinear",
            "wrap_mode": _WRAPS[picture.extension],
            "to_uv": mi.ScalarTransform3f(
                [list(row) for row in np.asarray(picture.transform, dtype=np.float64)]
            ),
        }
    )
