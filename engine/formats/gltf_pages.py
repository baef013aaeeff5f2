"""Atlas pages as few textures: how they are made smaller and put together, and their pictures."""

from dataclasses import dataclass
from io import BytesIO

import numpy as np

from ..analysis.false_colour import colours
from ..analysis.tone import encode_srgb, limit_to_white
from ..errors import SceneError
from ..photometry.colour import scene_linear

MOST_HALVINGS = 4
"""How often pages are halved at most. After that charts, whose rim is some lumels wide, would run into one another."""


@dataclass(frozen=True)
class TexturePlan:
    """Where pages lie on textures.

    Parameters
    ----------
    factor : int    Lumels per texel and side: 1, 2, 4, ...
    numbers : tuple of int    Of the pages, in the order of the result.
    sizes : (p, 2) int array    Width and height of the pages. [lumel]
    texture : (p,) int array    Number of the texture that each page lies on.
    corner : (p, 2) int array    Lower left corner there. [texel]
    extents : (n, 2) int array    Width and height of the textures. [texel]
    """

    factor: int
    numbers: tuple[int, ...]
    sizes: np.ndarray
    texture: np.ndarray
    corner: np.ndarray
    extents: np.ndarray

    def place(self, uv: np.ndarray, page: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Take texture coordinates from pages to textures.

        Parameters
        ----------
        uv : (t, 3, 2) array    In 0..1 of the page, v upwards.
        page : (t,) int array    Numbers of pages that the plan has.

        Returns
        -------
        (texture, uv)
            Number of the texture (t,) and coordinates in 0..1 of it, v downwards as glTF has it, (t, 3, 2) float32.
        """
        rows = np.full(max(self.numbers, default=0) + 1, -1)
        rows[list(self.numbers)] = np.arange(len(self.numbers))
        row = rows[page]
        texture = self.texture[row]
        texels = self.corner[row][:, None] + uv * (self.sizes[row] / self.factor)[:, None]
        shares = texels / self.extents[texture][:, None]
        shares[..., 1] = 1.0 - shares[..., 1]
        return texture, shares.astype(np.float32)


def plan_textures(pages, most: int, side: int) -> TexturePlan:
    """Find places for pages on textures: as they are if they fit, else all halved alike until they do.

    Parameters
    ----------
    pages : sequence of AtlasPage
    most : int    Textures.
    side : int    Largest side of one. [texel]

    Raises
    ------
    SceneError    They do not fit even when they are halved as often as they may be.
    """
    sizes = np.array([(page.width, page.height) for page in pages], dtype=np.int64).reshape(-1, 2)
    for halvings in range(MOST_HALVINGS + 1):
        factor = 1 << halvings
        small = -(-sizes // factor)
        if (small <= side).all():
            texture, corner = _pack(small, side)
            if texture.max(initial=-1) < most:
                break
    else:
        raise SceneError(
            f"{len(sizes)} pages of lux maps do not fit on {most} textures of {side} x {side} texels, even at "
            f"1/{factor} of their density; allow more or larger textures, or bake with fewer lumels per metre"
        )
    extents = np.zeros((texture.max(initial=-1) + 1, 2), dtype=np.int64)
    np.maximum.at(extents, texture, corner + small)
    return TexturePlan(
        factor, tuple(page.number for page in pages), sizes, texture, corner, extents
    )


def _pack(sizes: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray]:
    """Put rectangles on shelves, tallest first, each on the first shelf with room. Returns their texture and corner."""
    texture = np.zeros(len(sizes), dtype=np.int64)
    corner = np.zeros((len(sizes), 2), dtype=np.int64)
    shelves: list[list[int]] = []  # texture, bottom, height, free from
    tops: list[int] = []
    for i in sorted(range(len(sizes)), key=lambda i: (-sizes[i, 1], -sizes[i, 0], i)):
        width, height = (int(v) for v in sizes[i])
        shelf = next((s for s in shelves if s[3] + width <= side and height <= s[2]), None)
        if shelf is None:
            number = next((n for n, top in enumerate(tops) if top + height <= side), len(tops))
            if number == len(tops):
                tops.append(0)
            shelf = [number, tops[number], height, 0]
            tops[number] += height
            shelves.append(shelf)
        texture[i] = shelf[0]
        corner[i] = shelf[3], shelf[1]
        shelf[3] += width
    return texture, corner


def compose(plan: TexturePlan, pages, number: int, quantity: str) -> np.ndarray:
    """Return a texture's values, (h, w) or (h, w, 3) float32, row 0 at the bottom.

    A texel is the mean of its computed lumels, or of its filled ones where it has none. Where there is nothing at all
    the surroundings go on, so that smaller copies of the texture, which viewers make, have no dark fringes.

    Raises
    ------
    SceneError    A page holds a number that is not finite.
    """
    width, height = plan.extents[number]
    values, known = None, np.zeros((height, width), dtype=bool)
    for row in np.flatnonzero(plan.texture == number):
        page = pages[row]
        numbers = getattr(page, quantity)
        if not np.isfinite(numbers).all():
            raise SceneError(
                f"page {page.number} of the lux maps holds values of {quantity} that are not finite"
            )
        lit = numbers != 0.0 if numbers.ndim == 2 else (numbers != 0.0).any(axis=2)
        fine, has_fine = _shrink(numbers, page.covered, plan.factor)
        filled, has_filled = _shrink(numbers, page.covered | (page.chart >= 0) | lit, plan.factor)
        fine[~has_fine] = filled[~has_fine]
        if values is None:
            values = np.zeros((height, width, *numbers.shape[2:]), dtype=np.float32)
        left, bottom = plan.corner[row]
        window = (slice(bottom, bottom + len(fine)), slice(left, left + fine.shape[1]))
        values[window] = fine
        known[window] = has_filled
    return spread(values, known)


def _shrink(values: np.ndarray, mask: np.ndarray, factor: int) -> tuple[np.ndarray, np.ndarray]:
    """Mean of the marked lumels in blocks of ``factor`` a side, and whether a block has any."""
    if factor == 1:
        return values.astype(np.float32), mask
    weight = mask.astype(np.float32)
    shape = weight.shape + (1,) * (values.ndim - 2)
    count = _block_sums(weight, factor)
    total = _block_sums(values * weight.reshape(shape), factor)
    count_shape = count.shape + (1,) * (values.ndim - 2)
    return total / np.maximum(count, 1.0).reshape(count_shape), count > 0.0


def _block_sums(values: np.ndarray, factor: int) -> np.ndarray:
    """Sums over blocks from the lower left corner on; the last ones may be incomplete."""
    height, width = values.shape[:2]
    rest = values.shape[2:]
    padding = ((0, -height % factor), (0, -width % factor)) + ((0, 0),) * len(rest)
    padded = np.pad(values, padding)
    rows, columns = padded.shape[0] // factor, padded.shape[1] // factor
    return padded.reshape(rows, factor, columns, factor, *rest).sum(axis=(1, 3), dtype=np.float32)


def spread(values: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Fill what is not known from a pyramid of means of what is; all 0 where nothing is. (h, w[, c]), (h, w) bool"""
    if known.all() or not known.any():
        return np.where(known.reshape(known.shape + (1,) * (values.ndim - 2)), values, 0.0).astype(
            np.float32
        )
    coarse, has_coarse = _shrink(values, known, 2)
    above = spread(coarse, has_coarse)
    height, width = known.shape
    enlarged = above.repeat(2, axis=0).repeat(2, axis=1)[:height, :width]
    filled = values.astype(np.float32)
    filled[~known] = enlarged[~known]
    return filled


def encode_grey(values: np.ndarray, top: float) -> bytes:
    """Return a grey sRGB PNG of values (h, w) of which ``top`` and more are white."""
    return _encode(encode_srgb(values / np.float32(top)), "L")


def encode_colour(exitance: np.ndarray, white: float) -> bytes:
    """Return an sRGB PNG of exitance as X, Y, Z [lm/m2], seen as luminance of which ``white`` [cd/m2] is white."""
    return _encode(encode_srgb(limit_to_white(scene_linear(exitance / np.pi, white))), "RGB")


def encode_scale(values: np.ndarray, top: float) -> bytes:
    """Return a PNG in false colours whose codes are proportional to the values, 255 at ``top``."""
    codes = np.round(255.0 * np.clip(values / np.float32(top), 0.0, 1.0)).astype(np.uint8)
    return _encode(codes, "P", colours(np.linspace(0.0, 1.0, 256), 0.0, 1.0))


def _encode(codes: np.ndarray, mode: str, palette: np.ndarray | None = None) -> bytes:
    from PIL import Image

    picture = Image.fromarray(np.ascontiguousarray(codes[::-1]), "L" if mode == "P" else mode)
    if palette is not None:
        picture.putpalette(palette.tobytes())
    stream = BytesIO()
    picture.save(stream, "PNG")
    return stream.getvalue()
