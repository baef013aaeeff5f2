"""Objects of a baked scene as they are shown: their triangles with a place on the pages, their colours."""

from dataclasses import dataclass

import numpy as np

from ..analysis.false_colour import nice_maximum
from ..errors import SceneError
from ..scene.material import Material
from ..scene.mesh import Mesh
from .gltf_colour import FlatColour, flatten
from .gltf_geometry import is_closed

SCALE_SAMPLE = 1 << 22
"""Most lumels that the top of the scale of false colours is found from."""

NOWHERE = -1
"""Number of no page and of no texture."""


@dataclass(frozen=True)
class Side:
    """Triangles of one side of a mesh that have an area.

    Parameters
    ----------
    rows : (t,) int array    Of the mesh.
    triangles : (t, 3) int array    Vertices as they go round on this side.
    normals : (t, 3, 3) array or None    By corner.
    page : (t,) int array    `NOWHERE` without a map.
    uv : (t, 3, 2) array or None    In 0..1 of the page, v upwards.
    """

    rows: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray | None
    page: np.ndarray
    uv: np.ndarray | None


@dataclass(frozen=True)
class ShownObject:
    """A mesh with its maps, and with its triangles as they are shown.

    Parameters
    ----------
    mesh : Mesh
    maps : list of LuxMap    None if it was not baked.
    sides : list of Side    At least one.
    colours : list of FlatColour    By material slot.
    is_double : bool    Whether the back of a triangle shows what its front does.
    """

    mesh: Mesh
    maps: list
    sides: list[Side]
    colours: list[FlatColour]
    is_double: bool


class ShownScene:
    """What is written: objects with their maps, and the pages that they lie on.

    ``left_out`` has the names of objects of which something was left out because its light is not known.

    Raises
    ------
    SceneError    A mesh, a map and the pages do not belong together, or hold numbers that are not finite.
    """

    def __init__(self, meshes: list[Mesh], materials: dict[str, Material], result):
        self.result = result
        maps: dict[str, list] = {}
        for made in result.maps:
            maps.setdefault(made.id, []).append(made)
        flat: dict[str, FlatColour] = {}
        self.objects: list[ShownObject] = []
        self.left_out: list[str] = []
        for mesh in meshes:
            if not mesh.visible_to_camera or not len(mesh.triangles):
                continue
            if not np.isfinite(mesh.vertices).all():
                raise SceneError(f"object '{mesh.name}' has vertices that are not finite")
            for key in mesh.materials:
                if key not in materials:
                    raise SceneError(
                        f"object '{mesh.name}' refers to a material that the scene does not hold ({key})"
                    )
                if key not in flat:
                    flat[key] = flatten(materials[key])
            found = maps.get(mesh.id, [])
            sides = [side for made in found for side in _sides(mesh, made.layout)]
            has_back = len(sides) > 1
            self.objects.append(
                ShownObject(
                    mesh,
                    found,
                    sides or [_bare_side(mesh)],
                    [flat[key] for key in mesh.materials],
                    not has_back and not is_closed(mesh.vertices, mesh.triangles),
                )
            )
        used = {int(n) for shown in self.objects for s in shown.sides for n in np.unique(s.page)}
        self.pages = [page for page in result.pages if page.number in used]
        missing = used - {page.number for page in self.pages} - {NOWHERE}
        if missing:
            raise SceneError(f"the bake has no page {min(missing)}, which an object lies on")
        for page in self.pages:
            if page.illuminance is None:
                raise SceneError(
                    "the bake kept its pages in files only; bake with the pages kept to write a glTF file"
                )

    def find_top(self) -> float:
        """Round number that nearly all lumels in use lie under. [lx]"""
        total = sum(page.covered.size for page in self.pages)
        step = max(1, total // SCALE_SAMPLE)
        values = [page.illuminance[page.covered][::step] for page in self.pages]
        return nice_maximum(np.concatenate(values)) if values else 1.0


def _sides(mesh: Mesh, layout) -> list[Side]:
    """Triangles of a layout, by the side that they show; a layout may hold the backs after the fronts."""
    count = len(mesh.triangles)
    sides = []
    for start in range(0, len(layout.triangles), count):
        window = slice(start, start + count)
        triangles = layout.triangles[window]
        if np.array_equal(triangles, mesh.triangles):
            sign, order = 1.0, [0, 1, 2]
        elif np.array_equal(triangles, mesh.triangles[:, ::-1]):
            sign, order = -1.0, [2, 1, 0]
        else:
            raise SceneError(
                f"the lux map of object '{mesh.name}' was made for other triangles; bake it anew"
            )
        page = layout.page[window]
        rows = np.flatnonzero(page >= 0)
        uv = layout.uv[window][rows]
        if not np.isfinite(uv).all():
            raise SceneError(f"the lux map of object '{mesh.name}' has places that are not finite")
        normals = mesh.corner_normals
        if normals is not None:
            normals = sign * np.asarray(normals)[rows][:, order]
        sides.append(Side(rows, triangles[rows], normals, page[rows], uv))
    return sides


def _bare_side(mesh: Mesh) -> Side:
    """All triangles of a mesh that was not baked."""
    rows = np.flatnonzero(mesh.areas() > 0.0)
    normals = None if mesh.corner_normals is None else np.asarray(mesh.corner_normals)[rows]
    page = np.full(len(rows), NOWHERE)
    return Side(rows, mesh.triangles[rows], normals, page, None)
