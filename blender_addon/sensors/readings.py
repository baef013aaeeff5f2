"""What sensors told, kept with their empty in the file: arrays as text, so that undo, copies and saved files have them."""

import base64
import functools
import io
import json
import zlib
from dataclasses import dataclass, fields

import numpy as np

from ...engine.accuracy.extremes import Extreme
from ...engine.accuracy.group_sum import GroupSum
from ...engine.accuracy.readings import Figures, judge_readings
from ...engine.light_mix import NEUTRAL, LightMix
from ...engine.measurements import SensorSpectra
from .places import GLARE, INTENSITY, UNITS, PlacedSensors

ARRAYS = ("positions", "normals", "frame", "plane", "cells", "values", "errors")
"""Arrays of readings, in the order in which they are kept."""

FURTHER = (
    "direct", "direct_errors", "rated", "rated_errors", "edges", "bands", "band_errors", "doses", "dose_errors",
)  # fmt: skip
"""Further arrays, where they were measured."""

VERSION = 1


@dataclass(frozen=True, eq=False)
class Readings:
    """What the sensors of an empty told.

    Parameters
    ----------
    quantity : str    One of `settings.QUANTITIES`.
    positions, normals : (n, 3) float32 array    Where they stood. [m]
    frame, plane, cells, shape    As of `PlacedSensors`.
    groups : tuple of str    Names of the light groups that were kept apart; one without a name: all light together.
    values, errors : (g, n) float32 array    By group: what was measured, and its standard error, in ``unit``.
    samples : int    Per sensor and group.
    seed : int
    scene_hash, method : str
    signature : str    Of the empty when it was measured, see `places.signature_of`.
    has_common : bool    Whether errors of sensors may have much in common.
    seconds : float    That it took to measure these and those that were measured with them. [s]
    reflections : int or None    How often the light that counts was reflected at most; None: without a limit.
    direct, direct_errors : (g, n) float32 array or None    The part of the values that was not reflected, where it was asked
        for.
    lacks : str    What the values lack, in words; empty: nothing.
    keeps_sources : bool    Whether dimmed lights are glare sources as at full flux; ratings of old files are not so.
    simplified : float    Largest relative error by what was not modelled; it is in the errors. [-]
    size : (float, float, float)    Of the luminaire in a goniometer, along its axes. [m]
    mixes : tuple of str    Levels of light groups for which glare was rated besides, see `LightMix.key`.
    rated, rated_errors : (m, n) float32 array or None    Ratings by them.
    edges : (b + 1,) float32 array or None    Of bands, where the spectrum was asked for. [nm]
    bands : (g, n, b) float32 array or None    Mean spectral irradiance. [W/(m2 nm)]
    band_errors : (g, b) float32 array or None    Root mean square of the sensors' standard errors.
    doses, dose_errors : (g, n, 5) float32 array or None    Alpha-opic equivalent daylight illuminances. [lx]
    """

    quantity: str
    positions: np.ndarray
    normals: np.ndarray
    frame: np.ndarray
    plane: np.ndarray
    cells: np.ndarray
    shape: tuple[int, int]
    groups: tuple[str, ...]
    values: np.ndarray
    errors: np.ndarray
    samples: int
    seed: int
    scene_hash: str
    method: str
    signature: str
    has_common: bool = True
    seconds: float = 0.0
    reflections: int | None = None
    direct: np.ndarray | None = None
    direct_errors: np.ndarray | None = None
    lacks: str = ""
    keeps_sources: bool = False
    simplified: float = 0.0
    size: tuple[float, float, float] = (0.0, 0.0, 0.0)
    mixes: tuple[str, ...] = ()
    rated: np.ndarray | None = None
    rated_errors: np.ndarray | None = None
    edges: np.ndarray | None = None
    bands: np.ndarray | None = None
    band_errors: np.ndarray | None = None
    doses: np.ndarray | None = None
    dose_errors: np.ndarray | None = None

    @functools.cached_property
    def _sum(self) -> GroupSum:
        return GroupSum(self.values, self.errors)

    @property
    def is_rating(self) -> bool:
        """Whether the values rate glare: they do not add up, and are NaN where nothing dazzles."""
        return self.quantity == GLARE

    @property
    def is_distribution(self) -> bool:
        """Whether the values are the intensities of a luminaire, of which neither mean nor uniformity says anything."""
        return self.quantity == INTENSITY

    @property
    def is_field(self) -> bool:
        """Whether the sensors stand in a grid and their values vary evenly over it."""
        return min(self.shape) > 1 and not self.is_rating and not self.is_distribution

    @property
    def unit(self) -> str:
        """Of the values."""
        return UNITS.get(self.quantity, "lx")

    def mixed(self, levels: LightMix = NEUTRAL) -> tuple[np.ndarray, np.ndarray]:
        """Illuminance and standard error with the groups at other levels. (n,), (n,) float64 [lx]

        Ratings are those of these levels where it `is_told`, else of all light as in the scene.
        """
        if self.is_rating and not levels.is_neutral and self.is_told(levels):
            row = self.mixes.index(levels.key())
            return tuple(each[row].astype(np.float64) for each in (self.rated, self.rated_errors))
        if self.is_rating:
            levels = NEUTRAL
        fluxes = [levels.level(name).flux for name in self.groups]
        self._sum.set_levels(fluxes)
        return self._sum.total.copy(), self._widen(self._sum, fluxes)

    def _widen(self, made: GroupSum, fluxes) -> np.ndarray:
        """Errors of a sum of groups, of which what was not modelled is wrong alike. (n,)"""
        error = made.error
        if not self.simplified or len(fluxes) < 2:
            return error
        apart = np.einsum("g,gn->n", np.square(fluxes), np.square(made.values, dtype=np.float64))
        return np.hypot(error, self.simplified * np.sqrt(np.maximum(made.total**2 - apart, 0.0)))

    def is_told(self, levels: LightMix) -> bool:
        """Whether it is known what the sensors would read with the groups at these levels."""
        if levels.is_neutral:
            return True
        return levels.key() in self.mixes if self.is_rating else self.groups != ("",)

    @functools.cached_property
    def _direct_sum(self) -> GroupSum:
        return GroupSum(self.direct, self.direct_errors)

    @property
    def has_spectrum(self) -> bool:
        """Whether the spectra of the light are known."""
        return self.doses is not None

    def mixed_spectra(self, levels: LightMix = NEUTRAL) -> SensorSpectra:
        """Spectra with the groups at other levels, whose colours are not followed; only where `has_spectrum`."""
        factors = np.array([levels.level(name).flux for name in self.groups])

        def add(values):
            return np.tensordot(factors, values.astype(np.float64), 1)

        def add_errors(errors):
            return np.sqrt(np.tensordot(factors**2, errors.astype(np.float64) ** 2, 1))

        bands = add(self.bands)
        errors = np.broadcast_to(add_errors(self.band_errors), bands.shape)
        edges = self.edges.astype(np.float64)
        return SensorSpectra(edges, bands, errors, add(self.doses), add_errors(self.dose_errors))

    @property
    def has_direct(self) -> bool:
        """Whether it is known what was not reflected."""
        return self.direct is not None or self.reflections == 0

    def mixed_direct(self, levels: LightMix = NEUTRAL) -> tuple[np.ndarray, np.ndarray]:
        """As `mixed`, of the light that was not reflected; only where `has_direct`."""
        if self.direct is None:
            return self.mixed(levels)
        fluxes = [levels.level(name).flux for name in self.groups]
        self._direct_sum.set_levels(fluxes)
        return self._direct_sum.total.copy(), self._widen(self._direct_sum, fluxes)

    def figures(self, levels: LightMix = NEUTRAL) -> Figures:
        """Mean, extremes and uniformity with the groups at other levels; of ratings where there are any, else NaN."""
        values, errors = self.mixed(levels)
        if self.is_rating:
            seen = np.isfinite(values)
            values, errors = values[seen], errors[seen]
            if not seen.any():
                none = Extreme(np.nan, np.nan, np.nan)
                return Figures(np.nan, np.nan, none, none, none, none)
        return judge_readings(values, errors, self.has_common)

    def mean_error(self, levels: LightMix = NEUTRAL) -> float:
        """Relative standard error of the mean, infinite where nothing arrives. [-]"""
        figures = self.figures(levels)
        return figures.mean_error / figures.mean if figures.mean > 0.0 else np.inf

    def grid(self, values) -> np.ndarray:
        """Values by row and column of the grid, NaN where no sensor stands. (rows, columns)"""
        made = np.full(self.shape[0] * self.shape[1], np.nan)
        made[self.cells] = values
        return made.reshape(self.shape)


