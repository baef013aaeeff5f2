"""The body of a luminaire as a mesh to look at: its housing by the file's size, and the luminous opening."""

import bpy
import numpy as np

from ...engine.luminaires.formats.record import LuminaireFile
from ...engine.scene.distribution import Opening

SIDES = 32
"""Of what is round."""

RINGS = 12
"""Of what is round all over."""

SMALLEST = 0.05
"""Size of a body whose file states none. [m]"""

THIN = 0.001
"""Thickness of an opening without a housing, and how far openings stand out of it, so that they can be seen. [m]"""

COLOURS = {
    "Luminaire housing": (0.55, 0.55, 0.55, 1.0),
    "Luminaire opening": (1.0, 0.93, 0.7, 1.0),
}
"""Materials of a body and their colours."""


def body_extent(file: LuminaireFile) -> tuple[np.ndarray, np.ndarray]:
    """Return the least and the largest corner of a luminaire's body, in its own axes. [m]

    The photometric centre is the middle of the opening. Of the housing only the size is known: it is taken to end below
    with the opening.
    """
    least, largest = _opening_extent(file.opening)
    if file.housing is not None:
        length, width, height = file.housing
        half = 0.5 * np.array([length, width if width > 0.0 else length])
        low, high = np.append(-half, least[2]), np.append(half, least[2] + max(height, THIN))
        least, largest = np.minimum(least, low), np.maximum(largest, high)
    return least, largest


def build_body(file: LuminaireFile, name: str, scale: float):
    """Make the mesh of a luminaire's body, in its own axes.

    Parameters
    ----------
    file : LuminaireFile
    name : str    Of the mesh.
    scale : float    Metres per Blender unit.

    Returns
    -------
    bpy.types.Mesh
    """
    least, largest = _opening_extent(file.opening)
    parts = [(*_shape(file.opening, least, largest), 1)]
    if file.housing is not None:
        length, width, height = file.housing
        is_round = width <= 0.0
        half = 0.5 * np.array([length, length if is_round else width])
        # What shines below stands out a little, else it would lie in the housing's own face.
        low = np.append(-half, least[2] + THIN)
        high = np.append(half, least[2] + max(height, 2.0 * THIN))
        parts.append((*(make_prism(low, high, 2) if is_round else make_box(low, high)), 0))
    vertices, faces, materials = [], [], []
    for corners, polygons, material in parts:
        faces += [[index + len(vertices) for index in polygon] for polygon in polygons]
        vertices += [tuple(corner / scale) for corner in corners]
        materials += [material] * len(polygons)
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    for material in COLOURS:
        mesh.materials.append(_material(material))
    mesh.polygons.foreach_set("material_index", materials)
    mesh.update()
    return mesh


def _opening_extent(opening: Opening) -> tuple[np.ndarray, np.ndarray]:
    size = np.array(opening.size)
    if opening.shape == "point":
        size = np.full(3, SMALLEST)
    half = 0.5 * np.maximum(size, THIN)
    return -half, half


def _shape(opening: Opening, least, largest):
    """Corners (n, 3) and polygons of an opening."""
    axis = "xyz".index(opening.axis)
    match opening.shape:
        case "rectangle" | "box":
            return make_box(least, largest)
        case "ellipse" | "cylinder":
            return make_prism(least, largest, axis)
    return _ball(least, largest)


def make_box(least, largest):
    """Corners (8, 3) and polygons of a box from its least and its largest corner, facing outwards."""
    corners = np.array([[x, y, z] for z in (0, 1) for y in (0, 1) for x in (0, 1)])
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return least + corners * (largest - least), faces


def make_prism(least, largest, axis: int):
    """Elliptic cylinder along an axis."""
    angle = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)
    # The two others in cyclic order, so that the faces look outwards.
    across, up = (axis + 1) % 3, (axis + 2) % 3
    unit = np.zeros((2, SIDES, 3))
    unit[..., across], unit[..., up] = np.cos(angle), np.sin(angle)
    unit[0, :, axis], unit[1, :, axis] = -1.0, 1.0
    corners = 0.5 * (least + largest) + unit.reshape(-1, 3) * 0.5 * (largest - least)
    faces = [(i, (i + 1) % SIDES, SIDES + (i + 1) % SIDES, SIDES + i) for i in range(SIDES)]
    ends = [tuple(reversed(range(SIDES))), tuple(range(SIDES, 2 * SIDES))]
    return corners, [*faces, *ends]


def _ball(least, largest):
    """Ellipsoid of rings about z."""
    polar = np.pi * np.arange(1, RINGS) / RINGS
    angle = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)
    rings = np.stack(
        np.broadcast_arrays(
            np.sin(polar)[:, None] * np.cos(angle),
            np.sin(polar)[:, None] * np.sin(angle),
            -np.cos(polar)[:, None],
        ),
        axis=-1,
    ).reshape(-1, 3)
    unit = np.concatenate([rings, [[0.0, 0.0, -1.0], [0.0, 0.0, 1.0]]])
    low, high = len(rings), len(rings) + 1
    faces = []
    for i in range(SIDES):
        j = (i + 1) % SIDES
        faces.append((low, j, i))
        last = (RINGS - 2) * SIDES
        faces.append((high, last + i, last + j))
        for ring in range(RINGS - 2):
            row = ring * SIDES
            faces.append((row + i, row + j, row + SIDES + j, row + SIDES + i))
    return 0.5 * (least + largest) + unit * 0.5 * (largest - least), faces


def _material(name: str):
    """Return the local material of a name, made where it is missing; that of housings counts where they block light."""
    found = bpy.data.materials.get((name, None))
    if found is None:
        found = bpy.data.materials.new(name)
        found.diffuse_color = COLOURS[name]
        # Newer versions of Blender give every material nodes.
        shader = found.node_tree and found.node_tree.nodes.get("Principled BSDF")
        if shader:
            shader.inputs["Base Color"].default_value = COLOURS[name]
    return found
