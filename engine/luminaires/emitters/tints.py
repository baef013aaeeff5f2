"""Colours of luminaires by direction on the device, as of slides: what light of a direction has beside the lamp's spectrum.

The colour at every node of a distribution's grid is upsampled to a spectrum t, and light there is the lamp's spectrum S
times t over the luminous share of it,

    t / (int S t V / int S V),

so that intensities stay what the distribution says; it is linear between the nodes. Photometric variants have none of this.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...errors import SceneError
from ...photometry.spectra import GRID, luminous_efficiency
from ..distribution import TURN

STEP = 5
"""Of the wavelengths at which luminous shares are summed. [nm]"""

PIECE = 1 << 16
"""Nodes whose shares are summed at once."""

DARK = 1e-6
"""Share of the largest channel of all nodes up to which a node has no colour. [-]"""


class Tints:
    """The colours of those rows of a palette that have some; numbers count from 1, and 0 has none."""

    def __init__(self):
        self._kept: dict[tuple, np.ndarray] = {}
        self.commit([])

    def commit(self, rows) -> list[int]:
        """Hold the colours of these rows and return their numbers. ``rows``: of `palette.Row`.

        Raises
        ------
        SceneError    There is not one colour for each intensity.
        """
        numbers, kept, header, ranges = [], {}, [], []
        for row in rows:
            distribution = row.distribution
            if distribution.colours is None or "spectral" not in mi.variant():
                numbers.append(0)
                continue
            if distribution.colours.shape != (*distribution.intensity.shape, 3):
                raise SceneError(
                    f"a distribution of {distribution.intensity.shape} intensities has colours of the shape "
                    f"{distribution.colours.shape}; expected three channels at each"
                )
            key = (row.digest, row.density.tobytes())
            if key not in kept:
                offset = sum(map(len, kept.values()))
                known = self._kept.get(key)
                kept[key] = _nodes_of(distribution.colours, row.density) if known is None else known
                header.append((offset, *distribution.intensity.shape, 0))
                ends = (distribution.azimuth, distribution.polar)
                ranges.append([end for axis in ends for end in (axis[0], axis[-1])])
            numbers.append(list(kept).index(key) + 1)
        self._kept = kept
        self._header = upload(mi.UInt32, np.array(header or [(0, 2, 2, 0)], np.uint32))
        self._ranges = upload(mi.Float, np.array(ranges or [(0.0, 1.0, 0.0, 1.0)]))
        self._nodes = upload(mi.Float, np.concatenate([*kept.values()] or [np.zeros((4, 4))]))
        return numbers

    def __len__(self) -> int:
        """Count of luminaires' colours that are held."""
        return len(self._kept)

    def eval(self, number, direction, wavelengths, active):
        """Factor on the spectrum of a row's light in a direction of its grid's own axes. [-]

        Parameters
        ----------
        number : UInt32    As `commit` gave it; 0: the factor is 1.
        """
        active = mi.Bool(active) & (number > 0)
        place = dr.select(number > 0, number - 1, 0)
        offset, columns, rows, _ = dr.gather(mi.Vector4u, self._header, place, active)
        ends = dr.gather(mi.Vector4f, self._ranges, place, active)
        azimuth = dr.atan2(direction.y, direction.x)
        azimuth = dr.select(azimuth < ends.x - 1e-5, azimuth + TURN, azimuth)
        flat = dr.sqrt(dr.square(direction.x) + dr.square(direction.y))
        polar = dr.atan2(flat, -direction.z)
        column, u = _locate(azimuth, ends.x, ends.y, columns)
        row, v = _locate(polar, ends.z, ends.w, rows)
        total = mi.Spectrum(0.0)
        for across, weight in ((0, 1.0 - u), (1, u)):
            for up, share in ((0, 1.0 - v), (1, v)):
                node = offset + (column + across) * rows + row + up
                a, b, c, factor = dr.gather(mi.Vector4f, self._nodes, node, active)
                found = mi.srgb_model_eval(mi.Color3f(a, b, c), wavelengths)
                total += found * (factor * weight * share)
        return dr.select(active, total, mi.Spectrum(1.0))


def _locate(value, start, end, count):
    """Cell of a value on even nodes and the place in it, 0..1."""
    last = mi.Float(count - 1)
    place = dr.clip((value - start) / (end - start) * last, 0.0, last)
    cell = dr.minimum(mi.UInt32(place), count - 2)
    return cell, place - mi.Float(cell)


def _nodes_of(colours: np.ndarray, density: np.ndarray) -> np.ndarray:
    """Coefficients of the nodes' spectra, and one over their luminous share of the lamp's light. (a p, 4)"""
    colours = np.asarray(colours, np.float64).reshape(-1, 3)
    largest = colours.max(axis=1, keepdims=True)
    colours = np.where(largest > DARK * largest.max(), colours / np.maximum(largest, 1e-300), 1.0)
    different, place = np.unique(
        np.round(colours * 4095.0).astype(np.int64), axis=0, return_inverse=True
    )
    # Mitsuba upsamples pictures at once, and repeats those of one line.
    width = max((len(different) + 1) // 2, 2)
    filled = np.pad(different / 4095.0, ((0, 2 * width - len(different)), (0, 0)), mode="edge")
    bitmap = mi.Bitmap(filled.reshape(2, width, 3).astype(np.float32))
    texture = mi.load_dict({"type": "bitmap", "bitmap": bitmap, "raw": False, "format": "variant"})
    found = np.array(mi.traverse(texture)["data"].array, np.float64).reshape(-1, 3)
    found = found[: len(different)]
    weights = (density * luminous_efficiency())[::STEP]
    weights /= weights.sum()
    wavelengths = GRID[::STEP]
    shares = np.concatenate(
        [
            _sigmoid(part, wavelengths) @ weights
            for part in np.array_split(found, len(found) // PIECE + 1)
        ]
    )
    return np.concatenate([found, 1.0 / shares[:, None]], axis=1)[place.ravel()]


def _sigmoid(coefficients: np.ndarray, wavelengths: np.ndarray) -> np.ndarray:
    """Spectra of coefficients as Mitsuba evaluates them. (n, 3), (w,) -> (n, w)"""
    a, b, c = (coefficients[:, k, None] for k in range(3))
    x = (a * wavelengths + b) * wavelengths + c
    with np.errstate(invalid="ignore"):
        made = 0.5 + 0.5 * x / np.sqrt(1.0 + x * x)
    return np.where(np.isinf(c), np.where(c > 0.0, 1.0, 0.0), made)
