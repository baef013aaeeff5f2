"""A building of many rooms with doorways and furniture, all surfaces finely divided and a little bumpy."""

import numpy as np

from ...engine.scene.light import AreaLight, Output, Quantity
from ...engine.scene.material import Diffuse, Material
from ...engine.scene.mesh import Mesh
from ...engine.scene.spectrum import Constant
from ..common.pieces import Piece, grid, make_mesh, rigid_frame
from .scenes import AtlasScene

ROOM = np.array([5.0, 4.0, 3.0])
"""Size of a room. [m]"""

WALL = 0.2
"""Between neighbouring rooms. [m]"""

PIECES = 5
"""Pieces of furniture in a room."""

CHARTS = 6 * (1 + PIECES)
"""Flat sides in a room, each of which is a chart."""

BUMP = 0.01
"""Height of the bumps: nothing that a chart would be cut for. [m]"""

SURFACE = 136.5
"""About the surface of a room with its furniture, for the density that fills so many pages. [m2]"""


def build_building(triangles: int, charts: int, density: float) -> AtlasScene:
    """Build so many charts with so many triangles together, rounded to whole rooms and to even divisions."""
    rooms = max(round(charts / CHARTS), 1)
    fields = max(round(np.sqrt(0.5 * triangles / (rooms * CHARTS))), 1)
    columns = int(np.ceil(np.sqrt(rooms)))
    materials = [
        Material(name, name, Diffuse(Constant(value)))
        for name, value in (("plaster", 0.75), ("floor", 0.4), ("wood", 0.5))
    ]
    rng = np.random.default_rng(7)
    items, objects = list(materials), []
    for number in range(rooms):
        row, column = divmod(number, columns)
        corner = np.array([column, row, 0.0]) * (ROOM + WALL)
        meshes = _room(f"{number:04}", corner, fields, rng)
        items += meshes
        objects += [mesh.id for mesh in meshes]
        lamp = f"lamp {number:04}"
        frame = rigid_frame(corner + ROOM * [0.5, 0.5, 1.0] - [0, 0, 0.02], (0, 0, -1))
        flux = Output(Quantity.LUMINOUS_FLUX, 4000.0)
        items.append(AreaLight(lamp, lamp, flux, frame, 1.2, 0.6))
    title = f"Building of {rooms} rooms"
    return AtlasScene("building", title, tuple(items), tuple(objects), density, 0)


def count_triangles(scene: AtlasScene) -> int:
    """Triangles of a scene."""
    return sum(len(item.triangles) for item in scene.items if isinstance(item, Mesh))


def _room(number: str, corner: np.ndarray, fields: int, rng) -> list[Mesh]:
    """Shell and furniture of a room."""
    sides = _sides(corner, corner + ROOM, fields, inwards=True)
    if fields >= 5:
        # Doorways in the middle of both walls across x.
        open_ones = [(fields // 2, level) for level in range(2 * fields // 3)]
        sides[4] = _side(corner, corner + ROOM, 4, fields, True, open_ones)
        sides[5] = _side(corner, corner + ROOM, 5, fields, True, open_ones)
    shell = [_bumpy(side, rng) for side in sides]
    meshes = [
        make_mesh(f"floor {number}", shell[:1], "floor"),
        make_mesh(f"shell {number}", shell[1:], "plaster"),
    ]
    for piece in range(PIECES):
        # One in each fifth of the room, so that none meets another.
        size = np.array([0.6, 1.6, 0.5]) + rng.random(3) * [0.2, 0.8, 1.2]
        place = [0.1 + piece * (ROOM[0] - 0.2) / PIECES, 0.2 + rng.random() * 1.2, 0.01]
        low = corner + place
        pieces = [_bumpy(side, rng) for side in _sides(low, low + size, fields, inwards=False)]
        meshes.append(make_mesh(f"furniture {number} {piece}", pieces, "wood"))
    return meshes


def _sides(low, high, fields: int, inwards: bool) -> list[Piece]:
    return [_side(low, high, side, fields, inwards, ()) for side in range(6)]


def _side(low, high, side: int, fields: int, inwards: bool, without) -> Piece:
    """Side of a box, as a grid: bottom, top, -y, +y, -x, +x."""
    axis, is_high = (2, 2, 1, 1, 0, 0)[side], side % 2 == 1
    first, second = {2: (0, 1), 1: (0, 2), 0: (1, 2)}[axis]
    u, v, corner = np.zeros(3), np.zeros(3), np.array(low, dtype=np.float64)
    u[first], v[second] = high[first] - low[first], high[second] - low[second]
    if is_high:
        corner[axis] = high[axis]
    vertices, triangles = grid(corner, u, v, fields, fields, without)
    # First times second axis points along the third, but for y.
    points_up = axis != 1
    if points_up != (is_high != inwards):
        triangles = triangles[:, ::-1]
    return vertices, triangles


def _bumpy(piece: Piece, rng) -> Piece:
    """Move the vertices inside a flat grid along its normal."""
    vertices, triangles = piece
    corners = vertices[triangles[0]]
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    normal /= np.linalg.norm(normal)
    side = round(np.sqrt(len(vertices)))
    place = np.arange(side)
    inner = np.outer((place > 0) & (place < side - 1), (place > 0) & (place < side - 1)).ravel()
    height = BUMP * rng.random(len(vertices)) * inner
    return vertices + height[:, None] * normal, triangles
