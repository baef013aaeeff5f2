"""Mitsuba's table of smooth spectra by colour, read without Mitsuba, which takes long to start."""

import math
import struct
from functools import cache, lru_cache
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ..errors import LumenrayError

HEADER = struct.Struct("<4sI")
"""What the file begins with: ``SPEC`` and the number of steps of each axis."""

MOST_STEPS = 256
"""Steps beyond which a file is none of these; Mitsuba's has 64."""


@lru_cache(maxsize=4096)
def fetch_coefficients(red: float, green: float, blue: float) -> tuple[float, float, float]:
    """Coefficients of the sigmoid of a colour, as of `mitsuba.srgb_model_fetch`.

    Parameters
    ----------
    red, green, blue : float    Linear Rec. 709, 0 to 1.

    Returns
    -------
    (float, float, float)    Of the second, first and zeroth power of the wavelength in nm; the last is infinite of black
        and white.

    References
    ----------
    W. Jakob, J. Hanika: A low-dimensional function space for efficient spectral upsampling, 2019,
    doi:10.1111/cgf.13626
    """
    colour = np.clip(np.array([red, green, blue], dtype=np.float64), 0.0, 1.0)
    grey = float(colour[0])
    if (colour == grey).all():
        spread = math.sqrt(grey * (1.0 - grey))
        return 0.0, 0.0, (grey - 0.5) / spread if spread else math.copysign(math.inf, grey - 0.5)
    levels, table = _read()
    # Of equal channels Mitsuba takes the last for the largest.
    largest = 2 - int(np.argmax(colour[::-1]))
    steps, top = len(levels), colour[largest]
    x, y = (colour[(largest + more) % 3] * (steps - 1) / top for more in (1, 2))
    columns, lines = min(int(x), steps - 2), min(int(y), steps - 2)
    layer = min(max(int(np.searchsorted(levels, top, side="right")) - 1, 0), steps - 2)
    z = (top - levels[layer]) / (levels[layer + 1] - levels[layer])
    found = table[largest, layer : layer + 2, lines : lines + 2, columns : columns + 2]
    for share in (z, y - lines, x - columns):
        found = (1.0 - share) * found[0] + share * found[1]
    first, second, third = found.astype(np.float64)
    return float(first), float(second), float(third)


@cache
def _read() -> tuple[np.ndarray, np.ndarray]:
    """The levels of the largest channel, (n,), and the table of coefficients, (3, n, n, n, 3)."""
    origin = find_spec("mitsuba").origin
    path = Path(origin).with_name("data") / "srgb.coeff"
    try:
        with path.open("rb") as file:
            mark, steps = HEADER.unpack(file.read(HEADER.size))
    except (OSError, struct.error) as error:
        raise LumenrayError(
            f"{path}: Mitsuba's table of spectra cannot be read ({error})"
        ) from None
    size = HEADER.size + 4 * (steps + 9 * steps**3)
    if mark != b"SPEC" or not 2 <= steps <= MOST_STEPS or path.stat().st_size < size:
        raise LumenrayError(f"{path}: this is no table of spectra of the kind that Mitsuba 3 has")
    levels = np.fromfile(path, "<f4", steps, offset=HEADER.size).astype(np.float64)
    # A few of its millions of numbers are asked for.
    shape = (3, steps, steps, steps, 3)
    return levels, np.memmap(path, "<f4", "r", HEADER.size + 4 * steps, shape)
