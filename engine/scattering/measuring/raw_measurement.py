"""What a scattering instrument counts, before anything is made of it, and the text that holds it.

One row for each direction and band (all of it in ``docs/goniometer_format.md``)::

    # lumenray raw measurement 1
    # white brdf: 0.3119
    sigma, theta, phi, wavelength, sample, sample_reference, white, white_reference, dark, reference_dark
    10, 0, 0, 550, 20312, 10021, 15544, 10043, 52, 20

Angles are in degrees, about the mirror direction as those of `scene.scattering.ScatterTable`; the white sample was measured
in the same directions.
"""

import re
from dataclasses import dataclass, field

import numpy as np

from ...errors import FileFormatError
from ...reading.columns import Columns, name_columns, parse_columns, read_keyword
from ...reading.text import decode
from ..data.direction_samples import merge_angles

SIGNATURE = b"# lumenray raw measurement"

CHANNELS = "sample", "sample_reference", "white", "white_reference"
"""Columns of counts."""

MOST_CELLS = 1 << 23
"""Directions times bands of one measurement."""

LARGEST = 1e15
"""Count."""


@dataclass(frozen=True)
class Instrument:
    """What is known about the instrument.

    Parameters
    ----------
    readout : float    Standard deviation of a count when it is dark.
    shot : float    Variance that a count adds, over the count.
    repeatability : float    Relative standard deviation of a BRDF measured twice. [-]
    calibration_error : float    Relative error that all directions have in common, such as that of the white sample. [-]
    lowest, highest : float    Counts, dark ones taken off, that are trusted.
    resolution : float    Full width at half maximum, seen in a mirror; 0: not known. [rad]
    bandwidth : float    Full width at half maximum of a band, triangular; 0: narrow. [nm]
    """

    readout: float = 0.0
    shot: float = 0.0
    repeatability: float = 0.02
    calibration_error: float = 0.0
    lowest: float = 0.0
    highest: float = LARGEST
    resolution: float = 0.0
    bandwidth: float = 0.0


@dataclass(frozen=True, eq=False)
class RawSlice:
    """Counts for one angle of incidence.

    Parameters
    ----------
    incidence : float    [rad]
    radial, azimuth : (d,) float64 arrays    Directions about the mirror direction. [rad]
    sample, sample_reference, white, white_reference : (d, w) float64 arrays    Counts; nan where there are none.
    """

    incidence: float
    radial: np.ndarray
    azimuth: np.ndarray
    sample: np.ndarray
    sample_reference: np.ndarray
    white: np.ndarray
    white_reference: np.ndarray


@dataclass(frozen=True, eq=False)
class RawMeasurement:
    """Counts of a sample and of a white one whose BRDF is certified.

    Parameters
    ----------
    wavelengths : (w,) float64 array    Middles of the bands, ascending. [nm]
    slices : tuple of RawSlice    By ascending incidence.
    white_brdf : (w,) float64 array    Certified, the same in all directions. [1/sr]
    dark, reference_dark : (w,) float64 arrays    Counts without light, of the detector and of the reference channel.
    instrument : Instrument
    """

    wavelengths: np.ndarray
    slices: tuple[RawSlice, ...]
    white_brdf: np.ndarray
    dark: np.ndarray
    reference_dark: np.ndarray
    instrument: Instrument = field(default_factory=Instrument)


def is_raw_measurement(data: bytes) -> bool:
    """Whether a text begins as raw measurements do."""
    return data[:64].removeprefix(b"\xef\xbb\xbf").lower().startswith(SIGNATURE)


def read_raw_measurement(data: bytes, path) -> RawMeasurement:
    """Read a raw measurement.

    Raises
    ------
    FileFormatError    It is none, lacks a column or a count, or states what cannot be; names the line.
    """
    lines = decode(path, data).split("\n")
    version = re.match(r"^#\s*lumenray raw measurement\s+(\S+)\s*$", lines[0][:100].lower())
    if version is None or version[1] != "1":
        raise FileFormatError(path, "does not begin with '# lumenray raw measurement 1'", 1)
    head: dict[str, str] = {}
    for number, line in enumerate(lines):
        if line.lstrip().startswith("#") or not line.strip():
            if found := read_keyword(line[:1000]):
                head[found[0]] = found[1]
            continue
        mark, names = name_columns(line[: 1 << 16])
        return _assemble(parse_columns(lines, number + 1, path, head, mark, names))
    raise FileFormatError(path, "has no line that names its columns")


