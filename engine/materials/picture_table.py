"""Pictures of many materials in one table, so that their size, filter and extension are data and not code.

Mitsuba's `bitmap` writes the size of a picture, its filter and its way to go on outside into the kernel: each kind is a
model of its own, which every packet of rays visits. Here a picture is a row of numbers, and a look-up reads its row. Values
are those of `bitmap`: texels of colours are interpolated after their spectra are evaluated, not before.

Pictures of several tiles lie side by side on unit squares. A row of such a picture names a grid of squares, and a look-up
reads there where the texels of its square are. A scene without them compiles nothing of this.

Texels are in single precision. They take no more memory than the scene's own copy of the picture on the host, and twice as
much for the moment in which pictures come or go.
"""

from dataclasses import dataclass
from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np

from ..arrays import upload
from ..errors import SceneError
from ..scene.texture import Tile

WRAPS = ("repeat", "extend", "mirror")
"""What is outside 0..1, by the number in a row."""

MOST_NUMBERS = 1 << 31
"""Of all texels together: longer arrays cannot be addressed."""

_IS_NEAREST, _IS_COLOURED, _WRAP, _IS_TILED = 1, 2, 4, 16
"""Bits of the last number of a row; the wrap takes two from its own on."""

MOST_SQUARES = 1 << 16
"""Of the grid that the tiles of one picture lie on."""


@dataclass(frozen=True, eq=False)
class Texels:
    """Numbers of a picture on the device, row by row from v = 0.

    Parameters
    ----------
    values : Float    (height * width * channels,)
    width, height : int    [pixel]
    channels : int    1: plain numbers. 3: coefficients of `srgb_model_eval`, in spectral variants.
    """

    values: object
    width: int
    height: int
    channels: int

    @property
    def size(self) -> int:
        """Count of numbers."""
        return self.width * self.height * self.channels


@dataclass(frozen=True, eq=False)
class _Row:
    """A way to lay a picture."""

    name: object
    transform: np.ndarray
    is_nearest: bool
    wrap: int
    tiles: tuple[Tile, ...] = ()

    @property
    def grid(self) -> tuple[int, int]:
        """Columns and lines of the squares that hold all tiles."""
        return tuple(max((tile[k] + 1 for tile in self.tiles), default=0) for k in (0, 1))


