"""The intensities of a luminaire that is a scene: what its lights send out, and what its reflectors and lenses add.

Detectors stand far away. What lights send there straight is found by aiming at them; what else leaves the luminaire is found
in pictures of it, one from each detector. They are parallel ones where detectors are far away: intensity is the luminance
times the area at right angles to the way. From near by they have the detector's own perspective.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from .accuracy.stopping import Progress, StopRule
from .errors import SceneError
from .luminaires.goniometer import Detectors, Measured, find_intensities
from .scene.camera import Camera, Projection
from .scene.light import SunLight
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

NEAR = 100.0
"""Distance of detectors over the radius of the luminaire below which they see it in perspective: beyond, lengths of ways
differ by less than 1 %, and directions by less than 0.6 degrees. [-]"""


@dataclass(frozen=True, eq=False)
class Part:
    """What of a scene is the luminaire.

    Parameters
    ----------
    scene : Scene
    crossing : tuple of str    Names of what lies partly within the ball, and is no part of it.
    has_surroundings : bool    Whether a world or Sun lights were left out.
    """

    scene: Scene
    crossing: tuple[str, ...]
    has_surroundings: bool


@dataclass(frozen=True, eq=False)
class Extent:
    """Corners of the box about a luminaire, and the middle of what shines, in some frame's axes. (3,) each [m]"""

    low: np.ndarray
    high: np.ndarray
    middle: np.ndarray

    @property
    def size(self) -> float:
        """Diagonal of the box. [m]"""
        return float(np.linalg.norm(self.high - self.low))


@dataclass(frozen=True)
class Readings:
    """What a goniometer has found: intensities, and notes for people."""

    measured: Measured
    notes: tuple[str, ...]


def take_luminaire(scene: Scene, centre=None, radius: float = np.inf) -> Part:
    """Return what of a scene is the luminaire: all of it but the surroundings, or what lies within a ball.

    Parameters
    ----------
    scene : Scene    It is not changed.
    centre : (3,) array or None    Of the ball; None: there is none. [m]
    radius : float    Of the ball. [m]
    """
    suns = [key for key, light in scene.lights.items() if isinstance(light, SunLight)]
    surroundings = suns if scene.world is None else [*suns, scene.world.id]
    removed, crossing = list(surroundings), []
    if centre is not None:
        for key, item in [*scene.lights.items(), *scene.meshes.items()]:
            if key in suns:
                continue
            nearest, farthest = _distances(scene, key, centre)
            if farthest > radius:
                removed.append(key)
                if nearest < radius:
                    crossing.append(item.name)
    made = Scene()
    made.apply(SceneDelta(changed=_items(scene)))
    made.apply(SceneDelta(removed=tuple(removed)))
    return Part(made, tuple(crossing), bool(surroundings))


def _distances(scene: Scene, key: str, centre) -> tuple[float, float]:
    """Distances of the nearest and the farthest that is known of a light or a mesh from a place. [m]"""
    if key in scene.lights:
        light = scene.lights[key]
        distance = float(np.linalg.norm(np.asarray(light.place) - centre))
        return max(distance - float(light.reach), 0.0), distance + float(light.reach)
    mesh = scene.mesh(key)
    away = np.asarray(mesh.vertices, np.float64) - centre
    farthest = float(np.linalg.norm(away, axis=1).max())
    return _distance_of_nearest(away[mesh.triangles]), farthest


def _distance_of_nearest(corners: np.ndarray) -> float:
    """Distance of the origin from the nearest of some triangles (t, 3, 3). [m]"""
    found = []
    for start, end in ((0, 1), (1, 2), (2, 0)):
        edge = corners[:, end] - corners[:, start]
        square = np.maximum((edge**2).sum(axis=1), 1e-30)
        share = np.clip(-(corners[:, start] * edge).sum(axis=1) / square, 0.0, 1.0)
        found.append(np.linalg.norm(corners[:, start] + share[:, None] * edge, axis=1))
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    # Triangles without an area are their edges.
    is_within = length[:, 0] > 1e-30
    length = np.maximum(length, 1e-30)
    height = (corners[:, 0] * normal / length).sum(axis=1)
    foot = height[:, None] * normal / length
    for start, end in ((0, 1), (1, 2), (2, 0)):
        side = np.cross(corners[:, end] - corners[:, start], foot - corners[:, start])
        is_within &= (side * normal).sum(axis=1) >= 0.0
    found.append(np.where(is_within, np.abs(height), np.inf))
    return float(np.min(found)) if len(corners) else np.inf


