"""C25: the sun's disk, its penumbra, and the place of the patch that it throws through an opening."""

import numpy as np

from lumenray.engine.scene.light import Output, Quantity, SunLight
from lumenray.engine.sky.cie import sun_direction

from .. import stage
from ..bench import Bench, Finding, Findings
from ..reference import Group
from .registry import case

SUN_RADIUS = np.radians(0.2665)
"""Angular radius of the disk. [rad]"""

SUN_LUMINANCE = 1e9
"""Of the disk. [cd/m2]"""

PATCH_SUN = np.array((np.sqrt(0.375), -np.sqrt(0.375), 0.5))
"""Direction to the sun that throws the patch: 30 degrees high, 45 degrees from the facade's normal."""

PATCH_SUN_NORMAL = 1e5
"""Its illuminance on a plane that faces it. [lx]"""

HOLE_X, HOLE_Z = (1.0, 3.0), (1.0, 2.0)
"""The opening in the facade y = 0. [m]"""

PROBES = {
    "z=1": ((-0.3, 0.0), (0.3, 0.0), (0.0, -1.0)),
    "z=2": ((-0.3, 0.0), (0.3, 0.0), (0.0, 1.0)),
    "x=1": ((0.0, -0.2), (0.0, 0.2), (-1.0, 0.0)),
    "x=3": ((0.0, -0.2), (0.0, 0.2), (1.0, 0.0)),
}
"""By edge of the opening: two places in the patch, from its centre, and the way from there to the patch's edge. [m]"""

PROBE_LENGTH = 3.0
"""How far away from its start every edge is sought. [m]"""

PROBE_STEPS = 32
"""Parts that every search divides its range into."""

PROBE_ROUNDS = 3
"""Searches, each in the part where the last one found the edge; leaves 0.1 mm."""


@case("C25", "Sun disk", "daylight", quick=("C25.disk",))
def sun_disk(bench: Bench) -> Findings:
    """The patch, its place, the penumbra, illuminance by elevation."""
    groups = bench.groups("C25")
    facade = _facade()
    if "C25.patchE" in groups:
        yield bench.measure_group(facade, groups["C25.patchE"])
    if "C25.patch" in groups:
        yield _patch(bench, facade, groups["C25.patch"])
    if "C25.disk" in groups:
        yield _by_elevation(bench, groups["C25.disk"])
    if "C25.penumbra" in groups:
        blind = stage.quad("blind", (-20.0, -20.0, 10.0), (20.0, 0, 0), (0, 40.0, 0), "black")
        items = (stage.BLACK, blind, _disk(np.pi / 2.0))
        yield bench.measure_group(items, groups["C25.penumbra"])


def _disk(elevation: float) -> SunLight:
    """Sun of the stated luminance. [rad]"""
    normal = np.pi * SUN_LUMINANCE * np.sin(SUN_RADIUS) ** 2
    output = Output(Quantity.ILLUMINANCE, normal, stage.EVEN)
    return SunLight("sun", "sun", output, -sun_direction(elevation, 0.0), 2.0 * SUN_RADIUS)


def _by_elevation(bench: Bench, group: Group) -> Finding:
    values, errors = np.zeros_like(group.values), np.zeros_like(group.values)
    place, up = np.zeros((1, 3)), np.array([[0.0, 0.0, 1.0]])
    for i, label in enumerate(group.labels):
        items = (_disk(np.radians(float(label.removeprefix("elevation ")))),)
        made = bench.measure(items, place, up, group.allowed[i])
        values[i], errors[i] = made.values[0], made.errors[0]
    return Finding(group, values, errors)


def _facade() -> tuple:
    """Black wall with the opening, under a sun that is a point."""
    shares = [(np.array(HOLE_X) + 20.0) / 40.0, np.array(HOLE_Z) / 20.0]
    wall = stage.frame("facade", (-20.0, 0, 0), (40.0, 0, 0), (0, 0, 20.0), *shares, "black")
    output = Output(Quantity.ILLUMINANCE, PATCH_SUN_NORMAL, stage.EVEN)
    return stage.BLACK, wall, SunLight("sun", "sun", output, -PATCH_SUN)


def _patch(bench: Bench, facade: tuple, group: Group) -> Finding:
    """Corners of the patch as intersections of its edges, which are sought with sensors between light and dark."""
    middle = np.array((np.mean(HOLE_X), 0.0, np.mean(HOLE_Z)))
    centre = (middle - PATCH_SUN * middle[2] / PATCH_SUN[2])[:2]
    starts = np.array([centre + p[i] for p in PROBES.values() for i in range(2)])
    ways = np.array([p[2] for p in PROBES.values() for _ in range(2)])
    lit = PATCH_SUN_NORMAL * PATCH_SUN[2]
    near, width = np.zeros(len(starts)), PROBE_LENGTH
    for _ in range(PROBE_ROUNDS):
        width /= PROBE_STEPS
        distances = near[:, None] + width * (np.arange(PROBE_STEPS) + 1.0)
        places = starts[:, None] + distances[..., None] * ways[:, None]
        positions = np.concatenate([places, np.zeros((*distances.shape, 1))], axis=-1)
        normals = np.broadcast_to((0.0, 0.0, 1.0), positions.shape)
        made = bench.measure(facade, positions.reshape(-1, 3), normals.reshape(-1, 3), 0.1 * lit)
        dark = made.values.reshape(distances.shape) < 0.5 * lit
        dark[:, -1] = True
        near += width * dark.argmax(axis=1)
    points = starts + (near + 0.5 * width)[:, None] * ways
    edges = {key: points[2 * i : 2 * i + 2] for i, key in enumerate(PROBES)}
    values = []
    for label in group.labels:
        corner, axis = label.removeprefix("window corner ").split(": ")
        x, z = corner.strip("()").split(",")
        values.append(_crossing(edges[f"x={x}"], edges[f"z={z}"])["xy".index(axis)])
    # What the last search leaves open, evenly distributed; extrapolating an edge makes it about twice as much.
    error = 2.0 * width / np.sqrt(12.0)
    return Finding(group, np.array(values), np.full(len(values), error))


def _crossing(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Point where the line through two points crosses another. (2, 2), (2, 2)"""
    along, other = a[1] - a[0], b[1] - b[0]
    share = np.linalg.solve(np.stack([along, -other], axis=1), b[0] - a[0])[0]
    return a[0] + share * along