def make_readings(
    placed: PlacedSensors,
    groups,
    values,
    errors,
    *,
    samples,
    seed,
    scene_hash,
    method,
    signature,
    has_common=True,
    seconds=0.0,
    reflections=None,
    direct=None,
    direct_errors=None,
    lacks="",
    keeps_sources=False,
    simplified=0.0,
    size=(0.0, 0.0, 0.0),
    mixes=(),
    **further,
) -> Readings:
    """Return readings of sensors that stand somewhere; ``values``, ``errors`` and their direct parts: (g, n). [lx]

    ``further``: arrays of `Readings` by their names, or None.
    """
    return Readings(
        placed.quantity,
        placed.positions.astype(np.float32),
        placed.normals.astype(np.float32),
        placed.frame.astype(np.float32),
        placed.plane.astype(np.float32),
        placed.cells.astype(np.int32),
        tuple(placed.shape),
        tuple(groups),
        np.asarray(values, dtype=np.float32),
        np.asarray(errors, dtype=np.float32),
        samples,
        seed,
        scene_hash,
        method,
        signature,
        bool(has_common),
        float(seconds),
        reflections,
        None if direct is None else np.asarray(direct, dtype=np.float32),
        None if direct_errors is None else np.asarray(direct_errors, dtype=np.float32),
        lacks,
        bool(keeps_sources),
        float(simplified),
        tuple(size),
        tuple(mixes),
        **{
            name: None if each is None else np.asarray(each, dtype=np.float32)
            for name, each in further.items()
        },
    )


