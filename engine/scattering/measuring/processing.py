"""From what an instrument counts to a table of scattering: calibrated, smooth, complete, and with no more light than comes.

The instrument measures a few angles of incidence. Between them the table is linear about the mirror direction; along the
normal it is extrapolated, beyond the last angle that one's values hold.

References
----------
Voloboy, Software technologies that automate the making of realistic images, dissertation, Moscow 2012, section 2.1
"""

from dataclasses import dataclass, replace

import numpy as np

from ...errors import SceneError
from ...reading.remarks import Remark
from ...scene.scattering import ScatterTable
from ..data.direction_samples import SAME
from ..data.evaluation import GOOD_RECIPROCITY, measure_reciprocity
from ..data.normal_incidence import along_normal
from ..data.table import albedo_of, check_table, direction_of, evaluate_table
from .calibration import CalibratedSlice, calibrate
from .mirror_peak import split_mirror_peak
from .raw_measurement import RawMeasurement
from .smoothing import SmoothSlice, smooth_slice

RADIALS = np.radians(
    np.concatenate(
        [
            [0.0, 0.5, 1.0, 1.5, 2.0, 2.5],
            np.arange(3.0, 20.0),
            np.arange(20.0, 50.0, 2.0),
            np.arange(50.0, 90.0, 4.0),
            np.arange(90.0, 181.0, 15.0),
        ]
    )
)
"""Radial angles of the table."""

AZIMUTHS = np.radians(np.arange(0.0, 181.0, 10.0))
"""Azimuths of the table."""

STEEPEST = np.radians(89.0)
"""Nearer to the horizon values are those of this angle to the normal."""

FEWEST = 12
"""Directions that an angle of incidence needs."""

IN_PLANE = np.radians(2.0)
"""Directions so near to the plane of incidence are drawn as lying in it."""

ENERGY_STEP = np.radians(5.0)
"""Angles of incidence at which light is summed up, beside those of the table."""


@dataclass(frozen=True, eq=False)
class PolarCut:
    """A measurement and what was made of it in the plane of incidence.

    Parameters
    ----------
    incidence : float    [rad]
    angles : (n,) float64 array    To the normal, positive on the side of the mirror direction, ascending. [rad]
    measured : (n, w) float64 array    nan at holes. [1/sr]
    table_angles : (m,) float64 array    [rad]
    table : (m, w) float64 array    [1/sr]
    """

    incidence: float
    angles: np.ndarray
    measured: np.ndarray
    table_angles: np.ndarray
    table: np.ndarray


@dataclass(frozen=True, eq=False)
class ProcessedMeasurement:
    """A table and how it came about.

    Parameters
    ----------
    table : ScatterTable    Its ``error`` is ``statistical_error``.
    residual : float
        Relative difference of measured and smooth values, root mean square: noise, and what was smoothed away. [-]
    statistical_error : float    Estimated relative error of the smooth values by noise, root mean square. [-]
    calibration_error : float    Relative error that all values have in common, as stated. [-]
    reciprocity : float    As `evaluation.Reciprocity.residual`. [-]
    missing : float    Share of directions and bands that had to be filled. [-]
    remarks : tuple of Remark
    cuts : tuple of PolarCut    One for each measured angle of incidence.
    """

    table: ScatterTable
    residual: float
    statistical_error: float
    calibration_error: float
    reciprocity: float
    missing: float
    remarks: tuple[Remark, ...]
    cuts: tuple[PolarCut, ...]


