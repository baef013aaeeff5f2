"""A goniometer: places on a large sphere about a luminaire, whose illuminance tells its intensity, and a file of it."""

from dataclasses import dataclass

import numpy as np

from ..errors import SceneError
from ..scene.distribution import IntensityDistribution, Opening
from .coordinates import directions
from .formats.record import LuminaireFile

FAR = 1000.0
"""Distance of the detectors over the size of what shines, which is seen within 0.06 degrees: beams stay sharp. [-]"""

ALIKE = 3.0
"""Standard errors by which planes may differ that are taken for one."""

ROTATIONAL = 2e-3
"""Share of the peak by which they may differ beside that. [-]"""

MOST = 200_000
"""Detectors at most."""


@dataclass(frozen=True, eq=False)
class Detectors:
    """Where a goniometer measures.

    Parameters
    ----------
    azimuth, polar : (a,), (p,) float64 array    Angles C and gamma, the last plane below a full turn. [rad]
    positions, normals : (a * p, 3) float64 array    Plane by plane; normals look at the centre. [m]
    distance : float    From the centre. [m]
    """

    azimuth: np.ndarray
    polar: np.ndarray
    positions: np.ndarray
    normals: np.ndarray
    distance: float


@dataclass(frozen=True, eq=False)
class Measured:
    """Intensities of a luminaire, and their standard errors (a, p). [cd]"""

    distribution: IntensityDistribution
    standard_error: np.ndarray


def even_angles(step: float, whole: float) -> np.ndarray:
    """Angles from 0 to a whole turn or a part of it in even steps. [rad]

    Parameters
    ----------
    step, whole : float    [rad]

    Raises
    ------
    SceneError    The whole holds no whole number of steps.
    """
    if not 0.0 < step <= whole:
        raise SceneError(f"steps of {np.rad2deg(step):g} degrees make no goniometer")
    count = round(whole / step)
    if abs(count * step - whole) > 1e-5:
        raise SceneError(
            f"{np.rad2deg(whole):g} degrees hold no whole number of steps of {np.rad2deg(step):g} degrees"
        )
    return np.linspace(0.0, whole, count + 1)


def place_detectors(frame, azimuth, polar, distance: float) -> Detectors:
    """Return where to measure.

    Parameters
    ----------
    frame : (4, 4) array    The luminaire's axes and its photometric centre. [m]
    azimuth, polar : array    Angles C in 0..2 pi without the end, and gamma within 0..pi, ascending. [rad]
    distance : float    [m]

    Raises
    ------
    SceneError    There are too many, or a number makes no sense.
    """
    azimuth, polar = (np.atleast_1d(np.asarray(each, np.float64)) for each in (azimuth, polar))
    if not 0.0 < distance < np.inf:
        raise SceneError(f"the goniometer's distance is {distance} m, expected a number above 0")
    if len(azimuth) * len(polar) > MOST:
        raise SceneError(
            f"{len(azimuth)} planes of {len(polar)} angles are too many, at most {MOST} places are measured"
        )
    frame = np.asarray(frame, dtype=np.float64)
    away = directions(azimuth[:, None], polar[None]).reshape(-1, 3) @ frame[:3, :3].T
    return Detectors(azimuth, polar, frame[:3, 3] + distance * away, -away, distance)


def find_intensities(detectors: Detectors, illuminance, standard_error) -> Measured:
    """Return the distribution that detectors tell; ``illuminance``, ``standard_error``: (a * p,). [lx]

    A pole is one direction, which all planes have measured. Planes that differ by no more than their noise, or by little,
    become one; else the first plane ends the turn as well.
    """
    shape = (len(detectors.azimuth), len(detectors.polar))
    square = detectors.distance**2
    values, errors = (
        square * np.asarray(each, dtype=np.float64).reshape(shape)
        for each in (illuminance, standard_error)
    )
    for end, pole in ((0, 0.0), (-1, np.pi)):
        if abs(detectors.polar[end] - pole) < 1e-9:
            values[:, end] = values[:, end].mean()
            errors[:, end] = errors[:, end].mean()
    azimuth = detectors.azimuth
    if len(azimuth) > 1 and _is_rotational(values, errors):
        azimuth = azimuth[:1]
        values, errors = (each.mean(axis=0, keepdims=True) for each in (values, errors))
    elif len(azimuth) > 1:
        azimuth = np.append(azimuth, azimuth[0] + 2.0 * np.pi)
        values, errors = (np.concatenate([each, each[:1]]) for each in (values, errors))
    return Measured(IntensityDistribution(azimuth, detectors.polar, values), errors)


def to_luminaire(measured: Measured, size, metadata: dict[str, str], watts=None) -> LuminaireFile:
    """Return what was measured as a photometric file that can be written.

    Parameters
    ----------
    measured : Measured
    size : (float, float, float)    Extent of what shines along the luminaire's axes. [m]
    metadata : dict of str to str    Keywords of LM-63 and texts.
    watts : float or None    Electrical. [W]
    """
    distribution = measured.distribution
    size = tuple(float(side) if side > 1e-3 else 0.0 for side in size)
    flat = Opening("rectangle", (size[0], size[1], 0.0)) if min(size[:2]) > 0.0 else Opening()
    return LuminaireFile(
        format="goniometer",
        photometric_type="C",
        symmetry="rotational" if len(distribution.azimuth) == 1 else "none",
        distribution=distribution,
        opening=flat,
        stored_azimuths=np.rad2deg(distribution.azimuth),
        stored_polars=np.rad2deg(distribution.polar),
        is_absolute=True,
        watts=watts,
        metadata=metadata,
    )


def _is_rotational(values, errors) -> bool:
    mean = values.mean(axis=0)
    return bool((np.abs(values - mean) <= ALIKE * errors + ROTATIONAL * values.max()).all())
