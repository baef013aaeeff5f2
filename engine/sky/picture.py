"""What an equirectangular picture of the surroundings says: its luminances, and the integrals over them.

A pixel is a cell: column j of W spans the azimuths u = j/W to (j + 1)/W, row i of H the elevations v = i/H to (i + 1)/H
from the lowest point up, and its value stands at the cell's middle. In between the picture is bilinear, round the full
circle in azimuth; above the middle of the last row and below that of the first it goes on as it is there. With ``closest``
each cell is even.
"""

from dataclasses import dataclass

import numpy as np

from ..photometry.colour import REC709_LUMINANCE
from ..scene.memo import recall
from ..scene.texture import ImageTexture

WHITE = "D65"
"""Illuminant of what is white in a picture."""

ROWS_AT_ONCE = 256
"""Rows of a picture that are worked on together, so that large pictures need little memory."""

FINENESS = 1024
"""Places per half circle, at least, at which a tilted plane asks a coarse picture."""


@dataclass(frozen=True)
class Grid:
    """Rows and columns of a picture, and the bands between which it is linear.

    Band k, counted from the bottom, lies between the elevations `start` and `end` [rows] and leads from row `lower` to row
    `upper`. With ``closest`` there is one band for each row, else one more: between the middles of rows, and two half ones.
    """

    height: int
    width: int
    is_smooth: bool

    @property
    def shift(self) -> float:
        """Where a pixel's value stands, from the pixel's start. [pixel]"""
        return 0.5 if self.is_smooth else 0.0

    @property
    def step(self) -> int:
        """From a pixel to the one that the picture leads to from it. [pixel]"""
        return int(self.is_smooth)

    @property
    def bands(self) -> int:
        """Number of bands."""
        return self.height + self.step

    @property
    def start(self) -> np.ndarray:
        """(bands,) [row]"""
        return np.maximum(np.arange(self.bands) - self.shift, 0.0)

    @property
    def end(self) -> np.ndarray:
        """(bands,) [row]"""
        return np.minimum(np.arange(self.bands) + 1.0 - self.shift, self.height)

    @property
    def lower(self) -> np.ndarray:
        """(bands,) row numbers"""
        return np.maximum(np.arange(self.bands) - self.step, 0)

    @property
    def upper(self) -> np.ndarray:
        """(bands,) row numbers"""
        return np.minimum(np.arange(self.bands), self.height - 1)


def grid_of(image: ImageTexture) -> Grid:
    """Return the grid of a picture."""
    return Grid(*image.pixels.shape[:2], image.interpolation != "closest")


# ---- pixels ----


def count_faults(pixels: np.ndarray) -> tuple[int, int, int]:
    """Count pixels with a component that is NaN, that is infinite, and that is negative."""
    return recall(pixels, "faults", _count_faults)


def _count_faults(pixels) -> tuple[int, int, int]:
    counts = np.zeros(3, dtype=np.int64)
    for i in range(0, len(pixels), ROWS_AT_ONCE):
        part = pixels[i : i + ROWS_AT_ONCE]
        # A sum over the components of each pixel takes many times as long.
        if np.isfinite(part).all() and part.min() >= 0.0:
            continue
        tests = (np.isnan(part), np.isinf(part), part < 0.0)
        counts += [np.count_nonzero(test.any(axis=-1)) for test in tests]
    return tuple(int(count) for count in counts)


def describe_faults(image: ImageTexture) -> list[tuple[str, str]]:
    """Say what is wrong with a picture's pixels, and what is done instead: (message, remedy) each."""
    nan, infinite, negative = count_faults(image.pixels)
    height, width = image.pixels.shape[:2]
    name, of = image.name or "(unnamed)", f"of {height * width}"
    found = []
    if infinite:
        found.append(
            (
                f"environment picture '{name}' has {infinite} infinite pixels {of}",
                "they give no light, so what they stand for (a sun, mostly) is missing; state it as a Sun light, or save "
                "the picture with 32 bits",
            )
        )
    if nan:
        found.append(
            (f"environment picture '{name}' has {nan} NaN pixels {of}", "they give no light")
        )
    if negative:
        found.append(
            (
                f"environment picture '{name}' has {negative} pixels {of} with negative components",
                "their luminance is kept, or 0 if it is negative, and their colour is brought into Rec. 709",
            )
        )
    return found