def process_measurement(raw: RawMeasurement) -> ProcessedMeasurement:
    """Make a table of a raw measurement.

    Raises
    ------
    SceneError    An angle of incidence or a band has too few valid directions.
    """
    measured = calibrate(raw)
    remarks: list[Remark] = []
    smooth, mirrored = [], []
    resolution = raw.instrument.resolution
    for piece in measured:
        _check_slice(piece, raw.wavelengths)
        rest, share = split_mirror_peak(piece, resolution)
        mirrored.append(share)
        # Where a mirror's peak was taken off nothing narrow is left.
        narrow = 0.0 if share.any() else resolution
        smooth.append(smooth_slice(rest.radial, rest.azimuth, rest.values, rest.variance, narrow))
        if share.any():
            remarks.append(
                Remark(
                    f"at {np.degrees(piece.incidence):.3g}° a mirror's peak of {100.0 * share.mean():.2g} % "
                    "was taken off and is reflected sharply"
                )
            )
    values = np.stack([_on_grid(*pair) for pair in zip(measured, smooth, strict=True)])
    incidences = np.array([piece.incidence for piece in measured])
    incidences, values, mirrored = _complete(incidences, values, np.stack(mirrored), remarks)
    values, mirrored = _narrow_bands(raw, values, mirrored, remarks)
    noise = _mean_square(np.concatenate([each.residual.ravel() for each in smooth]))
    error = _mean_square(np.array([each.error for each in smooth]))
    table = ScatterTable(
        np.zeros(1),
        incidences,
        RADIALS,
        AZIMUTHS,
        raw.wavelengths,
        values[None].astype(np.float32),
        mirrored[None].astype(np.float32) if mirrored.any() else None,
        error,
    )
    table = _limit_energy(table, remarks)
    check_table(table)
    reciprocity = measure_reciprocity(table).residual
    if reciprocity > GOOD_RECIPROCITY:
        remarks.append(
            Remark(
                f"light there and back differs by {100.0 * reciprocity:.0f} %; a good measurement has less "
                f"than {100.0 * GOOD_RECIPROCITY:.0f} %"
            )
        )
    holes = np.concatenate([np.isnan(piece.values).ravel() for piece in measured])
    return ProcessedMeasurement(
        table,
        noise,
        error,
        raw.instrument.calibration_error,
        reciprocity,
        float(holes.mean()),
        tuple(remarks),
        tuple(_cut(piece, table) for piece in measured),
    )


def _mean_square(values) -> float:
    return float(np.sqrt(np.nanmean(np.square(values))))


def _check_slice(piece: CalibratedSlice, wavelengths) -> None:
    valid = np.isfinite(piece.values).sum(axis=0)
    if valid.min() < FEWEST:
        raise SceneError(
            f"the measurement has {valid.min()} valid directions at the incidence "
            f"{np.degrees(piece.incidence):.3g}° and {wavelengths[valid.argmin()]:g} nm, expected at least "
            f"{FEWEST}"
        )


# ---- directions ----


def _on_grid(piece: CalibratedSlice, smooth: SmoothSlice) -> np.ndarray:
    """Smooth values on the table's grid; below the steepest measured direction those of that. (t, a, w)"""
    radial, azimuth = (m.ravel() for m in np.meshgrid(RADIALS, AZIMUTHS, indexing="ij"))
    seen = np.isfinite(piece.values).any(axis=1)
    lowest = direction_of(piece.incidence, piece.radial[seen], piece.azimuth[seen])[:, 2].min()
    drawn = _draw_in(piece.incidence, radial, azimuth, max(lowest, np.cos(STEEPEST)))
    drawn = np.minimum(drawn, piece.radial[seen].max())
    made = smooth.read(drawn, azimuth).reshape(len(RADIALS), len(AZIMUTHS), -1)
    made[0] = made[0].mean(axis=0)
    return made


def _draw_in(incidence: float, radial, azimuth, lowest: float):
    """Radial angles, those of directions with a smaller cosine to the normal brought back to it along their azimuth."""
    across = np.cos(azimuth) * np.sin(incidence)
    lowest = min(lowest, np.cos(incidence))
    edge = np.arccos(lowest / np.hypot(np.cos(incidence), across)) - np.arctan2(
        across, np.cos(incidence)
    )
    cosine = direction_of(incidence, radial, azimuth)[..., 2]
    return np.where(cosine < lowest, np.minimum(radial, np.maximum(edge, 0.0)), radial)


# ---- angles of incidence ----


