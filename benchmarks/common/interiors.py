"""Rooms that several benchmarks compute: their items."""

import numpy as np

from ...engine.scene.distribution import IntensityDistribution
from ...engine.scene.light import AreaLight, CieSky, Luminaire, Output, Quantity
from ...engine.scene.material import Diffuse, Material, Transparent
from ...engine.scene.spectrum import Constant
from .pieces import box, grid, make_mesh, polygon, quad, rigid_frame, side_of_box

FEET = 0.01
"""Gap below things that stand on something, so that no lumel is half inside a solid. [m]"""

LENGTH, RADIUS, AXIS = 12.0, 1.9, 0.6
"""Of the cabin: length, radius of the tube, and height of its axis above the floor. [m]"""

SHELF = 1.5
"""Top of the cabin's cove, from which its lamps shine up. [m]"""


def build_cabin() -> tuple:
    """Closed tube with seats; strips of light in coves shine at the ceiling alone, so all light on the rest is indirect."""
    half_floor = np.sqrt(RADIUS**2 - AXIS**2)
    edge = np.arcsin(-AXIS / RADIUS)
    cove = np.arcsin((SHELF - 0.02 - AXIS) / RADIUS)
    right = _arc(np.linspace(edge, cove, 9))
    above = _arc(np.linspace(cove, np.pi - cove, 17))
    left = _arc(np.linspace(np.pi - cove, np.pi - edge, 9))
    sides = make_mesh("side walls", [_vault(right), _vault(left)], "lining")
    ceiling = make_mesh("ceiling", [_vault(above)], "vault")
    outline = np.concatenate([right, above[1:], left[1:]])
    ends = [
        np.column_stack([np.full(len(outline), x), line])
        for x, line in ((0.0, outline), (LENGTH, outline[::-1]))
    ]
    caps = make_mesh("ends", [polygon(corners) for corners in ends], "lining")
    floor = make_mesh(
        "floor", [quad((0, -half_floor, 0), (LENGTH, 0, 0), (0, 2 * half_floor, 0))], "carpet"
    )
    seats, coves, lamps = [], [], []
    for sign in (-1, 1):
        for row in range(10):
            seats += _seat(0.9 + 1.05 * row, 0.95 * sign)
        outer, inner = 1.64 * sign, 1.2 * sign
        coves.append(_between((0.02, inner, SHELF - 0.02), (LENGTH - 0.02, outer, SHELF)))
        lip = inner + 0.02 * sign
        coves.append(_between((0.02, inner, SHELF), (LENGTH - 0.02, lip, SHELF + 0.1)))
        frame = rigid_frame((LENGTH / 2, 1.42 * sign, SHELF + 0.02), (0, 0, 1))
        flux = Output(Quantity.LUMINOUS_FLUX, 6000.0)
        lamps.append(AreaLight(f"strip {sign}", f"strip {sign}", flux, frame, LENGTH - 0.4, 0.3))
    meshes = [
        floor,
        sides,
        ceiling,
        caps,
        make_mesh("seats", seats, "cloth"),
        make_mesh("coves", coves, "lining"),
    ]
    materials = [
        make_matt("carpet", Constant(0.6)),
        make_matt("lining", Constant(0.7)),
        make_matt("vault", Constant(0.8)),
        make_matt("cloth", Constant(0.6)),
    ]
    return (*materials, *meshes, *lamps)