class PictureTable:
    """Looks up pictures by a row. Owned and used by one thread.

    A picture's texels are there once, whatever the number of rows that show it.
    """

    def __init__(self):
        self._rows: list[_Row | None] = []
        self._staged: dict[object, Texels] = {}
        self._places: dict[object, tuple[int, Texels]] = {}
        self._has_changed = self._has_gaps = False
        self._texels = self._numbers = self._transforms = self._squares = None

    def __len__(self) -> int:
        """Count of rows in use."""
        return sum(row is not None for row in self._rows)

    def holds(self, name) -> bool:
        """Tell whether texels are there."""
        return name in self._places or name in self._staged

    def put(self, name, texels: Texels) -> None:
        """Take texels in under a name, for rows to come; they arrive with `commit`."""
        self._staged[name] = texels

    def lay(self, name, transform, is_nearest: bool, extension: str, tiles=()) -> int:
        """Take a row for texels that are there, and return its number.

        Parameters
        ----------
        transform : (3, 3) array    As of `ImageTexture`.
        is_nearest : bool    Whether texels are squares; if not, values are bilinear between their centres.
        extension : str    One of `WRAPS`.
        tiles : tuple of Tile    As of `ImageTexture`.

        Raises
        ------
        SceneError    Tiles lie at places of no grid, or do not have the texels that are there.
        """
        transform = np.asarray(transform, dtype=np.float64)
        row = _Row(name, transform, is_nearest, WRAPS.index(extension), tuple(tiles))
        if row.tiles:
            self._check_tiles(row)
        self._has_changed = True
        if None in self._rows:
            number = self._rows.index(None)
            self._rows[number] = row
        else:
            number = len(self._rows)
            self._rows.append(row)
        return number

    def _check_tiles(self, row: _Row) -> None:
        columns, lines = row.grid
        if min(min(tile) for tile in row.tiles) < 0 or columns * lines > MOST_SQUARES:
            raise SceneError(
                f"the tiles of a picture lie on {columns} x {lines} squares, and at most "
                f"{MOST_SQUARES} from the first on are read"
            )
        texels = self._staged.get(row.name) or self._places[row.name][1]
        count = sum(tile.width * tile.height for tile in row.tiles) + 1
        if texels.width * texels.height < count:
            raise SceneError(
                f"the tiles of a picture have {count} pixels, and {texels.width * texels.height} are there"
            )

    def drop(self, number: int) -> None:
        """Give a row back; texels go with the last row that shows them, and their memory at `commit`."""
        name, self._rows[number] = self._rows[number].name, None
        self._has_changed = True
        if all(row is None or row.name != name for row in self._rows):
            # The name may be given to others from now on.
            self._staged.pop(name, None)
            self._has_gaps |= self._places.pop(name, None) is not None

    def commit(self) -> None:
        """Bring what kernels read up to date.

        Raises
        ------
        SceneError    The pictures are too large together.
        """
        if not self._has_changed:
            return
        self._has_changed = False
        self._commit_texels()
        numbers = np.zeros((max(len(self._rows), 2), 4), dtype=np.uint32)
        # Two packets of four: what becomes u, and what becomes v.
        transforms = np.zeros((len(numbers), 2, 4))
        squares = []
        for number, row in enumerate(self._rows):
            if row is None:
                continue
            offset, texels = self._places[row.name]
            bits = _IS_NEAREST * row.is_nearest + _IS_COLOURED * (texels.channels == 3)
            bits += _WRAP * row.wrap
            numbers[number] = (offset, texels.width, texels.height, bits)
            transforms[number, :, :3] = row.transform[:2]
            if row.tiles:
                numbers[number] = (sum(map(len, squares)), *row.grid, bits + _IS_TILED)
                squares.append(_squares_of(row, offset, texels.channels))
        self._squares = None
        if squares:
            self._squares = upload(mi.UInt32, np.concatenate(squares))
            dr.eval(self._squares)
        self._numbers = upload(mi.UInt32, numbers)
        self._transforms = upload(mi.Float, transforms)
        dr.eval(self._numbers, self._transforms)

    def _commit_texels(self) -> None:
        if not self._staged and not self._has_gaps:
            return
        pieces = self._places | {name: (None, texels) for name, texels in self._staged.items()}
        # Plain numbers are read as three too.
        size = sum(texels.size for _, texels in pieces.values()) + 2
        if size > MOST_NUMBERS:
            raise SceneError(
                f"the pictures of the scene's materials hold {size} numbers, and at most {MOST_NUMBERS} "
                "can be addressed; use smaller pictures"
            )
        made, start = dr.zeros(mi.Float, size), 0
        places = {}
        for name, (old, texels) in pieces.items():
            index = dr.arange(mi.UInt32, texels.size)
            values = texels.values
            if old is not None:
                values = dr.gather(mi.Float, self._texels, index + dr.opaque(mi.UInt32, old))
            dr.scatter(made, values, index + dr.opaque(mi.UInt32, start))
            places[name] = (start, Texels(None, texels.width, texels.height, texels.channels))
            start += texels.size
        dr.eval(made)
        self._texels, self._places, self._staged, self._has_gaps = made, places, {}, False

    def eval(self, uv, wavelengths, row, active):
        """Value of pictures at surfaces.

        Parameters
        ----------
        uv : Point2f    Of the surface, before a picture's transform.
        wavelengths : Wavelength    Of the surface; photometric variants have none. [nm]
        row : UInt32    As `lay` gave it.

        Returns
        -------
        Spectrum    [-]
        """
        read = self._read_plain
        if len(wavelengths):
            read = partial(self._read_colour, wavelengths)
        return self._interpolate(uv, row, read, mi.Spectrum(0.0), active)

    def eval_1(self, uv, row, active):
        """As `eval`, for pictures of plain numbers. -> Float"""
        return self._interpolate(uv, row, self._read_plain, mi.Float(0.0), active)

    def vector(self, uv, row, active):
        """As `eval`, for pictures of three plain numbers. -> Vector3f"""

        def read(index, _is_coloured, active):
            return mi.Vector3f(
                *(dr.gather(mi.Float, self._texels, index + k, active) for k in range(3))
            )

        return self._interpolate(uv, row, read, mi.Vector3f(0.0), active)

    def slope(self, uv, row, active):
        """How pictures of plain numbers rise along U and V: the derivative of `eval_1`. -> (Float, Float)"""
        offset, width, height, bits, axes, columns, weights = self._texels_at(uv, row, active)
        (a, b), (c, d) = (
            [
                dr.gather(mi.Float, self._texels, offset + line * width + column, active)
                for column in columns[0]
            ]
            for line in columns[1]
        )
        # Between squares there are steps, which have no slope.
        is_smooth = dr.select((bits & _IS_NEAREST) != 0, 0.0, 1.0)
        along = is_smooth * mi.Float(width) * dr.lerp(b - a, d - c, weights[1][1])
        across = is_smooth * mi.Float(height) * dr.lerp(c - a, d - b, weights[0][1])
        (x_u, x_v), (y_u, y_v) = axes
        return along * x_u + across * y_u, along * x_v + across * y_v

    def _interpolate(self, uv, row, read, nothing, active):
        """Value between texels that ``read(index, is_coloured, active)`` gives."""
        offset, width, _, bits, _, columns, weights = self._texels_at(uv, row, active)
        is_coloured = (bits & _IS_COLOURED) != 0
        stride = dr.select(is_coloured, mi.UInt32(3), 1)
        value = nothing
        for j in (0, 1):
            line = nothing
            for i in (0, 1):
                index = offset + (columns[1][j] * width + columns[0][i]) * stride
                line = dr.fma(weights[0][i], read(index, is_coloured, active), line)
            value = dr.fma(weights[1][j], line, value)
        return value

    def _texels_at(self, uv, row, active):
        """Four texels about a place.

        Returns
        -------
        (UInt32, UInt32, UInt32, UInt32, list, list, list)
            Where the picture begins, its width and height, bits of its row; of u and of v of the picture each how it follows
            from U and V, two columns or lines, and their weights.
        """
        offset, width, height, bits = dr.gather(mi.Vector4u, self._numbers, row, active)
        is_nearest = (bits & _IS_NEAREST) != 0
        wrap = bits // _WRAP
        axes, columns, weights, places = [], [], [], []
        for axis in (0, 1):
            a, b, c, _ = dr.gather(mi.Vector4f, self._transforms, 2 * row + axis, active)
            axes.append((a, b))
            places.append(dr.fma(b, uv.y, dr.fma(a, uv.x, c)))
        if self._squares is not None:
            wrap &= 3
            offset, width, height, places = self._on_tile(
                offset, width, height, bits, places, active
            )
        for place, count in zip(places, (width, height), strict=True):
            texel = dr.fma(place, mi.Float(count), dr.select(is_nearest, 0.0, -0.5))
            below = dr.floor(texel)
            share = dr.select(is_nearest, 0.0, texel - below)
            first = mi.Int32(below)
            columns.append([_wrap(first + k, mi.Int32(count), wrap) for k in (0, 1)])
            weights.append([1.0 - share, share])
        return offset, width, height, bits, axes, columns, weights

    def _on_tile(self, offset, width, height, bits, places, active):
        """Where the texels of the tile at a place begin, its width and height, and the place on it.

        Squares are counted towards 0, as in Cycles: what is less than one before the first lies outside that one's edge.
        """
        is_tiled = (bits & _IS_TILED) != 0
        whole = [dr.trunc(place) for place in places]
        inside = (
            (whole[0] >= 0.0)
            & (whole[1] >= 0.0)
            & (whole[0] < mi.Float(width))
            & (whole[1] < mi.Float(height))
        )
        column, line = (mi.UInt32(dr.select(inside, each, 0.0)) for each in whole)
        square = offset + dr.select(inside, line * width + column, width * height)
        first, across, up, _ = dr.gather(mi.Vector4u, self._squares, square, active & is_tiled)
        return (
            dr.select(is_tiled, first, offset),
            dr.select(is_tiled, across, width),
            dr.select(is_tiled, up, height),
            [
                dr.select(is_tiled, place - each, place)
                for place, each in zip(places, whole, strict=True)
            ],
        )

    def _read_plain(self, index, _is_coloured, active):
        """Number of a texel."""
        return dr.gather(mi.Float, self._texels, index, active)

    def _read_colour(self, wavelengths, index, is_coloured, active):
        """Spectrum of a texel whose numbers begin at an index."""
        plain = dr.gather(mi.Float, self._texels, index, active)
        others = (dr.gather(mi.Float, self._texels, index + k, active) for k in (1, 2))
        colour = mi.srgb_model_eval(mi.Color3f(plain, *others), wavelengths)
        return dr.select(is_coloured, colour, plain)


def _squares_of(row: _Row, offset: int, channels: int) -> np.ndarray:
    """Where the texels of each square of a grid begin, their columns and lines; the last is of what is outside. (n, 4)"""
    columns, lines = row.grid
    count = sum(tile.width * tile.height for tile in row.tiles)
    made = np.zeros((columns * lines + 1, 4), np.uint32)
    made[:] = (offset + count * channels, 1, 1, 0)
    for tile in row.tiles:
        made[tile.line * columns + tile.column, :3] = (offset, tile.width, tile.height)
        offset += tile.width * tile.height * channels
    return made


def _wrap(place, count, wrap):
    """Index of a texel that stands for one outside a picture."""
    # Single precision errs by one period at most where it is exact to the texel, which the remainder shows.
    period = mi.Int32(dr.floor(mi.Float(place) / mi.Float(count)))
    rest = place - period * count
    period += dr.select(rest < 0, -1, dr.select(rest >= count, 1, 0))
    rest = place - period * count
    rest = dr.select((wrap == WRAPS.index("mirror")) & ((period & 1) == 1), count - 1 - rest, rest)
    rest = dr.select(wrap == WRAPS.index("extend"), place, rest)
    return mi.UInt32(dr.clip(rest, 0, count - 1))