def find_extent(scene: Scene, frame=None) -> Extent:
    """Return how large a luminaire is along the axes of a frame.

    Parameters
    ----------
    scene : Scene    All of it is the luminaire.
    frame : (4, 4) array or None    Rigid; None: that of the world. [m]

    Raises
    ------
    SceneError    Nothing of it shines.
    """
    frame = np.eye(4) if frame is None else np.asarray(frame, dtype=np.float64)

    def place(points):
        return (np.asarray(points, dtype=np.float64) - frame[:3, 3]) @ frame[:3, :3]

    points, shining = [], []
    for light in scene.lights.values():
        middle, reach = place(light.place), float(light.reach)
        shining += [middle - reach, middle + reach]
    points += shining
    glowing = {m.id for m in scene.materials.values() if m.emission is not None}
    for key, item in scene.meshes.items():
        vertices = place(scene.mesh(key).vertices)
        corners = [vertices.min(axis=0), vertices.max(axis=0)]
        points += corners
        shining += corners if glowing & set(item.materials) else []
    if not shining:
        raise SceneError("there is no light that could be measured")
    middle = 0.5 * (np.min(shining, axis=0) + np.max(shining, axis=0))
    return Extent(np.min(points, axis=0), np.max(points, axis=0), middle)


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
    session : Session or RemoteSession    An empty one; it is empty again afterwards.
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
    if detectors.distance <= radius:
        raise SceneError(
            f"the goniometer's distance of {detectors.distance:g} m lies within the luminaire, which reaches {radius:.3g} m"
        )
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
        dark = _without_lights_seen(scene)
        session.apply(dark)
        settings = ViewSettings(
            StopRule(samples=samples), transport=transport, method="paths", shares=False
        )
        count = len(lux)
        found = np.empty((PICTURES, count))
        for number, (place, towards) in enumerate(
            zip(detectors.positions, -detectors.normals, strict=True)
        ):
            for half in range(PICTURES):
                own = (seed + PICTURE_SEEDS * (PICTURES * number + half + 1)) % 2**31
                shift = np.random.default_rng(own).uniform(-0.5, 0.5, 2)
                look = _Look(np.asarray(centre), radius, place, towards, shift)
                picture = session.render(look.camera, replace(settings, seed=own))
                found[half, number] = look.illuminance(picture.tristimulus[..., 1])
                notes |= dict.fromkeys(picture.provenance.notes)
            if progress is not None:
                stage = f"direction {number + 1} of {count}"
                progress(Progress((number + 1) / count, samples, np.inf, 0.0, None, stage))
        lux += found.mean(axis=0)
        errors = np.hypot(errors, _pooled(found))
        session.apply(SceneDelta(removed=tuple(item.id for item in dark.changed)))
    session.apply(SceneDelta(removed=tuple(item.id for item in _items(scene))))
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


class _Look:
    """What a detector sees of a luminaire in a ball.

    Parameters
    ----------
    centre : (3,) array    Of the ball. [m]
    radius : float    [m]
    place, towards : (3,) array    Of the detector [m]; from the luminaire to it, unit length.
    shift : (2,) array    Of the film, by parts of a pixel. [-]
    """

    def __init__(self, centre, radius: float, place, towards, shift):
        distance = float(np.linalg.norm(place - centre))
        self._is_near = distance < NEAR * radius
        if not self._is_near:
            self._side = 2.0 * ROOM * radius
            frame = _frame(centre + 2.0 * radius * towards, towards)
            frame[:3, 3] += frame[:3, :2] @ shift * self._side / SIDE
            end = 8.0 * max(radius, 1e-3)
            self._weight = self._side**2 / distance**2
            self.camera = Camera(
                frame, Projection.ORTHOGRAPHIC, SIDE, SIDE, self._side, self._side, clip_end=end
            )
            return
        # The ball's middle need not lie on the axis of the detector, which looks at the photometric centre.
        way = (place - centre) / distance
        self._side = 2.0 * ROOM * radius / np.sqrt(distance**2 - radius**2)
        self._shift = shift * self._side / SIDE
        self._weight = self._side**2
        frame = _frame(place, way)
        self._turn, self._normal = frame[:3, :3], towards
        self.camera = Camera(
            frame, Projection.PERSPECTIVE, SIDE, SIDE, self._side, self._side, *self._shift
        )

    def illuminance(self, luminance) -> float:
        """Illuminance of the detector by the luminance of its picture (h, w). [cd/m2 -> lx]"""
        values = np.asarray(luminance, dtype=np.float64)
        if self._is_near:
            middle = self._side * ((np.arange(SIDE) + 0.5) / SIDE - 0.5)
            x, y = np.meshgrid(middle + self._shift[0], middle + self._shift[1])
            ways = np.stack([x, y, -np.ones_like(x)], axis=-1) @ self._turn.T
            length = np.linalg.norm(ways, axis=-1)
            # Solid angle of a pixel over its area on a film at unit distance, and the cosine at the detector.
            facing = np.maximum(-(ways @ self._normal) / length, 0.0)
            values = values * facing / length**3
        return float(values.mean()) * self._weight


def _frame(place, towards) -> np.ndarray:
    """Frame of a camera at a place that looks against a direction. (4, 4) [m]"""
    z = np.asarray(towards, dtype=np.float64)
    x = np.cross([0.0, 0.0, 1.0] if abs(z[2]) < 0.9 else [1.0, 0.0, 0.0], z)
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([x, np.cross(z, x), z], axis=1)
    frame[:3, 3] = place
    return frame
