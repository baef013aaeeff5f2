"""C11: luminances and illuminances of the CIE's sky types."""

import numpy as np

from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.camera import Camera, Projection
from lumenray.engine.scene.light import CieSky
from lumenray.engine.scene.sensor import SensorKind
from lumenray.engine.sky.cie import sun_direction
from lumenray.engine.sky.skies import zenith_luminance

from ..bench import Bench, Finding, Findings
from ..reference import Group
from .registry import case
from .rooms import HORIZONTAL, SUN_ELEVATION, UNIFORM, sky

UP = (0.0, 0.0, 1.0)

WALLS = {"C11.vertS": (0.0, -1.0, 0.0), "C11.vertN": (0.0, 1.0, 0.0), "C11.vertE": (1.0, 0.0, 0.0)}
"""Normals of the vertical sensors by group; the sun stands in the south."""

LEAST_WALL = 0.2
"""Below the least illuminance of a wall relative to the horizontal one; what their errors are measured by. [-]"""

DOME_LUMINANCE = 1000.0
"""Of the uniform dome. [cd/m2]"""

COMPASS = {"N": 0.0, "E": 0.5 * np.pi, "S": np.pi}
"""Azimuths by name. [rad]"""

VIEW = 1e-6
"""Angular size of the picture that shows the luminance of a direction. [rad]"""


@case("C11", "CIE general skies", "daylight", quick=("C11.Eh60", "C11.vertS", "C11.lum12"))
def skies(bench: Bench) -> Findings:
    """Illuminances of planes, the dome's on bodies, luminances."""
    groups = bench.groups("C11")
    walls = {key: WALLS[key] for key in WALLS if key in groups}
    yield from _illuminances(bench, groups, "C11.Eh60", SUN_ELEVATION, walls)
    yield from _illuminances(bench, groups, "C11.Eh20", np.radians(20.0), {})
    if "C11.dome" in groups:
        yield _dome(bench, groups["C11.dome"])
    for key, group in groups.items():
        if key.startswith("C11.lum"):
            yield _luminances(bench, group)


def _illuminances(
    bench: Bench, groups: dict[str, Group], level: str, elevation: float, walls: dict
) -> Findings:
    """Yield horizontal illuminances over the zenith's luminance, and walls' over the horizontal one."""
    wanted = [groups[key] for key in (level, *walls) if key in groups]
    if not wanted:
        return
    normals = np.array([UP, *walls.values()])
    places = np.zeros_like(normals)
    # Two errors go into a ratio.
    share = 0.5 * min((group.allowed / group.values).min() for group in wanted)
    allowed = share * HORIZONTAL * np.where(normals[:, 2] > 0.0, 1.0, LEAST_WALL)
    values, errors, zeniths = [], [], []
    for label in wanted[0].labels:
        made_of = sky(int(label.removeprefix("sky ")), sun_direction(elevation, COMPASS["S"]))
        made = bench.measure((made_of,), places, normals, allowed)
        values.append(made.values)
        errors.append(made.errors)
        zeniths.append(zenith_luminance(made_of))
    values, errors, zeniths = np.array(values), np.array(errors), np.array(zeniths)
    if level in groups:
        yield Finding(groups[level], values[:, 0] / zeniths, errors[:, 0] / zeniths)
    shares = errors / values
    for i, key in enumerate(walls, start=1):
        ratio = values[:, i] / values[:, 0]
        yield Finding(groups[key], ratio, ratio * np.hypot(shares[:, i], shares[:, 0]))


def _dome(bench: Bench, group: Group) -> Finding:
    dome = CieSky(UNIFORM, np.array(UP), np.pi * DOME_LUMINANCE)
    sloping = (np.sqrt(0.5), 0.0, np.sqrt(0.5))
    sensors = {
        "horizontal": (UP, SensorKind.PLANAR),
        "vertical": ((1.0, 0.0, 0.0), SensorKind.PLANAR),
        "45 deg tilt": (sloping, SensorKind.PLANAR),
        "mean spherical": (UP, SensorKind.SPHERICAL),
        "cylindrical": (UP, SensorKind.CYLINDRICAL),
    }
    normals = np.array([sensors[label][0] for label in group.labels])
    kinds = [sensors[label][1] for label in group.labels]
    places = np.zeros_like(normals)
    bench.show(group, (dome,), places, normals)
    values, errors = np.zeros_like(group.values), np.zeros_like(group.values)
    for kind in dict.fromkeys(kinds):
        rows = np.array([k is kind for k in kinds])
        made = bench.measure((dome,), places[rows], normals[rows], group.allowed[rows], kind=kind)
        values[rows], errors[rows] = made.values, made.errors
    return Finding(group, values, errors)


def _luminances(bench: Bench, group: Group) -> Finding:
    """Luminances over that of the zenith, from pictures of one pixel."""
    kind = int(group.id.removeprefix("C11.lum"))
    items = (sky(kind, sun_direction(SUN_ELEVATION, COMPASS["S"])),)
    zenith, noise = _seen(bench, items, np.array(UP))
    values, errors = [], []
    for label in group.labels:
        luminance, error = _seen(bench, items, _direction(label))
        values.append(luminance / zenith)
        errors.append(np.hypot(error, noise) / zenith)
    return Finding(group, np.array(values), np.array(errors))


def _direction(label: str) -> np.ndarray:
    """Direction by a label such as ``el 45 S``."""
    if label == "zenith":
        return np.array(UP)
    if label.startswith("sun"):
        return sun_direction(SUN_ELEVATION, COMPASS["S"])
    _, elevation, azimuth = label.split()
    return sun_direction(np.radians(float(elevation)), COMPASS[azimuth])


def _seen(bench: Bench, items: tuple, direction: np.ndarray) -> tuple[float, float]:
    """Luminance of a direction, with its standard error. [cd/m2]"""
    frame = np.eye(4)
    back = -direction
    right = np.cross((0.0, 1.0, 0.0), back)
    right /= np.linalg.norm(right)
    frame[:3, :3] = np.stack([right, np.cross(back, right), back], axis=1)
    camera = Camera(frame, Projection.PERSPECTIVE, 1, 1, VIEW, VIEW)
    picture = bench.engine.render(items, camera, StopRule(samples=16), bench.seed)
    return float(picture.tristimulus[0, 0, 1]), float(picture.luminance_error[0, 0])
