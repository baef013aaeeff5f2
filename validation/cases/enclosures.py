"""Closed rooms in which light is reflected over and over: cube, spheres, furnaces."""

import numpy as np

from lumenray.engine.scene.light import UniformWorld
from lumenray.engine.scene.material import Black

from ..bench import Bench, Finding, Findings, Setup
from ..reference import Group
from ..stage import BLACK, box, lumen, material, matt, mesh, quad, sphere
from .interreflection import reflectances
from .means import look, mean_at_points, mean_by_bake, mean_of_picture, reseeded
from .quadrature import plane_grid
from .registry import case

FLUX = 10_000.0
"""Of the lamp of C10. [lm]"""

LAMP = lumen("lamp", (0.0, 0.0, 0.0), FLUX)

CUBE = box("cube", (-2.0, -2.0, -2.0), (2.0, 2.0, 2.0), "paint", inwards=True)

CUBE_AREA = 96.0
"""[m2]"""

GRID = 4
"""Points along each edge of a quarter of a face; with Gauss's weights the mean of the direct light is good to 1e-5."""

RADIUS, INNER_RADIUS = 2.0, 0.5
"""Of the spheres. [m]"""

GAP = 1e-4
"""Of sensors before a sphere, whose flat triangles lie up to 4e-5 m inside it. [m]"""

GLOW = 100.0
"""Luminance that every surface of the furnace emits. [cd/m2]"""

DEFICIT = 1e-3
"""Share of the light that may be missing where bounces are counted. [-]"""


def _ring_directions() -> np.ndarray:
    """Directions below the horizon, where no sphere has its port. (8, 3)"""
    heights, azimuths = np.repeat((-0.2, -0.8), 4), np.arange(8) * np.pi / 2.0 + 0.3
    flat = np.sqrt(1.0 - heights**2)
    return np.stack([flat * np.cos(azimuths), flat * np.sin(azimuths), heights], axis=1)


DIRECTIONS = _ring_directions()


@case(
    "C10",
    "Internally reflected component",
    "interreflection",
    quick=("C10.cube0.95",),
)
def run_lit_enclosures(bench: Bench) -> Findings:
    """A lamp in a cube and in spheres; a glowing sphere in another."""
    groups = bench.groups("C10")
    for key, group in groups.items():
        if key.startswith("C10.cube") and key != "C10.cube_mean":
            paint = matt("paint", float(key.removeprefix("C10.cube")))
            yield bench.measure_group([paint, CUBE, LAMP], group)
    yield from _measure_face(bench, groups)
    if group := groups.get("C10.sphere"):
        yield _measure_spheres(bench, group)
    if group := groups.get("C10.sphere_off"):
        lamp = lumen("lamp", (0.0, 0.0, 1.0), FLUX)
        yield bench.measure_group([matt("paint", 0.8), _shell(), lamp], group)
    if group := groups.get("C10.sphere_port"):
        yield _measure_ports(bench, group)
    if group := groups.get("C10.cube_mean"):
        found = []
        for i, reflectance in enumerate(reflectances(group)):
            ideal = FLUX / ((1.0 - reflectance) * CUBE_AREA)
            items, allowed = [matt("paint", reflectance), CUBE, LAMP], group.allowed[i] * ideal
            made = mean_by_bake(reseeded(bench, i), items, (CUBE,), allowed, CUBE_AREA)
            found.append(np.divide(made, ideal))
        yield Finding(group, *np.array(found).T)
    if group := groups.get("C10.concentric"):
        yield _measure_concentric(bench, group)


def _measure_face(bench: Bench, groups: dict[str, Group]) -> Findings:
    """Means over a quarter of a face, which by symmetry is like all others: total, and less that of black walls."""
    wanted = [groups[key] for key in ("C10.avg_ind", "C10.avg_tot") if key in groups]
    if not wanted:
        return
    points, weights = plane_grid((0.0, 0.0, -2.0), (2.0, 0.0, 0.0), (0.0, 2.0, 0.0), GRID)
    normals = np.tile((0.0, 0.0, 1.0), (len(points), 1))
    allowed = np.min([group.allowed for group in wanted], axis=0)

    def measure(number: int, paint, allowed: float):
        items = [paint, CUBE, LAMP]
        return mean_at_points(reseeded(bench, number), items, points, normals, allowed, weights)

    paints = [matt("paint", reflectance) for reflectance in reflectances(wanted[0])]
    found = [measure(i, *pair) for i, pair in enumerate(zip(paints, allowed, strict=True))]
    values, errors = np.array(found).T
    if group := groups.get("C10.avg_ind"):
        direct, error = measure(len(paints), material("paint", Black()), allowed.min())
        yield Finding(group, values - direct, np.hypot(errors, error))
    if group := groups.get("C10.avg_tot"):
        yield Finding(group, values, errors)


