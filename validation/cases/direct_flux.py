"""Flux between a source, an opening and the surfaces of a black room: nothing is lost, nothing comes from nowhere."""

import numpy as np

from lumenray.engine.scene.light import CieSky
from lumenray.engine.scene.material import Transparent

from ..bench import Bench, Finding, Findings
from ..reference import groups_of
from ..stage import BLACK, frame, glowing, lumen, material, quad
from .quadrature import plane_grid
from .registry import case

WIDTH, HEIGHT = 4.0, 3.0
"""Of the room, whose plan is a square. [m]"""

FLUX = 10_000.0
"""Of the lamp. [lm]"""

SKY_ILLUMINANCE = 10_000.0
"""Of an unobstructed horizontal plane. [lx]"""

TOWARDS_SUN = np.array([0.0, np.cos(np.radians(60.0)), np.sin(np.radians(60.0))])
"""Elevation 60 degrees, towards +y."""

_X, _Y, _Z = WIDTH * np.eye(3)[0], WIDTH * np.eye(3)[1], HEIGHT * np.eye(3)[2]

FACES = {
    "floor": (np.zeros(3), _X, _Y),
    "ceiling": (_Z, _Y, _X),
    "wall_x0": (np.zeros(3), _Y, _Z),
    "wall_x4": (_X, _Z, _Y),
    "wall_y0": (np.zeros(3), _Z, _X),
    "wall_y4": (_Y, _X, _Z),
}
"""Corner and edges of each face, facing inwards. [m]"""

GRID = 12
"""Points along each edge of a face; with Gauss's weights the means are good to 4e-5, of clear skies with their peak too."""


def face(key: str):
    """Black face of the room."""
    return quad(key, *FACES[key], BLACK.id)


def mean_over_faces(bench: Bench, items, keys, allowed: float):
    """Mean illuminances over faces and their standard errors, each (n,). [lx]

    Parameters
    ----------
    keys : sequence of str    Faces.
    allowed : float    Largest difference of a mean that passes. [lx]
    """
    points, normals = [], []
    for key in keys:
        corner, u, v = FACES[key]
        places, weights = plane_grid(corner, u, v, GRID)
        points.append(places)
        normals.append(np.broadcast_to(np.cross(u, v), places.shape))
    # The errors of single points add up like squares.
    each = allowed / np.sqrt((weights**2).sum())
    made = bench.measure(items, np.concatenate(points), np.concatenate(normals), each)
    values, errors = (x.reshape(len(keys), -1) for x in (made.values, made.errors))
    return values @ weights, np.sqrt(errors**2 @ weights**2)


def area_of(key: str) -> float:
    """Area of a face. [m2]"""
    _, u, v = FACES[key]
    return float(np.linalg.norm(np.cross(u, v)))


def roof(side: float, paint: str) -> list:
    """Ceiling with a square in its middle that is of another material and faces down."""
    low, high = 0.5 * (WIDTH - side), 0.5 * (WIDTH + side)
    inner = quad("opening", (low, low, HEIGHT), (0.0, side, 0.0), (side, 0.0, 0.0), paint)
    if side == WIDTH:
        return [inner]
    hole = (low / WIDTH, high / WIDTH)
    return [frame("ceiling", *FACES["ceiling"], hole, hole, BLACK.id), inner]


@case("C06", "Luminous flux conservation", "direct", quick=("C06.point", "C06.point_sum"))
def run_flux(bench: Bench) -> Findings:
    """A lamp, the sky and a bright opening in a black room."""
    groups = bench.groups("C06")
    yield from _measure_lamp(bench, groups)
    shell = [BLACK, *(face(key) for key in FACES if key != "ceiling")]
    if group := groups.get("C06.roof_ff"):
        yield _measure_form_factors(bench, group, shell)
    if group := groups.get("C06.roof"):
        yield _measure_sky(bench, group, shell)


def _measure_lamp(bench: Bench, groups) -> Findings:
    """Means over the faces, and their sum over the lamp's flux."""
    wanted = [groups[key] for key in ("C06.point", "C06.point_sum") if key in groups]
    if not wanted:
        return
    items = [BLACK, lumen("lamp", (1.2, 2.1, 2.0), FLUX), *(face(key) for key in FACES)]
    # The darkest face's mean is to be as good as the sum, in proportion.
    darkest = groups_of("C06")["C06.point"].values.min()
    allowed = min((group.allowed / group.values).min() * darkest for group in wanted)
    values, errors = mean_over_faces(bench, items, list(FACES), allowed)
    if group := groups.get("C06.point"):
        order = [list(FACES).index(label) for label in group.labels]
        points = np.array([np.add(c, 0.5 * np.add(u, v)) for c, u, v in FACES.values()])
        normals = np.array([np.cross(u, v) for _, u, v in FACES.values()])
        bench.show(group, items, points[order], normals[order])
        yield Finding(group, values[order], errors[order])
    if group := groups.get("C06.point_sum"):
        areas = np.array([area_of(key) for key in FACES]) / FLUX
        yield Finding(group, np.array([areas @ values]), np.array([np.sqrt(areas**2 @ errors**2)]))


def _share_on_floor(bench: Bench, items, share: float, allowed: float) -> tuple[float, float]:
    """Share of a flux that reaches the floor, with its standard error. ``share``: of 1 lx on the floor. [1/lx]"""
    (mean,), (error,) = mean_over_faces(bench, items, ["floor"], allowed / share)
    return mean * share, error * share


def _measure_form_factors(bench: Bench, group, shell) -> Finding:
    """Share of the flux of a glowing opening that reaches the floor."""
    shine = glowing("shine", 1000.0)
    found = []
    for label, allowed in zip(group.labels, group.allowed, strict=True):
        side = float(label.split("x")[0])
        share = area_of("floor") / (np.pi * 1000.0 * side**2)
        items = [*shell, shine, *roof(side, shine.id)]
        found.append(_share_on_floor(bench, items, share, allowed))
    return Finding(group, *np.array(found).T)


def _measure_sky(bench: Bench, group, shell) -> Finding:
    """Share of the sky's flux through the opening that reaches the floor."""
    air = material("air", Transparent())
    roofs = {side: roof(side, air.id) for side in (1.0, WIDTH)}
    found = []
    for label, allowed in zip(group.labels, group.allowed, strict=True):
        # Labels say "1x1 sky 12 floor".
        size, _, sky_type, _ = label.split()
        side = float(size.split("x")[0])
        share = area_of("floor") / (SKY_ILLUMINANCE * side**2)
        sky = CieSky(int(sky_type), TOWARDS_SUN, SKY_ILLUMINANCE)
        items = [*shell, air, sky, *roofs[side]]
        found.append(_share_on_floor(bench, items, share, allowed))
    return Finding(group, *np.array(found).T)
