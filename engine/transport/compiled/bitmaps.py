"""Pictures on the device, as rows of one table: each is made once and kept while a material uses it."""

from dataclasses import dataclass, replace

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...materials.picture_table import PictureTable, Texels
from ...requirements.facts import spread
from ...scene.texture import ImageTexture


@dataclass(frozen=True, eq=False)
class _Laid:
    """A row of the table with the array that its texels were made of, which keeps the array's id taken."""

    pixels: np.ndarray
    row: int


class Bitmaps:
    """Rows by the identity of a picture's array and the way it is laid.

    ``asked`` holds the keys of what was asked for; whoever wants to know empties it before. ``table`` holds the rows; it
    waits for its `commit`.
    """

    def __init__(self):
        self.asked: set[tuple] = set()
        self.table = PictureTable()
        self._rows: dict[tuple, _Laid] = {}

    def __len__(self) -> int:
        """Number of pictures that are kept, each as often as it is laid in another way."""
        return len(self._rows)

    def texture(self, picture: ImageTexture, largest: float = 1.0, power: float | None = None):
        """Return a texture of a picture. Parameters are those of `row`."""
        texture = mi.load_dict({"type": "lumenray_laid_picture"})
        texture.lay(self.table, self.row(picture, largest, power))
        return texture

    def row(self, picture: ImageTexture, largest: float = 1.0, power: float | None = None) -> int:
        """Return the row of a picture in ``table``.

        Parameters
        ----------
        picture : ImageTexture
        largest : float    Values are held within 0 and this. Infinity: they are plain numbers, whatever their sign.
        power : float or None    For plain numbers: the channels' mean is raised to it. None: a colour.
        """
        if picture.pixels.flags.writeable:
            # Its numbers may become others under the same name.
            picture = replace(picture, pixels=picture.pixels.copy())
        key = key_of(picture, largest, power)
        self.asked.add(key)
        if key not in self._rows:
            name = key[0]
            if not self.table.holds(name):
                texels = _numbers if np.isinf(largest) else _texels
                values = _values(picture.pixels, largest, power)
                self.table.put(name, texels(_in_lines(values) if picture.tiles else values))
            row = self.table.lay(
                name,
                picture.transform,
                picture.interpolation == "closest",
                picture.extension,
                picture.tiles,
            )
            self._rows[key] = _Laid(picture.pixels, row)
        return self._rows[key].row

    def keep(self, keys: set[tuple]) -> None:
        """Forget all others: their rows are given to what comes next."""
        for key in [key for key in self._rows if key not in keys]:
            self.table.drop(self._rows.pop(key).row)


def key_of(picture: ImageTexture, largest: float = 1.0, power: float | None = None) -> tuple:
    """Name a picture laid in a way: same key, same row, while the array lives."""
    transform = np.asarray(picture.transform, dtype=np.float64).tobytes()
    how = (picture.interpolation, picture.extension, transform, picture.tiles)
    return ((id(picture.pixels), float(largest), power), *how)


def _values(pixels: np.ndarray, largest: float, power: float | None) -> np.ndarray:
    if np.isinf(largest):
        return np.nan_to_num(pixels, posinf=0.0, neginf=0.0).astype(np.float32)
    if power is not None:
        pixels = np.clip(pixels.mean(axis=2, keepdims=True), 0.0, 1.0) ** power
    pixels = np.clip(np.nan_to_num(pixels), 0.0, largest).astype(np.float32)
    if pixels.shape[2] == 3 and spread(pixels) <= 1e-6:
        pixels = pixels[:, :, :1]
    return pixels


def _in_lines(values: np.ndarray) -> np.ndarray:
    """Return numbers of one line (1, n, c) in two of at least two: Mitsuba repeats what is narrower. The last may repeat."""
    width = max((values.shape[1] + 1) // 2, 2)
    filled = np.pad(values[0], ((0, 2 * width - values.shape[1]), (0, 0)), mode="edge")
    return filled.reshape(2, width, -1)


def _numbers(values: np.ndarray) -> Texels:
    """Plain numbers, one or three for each texel."""
    height, width, channels = values.shape
    return Texels(upload(mi.Float, values), width, height, channels)


def _texels(values: np.ndarray) -> Texels:
    """Numbers of a picture as Mitsuba's texture has them, or their luminances in photometric variants."""
    texture = mi.load_dict(
        {
            "type": "bitmap",
            "bitmap": mi.Bitmap(np.ascontiguousarray(values)),
            # Three channels are upsampled spectrally by Mitsuba (`srgb_model`).
            "raw": values.shape[2] == 1,
            "format": "variant",
        }
    )
    data = mi.traverse(texture)["data"]
    height, width, channels = data.shape
    flat = data.array
    if channels == 3 and mi.is_monochromatic:
        index = dr.arange(mi.UInt32, height * width)
        flat, channels = mi.luminance(dr.gather(mi.Color3f, flat, index)), 1
    return Texels(flat, width, height, channels)