def _shell():
    """Sphere that is looked at from inside."""
    return sphere("shell", (0.0, 0.0, 0.0), RADIUS, "paint", inwards=True)


def _mean_in_shell(bench: Bench, items, allowed: float, **more) -> tuple[float, float]:
    """Mean illuminance at places of the shell, which are all alike. [lx]"""
    points = (RADIUS - GAP) * DIRECTIONS
    return mean_at_points(bench, items, points, -DIRECTIONS, allowed, **more)


def _measure_spheres(bench: Bench, group: Group) -> Finding:
    """A lamp in the centre of a sphere, for each reflectance."""
    shell, found = _shell(), []
    for i, reflectance in enumerate(reflectances(group)):
        items = [matt("paint", reflectance), shell, LAMP]
        found.append(_mean_in_shell(reseeded(bench, i), items, group.allowed[i]))
    return Finding(group, *np.array(found).T)


def _measure_ports(bench: Bench, group: Group) -> Finding:
    """Spheres whose cap around +z is black."""
    shells, found = {}, []
    for i, (label, reflectance) in enumerate(zip(group.labels, reflectances(group), strict=True)):
        # Labels say "port half-angle 20 deg, rho=0.5".
        angle = float(label.split()[2])
        if angle not in shells:
            caps = (np.radians(angle), BLACK.id)
            shells[angle] = sphere("shell", (0, 0, 0), RADIUS, "paint", inwards=True, caps=caps)
        items = [BLACK, matt("paint", reflectance), shells[angle], LAMP]
        found.append(_mean_in_shell(reseeded(bench, i), items, group.allowed[i]))
    return Finding(group, *np.array(found).T)


def _measure_concentric(bench: Bench, group: Group) -> Finding:
    """Radiosities as pictures show them, illuminances as sensors do."""
    core = sphere("core", (0.0, 0.0, 0.0), INNER_RADIUS, "core_paint")
    items = [matt("core_paint", 0.3, 1000.0 / np.pi), core, matt("paint", 0.6), _shell()]
    eye = (0.0, -1.25, 0.0)
    # The core fills a view of 0.4, and nothing of it is seen to the other side.
    views = (look(eye, (0.0, 0.0, 0.0), 0.4), look(eye, (0.0, -2.0, 0.0), 1.0))
    found = [
        np.pi * np.array(mean_of_picture(bench, items, view, allowed / np.pi))
        for view, allowed in zip(views, group.allowed[:2], strict=True)
    ]
    points = (INNER_RADIUS + GAP) * DIRECTIONS
    found.append(mean_at_points(bench, items, points, DIRECTIONS, group.allowed[2]))
    found.append(_mean_in_shell(bench, items, group.allowed[3]))
    return Finding(group, *np.array(found).T)


@case("C19", "Closed furnace", "interreflection", quick=("C19.furnace_E", "C19.env"))
def run_furnaces(bench: Bench) -> Findings:
    """Rooms whose surfaces all glow and reflect alike, and a ball in even surroundings."""
    groups = bench.groups("C19")
    if group := groups.get("C19.furnace_E"):
        yield _measure_furnaces(bench, group)
    if group := groups.get("C19.bounces"):
        yield _count_bounces(bench, group)
    if group := groups.get("C19.furnace"):
        room = _angled_room()
        view = look((0.6, 3.5, 1.4), (2.6, 0.6, 1.3), 1.6)
        yield _photograph(
            bench, group, [[matt("paint", r, GLOW), *room] for r in reflectances(group)], view
        )
    if group := groups.get("C19.env"):
        ball = sphere("ball", (0.0, 0.0, 0.0), 1.0, "paint")
        view = look((0.0, -3.0, 0.0), (0.0, 0.0, 0.0), 0.2)
        dome = UniformWorld(100.0)
        yield _photograph(
            bench, group, [[dome, matt("paint", r), ball] for r in reflectances(group)], view
        )


