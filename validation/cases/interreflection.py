"""One reflection, and light from a sky that is reflected in a street, or in a room with a pinhole."""

import numpy as np

from lumenray.engine.scene.light import UniformWorld
from lumenray.engine.scene.material import Transparent

from ..bench import Bench, Finding, Findings
from ..stage import BLACK, box, frame, glowing, material, matt, quad
from .means import mean_at_points, mean_by_bake, reseeded
from .quadrature import plane_grid
from .registry import case

LIT = glowing("lit", 100.0 / np.pi)
"""A reflecting surface that is lit evenly: it sends out 100 lm/m2, so that readings are percent of that."""

SIDES = {"C08.s1": 0.5, "C08.s2": 4.0, "C08.s3": 500.0}
"""Of the square of C08. [m]"""

X, Y, Z = np.diag((4.0, 4.0, 3.0))
"""Edges of the room of C08 and C26. [m]"""

FLOOR = (np.zeros(3), X, Y)

WALLS = {
    "wall_x0": (np.zeros(3), Y, Z),
    "wall_x4": (X, Z, Y),
    "wall_y0": (np.zeros(3), Z, X),
    "wall_y4": (Y, X, Z),
}
"""Corner and edges of each wall of that room, facing inwards. [m]"""

CEILING = (Z, Y, X)

AREA = 80.0
"""Of its faces, with what is open of them. [m2]"""

STREET_LENGTH = 2000.0
"""An endless street differs by less than 1e-5. [m]"""

STREET_ILLUMINANCE = 1000.0
"""Of a horizontal plane under the whole sky of C20. [lx]"""

PINHOLE = 0.05
"""Side of the opening of C26. [m]"""

PINHOLE_SKY = UniformWorld(10_000.0)


@case("C08", "Light reflection over a diffuse surface", "interreflection", quick=("C08.s2",))
def run_diffuse_reflection(bench: Bench) -> Findings:
    """Squares that reflect evenly, seen from where walls and a ceiling would be; a bright patch in a black room."""
    groups = bench.groups("C08")
    for key, side in SIDES.items():
        if group := groups.get(key):
            corner = (2.0 - 0.5 * side, 2.0 - 0.5 * side, 0.0)
            square = quad("square", corner, (side, 0.0, 0.0), (0.0, side, 0.0), LIT.id)
            yield bench.measure_group([LIT, square], group)
    if group := groups.get("C08.element"):
        yield bench.measure_group(_room_with_patch(), group)


def _room_with_patch() -> list:
    """Black room with a patch of reflectance 0.5 that 10 000 lx fall on."""
    patch = glowing("patch", 0.5 * 10_000.0 / np.pi)
    item = quad("patch_quad", (0.0, 1.9, 1.4), (0.0, 0.2, 0.0), (0.0, 0.0, 0.2), patch.id)
    hole = ((1.9 / 4.0, 2.1 / 4.0), (1.4 / 3.0, 1.6 / 3.0))
    around = frame("wall_x0", *WALLS["wall_x0"], *hole, BLACK.id)
    walls = [quad(key, *sides, BLACK.id) for key, sides in WALLS.items() if key != "wall_x0"]
    ends = [quad("floor", *FLOOR, BLACK.id), quad("ceiling", *CEILING, BLACK.id)]
    return [BLACK, patch, item, around, *walls, *ends]


@case(
    "C09",
    "Diffuse reflection with an internal obstruction",
    "interreflection",
    quick=("C09.form",),
)
def run_obstruction(bench: Bench) -> Findings:
    """A wall that reflects evenly, seen over a black box."""
    groups = bench.groups("C09")
    if group := groups.get("C09.form"):
        wall = quad("wall", (0.0, 4.0, 0.0), (4.0, 0.0, 0.0), (0.0, 0.0, 3.0), LIT.id)
        obstacle = box("obstacle", (0.0, 2.5, 0.0), (4.0, 2.7, 1.0), BLACK.id)
        yield bench.measure_group([BLACK, LIT, wall, obstacle], group)


@case("C20", "Infinite street canyon, uniform sky", "interreflection", quick=("C20.diffuse",))
def run_street(bench: Bench) -> Findings:
    """A long street under an even sky, black and matt."""
    groups = bench.groups("C20")
    sky = UniformWorld(STREET_ILLUMINANCE / np.pi)
    half, along, up = 0.5 * STREET_LENGTH, (0.0, STREET_LENGTH, 0.0), (0.0, 0.0, 10.0)
    street = [
        quad("floor", (-5.0, -half, 0.0), (10.0, 0.0, 0.0), along, "ground"),
        quad("left", (-5.0, -half, 0.0), along, up, "facade"),
        quad("right", (5.0, -half, 0.0), up, along, "facade"),
    ]
    for key, ground, facade in (("C20.black", 0.0, 0.0), ("C20.diffuse", 0.3, 0.6)):
        if group := groups.get(key):
            paints = [matt("ground", ground), matt("facade", facade)]
            yield bench.measure_group([sky, *paints, *street], group, 1.0 / STREET_ILLUMINANCE)


@case("C26", "Light through a small window", "interreflection", quick=("C26.pin",))
def run_pinhole(bench: Bench) -> Findings:
    """A room whose ceiling has a small opening to an even sky."""
    groups = bench.groups("C26")
    air = material("air", Transparent())
    low = 2.0 - 0.5 * PINHOLE
    opening = quad("opening", (low, low, 3.0), (0.0, PINHOLE, 0.0), (PINHOLE, 0.0, 0.0), air.id)
    hole = (low / 4.0, 1.0 - low / 4.0)
    faces = (
        quad("floor", *FLOOR, "paint"),
        *(quad(key, *sides, "paint") for key, sides in WALLS.items()),
        frame("ceiling", *CEILING, hole, hole, "paint"),
    )
    shell = [PINHOLE_SKY, air, opening, *faces]
    black = [matt("paint", 0.0), *shell]
    if group := groups.get("C26.pin"):
        yield bench.measure_group(black, group)
    if group := groups.get("C26.lit"):
        points, weights = plane_grid(
            (low, low, 3.0), (PINHOLE, 0.0, 0.0), (0.0, PINHOLE, 0.0), count=4
        )
        normals = np.tile((0.0, 0.0, 1.0), (len(points), 1))
        area = PINHOLE**2
        mean, error = mean_at_points(
            bench, black, points, normals, group.allowed[0] / area, weights
        )
        yield Finding(group, np.array([mean * area]), np.array([error * area]))
    if group := groups.get("C26.mean"):
        # What falls on the opening from inside is 1e-5 of the whole and left out.
        found = []
        for i, reflectance in enumerate(reflectances(group)):
            items = [matt("paint", reflectance), *shell]
            found.append(mean_by_bake(reseeded(bench, i), items, faces, group.allowed[i], AREA))
        yield Finding(group, *np.array(found).T)


def reflectances(group) -> list[float]:
    """Read the reflectances off labels such as ``rho=0.5``."""
    return [float(label.rpartition("=")[2]) for label in group.labels]
