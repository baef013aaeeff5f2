"""Numbers or colours over a surface: one constant, or a picture laid by a UV map."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from ....engine.scene.colour import Colour, Scalar
from ....engine.scene.memo import recall
from ....engine.scene.spectrum import Constant, Rgb
from ....engine.scene.texture import ImageTexture, Tile
from . import tiles

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)
"""Weights of linear Rec. 709 red, green and blue in the luminance. [-]"""

LARGEST_TILE = 2048
"""Side of the largest picture that resampling makes. [pixels]"""

_EQUAL = 1e-6

TWO_MAPS = "Two UV maps meet in one colour"
"""What is noted where places on one map say nothing of those on the other."""

OTHER_PLACES = "Pictures with different placements are combined"
"""What is noted where no tile holds whole numbers of several pictures."""

SAMPLES = 256
"""Values that stand for one that nothing is known of but how it is spread."""

LARGEST_AVERAGE = 1 << 22
"""Numbers to be calculated at most where such a value meets a picture."""


@dataclass(frozen=True, eq=False)
class Layout:
    """How a picture lies on the surface; attributes as in `ImageTexture`."""

    uv_map: str
    transform: np.ndarray
    interpolation: str = "linear"
    extension: str = "repeat"
    name: str = ""
    tiles: tuple[Tile, ...] = ()

    def lies_as(self, other) -> bool:
        """Whether the same (u, v) shows the same place of both pictures."""
        return (
            self.uv_map == other.uv_map
            and self.extension == other.extension
            and self.tiles == other.tiles
            and np.allclose(self.transform, other.transform, atol=_EQUAL)
        )

    def picture(self, values: np.ndarray) -> np.ndarray:
        """Return values as the pixels of the picture."""
        return values


@dataclass(frozen=True, eq=False)
class Field:
    """A value over a surface; one channel counts as grey wherever a colour is wanted.

    Attributes
    ----------
    values : (1,) or (3,) float32 array, or (height, width, 1 or 3) with a layout
        Linear Rec. 709 or plain numbers, row 0 at the bottom.
    layout : Layout or None    None for a constant.
    is_stand_in : bool    Whether a node that cannot be taken over, or a number that is none, had a part in it.
    """

    values: np.ndarray
    layout: Layout | None = None
    is_stand_in: bool = False

    @property
    def is_constant(self) -> bool:
        """Whether the value is the same everywhere."""
        return self.layout is None

    @property
    def is_spread(self) -> bool:
        """Whether the values are samples of something unknown; what is done with it in the end counts by its mean."""
        return self.layout is SPREAD

    def settled(self) -> "Field":
        """Return the field with its mean in place of samples."""
        return Field(self.mean(), None, self.is_stand_in) if self.is_spread else self

    def mean(self) -> np.ndarray:
        """Return the mean over the picture, (1,) or (3,)."""
        if self.is_constant:
            return self.values
        if self.layout.tiles:
            return recall(self.values, "mean of tiles", lambda v: _mean(v[:, :-1]))
        return mean_of_picture(self.values)

    def key(self) -> tuple:
        """Return what the field is but for a picture's pixels, as values to compare."""
        if self.is_constant:
            return self.values.shape, self.values.tobytes()
        layout = self.layout
        how = (layout.uv_map, layout.interpolation, layout.extension, layout.name, layout.tiles)
        return self.values.shape, layout.transform.tobytes(), *how

    def limits(self) -> tuple[float, float]:
        """Return the smallest and the largest number."""
        return recall(self.values, "limits", lambda v: (float(v.min()), float(v.max())))

    def clipped(self) -> "Field":
        """Return the field with its numbers held within 0..1."""
        low, high = self.limits()
        if low >= 0 and high <= 1:
            return self
        clipped = recall(self.values, "clipped", lambda v: np.clip(v, 0, 1))
        return replace(self, values=clipped)

    def is_everywhere(self, value) -> bool:
        """Whether the field is constant and equal to a number."""
        return self.is_constant and bool(np.all(np.abs(self.values - value) < _EQUAL))


def constant(*values) -> Field:
    """Return the field that is the same everywhere."""
    return Field(np.array(values, np.float32))


SPREAD = Layout("samples", np.eye(3), name="samples")
"""Layout of samples; it lies on no surface."""


def spread(samples: np.ndarray) -> Field:
    """Return the field of something of which only samples are known, equally likely ones. (n, 1 or 3)"""
    return Field(np.asarray(samples, np.float32)[None], SPREAD, True)


def luminance(values) -> np.ndarray:
    """Return the Rec. 709 luminance of an array of colours, last axis kept with length 1."""
    if values.shape[-1] == 1:
        return values
    return recall(values, "luminance", lambda v: (v @ LUMINANCE)[..., None])


def mean_of_picture(pixels) -> np.ndarray:
    """Return the mean over a picture, (channels,)."""
    return recall(pixels, "mean", _mean)


def _mean(pixels) -> np.ndarray:
    return pixels.mean(axis=(0, 1), dtype=np.float64).astype(np.float32)


