"""The intensities of a luminaire that is a scene: what its lights send out, and what its reflectors and lenses add.

Detectors stand far away. What lights send there straight is found by aiming at them; what else leaves the luminaire is found
in parallel pictures of it, one from each detector: intensity is the luminance times the area at right angles to the way.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .accuracy.stopping import Progress, StopRule
from .luminaires.goniometer import Detectors, Measured, find_intensities
from .scene.camera import Camera, Projection
from .scene.scene import Scene, SceneDelta
from .views import ViewSettings

SIDE = 96
"""Side of the pictures. [pixel]"""

PICTURES = 2
"""Pictures from each direction, each shifted by parts of a pixel of its own: a pixel's filter does not count all parts of
what it sees alike, which shifts by chance make good. Their difference tells the error of that, and the noise."""

ROOM = 1.05
"""Side of what they show over the width of the luminaire. [-]"""

DIRECT = StopRule(error=5e-4, samples=1 << 16)
"""Of what arrives straight."""

PICTURE_SEEDS = 7919
"""Distance between the seeds of pictures."""


@dataclass(frozen=True)
class Readings:
    """What a goniometer has found: intensities, and notes for people."""

    measured: Measured
    notes: tuple[str, ...]


def measure_intensities(
    session,
    scene: Scene,
    detectors: Detectors,
    centre,
    radius: float,
    samples: int,
    seed: int = 0,
    transport: str = "auto",
    progress: Callable[[Progress], None] | None = None,
) -> Readings:
    """Measure a luminaire.

    Parameters
    ----------
    session : Session or RemoteSession    An empty one.
    scene : Scene    All of it is the luminaire.
    detectors : Detectors
    centre : (3,) array    Of a ball that holds the luminaire. [m]
    radius : float    Of this ball. [m]
    samples : int    Per pixel of every picture.
    progress : callable or None    Gets a `Progress`.

    Raises
    ------
    Cancelled    After `cancel`.
    LumenrayError    The scene or the machine does not allow it.
    """
    session.apply(SceneDelta(changed=_items(scene)))
    # Light paths would hardly ever cross places so far away.
    direct = session.measure(
        detectors.positions,
        detectors.normals,
        DIRECT,
        seed,
        transport,
        progress,
        reflections=0,
        method="paths",
        witness=False,
    )
    lux, errors = direct.illuminance.copy(), direct.standard_error.copy()
    notes = dict.fromkeys(direct.provenance.notes)
    if scene.meshes:
        session.apply(_without_lights_seen(scene))
        settings = ViewSettings(
            StopRule(samples=samples), transport=transport, method="paths", shares=False
        )
        side, count = 2.0 * ROOM * radius, len(lux)
        found = np.empty((PICTURES, count))
        for number, towards in enumerate(-detectors.normals):
            for half in range(PICTURES):
                own = (seed + PICTURE_SEEDS * (PICTURES * number + half + 1)) % 2**31
                shift = np.random.default_rng(own).uniform(-0.5, 0.5, 2) * side / SIDE
                place = np.asarray(centre) + 2.0 * radius * towards
                camera = _look_from(place, towards, side, radius, shift)
                picture = session.render(camera, replace(settings, seed=own))
                mean = float(picture.tristimulus[..., 1].mean(dtype=np.float64))
                found[half, number] = mean * side**2 / detectors.distance**2
                notes |= dict.fromkeys(picture.provenance.notes)
            if progress is not None:
                stage = f"direction {number + 1} of {count}"
                progress(Progress((number + 1) / count, samples, np.inf, 0.0, None, stage))
        lux += found.mean(axis=0)
        errors = np.hypot(errors, _pooled(found))
    return Readings(find_intensities(detectors, lux, errors), tuple(notes))


def _pooled(found: np.ndarray) -> np.ndarray:
    """Standard errors of means over pictures (k, n), of one proportion: the differences of one direction tell little."""
    mean = found.mean(axis=0)
    variance = found.var(axis=0, ddof=1) / len(found)
    total = float((mean**2).sum())
    return mean * np.sqrt(float(variance.sum()) / total) if total > 0.0 else 0.0 * mean


def _items(scene: Scene) -> tuple:
    tables = (scene.pixels, scene.geometries, scene.materials, scene.meshes, scene.lights)
    return (*(item for table in tables for item in table.values()), scene.modelling)


def _without_lights_seen(scene: Scene) -> SceneDelta:
    """What hides from the camera's own rays all that shines, which has been measured; mirrors and lenses still show it."""
    changed = [
        replace(light, visible_to_camera=False)
        for light in scene.lights.values()
        if getattr(light, "visible_to_camera", False)
    ]
    changed += [
        replace(item, seen=replace(item, id=f"{item.id}/dark", emission=None, seen=None))
        for item in scene.materials.values()
        if item.emission is not None
    ]
    return SceneDelta(changed=tuple(changed))


def _look_from(place, towards, side: float, radius: float, shift=(0.0, 0.0)) -> Camera:
    """Parallel camera at a place, shifted along its film, which looks against a direction. [m]"""
    z = np.asarray(towards, dtype=np.float64)
    x = np.cross([0.0, 0.0, 1.0] if abs(z[2]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    frame[:3, 3] = place + frame[:3, :2] @ np.asarray(shift)
    return Camera(
        frame, Projection.ORTHOGRAPHIC, SIDE, SIDE, side, side, clip_end=8.0 * max(radius, 1e-3)
    )
