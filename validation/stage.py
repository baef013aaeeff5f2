"""Scene items that the cases are built of."""

from dataclasses import replace

import numpy as np

from lumenray.engine.scene.light import Output, PointLight, Quantity
from lumenray.engine.scene.material import Black, Diffuse, Emission, Material, Surface
from lumenray.engine.scene.mesh import Mesh
from lumenray.engine.scene.spectrum import Constant, Spectrum

EVEN = Constant(1.0)
"""Equal-energy spectrum."""

BLACK = Material("black", "black", Black())
"""Absorbs everything."""


def material(
    key: str, surface: Surface, luminance: float = 0.0, two_sided: bool = False
) -> Material:
    """Surface that may glow on the side of its normal, or on both. [cd/m2]"""
    glow = Emission(Constant(1.0), luminance, two_sided=two_sided) if luminance > 0.0 else None
    return Material(key, key, surface, glow)


def matt(key: str, reflectance: float, luminance: float = 0.0) -> Material:
    """Neutral Lambertian surface."""
    return material(key, Diffuse(Constant(reflectance)), luminance)


def glowing(key: str, luminance: float) -> Material:
    """Black surface that emits evenly on the side of its normal. [cd/m2]"""
    return material(key, Black(), luminance)


def mesh(key: str, vertices, triangles, paint: str) -> Mesh:
    """Triangles of one material."""
    triangles = np.ascontiguousarray(triangles, dtype=np.int32)
    vertices = np.ascontiguousarray(vertices, dtype=np.float64)
    return Mesh(key, key, vertices, triangles, (paint,), np.zeros(len(triangles), np.int32))


def quad(key: str, corner, edge_u, edge_v, paint: str) -> Mesh:
    """Parallelogram that faces edge_u x edge_v."""
    corner, u, v = (np.asarray(x, dtype=np.float64) for x in (corner, edge_u, edge_v))
    return mesh(
        key, [corner, corner + u, corner + u + v, corner + v], [[0, 1, 2], [0, 2, 3]], paint
    )


def frame(key: str, corner, edge_u, edge_v, hole_u, hole_v, paint: str) -> Mesh:
    """Rectangle with a rectangular hole; ``hole_u``, ``hole_v`` are its ranges along the edges, 0 to 1."""
    corner, u, v = (np.asarray(x, dtype=np.float64) for x in (corner, edge_u, edge_v))
    steps_u, steps_v = (0.0, *hole_u, 1.0), (0.0, *hole_v, 1.0)
    vertices = [corner + a * u + b * v for b in steps_v for a in steps_u]
    triangles = []
    for row in range(3):
        for column in range(3):
            if (row, column) == (1, 1):
                continue
            if steps_u[column] == steps_u[column + 1] or steps_v[row] == steps_v[row + 1]:
                continue
            a = 4 * row + column
            triangles += [(a, a + 1, a + 5), (a, a + 5, a + 4)]
    return mesh(key, vertices, triangles, paint)


def without(whole: Mesh, left_out: np.ndarray) -> Mesh:
    """Mesh without some of its triangles. ``left_out``: (t,) bool."""
    return replace(
        whole,
        triangles=whole.triangles[~left_out],
        material_index=whole.material_index[~left_out],
    )


def box(key: str, low, high, paint: str, inwards: bool = False) -> Mesh:
    """Axis-aligned box whose faces look outwards or inwards."""
    low, high = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    pick = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=bool)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    return mesh(key, np.where(pick, high, low), triangles[:, ::-1] if inwards else triangles, paint)


def sphere(
    key: str, centre, radius: float, paint: str, inwards=False, rings=256, caps=None, smooth=False
):
    """Sphere of triangles between ``rings`` parallels about z; ``smooth``: with the true sphere's normals.

    ``caps`` = (angle, paint): triangles within the angle [rad] from +z have another material, cut exactly there.
    """
    angles = np.linspace(0.0, np.pi, rings + 1)
    if caps is not None:
        share = int(np.clip(round(rings * caps[0] / np.pi), 2, rings - 2))
        angles = np.concatenate(
            [
                np.linspace(0.0, caps[0], share + 1),
                np.linspace(caps[0], np.pi, rings - share + 1)[1:],
            ]
        )
    around = 2 * rings
    phi = 2.0 * np.pi * np.arange(around) / around
    points = np.stack(
        [
            np.outer(np.sin(angles), np.cos(phi)),
            np.outer(np.sin(angles), np.sin(phi)),
            np.outer(np.cos(angles), np.ones(around)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    row, column = np.meshgrid(np.arange(rings), np.arange(around), indexing="ij")
    a = row * around + column
    b = row * around + (column + 1) % around
    upper = np.stack([a, a + around, b + around], axis=-1)
    lower = np.stack([a, b + around, b], axis=-1)
    # At the poles one of the two has no area.
    triangles = np.concatenate([upper[:-1].reshape(-1, 3), lower[1:].reshape(-1, 3)])
    rows = np.concatenate([row[:-1].ravel(), row[1:].ravel()])
    if inwards:
        triangles = triangles[:, ::-1]
    vertices = np.asarray(centre, dtype=np.float64) + radius * points
    made = mesh(key, vertices, triangles, paint)
    if smooth:
        normals = (-points if inwards else points)[made.triangles]
        made = replace(made, corner_normals=normals.astype(np.float32))
    if caps is None:
        return made
    slots = (rows < share).astype(np.int32)
    return replace(made, materials=(paint, caps[1]), material_index=slots)


def candela(key: str, position, intensity: float, spectrum: Spectrum = EVEN, radius=0.0):
    """Isotropic point, or sphere, of a luminous intensity. [cd]"""
    output = Output(Quantity.LUMINOUS_INTENSITY, intensity, spectrum)
    return PointLight(key, key, output, np.asarray(position, dtype=np.float64), radius)


def lumen(key: str, position, flux: float, spectrum: Spectrum = EVEN, radius=0.0):
    """Isotropic point, or sphere, of a luminous flux. [lm]"""
    output = Output(Quantity.LUMINOUS_FLUX, flux, spectrum)
    return PointLight(key, key, output, np.asarray(position, dtype=np.float64), radius)