def rgb(values) -> np.ndarray:
    """Return an array of colours with three channels."""
    if values.shape[-1] == 3:
        return values
    return np.broadcast_to(values, (*values.shape[:-1], 3))


def map_fields(function, *fields, note: Callable[[str, str], None]) -> Field:
    """Apply a function of arrays to fields place by place.

    Parameters
    ----------
    function : callable    Takes one array per field, which broadcast, and returns one array.
    fields : Field    Its arguments.
    note : callable    Told (message, remedy) when pictures cannot be brought together exactly.

    Returns
    -------
    Field    Constant if all arguments are; samples if some of them are samples and the others constant.
    """
    is_stand_in = any(field.is_stand_in for field in fields)
    made, is_finite = _map(function, fields, note)
    if not is_finite:
        note("A number that is not finite arises", "0 or the largest number is used")
    return Field(made.values, made.layout, is_stand_in or not is_finite)


def _map(function, fields, note) -> tuple[Field, bool]:
    """Apply a function, and tell whether all results are numbers."""
    pictures = [field for field in fields if not field.is_constant]
    is_spread = [field.is_spread for field in pictures]
    if any(is_spread) and not all(is_spread):
        return _average(function, fields, note)
    if pictures:
        kept = pictures[0].layout.uv_map
        if any(field.layout.uv_map != kept for field in pictures):
            note(
                TWO_MAPS,
                f"the pictures on other maps than {kept or 'the default map'!r} become their mean",
            )
            fields = [_onto_map(field, kept) for field in fields]
            pictures = [field for field in fields if not field.is_constant]
    if not pictures:
        values, is_finite = _finite(function(*(field.values for field in fields)))
        return Field(values), is_finite
    layout, shape, is_shared = _common_layout(pictures, note)
    arrays = [
        field.values if field.is_constant else _onto_grid(field, layout, shape, is_shared)
        for field in fields
    ]
    values, is_finite = _finite(function(*arrays))
    values.flags.writeable = False
    return Field(np.broadcast_to(values, (*shape, values.shape[-1])), layout), is_finite