def _photograph(bench: Bench, group: Group, scenes: list, view) -> Finding:
    """Mean luminance of a view, for each scene."""
    found = [
        mean_of_picture(reseeded(bench, i), items, view, group.allowed[i])
        for i, items in enumerate(scenes)
    ]
    return Finding(group, *np.array(found).T)


def _measure_furnaces(bench: Bench, group: Group) -> Finding:
    """A glowing box: on a face, in an edge, near a corner and, turned, in mid-air."""
    room = box("room", (0.0, 0.0, 0.0), (4.0, 4.0, 3.0), "paint", inwards=True)
    points = np.array([(1.7, 2.2, 0.0), (4.0, 1.1, 2.999), (0.001, 3.999, 0.001), (3.1, 2.7, 2.1)])
    normals = np.array([(0.0, 0.0, 1.0), (-1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (2.0, -1.0, 2.0)])
    labels = ("face", "edge", "corner", "mid-air")
    found = []
    for i, reflectance in enumerate(reflectances(group)):
        items = [matt("paint", reflectance, GLOW), room]
        found.append(mean_at_points(reseeded(bench, i), items, points, normals, group.allowed[i]))
        bench.setups.setdefault(group.case, Setup(tuple(items), points, normals, labels))
    return Finding(group, *np.array(found).T)


def _count_bounces(bench: Bench, group: Group) -> Finding:
    """Bounces after which no more than `DEFICIT` is missing, from the part that one bounce leaves of the light.

    In a sphere with a lamp in its centre every bounce adds the same share q of what the one before it added, so that
    after k of them q^(k+1) is missing. The share comes from the first two: E_2 - E_1 = q (E_1 - E_0), E_k with at most k
    reflections. There no path has been ended by chance yet, so that the readings are good to 1e-6; from a deficit after
    many bounces the count for 0.99 could be told to one only by millions of paths of hundred bounces each. That nothing
    is lost in those is what C19.furnace and C10.sphere show.
    """
    shell = _shell()
    found = []
    for i, reflectance in enumerate(reflectances(group)):
        items = [matt("paint", reflectance), shell, LAMP]
        # How an error of q changes the count, and how one of the readings changes q.
        slope = abs(np.log(DEFICIT)) / (reflectance * np.log(reflectance) ** 2)
        step = FLUX / (4.0 * np.pi * RADIUS**2) * reflectance
        limit = 0.25 * group.allowed[i] / slope * step
        (direct, _), (once, error), (twice, second) = (
            _mean_in_shell(reseeded(bench, i), items, limit, reflections=k) for k in range(3)
        )
        share = (twice - once) / (once - direct)
        error = np.hypot((1.0 + share) * error, second) / (once - direct)
        bounces = np.ceil(np.log(DEFICIT) / np.log(share)) - 1.0
        found.append((bounces, error * slope))
    return Finding(group, *np.array(found).T)


def _angled_room() -> list:
    """An L-shaped room with a box on its floor, one that hangs, and one that stands askew."""
    outline = np.array([(0, 0), (5, 0), (5, 2), (2, 2), (2, 4), (0, 4)], dtype=np.float64)
    high = 2.8
    items = []
    for number, (start, end) in enumerate(zip(outline, np.roll(outline, -1, axis=0), strict=True)):
        along, up = (*(end - start), 0.0), (0.0, 0.0, high)
        # The outline runs anticlockwise, so that up x along looks inwards.
        items.append(quad(f"wall{number}", (*start, 0.0), up, along, "paint"))
    for key, corner, x, y in (("long", (0.0, 0.0), 5.0, 2.0), ("short", (0.0, 2.0), 2.0, 2.0)):
        sides = (x, 0.0, 0.0), (0.0, y, 0.0)
        items.append(quad(f"floor_{key}", (*corner, 0.0), *sides, "paint"))
        items.append(quad(f"ceiling_{key}", (*corner, high), *sides[::-1], "paint"))
    items.append(box("cupboard", (4.2, 0.3, 0.0), (4.8, 1.7, 2.0), "paint"))
    items.append(box("pendant", (0.8, 2.6, 2.1), (1.4, 3.4, 2.2), "paint"))
    table = box("table", (-0.5, -0.3, 0.7), (0.5, 0.3, 0.75), "paint")
    turn = np.array([(0.8, -0.6, 0.0), (0.6, 0.8, 0.0), (0.0, 0.0, 1.0)])
    items.append(mesh("table", table.vertices @ turn.T + (2.6, 0.9, 0.0), table.triangles, "paint"))
    return items