def _complete(incidences, values, mirrored, remarks):
    """Add the angles of incidence 0 and 90 degrees."""
    if incidences[0] > SAME:
        remarks.append(
            Remark(f"light along the normal is extrapolated from {_told(incidences[:2])}")
        )
        first = along_normal(RADIALS, AZIMUTHS, incidences, values)
        incidences, values = np.append(0.0, incidences), np.concatenate([first[None], values])
        mirrored = np.concatenate([mirrored[:1], mirrored])
    if incidences[-1] < 0.5 * np.pi - SAME:
        remarks.append(Remark(f"from {_told(incidences[-1:])} to the horizon that incidence holds"))
        incidences = np.append(incidences, 0.5 * np.pi)
        values, mirrored = (np.concatenate([m, m[-1:]]) for m in (values, mirrored))
    return incidences, values, mirrored


def _told(angles) -> str:
    return " and ".join(f"{np.degrees(angle):.3g}°" for angle in angles)


# ---- bands and energy ----


def _narrow_bands(raw: RawMeasurement, values, mirrored, remarks):
    """Undo what the width of bands takes off peaks of spectra (Stearns & Stearns), where bands are even and not too wide."""
    width, step = raw.instrument.bandwidth, np.diff(raw.wavelengths)
    if width <= 0.0 or len(step) < 2:
        return values, mirrored
    if np.ptp(step) > 0.01 * step.mean() or width > 2.0 * step.mean():
        remarks.append(Remark(f"bands are {width:g} nm wide, which is left as it is"))
        return values, mirrored
    share = width**2 / (12.0 * step.mean() ** 2)
    remarks.append(Remark(f"bands are {width:g} nm wide, which is corrected for"))
    made = []
    for each in (values, mirrored):
        ends = np.concatenate([each[..., :1], each, each[..., -1:]], axis=-1)
        sharper = each + share * (2.0 * each - ends[..., :-2] - ends[..., 2:])
        made.append(np.clip(sharper, 0.5 * each, 1.5 * each))
    return made[0], made[1]


def _limit_energy(table: ScatterTable, remarks: list[Remark]) -> ScatterTable:
    """Scale bands that send away more light than comes, at the angles of incidence beside it."""
    values = table.values.astype(np.float64)
    direct = np.zeros((1, len(table.incidences), len(table.wavelengths)))
    if table.direct is not None:
        direct = table.direct.astype(np.float64)
    grid = table.incidences
    # First those of the table, so that those in between are not laid to the wrong side.
    between = np.setdiff1d(np.arange(0.0, 0.5 * np.pi, ENERGY_STEP), grid)
    most = 0.0
    for angle in (*grid, *between):
        share = albedo_of(replace(table, values=values.astype(np.float32)), angle)
        sharp = np.array([np.interp(angle, grid, line) for line in direct[0].T])
        total = share + sharp
        most = max(most, float(total.max()))
        # A little less, so that rounding to single precision does not bring it back.
        left = np.maximum(1.0 - 1e-5 - sharp, 0.0) / np.maximum(share, 1e-12)
        factor = np.where(total > 1.0, left, 1.0)
        after = np.searchsorted(grid, angle)
        for s in {after, after - int(grid[after] > angle)}:
            values[:, s] *= factor
    if most > 1.0:
        remarks.append(
            Remark(f"sent away up to {100.0 * most:.4g} % of the light; bands were scaled to 100 %")
        )
    return replace(table, values=values.astype(np.float32))


# ---- pictures ----


def _cut(piece: CalibratedSlice, table: ScatterTable) -> PolarCut:
    """Measured and smooth values in the plane of incidence."""
    side = np.where(np.cos(piece.azimuth) > 0.0, 1.0, -1.0)
    away = np.abs(np.sin(piece.azimuth)) * np.sin(piece.radial) < np.sin(IN_PLANE)
    signed = piece.incidence + side * piece.radial
    rows = np.flatnonzero(away & (np.abs(signed) < 0.5 * np.pi))
    rows = rows[np.argsort(signed[rows], kind="stable")]
    angles = np.radians(np.arange(-89.0, 89.5, 0.5))
    wo = np.stack([-np.sin(angles), 0.0 * angles, np.cos(angles)], axis=1)
    wi = np.array([np.sin(piece.incidence), 0.0, np.cos(piece.incidence)])
    made = evaluate_table(table, np.broadcast_to(wi, wo.shape), wo)
    return PolarCut(piece.incidence, signed[rows], piece.values[rows], angles, made)
