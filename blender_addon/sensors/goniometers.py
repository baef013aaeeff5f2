"""Goniometers: empties in the middle of a sphere, on which detectors measure the luminaire within; and the file of it."""

from dataclasses import dataclass

import numpy as np

from ...engine.errors import SceneError
from ...engine.goniometry import find_extent, measure_intensities, take_luminaire
from ...engine.luminaires.distribution import flux
from ...engine.luminaires.formats.reader import write_luminaire
from ...engine.luminaires.goniometer import (
    FAR,
    Detectors,
    Measured,
    even_angles,
    find_intensities,
    place_detectors,
    to_luminaire,
)

SAMPLES = 4
"""Of every pixel of the pictures that tell what reflectors and lenses send to a detector."""

MOST_NAMES = 4
"""Objects that a note names."""

FULL_TURN = 2.0 * np.pi

WHOLE = (
    "light groups are not told apart: the luminaire is measured with all its light as in the scene"
)
"""What is said where levels are others."""


@dataclass(frozen=True, eq=False)
class Sphere:
    """What a goniometer is: its detectors, and the ball within which the luminaire is. [m]"""

    detectors: Detectors
    frame: np.ndarray
    radius: float


@dataclass(frozen=True, eq=False)
class Intensities:
    """What a goniometer has found: intensities and standard errors (n,) [cd], size of the luminaire (3,) [m]."""

    values: np.ndarray
    errors: np.ndarray
    size: tuple[float, float, float]
    notes: tuple[str, ...]


def lay_sphere(settings, frame) -> Sphere:
    """Return the sphere of a goniometer; ``settings``: of its empty, ``frame``: its rigid axes. (4, 4) [m]

    Raises
    ------
    SceneError    The steps, the distance or the quantity make no sense.
    """
    if settings.quantity != "INTENSITY":
        raise SceneError("a goniometer tells intensities; set the quantity to Intensity")
    if settings.use_distance and settings.distance <= settings.radius:
        raise SceneError(
            f"the detectors' distance of {settings.distance:g} m lies within the radius of {settings.radius:g} m; take more"
        )
    distance = settings.distance if settings.use_distance else 2.0 * FAR * settings.radius
    azimuth = even_angles(settings.plane_step, FULL_TURN)[:-1]
    polar = even_angles(settings.polar_step, np.pi)
    return Sphere(
        place_detectors(frame, azimuth, polar, distance), np.asarray(frame), settings.radius
    )


def measure_sphere(session, scene, sphere: Sphere, seed: int, transport: str, progress=None):
    """Measure the luminaire of a scene that lies within a goniometer's ball; return its `Intensities`.

    Parameters
    ----------
    session : Session or RemoteSession    An empty one; it is empty again afterwards.
    progress : callable or None    Gets a `Progress`.

    Raises
    ------
    SceneError    Nothing within the ball shines.
    Cancelled    After `cancel`.
    """
    centre = sphere.frame[:3, 3]
    part = take_luminaire(scene, centre, sphere.radius)
    notes = []
    if part.crossing:
        more = ", …" if len(part.crossing) > MOST_NAMES else ""
        names = ", ".join(part.crossing[:MOST_NAMES]) + more
        notes.append(f"lies partly within the goniometer's radius and is no part of it: {names}")
    try:
        extent = find_extent(part.scene, sphere.frame)
    except SceneError:
        words = f"; {notes[0]}" if notes else ""
        raise SceneError(
            f"no light lies within the goniometer's radius of {sphere.radius:g} m{words}"
        ) from None
    middle = sphere.frame[:3, :3] @ (0.5 * (extent.low + extent.high)) + centre
    found = measure_intensities(
        session,
        part.scene,
        sphere.detectors,
        middle,
        max(0.5 * extent.size, 1e-3),
        SAMPLES,
        seed,
        transport,
        progress,
    )
    planes = len(sphere.detectors.azimuth)
    # One plane stands for all of a rotational luminaire; of others the first one ends the turn again.
    values, errors = (
        np.broadcast_to(each if len(each) == 1 else each[:planes], (planes, each.shape[1])).ravel()
        for each in (found.measured.distribution.intensity, found.measured.standard_error)
    )
    size = tuple(float(side) for side in extent.high - extent.low)
    return Intensities(values, errors, size, (*notes, *found.notes))


def measured_of(readings) -> Measured:
    """Return what a goniometer told as a distribution; ``readings``: `Readings` of intensities."""
    planes, angles = readings.shape
    azimuth = np.linspace(0.0, FULL_TURN, planes, endpoint=False)
    # Luxes at a metre are candelas.
    detectors = place_detectors(np.eye(4), azimuth, np.linspace(0.0, np.pi, angles), 1.0)
    return find_intensities(detectors, readings.values.sum(axis=0), readings.errors[0])


def describe_intensities(readings) -> list[tuple[str, str]]:
    """Labels and values of what a goniometer told."""
    measured = measured_of(readings)
    table = measured.distribution.intensity
    planes, angles = readings.shape
    lines = [("directions", f"{planes} planes of {angles} angles")]
    if not table.max() > 0.0:
        return [*lines, ("luminous flux", "none: no light leaves what lies within its radius")]
    row, column = np.unravel_index(int(table.argmax()), table.shape)
    azimuth, polar = measured.distribution.azimuth[row], measured.distribution.polar[column]
    where = f"C {np.rad2deg(azimuth):.3g}°, gamma {np.rad2deg(polar):.3g}°"
    if len(table) == 1:
        where = f"gamma {np.rad2deg(polar):.3g}° all around"
    return [
        *lines,
        ("luminous flux", f"{flux(measured.distribution):.5g} lm"),
        ("largest intensity", f"{table.max():.4g} cd at {where}"),
        (
            "standard error",
            f"{max(100.0 * error_of(measured), 0.001):.2g} % of the largest at most",
        ),
    ]


def error_of(measured: Measured) -> float:
    """Standard error of intensities, the root of its mean square, over the largest intensity. [-]"""
    top = float(measured.distribution.intensity.max())
    return float(np.sqrt((measured.standard_error**2).mean())) / top if top > 0.0 else 0.0


def write_intensities(readings, name: str, path) -> list[str]:
    """Write what a goniometer told as a photometric file; return what is to be known of it.

    Parameters
    ----------
    readings : Readings    Of intensities.
    name : str    Of the luminaire.
    path : Path    The end of its name says the format: .ies, .ldt.

    Raises
    ------
    LumenrayError    No light was measured, or the file cannot be written.
    """
    measured = measured_of(readings)
    if not measured.distribution.intensity.max() > 0.0:
        raise SceneError(f"goniometer '{name}': no light leaves what lies within its radius")
    file = to_luminaire(measured, readings.size, {"LUMINAIRE": name})
    return [str(remark) for remark in write_luminaire(file, path)]
