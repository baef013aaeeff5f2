"""A piece of cloth as a mesh: its yarns as tubes, for pictures from so near that threads are seen.

A piece is whole repeats of the weave. Copies of it beside each other join without a seam, so one piece can be instanced
over a surface. Yarns are those that the tables are computed of (`tubes`).
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import SceneError
from ..reading.whole_file import write_whole
from .composition import Cloth
from .tubes import lay_out

CORNERS, RINGS = 16, 12
"""Corners around a yarn, and rings of each crossing. [-]"""

MOST_QUADS = 4_000_000

KINDS = ("warp", "weft", "pile")


@dataclass(frozen=True, eq=False)
class ClothMesh:
    """A piece of cloth.

    Parameters
    ----------
    points : (n, 3) float64 array    The warp runs along y, the front is +z. [m]
    normals : (n, 3) float64 array    Outwards.
    quads : (m, 4) int64 array    Counter-clockwise as seen from outside.
    kinds : (m,) int array    Yarn of each: place in `KINDS`.
    size : (2,) array    Of the piece along x and y, by which copies are shifted. [m]
    """

    points: np.ndarray
    normals: np.ndarray
    quads: np.ndarray
    kinds: np.ndarray
    size: np.ndarray


def mesh_of(
    cloth: Cloth, repeats: int = 1, corners: int = CORNERS, rings: int = RINGS
) -> ClothMesh:
    """Make a piece of cloth.

    Parameters
    ----------
    repeats : int    Of the weave along both.

    Raises
    ------
    SceneError    It would have more faces than `MOST_QUADS`, or its pile is too dense.
    """
    ends, picks = (repeats * count for count in cloth.weave.is_warp_up.shape)
    wanted = corners * rings * (ends + picks) * max(ends, picks)
    if wanted > MOST_QUADS:
        raise SceneError(
            f"{ends} x {picks} crossings of '{cloth.name}' have {wanted} faces, expected {MOST_QUADS} at most"
        )
    tubes = lay_out(cloth, repeats, 0, rings)
    count, length = tubes.widths.shape
    turn = 2.0 * np.pi * np.arange(corners) / corners
    across = np.cross(tubes.tangents, tubes.ups)[:, :, None]
    up, a, b = (
        tubes.ups[:, :, None],
        *(0.5 * each[:, :, None, None] for each in (tubes.widths, tubes.heights)),
    )
    cosine, sine = np.cos(turn)[:, None], np.sin(turn)[:, None]
    points = tubes.centres[:, :, None] + b * cosine * up + a * sine * across
    normals = a * cosine * up + b * sine * across
    normals /= np.linalg.norm(normals, axis=3, keepdims=True)
    tube, ring, corner = np.meshgrid(
        np.arange(count), np.arange(length - 1), np.arange(corners), indexing="ij"
    )
    first = (tube * length + ring) * corners
    here, following = first + corner, first + (corner + 1) % corners
    quads = np.stack([here, following, following + corners, here + corners], axis=-1)
    kinds = np.repeat(tubes.kinds, (length - 1) * corners)
    return ClothMesh(
        1e-3 * points.reshape(-1, 3),
        normals.reshape(-1, 3),
        quads.reshape(-1, 4),
        kinds,
        1e-3 * tubes.size,
    )


def write_obj(path: Path, mesh: ClothMesh, name: str) -> None:
    """Write a mesh as Wavefront OBJ, an object with a material for each kind of yarn."""
    lines = [
        f"# {name}, metres; copies join when shifted by {mesh.size[0]:.9g} and {mesh.size[1]:.9g}"
    ]
    lines += [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in mesh.points]
    lines += [f"vn {x:.4f} {y:.4f} {z:.4f}" for x, y, z in mesh.normals]
    for kind in np.unique(mesh.kinds):
        lines += [f"o {KINDS[kind]}", f"usemtl {KINDS[kind]}"]
        own = mesh.quads[mesh.kinds == kind] + 1
        lines += ["f " + " ".join(f"{corner}//{corner}" for corner in quad) for quad in own]
    with write_whole(path) as file:
        file.write(("\n".join(lines) + "\n").encode())