def _average(function, fields, note) -> tuple[Field, bool]:
    """Apply a function to samples and pictures: the mean over the samples, place by place."""
    pixels = max(field.values.size for field in fields if not field.is_spread)
    step = SAMPLES // int(np.clip(LARGEST_AVERAGE // pixels, 4, SAMPLES))
    numbers = range(step // 2, SAMPLES, step)
    total, is_finite = 0.0, True
    for turn, number in enumerate(numbers):
        chosen = [Field(f.values[0, number]) if f.is_spread else f for f in fields]
        made, is_fine = _map(function, chosen, note if turn == 0 else lambda *_: None)
        total, is_finite = total + made.values / np.float32(len(numbers)), is_finite and is_fine
    total.flags.writeable = False
    return Field(total, made.layout), is_finite


def _finite(values) -> tuple[np.ndarray, bool]:
    values = np.asarray(values, np.float32)
    if np.isfinite(values).all():
        return values, True
    return np.nan_to_num(values, posinf=3e38, neginf=-3e38), False


def _onto_map(field, uv_map):
    if field.is_constant or field.layout.uv_map == uv_map:
        return field
    return Field(field.mean())


def _common_layout(pictures, note):
    """Return a layout, a pixel grid and whether all pictures lie like that already."""
    first = pictures[0].layout
    tiled = next((field.layout for field in pictures if field.layout.tiles), None)
    if all(field.layout.lies_as(first) for field in pictures):
        shape = np.max([field.values.shape[:2] for field in pictures], axis=0)
        return first, tuple(int(side) for side in shape), True
    if tiled is not None:
        sides = [pixels_on(field, tiled.transform) for field in pictures if not field.layout.tiles]
        layout, is_whole = tiles.common_layout(
            tiled, [field.layout for field in pictures], np.max([[1, 1], *sides], axis=0)
        )
        if not is_whole:
            note("Pictures of tiles need a very large common picture", "they are resampled")
        return layout, (1, tiles.count(layout.tiles)), False
    transform = _periodic_tile(pictures)
    is_exact = transform is not None
    if not is_exact:
        alike = all(np.allclose(f.layout.transform, first.transform) for f in pictures)
        transform = first.transform if alike else np.eye(3)
    wanted = np.max([pixels_on(field, transform) for field in pictures], axis=0)
    shape = tuple(int(side) for side in np.clip(np.ceil(wanted - 1e-3), 1, LARGEST_TILE))
    if not is_exact:
        note(
            OTHER_PLACES,
            f"they are resampled on one UV tile of {shape[1]} x {shape[0]} pixels that repeats",
        )
    elif max(wanted) > LARGEST_TILE:
        note(
            "Pictures with different placements need a very large common picture",
            f"they are resampled on {shape[1]} x {shape[0]} pixels",
        )
    layout = Layout(first.uv_map, transform, first.interpolation, "repeat", first.name)
    return layout, shape, False


def _periodic_tile(pictures):
    """Return the UV transform of a tile in which every picture repeats a whole number of times."""
    if any(field.layout.extension != "repeat" for field in pictures):
        return None
    for base in [np.eye(3), *(field.layout.transform for field in pictures)]:
        if abs(np.linalg.det(base)) < 1e-9:
            continue
        relative = [field.layout.transform @ np.linalg.inv(base) for field in pictures]
        linear = np.array([matrix[:2, :2] for matrix in relative])
        if np.allclose(linear, np.round(linear), atol=1e-5):
            return base
    return None


def pixels_on(field, transform):
    """Return the (height, width) that keeps a picture's sharpness on a tile."""
    relative = field.layout.transform @ np.linalg.inv(transform)
    height, width = field.values.shape[:2]
    if field.layout.tiles:
        width, height = (max(tile[k] for tile in field.layout.tiles) for k in (2, 3))
    per_u = np.hypot(relative[0, 0] * width, relative[1, 0] * height)
    per_v = np.hypot(relative[0, 1] * width, relative[1, 1] * height)
    return np.array([per_v, per_u])


def _onto_grid(field, layout, shape, is_shared):
    if is_shared and field.values.shape[:2] == shape:
        return field.values
    if layout.tiles:
        relative = field.layout.transform @ np.linalg.pinv(layout.transform)
        return look_up(field, *tiles.places_on(layout.tiles, relative))
    v, u = np.meshgrid(
        (np.arange(shape[0]) + 0.5) / shape[0],
        (np.arange(shape[1]) + 0.5) / shape[1],
        indexing="ij",
    )
    if not is_shared:
        relative = field.layout.transform @ np.linalg.inv(layout.transform)
        u, v = (
            relative[0, 0] * u + relative[0, 1] * v + relative[0, 2],
            relative[1, 0] * u + relative[1, 1] * v + relative[1, 2],
        )
    return look_up(field, u, v)


def look_up(field, u, v) -> np.ndarray:
    """Return a picture's values at places of the picture itself.

    Parameters
    ----------
    field : Field    Not a constant.
    u, v : arrays of one shape    Picture coordinates, 0..1 across the picture.

    Returns
    -------
    array    Shape of `u` and then the channels.
    """
    if field.layout.tiles:
        return tiles.look_up(field, u, v, look_up)
    height, width = field.values.shape[:2]
    x, y = u * width - 0.5, v * height - 0.5
    extension = field.layout.extension
    if field.layout.interpolation == "closest":
        row = _wrap(np.round(y), height, extension)
        return field.values[row, _wrap(np.round(x), width, extension)]
    left, bottom = np.floor(x), np.floor(y)
    right_share = (x - left)[..., None].astype(np.float32)
    top_share = (y - bottom)[..., None].astype(np.float32)
    columns = [_wrap(left + step, width, extension) for step in (0, 1)]
    rows = [
        field.values[row, columns[0]] * (1 - right_share)
        + field.values[row, columns[1]] * right_share
        for row in (_wrap(bottom + step, height, extension) for step in (0, 1))
    ]
    return rows[0] * (1 - top_share) + rows[1] * top_share


def _wrap(index, size, extension):
    index = index.astype(np.int64)
    if extension == "extend":
        return np.clip(index, 0, size - 1)
    if extension == "mirror":
        index = np.mod(index, 2 * size)
        return np.where(index < size, index, 2 * size - 1 - index)
    return np.mod(index, size)


def as_colour(field: Field) -> Colour:
    """Return a field as the engine's description of a colour."""
    field = field.settled()
    if field.is_constant:
        red, green, blue = (float(value) for value in rgb(field.values))
        if max(red, green, blue) - min(red, green, blue) < _EQUAL:
            return Constant(red)
        return Rgb(red, green, blue)
    return as_texture(field)


def as_scalar(field: Field) -> Scalar:
    """Return a field as a plain number or a one-channel picture."""
    field = field.settled()
    if field.is_constant:
        return float(luminance(field.values)[0])
    return as_texture(Field(luminance(field.values), field.layout))


def as_texture(field: Field) -> ImageTexture:
    """Return a field that is not constant as the engine's picture."""
    layout = field.layout
    pixels = layout.picture(field.values)
    if pixels.dtype != np.float32 or not pixels.flags.c_contiguous:
        pixels = recall(pixels, "contiguous", lambda v: np.ascontiguousarray(v, np.float32))
    if pixels.flags.writeable:
        # What was made for this picture alone changes no more, and read-only arrays need be digested only once.
        pixels = pixels.view()
        pixels.flags.writeable = False
    return ImageTexture(
        pixels,
        layout.uv_map,
        np.array(layout.transform, np.float64),
        layout.interpolation,
        layout.extension,
        layout.name,
        layout.tiles,
    )


def from_colour(colour: Colour) -> Field:
    """Return the field of a colour that came from a node tree."""
    if isinstance(colour, ImageTexture):
        layout = Layout(
            colour.uv_map,
            colour.transform,
            colour.interpolation,
            colour.extension,
            colour.name,
            colour.tiles,
        )
        return Field(colour.pixels, layout)
    if isinstance(colour, Rgb):
        return constant(colour.red, colour.green, colour.blue)
    return constant(colour.value)
