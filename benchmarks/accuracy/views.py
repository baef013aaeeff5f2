"""Error over time of pictures and of the live view, pixel by pixel, beside as many sensors at the same place."""

import time

import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.scene.camera import Camera, Projection
from ...engine.scene.material import Diffuse, Material
from ...engine.session import Session
from ...engine.views import Display, DisplayMode, LiveSettings, ViewSettings
from ...validation.bench import Engine
from .programs import FIRST_SEED, GROWTH
from .scenes import ExactScene, load_scene

SCENE, SENSOR = "C10.cube0.8", 1
"""Place that is looked at: a sensor of a scene whose surfaces are matt and alike."""

PIXELS = 64
"""Along the sides of the view."""

EXTENT = 1e-3
"""Side of the square that the view shows, over which the illuminance does not change. [m]"""

DISTANCE = 0.5
"""From where it is looked at; nothing is in between. [m]"""

LEAST_SAMPLES, MOST_SAMPLES = 16, 1 << 12
"""Per pixel; the least is one for each of the groups of a sensor."""

WAYS = ("sensors", "picture", "live view")


def measure_views(rounds: int, longest: float, say) -> dict:
    """Measure all ways.

    Returns
    -------
    dict    By way, as `programs.measure_scene` has it.
    """
    scene = load_scene(SCENE)
    session = Engine().stage(scene.items)
    made = {
        way: {
            "unit": "samples per pixel",
            "is_ours": True,
            "seconds": [],
            "errors": [],
            "stated": [],
        }
        for way in WAYS
    }
    work = _climb(scene, session, longest)
    for number in range(-1, rounds):
        for way, take in zip(WAYS, (_take_sensors, _take_picture, _take_live), strict=True):
            runs = take(scene, session, work, number)
            row = made[way]
            if number < 0:
                # Kernels are compiled now, and nothing counts.
                row["work"], row["first_seconds"] = work, runs[0][0]
                continue
            for name, column in zip(
                ("seconds", "errors", "stated"), zip(*runs, strict=True), strict=True
            ):
                row[name].append(list(column))
        if number >= 0:
            say(f"views: round {number + 1} of {rounds}")
    return made


def _climb(scene: ExactScene, session: Session, longest: float) -> list[int]:
    work, seconds = [LEAST_SAMPLES], 0.0
    while GROWTH * seconds < longest and work[-1] < MOST_SAMPLES:
        work.append(work[-1] * GROWTH)
        _take_picture(scene, session, work[-1:], -1)
        ((seconds, _, _),) = _take_picture(scene, session, work[-1:], -1)
    return work


def _take_sensors(scene: ExactScene, session: Session, work, number: int) -> list:
    """Time, true and stated error for each amount of work."""
    count, exact = PIXELS**2, scene.exact[SENSOR]
    places = np.tile(scene.positions[SENSOR], (count, 1))
    normals = np.tile(scene.normals[SENSOR], (count, 1))
    runs = []
    for samples in work:
        start = time.perf_counter()
        made = session.measure(
            places, normals, StopRule(samples=samples), FIRST_SEED + number, "mono"
        )
        seconds = time.perf_counter() - start
        runs.append(
            (
                seconds,
                _relative(made.illuminance - exact, exact),
                _relative(made.standard_error, exact),
            )
        )
    return runs


def _take_picture(scene: ExactScene, session: Session, work, number: int) -> list:
    exact, runs = scene.exact[SENSOR], []
    for samples in work:
        settings = ViewSettings(
            StopRule(samples=samples), FIRST_SEED + number, illuminance=True, transport="mono"
        )
        start = time.perf_counter()
        made = session.render(_camera(scene), settings)
        seconds = time.perf_counter() - start
        runs.append(
            (
                seconds,
                _relative(made.illuminance - exact, exact),
                _relative(made.illuminance_error, exact),
            )
        )
    return runs


def _take_live(scene: ExactScene, session: Session, work, number: int) -> list:
    """Watch until the last amount of work is done; the first frame with each amount counts."""
    exact = _reflectance(scene) * scene.exact[SENSOR] / np.pi
    settings = LiveSettings(max(work), FIRST_SEED + number, transport="mono")
    session.unwatch()
    runs, start = [], time.perf_counter()
    session.watch(_camera(scene), settings, Display(DisplayMode.LUMINANCE, white=1.0))
    while session.has_view_work:
        frame = session.refine()
        seconds = time.perf_counter() - start
        while frame is not None and len(runs) < len(work) and frame.samples >= work[len(runs)]:
            error = _relative(frame.pixels[..., 1] - exact, exact)
            runs.append((seconds, error, frame.relative_error))
    session.unwatch()
    return runs


def _camera(scene: ExactScene) -> Camera:
    """View straight at the sensor."""
    normal = scene.normals[SENSOR]
    right = np.cross((0.0, 1.0, 0.0) if abs(normal[1]) < 0.9 else (1.0, 0.0, 0.0), normal)
    right /= np.linalg.norm(right)
    frame = np.eye(4)
    frame[:3, :3] = np.stack([right, np.cross(normal, right), normal], axis=1)
    frame[:3, 3] = scene.positions[SENSOR] + DISTANCE * normal
    return Camera(frame, Projection.ORTHOGRAPHIC, PIXELS, PIXELS, EXTENT, EXTENT)


def _reflectance(scene: ExactScene) -> float:
    """Of the one matt material of the scene. [-]"""
    (surface,) = (item.surface for item in scene.items if isinstance(item, Material))
    assert isinstance(surface, Diffuse)
    return float(surface.reflectance.value)


def _relative(values, exact: float) -> float:
    return float(np.sqrt(np.mean(np.square(values, dtype=np.float64)))) / exact