def clean(pixels: np.ndarray) -> np.ndarray:
    """Return pixels without faults, as `describe_faults` says. (height, width, channels) -> the same, float32"""
    if not any(count_faults(pixels)):
        return np.asarray(pixels, dtype=np.float32)
    pixels = np.array(pixels, dtype=np.float32)
    pixels[~np.isfinite(pixels).all(axis=-1)] = 0.0
    faulty = (pixels < 0.0).any(axis=-1)
    given = pixels[faulty]
    held = np.maximum(given, 0.0)
    wanted, found = (np.maximum(_luminance(each), 0.0) for each in (given, held))
    pixels[faulty] = held * (wanted / np.maximum(found, 1e-38))[:, None]
    return pixels


def _luminance(pixels) -> np.ndarray:
    """(..., channels) -> (...), float64"""
    if pixels.shape[-1] == 1:
        return pixels[..., 0].astype(np.float64)
    return pixels @ REC709_LUMINANCE


def find_luminances(pixels: np.ndarray) -> np.ndarray:
    """Rec. 709 luminance of clean pixels. (height, width, channels) -> (height, width) float32"""
    return np.concatenate(
        [
            _luminance(pixels[i : i + ROWS_AT_ONCE]).astype(np.float32)
            for i in range(0, len(pixels), ROWS_AT_ONCE)
        ]
    )


# ---- integrals ----


def weigh_rows(grid: Grid) -> np.ndarray:
    """Part of the sphere that each row's value stands for. (height,) [-], sum 1"""
    low, high = (np.pi * each / grid.height for each in (grid.start, grid.end))
    slope = (np.sin(high) - np.sin(low)) / (high - low)
    rows = np.zeros(grid.height)
    # Integrals of (1 - t) sin and t sin of the angle from the lowest point over a band.
    np.add.at(rows, grid.lower, np.cos(low) - slope)
    np.add.at(rows, grid.upper, slope - np.cos(high))
    return 0.5 * rows


def find_mean(luminances: np.ndarray, grid: Grid) -> float:
    """Mean luminance over all directions, exact."""
    return float(weigh_rows(grid) @ luminances.mean(axis=1, dtype=np.float64))


def find_illuminance(image: ImageTexture, rotation: np.ndarray, normal) -> float:
    """Illuminance of a plane under a picture whose luminances are in cd/m2.

    Parameters
    ----------
    image : ImageTexture
    rotation : (3, 3) array    As in `ImageWorld`.
    normal : (3,) array    Unit vector in world space.

    Returns
    -------
    float    [lx]
    """
    normal = np.asarray(rotation, dtype=np.float64) @ np.asarray(normal, dtype=np.float64)
    key = ("illuminance", image.interpolation, normal.tobytes())
    return recall(image.pixels, key, lambda _: _integrate(image, normal))


def _integrate(image: ImageTexture, normal: np.ndarray) -> float:
    grid = grid_of(image)
    luminances = find_luminances(clean(image.pixels))
    if abs(normal[2]) > 1.0 - 1e-12:
        # Seen from the axis all columns are alike.
        luminances = luminances.mean(axis=1, keepdims=True, dtype=np.float64)
        grid = Grid(grid.height, 1, grid.is_smooth)
    points = max(2, -(-FINENESS // grid.height))
    nodes, weights = np.polynomial.legendre.leggauss(points)
    nodes, weights = 0.5 + 0.5 * nodes, 0.5 * weights
    along = max(points, -(-2 * FINENESS // grid.width)) if grid.width > 1 else 1
    across, shares = np.polynomial.legendre.leggauss(along)
    across, shares = 0.5 + 0.5 * across, 0.5 * shares
    azimuth = (
        (0.5 - (np.arange(grid.width)[:, None] + grid.shift + across) / grid.width) * 2 * np.pi
    )
    # Of the normal's part in the plane of the azimuth, relative to the direction's.
    level = normal[0] * np.cos(azimuth) + normal[1] * np.sin(azimuth)
    total = 0.0
    for k in range(grid.bands):
        low, high = luminances[grid.lower[k]], luminances[grid.upper[k]]
        size = grid.end[k] - grid.start[k]
        for t, weight in zip(nodes, weights, strict=True):
            polar = np.pi * (grid.start[k] + t * size) / grid.height
            row = (1.0 - t) * low + t * high
            onwards = np.roll(row, -grid.step)
            seen = np.maximum(level * np.sin(polar) - normal[2] * np.cos(polar), 0.0) @ (
                np.stack([shares * (1.0 - across), shares * across], axis=1)
            )
            amount = row @ seen[:, 0] + onwards @ seen[:, 1]
            total += float(amount) * weight * size * np.sin(polar)
    return total * 2.0 * np.pi**2 / (grid.width * grid.height)