def build_window() -> tuple:
    """Room of 6 x 4 x 3 m that a clear sky lights through a window of 1.2 x 1.0 m in a thick wall."""
    room = ((0.0, 0.0, 0.0), (6.0, 4.0, 3.0))
    paint = {"bottom": "floor", "top": "ceiling"}
    walls = [
        make_mesh(f"wall {name}", [side_of_box(*room, name)], paint.get(name, "wall"))
        for name in ("bottom", "top", "-y", "-x", "+x")
    ]
    # Three by three fields, the middle one open.
    x, z, depth = (2.4, 3.6), (1.0, 2.0), 0.25
    fields = []
    for left, right in zip((0.0, *x), (*x, 6.0), strict=True):
        for low, high in zip((0.0, *z), (*z, 3.0), strict=True):
            if (left, low) != (x[0], z[0]):
                fields.append(quad((left, 4, low), (right - left, 0, 0), (0, 0, high - low)))
    walls.append(make_mesh("wall +y", fields, "wall"))
    across, up, out = (x[1] - x[0], 0, 0), (0, 0, z[1] - z[0]), (0, depth, 0)
    reveal = [
        quad((x[0], 4, z[0]), across, out),
        quad((x[0], 4, z[1]), out, across),
        quad((x[0], 4, z[0]), out, up),
        quad((x[1], 4, z[0]), up, out),
    ]
    opening = make_mesh("opening", [quad((x[0], 4 + depth, z[0]), up, across)], "air")
    table = make_mesh("table", [box((2.0, 1.4, 0.70), (3.8, 2.3, 0.74))], "board")
    cupboard = make_mesh("cupboard", [box((0.05, 0.6, FEET), (0.6, 2.4, 1.8))], "board")
    sky = CieSky(12, np.array([0.4, -0.6, 0.7]), 12_000.0, 0.2)
    materials = [
        make_matt("floor", Constant(0.5)),
        make_matt("ceiling", Constant(0.8)),
        make_matt("wall", Constant(0.7)),
        make_matt("board", Constant(0.5)),
        Material("air", "air", Transparent()),
    ]
    return (*materials, *walls, make_mesh("reveal", reveal, "wall"), opening, table, cupboard, sky)


def build_hall() -> tuple:
    """Hall of 24 x 16 x 6 m with 120 luminaires of three distributions, and machines."""
    room = ((0.0, 0.0, 0.0), (24.0, 16.0, 6.0))
    paint = {"bottom": "floor", "top": "ceiling"}
    walls = [
        make_mesh(f"wall {name}", [side_of_box(*room, name)], paint.get(name, "wall"))
        for name in ("bottom", "top", "-y", "+y", "-x", "+x")
    ]
    machines = [
        box((3.0 + 5 * i, 2.0 + 4.6 * j, FEET), (5.5 + 5 * i, 4.2 + 4.6 * j, 1.2 + 0.4 * j))
        for i in range(4)
        for j in range(3)
    ]
    polar = np.radians(np.arange(0.0, 91.0, 2.5))
    shapes = [
        np.cos(polar),
        np.cos(polar) ** 12,
        np.cos(polar) * np.exp(-(((np.degrees(polar) - 35.0) / 14.0) ** 2)) + 0.05 * np.cos(polar),
    ]
    distributions = [
        IntensityDistribution(np.zeros(1), polar, np.clip(shape, 0.0, None)[None, :])
        for shape in shapes
    ]
    lamps = []
    for number in range(120):
        row, column = divmod(number, 12)
        kind = (row + column) % len(distributions)
        lamps.append(
            Luminaire(
                f"luminaire {number}",
                f"luminaire {number}",
                Output(Quantity.LUMINOUS_FLUX, (2500.0, 4000.0, 1500.0)[kind]),
                rigid_frame((1.0 + 2.0 * column, 0.8 + 1.6 * row, 5.0), (0, 0, -1)),
                distributions[kind],
            )
        )
    materials = [
        make_matt("floor", Constant(0.25)),
        make_matt("ceiling", Constant(0.7)),
        make_matt("wall", Constant(0.5)),
        make_matt("machine", Constant(0.4)),
    ]
    meshes = [*walls, make_mesh("machines", machines, "machine")]
    return (*materials, *meshes, *lamps)


def make_matt(name: str, reflectance) -> Material:
    """Diffuse material."""
    return Material(name, name, Diffuse(reflectance))


def _between(one, two):
    """Box between any two opposite corners."""
    return box(np.minimum(one, two), np.maximum(one, two))


def _seat(x: float, y: float) -> list:
    """Seat and back, facing -x."""
    seat = box((x, y - 0.5, 0.3), (x + 0.5, y + 0.5, 0.45))
    back = box((x + 0.51, y - 0.5, FEET), (x + 0.63, y + 0.5, 1.15))
    return [seat, back]


def _arc(angles) -> np.ndarray:
    """Points (n, 2) of the cabin's outline across and up. [m]"""
    return np.stack([RADIUS * np.cos(angles), AXIS + RADIUS * np.sin(angles)], axis=1)


def _vault(line: np.ndarray):
    """Strip along the cabin that follows a line (n, 2), seen from inside."""
    count = len(line)
    vertices, triangles = grid((0, 0, 0), (0, 1, 0), (LENGTH, 0, 0), count - 1, 1)
    vertices[:, 1:] = np.tile(line, (2, 1))
    # Up times along points outwards.
    return vertices, triangles[:, ::-1]
