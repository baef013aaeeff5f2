"""Discomfort glare of luminaires: the unified glare rating of CIE 117:1995."""

from dataclasses import dataclass, field

import numpy as np

from ..errors import SceneError


@dataclass(frozen=True, eq=False)
class Observer:
    """An eye and where it looks.

    Parameters
    ----------
    position : (3,) array    [m]
    direction : (3,) array    Line of sight, any length above 0.
    up : (3,) array    Upwards for the head, not along the line of sight.
    """

    position: np.ndarray
    direction: np.ndarray
    up: np.ndarray = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))


@dataclass(frozen=True, eq=False)
class FlatOpenings:
    """Flat luminous openings of luminaires, each small against its distance and lit evenly.

    Parameters
    ----------
    centres, normals : (n, 3) array    Normals have any length above 0; light leaves on their side. [m]
    areas : (n,) array    [m2]
    """

    centres: np.ndarray
    normals: np.ndarray
    areas: np.ndarray


def projected_areas(observer: Observer, openings: FlatOpenings) -> np.ndarray:
    """Areas of openings as an observer sees them, A cos.

    Returns
    -------
    (n,) float64 array    0 where the observer is behind the opening. [m2]

    Raises
    ------
    SceneError    An opening's centre is at the observer's eye, or it has no normal or no area.
    """
    away, distances = _sight(observer, openings.centres)
    normals = np.asarray(openings.normals, dtype=np.float64).reshape(-1, 3)
    lengths = np.linalg.norm(normals, axis=1)
    areas = np.asarray(openings.areas, dtype=np.float64).reshape(-1)
    _require(lengths > 0.0, "luminous opening {} has no normal")
    _require(areas > 0.0, "luminous opening {} needs an area above 0")
    cosines = -np.einsum("ij,ij->i", away, normals) / (distances * lengths)
    return areas * np.maximum(cosines, 0.0)


def solid_angles(observer: Observer, openings: FlatOpenings) -> np.ndarray:
    """Solid angles of openings at an observer's eye, A cos / d^2. (CIE 117:1995, chapter 4)

    Returns
    -------
    (n,) float64 array    [sr]

    Raises
    ------
    SceneError    As `projected_areas`.
    """
    _, distances = _sight(observer, openings.centres)
    return projected_areas(observer, openings) / distances**2


def sight_angles(observer: Observer, points) -> tuple[np.ndarray, np.ndarray]:
    """Where points lie in an observer's field of view.

    Parameters
    ----------
    points : (n, 3) array    [m]

    Returns
    -------
    turns : (n,) float64 array
        Angle from the vertical plane through the line of sight to the plane through it and the point: 0 above, 90 beside,
        180 below it. [deg]
    eccentricities : (n,) float64 array    Angle between the line of sight and the point. [deg]

    Raises
    ------
    SceneError    A point is at the eye, or the observer has no line of sight or no upwards beside it.
    """
    away, _ = _sight(observer, points)
    forwards, upwards, sideways = _axes(observer)
    along, high, beside = away @ forwards, away @ upwards, np.abs(away @ sideways)
    turns = np.degrees(np.arctan2(beside, high))
    return turns, np.degrees(np.arctan2(np.hypot(beside, high), along))


def guth_position_index(turns, eccentricities) -> np.ndarray:
    """Position index of Guth: how much a source may be brighter than one on the line of sight to disturb as much.

    Parameters
    ----------
    turns : array    Angle from the vertical plane through the line of sight, 0 to 90. [deg]
    eccentricities : array    Angle from the line of sight, 0 to less than 90. [deg]

    Returns
    -------
    array    At least 1, which is that on the line of sight. [-]

    Raises
    ------
    SceneError    A source is below the line of sight or behind the observer, where the index is not defined.

    Notes
    -----
    The formula fits Guth's curves to 12 % at worst; CIE 117:1995, 4.5 gives them as a table and leaves out sources whose
    distance to the side is more than three times that along the line of sight, and those that brow and forehead hide.

    References
    ----------
    R. E. Levin: Position index in visual comfort probability calculations, Journal of the IES 4 (1975) 99-105
    """
    turns, eccentricities = (np.asarray(x, dtype=np.float64) for x in (turns, eccentricities))
    inside = (turns >= 0.0) & (turns <= 90.0) & (eccentricities >= 0.0) & (eccentricities < 90.0)
    # On the line of sight itself there is no turn.
    inside |= eccentricities == 0.0
    if not inside.all():
        raise SceneError(
            "the position index is defined for sources before the observer and not below the line of sight"
        )
    first = (35.2 - 0.31889 * turns - 1.22 * np.exp(-2.0 * turns / 9.0)) * 1e-3
    second = (21.0 + 0.26667 * turns - 0.002963 * turns**2) * 1e-5
    return np.exp(first * eccentricities + second * eccentricities**2)


