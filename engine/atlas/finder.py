"""Lumels of places that are known by shape, triangle and barycentric coordinates, as traced light lands on them."""

import numpy as np

from .layout import Atlas
from .lumels import LumelTable


class LumelFinder:
    """Finds lumels.

    Parameters
    ----------
    scene : CompiledScene
    keys : list of str    Id of the object of each layout.
    meshes : list of Mesh    Mesh of each layout.
    atlas : Atlas
    table : LumelTable
    """

    def __init__(self, scene, keys, meshes, atlas: Atlas, table: LumelTable):
        self._atlas, self._table = atlas, table
        sides = {(k, layout.is_back): n for n, (k, layout) in enumerate(zip(keys, atlas.layouts, strict=True))}  # fmt: skip
        # By shape: layouts of its front and back, and which triangle of the mesh each of its own is.
        self._shapes: dict[int, tuple[tuple[int, int], np.ndarray]] = {}
        for key, part, _ in scene.parts():
            pair = (sides.get((key, False), -1), sides.get((key, True), -1))
            if max(pair) < 0:
                continue
            mesh = meshes[max(pair)]
            own = np.arange(len(mesh.triangles))
            if len(mesh.materials) > 1:
                own = np.flatnonzero(mesh.material_index == part.slot)
            self._shapes[part.number] = (pair, own)
        first = np.concatenate([[0], np.cumsum(table.counts)])
        self._blocks: dict[tuple[int, int], list[tuple[int, int]]] = {}
        for number in range(len(table.counts)):
            place = (table.layout(number), table.page(number))
            self._blocks.setdefault(place, []).append((number, int(first[number])))

    def find(self, shape, prim, uv, back) -> np.ndarray:
        """Numbers of lumels over the whole table, -1 where there is none.

        Parameters
        ----------
        shape, prim : (m,) int array
        uv : (m, 2) array    Barycentric coordinates of the second and third corner.
        back : (m,) bool array
        """
        found = np.full(len(shape), -1, dtype=np.int64)
        for number in np.unique(shape):
            if int(number) not in self._shapes:
                continue
            layouts, triangles = self._shapes[int(number)]
            for side in (0, 1):
                mine = np.flatnonzero((shape == number) & (back == bool(side)))
                if layouts[side] >= 0 and len(mine):
                    found[mine] = self._find(layouts[side], triangles[prim[mine]], uv[mine])
        return found

    def _find(self, number: int, triangle: np.ndarray, uv: np.ndarray) -> np.ndarray:
        layout = self._atlas.layouts[number]
        weights = np.stack([1.0 - uv.sum(axis=1), uv[:, 0], uv[:, 1]], axis=1)
        place = np.einsum("mc,mcx->mx", weights, layout.uv[triangle])
        page = layout.page[triangle]
        found = np.full(len(triangle), -1, dtype=np.int64)
        for sheet in np.unique(page[page >= 0]):
            mine = np.flatnonzero(page == sheet)
            width = int(self._atlas.sizes[sheet][0])
            pixel = np.floor(place[mine]).astype(np.int64)
            flat = pixel[:, 1] * width + pixel[:, 0]
            for block, first in self._blocks.get((number, int(sheet)), ()):
                index = self._table.facts(block).index
                row = np.minimum(np.searchsorted(index, flat), len(index) - 1)
                hit = index[row] == flat
                found[mine[hit]] = first + row[hit]
        return found
