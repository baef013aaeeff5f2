"""Luminous openings as shapes that rays meet."""

from dataclasses import dataclass

import mitsuba as mi
import numpy as np

from ...arrays import upload
from ...luminaires.emitters.palette import Row

SIDES, RINGS = 64, 32
"""Facets around round bodies and from pole to pole. The light of a body depends on the ray alone, so they show only as a
slightly cornered outline."""


@dataclass
class OpeningBody:
    """Shape of an opening, and what a `SurfacePool` has to know of it: a normal, a centre or triangles."""

    shape: object
    normal: np.ndarray | None = None
    centre: np.ndarray | None = None
    positions: np.ndarray | None = None
    faces: np.ndarray | None = None

    def put_into(self, pool, number: int) -> None:
        """Tell a `SurfacePool` about the shape."""
        if self.normal is not None:
            pool.add_flat(number, self.normal)
        elif self.centre is not None:
            pool.add_sphere(number, self.centre)
        else:
            pool.add_mesh(number, self.positions, self.faces)


def make_body(shape: str, row: Row, nothing) -> OpeningBody:
    """Make the shape of an opening, which others' light passes.

    Parameters
    ----------
    shape : str    One of `scene.distribution.SHAPES`, not ``point``.
    row : Row    Where it is and how large.
    nothing : mi.BSDF    What it is made of for others' light; one for all, since every surface model is part of kernels.
    """
    if shape in {"rectangle", "ellipse"}:
        frame = np.eye(4)
        frame[:3, :3] = row.axes * np.array([row.half[0], row.half[1], 1.0])
        frame[:3, 3] = row.centre
        kind = "disk" if shape == "ellipse" else "rectangle"
        place = mi.ScalarTransform4f([list(line) for line in frame])
        made = mi.load_dict({"type": kind, "to_world": place, "bsdf": nothing})
        return OpeningBody(made, normal=row.axes[:, 2])
    if shape == "ellipsoid" and np.ptp(row.half) <= 1e-6 * row.half.max():
        place = [float(x) for x in row.centre]
        made = mi.load_dict(
            {"type": "sphere", "center": place, "radius": row.half[0], "bsdf": nothing}
        )
        return OpeningBody(made, centre=row.centre)
    unit, faces = {"box": _box, "ellipsoid": _sphere, "cylinder": _cylinder}[shape]()
    positions = (unit * row.half) @ row.axes.T + row.centre
    if np.linalg.det(row.axes) < 0.0:
        faces = faces[:, ::-1]
    properties = mi.Properties()
    properties["bsdf"] = nothing
    properties["face_normals"] = True
    made = mi.Mesh("opening", len(positions), len(faces), properties, False, False)
    values = mi.traverse(made)
    values["vertex_positions"] = upload(mi.Float, positions)
    values["faces"] = upload(mi.UInt32, faces)
    values.update()
    return OpeningBody(made, positions=positions, faces=faces)


def _box() -> tuple[np.ndarray, np.ndarray]:
    """Cube of half size 1 as vertices and triangles that look outwards."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = [[a, b, c] for a, b, c, _ in quads] + [[a, c, d] for a, _, c, d in quads]
    return corners, np.array(faces)


def _rings(heights, radii) -> tuple[np.ndarray, np.ndarray]:
    """Surface of revolution about z, from the lowest height up. Triangles look outwards."""
    angle = 2.0 * np.pi * np.arange(SIDES) / SIDES
    around = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    vertices = np.concatenate(
        [
            np.column_stack([r * around, np.full(SIDES, z)])
            for z, r in zip(heights, radii, strict=True)
        ]
    )
    following = np.roll(np.arange(SIDES), -1)
    faces = []
    for ring in range(len(heights) - 1):
        low, high = ring * SIDES, (ring + 1) * SIDES
        a, b = low + np.arange(SIDES), low + following
        c, d = high + following, high + np.arange(SIDES)
        faces += [np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)]
    return vertices, np.concatenate(faces)


def _sphere() -> tuple[np.ndarray, np.ndarray]:
    polar = np.linspace(0.0, np.pi, RINGS + 1)
    return _rings(-np.cos(polar), np.sin(polar))


def _cylinder() -> tuple[np.ndarray, np.ndarray]:
    return _rings([-1.0, -1.0, 1.0, 1.0], [0.0, 1.0, 1.0, 0.0])