def write_readings(readings: Readings) -> str:
    """Return readings as text."""
    names = [entry.name for entry in fields(readings) if entry.name not in ARRAYS + FURTHER]
    head = {"version": VERSION} | {name: getattr(readings, name) for name in names}
    arrays = (*ARRAYS, *(name for name in FURTHER if getattr(readings, name) is not None))
    head["arrays"] = arrays
    stream = io.BytesIO()
    stream.write(json.dumps(head).encode() + b"\n")
    for name in arrays:
        np.save(stream, getattr(readings, name), allow_pickle=False)
    return base64.b85encode(zlib.compress(stream.getvalue(), 6)).decode()


@functools.lru_cache(maxsize=256)
def read_readings(text: str) -> Readings | None:
    """Return readings that were kept as text; None where there are none, or they are of another version."""
    if not text:
        return None
    try:
        stream = io.BytesIO(zlib.decompress(base64.b85decode(text)))
        head = json.loads(stream.readline())
        if head.pop("version") != VERSION:
            return None
        # Older files do not say which arrays they have.
        names = head.pop("arrays", ARRAYS)
        arrays = {name: np.load(stream, allow_pickle=False) for name in names}
    except (ValueError, zlib.error, KeyError, EOFError):
        # A file that was damaged, or written by hand: the sensors are measured again.
        return None
    known = {entry.name for entry in fields(Readings)}
    if not set(ARRAYS) <= arrays.keys() or not (head.keys() | arrays.keys()) <= known:
        return None
    for name in ("shape", "groups", "size", "mixes"):
        if name in head:
            head[name] = tuple(head[name])
    return Readings(**head, **arrays)


def readings_of(empty) -> Readings | None:
    """Return what the sensors of an empty told, None if they were not measured yet."""
    return read_readings(empty.lumenray.sensor.kept)