def _assemble(columns: Columns) -> RawMeasurement:
    """Counts by incidence, direction and band."""
    needed = ("sigma", "theta", "phi", "wavelength", *CHANNELS)
    found = {name: columns.find(name) for name in needed}
    for name, values in found.items():
        if values is None:
            columns.fail(f"lacks the column '{name}'")
    _check_rows(columns, found)
    incidences, s = merge_angles(np.radians(found["sigma"]))
    wavelengths, w = merge_angles(found["wavelength"])
    turn = np.radians(found["phi"]) % (2.0 * np.pi)
    radial = np.radians(found["theta"])
    slices = []
    for number, incidence in enumerate(incidences):
        rows = np.flatnonzero(s == number)
        t, a = merge_angles(radial[rows])[1], merge_angles(turn[rows])[1]
        _, first, d = np.unique(t * (a.max() + 1) + a, return_index=True, return_inverse=True)
        if len(first) * len(wavelengths) > MOST_CELLS:
            columns.fail(f"has more than {MOST_CELLS} directions and bands")
        counts = []
        for name in CHANNELS:
            made = np.full((len(first), len(wavelengths)), np.nan)
            made[d, w[rows]] = found[name][rows]
            counts.append(made)
        place = rows[first]
        slices.append(RawSlice(float(incidence), radial[place], turn[place], *counts))
    white = columns.find("white_brdf")
    if white is None:
        stated = columns.number("white brdf", np.nan, 1e-3, 10.0)
        if not np.isfinite(stated):
            columns.fail(
                "states no BRDF of the white sample: '# white brdf: 0.312' or a column white_brdf"
            )
        white_brdf = np.full(len(wavelengths), stated)
    else:
        white_brdf = _by_band(columns, "white_brdf", w, len(wavelengths), np.nan)
    if not np.all((white_brdf > 1e-3) & (white_brdf < 10.0)):
        columns.fail("has a band without a BRDF of the white sample between 0.001 and 10 1/sr")
    return RawMeasurement(
        wavelengths,
        tuple(slices),
        white_brdf,
        _by_band(columns, "dark", w, len(wavelengths), 0.0),
        _by_band(columns, "reference_dark", w, len(wavelengths), 0.0),
        _read_instrument(columns),
    )


def _check_rows(columns: Columns, found: dict) -> None:
    bounds = {"sigma": (0.0, 89.0), "theta": (0.0, 180.0), "phi": (-360.0, 360.0), "wavelength": (100.0, 1e5)}  # fmt: skip
    bounds |= dict.fromkeys(CHANNELS, (-LARGEST, LARGEST))
    for name, (low, high) in bounds.items():
        values = found[name]
        good = (values >= low) & (values <= high)
        if name in CHANNELS:
            good |= np.isnan(values)
        for row in np.flatnonzero(~good)[:1]:
            columns.fail(f"has {values[row]:g} as {name}, expected {low:g} to {high:g}", row)


def _by_band(columns: Columns, name: str, band, count: int, default: float) -> np.ndarray:
    """Mean of a column over the rows of each band; of a keyword where there is no such column. (w,)"""
    values = columns.find(name)
    if values is None:
        return np.full(count, columns.number(name.replace("_", " "), default, -LARGEST, LARGEST))
    good = np.isfinite(values) & (np.abs(np.nan_to_num(values)) <= LARGEST)
    sums = np.bincount(band[good], values[good], minlength=count)
    counts = np.bincount(band[good], minlength=count)
    return np.where(counts > 0, sums / np.maximum(counts, 1), default)


def _read_instrument(columns: Columns) -> Instrument:
    known = Instrument()
    return Instrument(
        columns.number("readout", known.readout, 0.0, LARGEST),
        columns.number("shot", known.shot, 0.0, LARGEST),
        columns.number("repeatability", known.repeatability, 1e-6, 1.0),
        columns.number("calibration error", known.calibration_error, 0.0, 1.0),
        columns.number("lowest", known.lowest, -LARGEST, LARGEST),
        columns.number("highest", known.highest, 0.0, LARGEST),
        np.radians(columns.number("resolution", known.resolution, 0.0, 20.0)),
        columns.number("bandwidth", known.bandwidth, 0.0, 200.0),
    )