def unified_glare_rating(background, luminances, solid_angles, positions) -> float:
    """Unified glare rating, 8 log10(0.25 / L_b * sum of L^2 omega / p^2). (CIE 117:1995, chapter 4)

    Parameters
    ----------
    background : float    Background luminance L_b: the indirect illuminance at the eye over pi. [cd/m2]
    luminances : (n,) array    L of each source towards the eye. [cd/m2]
    solid_angles : (n,) array    omega of each source at the eye. [sr]
    positions : (n,) array    Position index p of each source. [-]

    Returns
    -------
    float    Practical ratings are 10 to 30; each step of 1 is just noticed. [-]

    Raises
    ------
    SceneError    The background is not above 0, a value is not usable, or nothing that shines is seen.

    Notes
    -----
    For sources of 0.0003 sr to 0.1 sr; smaller and larger ones have rules of their own (CIE 147:2002).
    """
    background = float(background)
    if not (np.isfinite(background) and background > 0.0):
        raise SceneError(
            f"the background luminance is {background:g} cd/m2, expected a number above 0"
        )
    luminances, solid_angles, positions = (
        np.atleast_1d(np.asarray(x, dtype=np.float64))
        for x in (luminances, solid_angles, positions)
    )
    if not luminances.shape == solid_angles.shape == positions.shape:
        raise SceneError(
            "the glare rating needs one luminance, one solid angle and one position index per source, found "
            f"{luminances.size}, {solid_angles.size} and {positions.size}"
        )
    _require(
        np.isfinite(luminances) & (luminances >= 0.0), "source {} needs a luminance of at least 0"
    )
    _require(
        np.isfinite(solid_angles) & (solid_angles >= 0.0),
        "source {} needs a solid angle of at least 0",
    )
    _require(
        np.isfinite(positions) & (positions >= 1.0),
        "source {} needs a position index of at least 1",
    )
    amount = float(np.sum(luminances**2 * solid_angles / positions**2))
    if amount <= 0.0:
        raise SceneError("the observer sees no source that shines, so there is no glare to rate")
    return float(8.0 * np.log10(0.25 / background * amount))


def _sight(observer: Observer, points) -> tuple[np.ndarray, np.ndarray]:
    """Vectors from the eye to points, (n, 3), and their lengths, (n,). [m]"""
    places = np.asarray(points, dtype=np.float64).reshape(-1, 3)
    away = places - np.asarray(observer.position, dtype=np.float64)
    distances = np.linalg.norm(away, axis=1)
    _require(distances > 0.0, "point {} is at the observer's eye, or no point")
    return away, distances


def _axes(observer: Observer) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return unit vectors forwards, upwards and sideways of the line of sight."""
    forwards = np.asarray(observer.direction, dtype=np.float64)
    sideways = np.cross(forwards, observer.up)
    lengths = np.linalg.norm(forwards), np.linalg.norm(sideways)
    if not (np.isfinite(lengths).all() and min(lengths) > 0.0):
        raise SceneError(
            "the observer needs a line of sight, and a direction upwards that is not along it"
        )
    forwards, sideways = forwards / lengths[0], sideways / lengths[1]
    return forwards, np.cross(sideways, forwards), sideways


def _require(usable: np.ndarray, sentence: str) -> None:
    """Refuse the first of several that is not usable; the sentence has a place for its number, from 1."""
    if not usable.all():
        raise SceneError(sentence.format(int(np.argmin(usable)) + 1))
