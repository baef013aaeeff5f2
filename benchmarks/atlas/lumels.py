"""Where lumels lie on surfaces, found from the texture coordinates of a result alone, as whoever uses the maps would."""

import hashlib
from dataclasses import dataclass

import numpy as np

from ...engine.baking.order import BakeResult, LuxMap
from ...engine.scene.mesh import Mesh
from ...engine.transport.paths.illuminance import Receivers

FINENESS = 8
"""Places along the side of a lumel, of which no two lie in a row or column: edges of shadows run along lumels."""

LEAST_SHARE = 0.25
"""Lumels of which less lies on a surface are left out: so few places say too little about them."""

CHUNK = 1 << 22
"""Candidates that are looked at in one go."""


@dataclass(frozen=True, eq=False)
class LumelPlaces:
    """Lumels and the places in each, evenly spread over its part of the surface.

    Parameters
    ----------
    page, x, y : (n,) int array    Which lumel of which page.
    start, count : (n,) int array    Range of places of every lumel.
    positions, normals, geometric_normals : (k, 3) float64 array    World space. [m]
    area : (n,) float64 array    Surface in each lumel. [m2]
    is_inner : (n,) bool array    Whether all of the lumel and of its neighbours lies on the surface, so that every program
        means the same by it.
    """

    page: np.ndarray
    x: np.ndarray
    y: np.ndarray
    start: np.ndarray
    count: np.ndarray
    positions: np.ndarray
    normals: np.ndarray
    geometric_normals: np.ndarray
    area: np.ndarray
    is_inner: np.ndarray

    def __len__(self) -> int:
        """How many lumels."""
        return len(self.page)

    def receivers(self) -> Receivers:
        """As the engine's estimators take them."""
        return Receivers(
            self.positions,
            self.normals,
            self.geometric_normals,
            self.start,
            self.count,
            self.area,
        )

    def take(self, rows) -> "LumelPlaces":
        """Lumels by their rows."""
        rows = np.asarray(rows)
        count = self.count[rows]
        start = np.concatenate([[0], np.cumsum(count)[:-1]]).astype(np.int64)
        # Places of lumel i are start[i] + 0, 1, ...
        number = np.repeat(self.start[rows] - start, count) + np.arange(int(count.sum()))
        return LumelPlaces(
            self.page[rows],
            self.x[rows],
            self.y[rows],
            start,
            count,
            self.positions[number],
            self.normals[number],
            self.geometric_normals[number],
            self.area[rows],
            self.is_inner[rows],
        )

    def values(self, result: BakeResult) -> np.ndarray:
        """Illuminance of the lumels in a result with the same layout. (n,) [lx]"""
        return self._read(result, "illuminance")

    def errors(self, result: BakeResult) -> np.ndarray:
        """Stated standard errors. (n,) [lx]"""
        return self._read(result, "standard_error")

    def _read(self, result: BakeResult, name: str) -> np.ndarray:
        made = np.zeros(len(self))
        for page in result.pages:
            mine = self.page == page.number
            made[mine] = getattr(page, name)[self.y[mine], self.x[mine]]
        return made

    def digest(self) -> str:
        """Hexadecimal SHA-256 of where the places lie, to a micrometre."""
        digest = hashlib.sha256()
        for array in (self.positions, self.normals, self.geometric_normals):
            digest.update(np.round(array * 1e6).astype(np.int64).tobytes())
        for array in (self.start, self.count):
            digest.update(array.astype(np.int64).tobytes())
        return digest.hexdigest()


def find_places(result: BakeResult, meshes: dict[str, Mesh]) -> LumelPlaces:
    """Find the places of all computed lumels of a result.

    Parameters
    ----------
    result : BakeResult    With its pages.
    meshes : dict of str to Mesh    By id.
    """
    parts = [
        _of_map(made, page, meshes[made.id], FINENESS)
        for made in result.maps
        for page in result.pages
        if (made.layout.page == page.number).any()
    ]
    return _join([part for part in parts if len(part)])


def _of_map(made: LuxMap, page, mesh: Mesh, fineness: int) -> LumelPlaces:
    """Places of one object's lumels on one page."""
    rows = np.flatnonzero(made.layout.page == page.number)
    size = np.array([page.width, page.height]) * fineness
    uv = made.layout.uv[rows].astype(np.float64) * size
    triangle, cell, bary = _cover(uv, int(size[0]), int(size[1]), fineness)
    y, x = np.divmod(cell, size[0])
    lumel = (y // fineness) * page.width + x // fineness
    order = np.argsort(lumel, kind="stable")
    lumel, triangle, bary = lumel[order], triangle[order], bary[order]
    index, start, count = np.unique(lumel, return_index=True, return_counts=True)

    corners = mesh.vertices[mesh.triangles[rows]].astype(np.float64)
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(across, axis=1)
    geometric = (across / np.maximum(length, 1e-300)[:, None])[triangle]
    normals = geometric
    if mesh.corner_normals is not None:
        bent = mesh.corner_normals[rows][triangle].astype(np.float64)
        normals = np.einsum("kc,kcx->kx", bary, bent)
        normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    edge = uv[:, 1:] - uv[:, :1]
    flat = 0.5 * np.abs(edge[:, 0, 0] * edge[:, 1, 1] - edge[:, 0, 1] * edge[:, 1, 0])
    scale = np.where(flat > 0.0, 0.5 * length / np.maximum(flat, 1e-300), 0.0)
    area = np.add.reduceat(scale[triangle], start) if len(start) else np.zeros(0)

    full = np.zeros(page.width * page.height, dtype=bool)
    full[index] = count == fineness**2
    is_inner = _eroded(full.reshape(page.height, page.width)).ravel()[index]
    places = LumelPlaces(
        np.full(len(index), page.number),
        index % page.width,
        index // page.width,
        start,
        count,
        np.einsum("kc,kcx->kx", bary, corners[triangle]),
        normals,
        geometric,
        area,
        is_inner,
    )
    mine = (page.object == made.number) & page.covered
    kept = mine.ravel()[index] & (count >= LEAST_SHARE * fineness**2)
    return places.take(np.flatnonzero(kept))


def _cover(corners: np.ndarray, width: int, height: int, fineness: int):
    """Cells whose place lies in a triangle, every cell at most once.

    Parameters
    ----------
    corners : (t, 3, 2) float64 array    In cells.
    fineness : int    Cells along the side of a lumel.

    Returns
    -------
    triangle (k,), flat cell (k,), barycentric coordinates (k, 3)
    """
    low = np.clip(np.floor(corners.min(axis=1)), 0, [width, height]).astype(np.int64)
    high = np.clip(np.floor(corners.max(axis=1)) + 1, 0, [width, height]).astype(np.int64)
    size = np.maximum(high - low, 0)
    counts = size[:, 0] * size[:, 1]
    ends = np.cumsum(counts)
    found = [(np.zeros(0, np.int64), np.zeros(0, np.int64), np.zeros((0, 3)))]
    for begin in range(0, int(ends[-1]) if len(ends) else 0, CHUNK):
        number = np.arange(begin, min(begin + CHUNK, int(ends[-1])))
        triangle = np.searchsorted(ends, number, side="right")
        dy, dx = np.divmod(number - (ends[triangle] - counts[triangle]), size[triangle, 0])
        x, y = low[triangle, 0] + dx, low[triangle, 1] + dy
        places = np.stack([x + _aside(y, fineness), y + _aside(x, fineness)], axis=1)
        bary = _barycentric(corners[triangle], places)
        inside = (bary >= -1e-9).all(axis=1)
        found.append((triangle[inside], (y * width + x)[inside], bary[inside]))
    triangle, cell, bary = (np.concatenate(parts) for parts in zip(*found, strict=True))
    cell, first = np.unique(cell, return_index=True)
    return triangle[first], cell, np.clip(bary[first], 0.0, 1.0)


def _aside(number: np.ndarray, fineness: int) -> np.ndarray:
    """Where in its cell a place lies, by the number of the cell the other way. (k,)"""
    return (number % fineness + 0.5) / fineness


def _barycentric(corners: np.ndarray, points: np.ndarray) -> np.ndarray:
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]

    def cross(p, q):
        return p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]

    whole = cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        v = cross(points - a, c - a) / whole
        w = cross(b - a, points - a) / whole
    bary = np.stack([1.0 - v - w, v, w], axis=1)
    return np.where(np.isfinite(bary), bary, -1.0)


def _eroded(mask: np.ndarray) -> np.ndarray:
    """Pixels that are set with all their eight neighbours."""
    padded = np.pad(mask, 1)
    made = mask.copy()
    for dy in range(3):
        for dx in range(3):
            made &= padded[dy : dy + mask.shape[0], dx : dx + mask.shape[1]]
    return made


def _join(parts: list[LumelPlaces]) -> LumelPlaces:
    starts = np.cumsum([0, *(len(part.positions) for part in parts)])
    return LumelPlaces(
        *(
            np.concatenate(
                [
                    getattr(part, name) + (start if name == "start" else 0)
                    for part, start in zip(parts, starts, strict=False)
                ]
            )
            if name != "is_inner"
            else np.concatenate([part.is_inner for part in parts])
            for name in LumelPlaces.__dataclass_fields__
        )
    )


def draw_rows(places: LumelPlaces, allowed: np.ndarray, count: int, seed: int) -> np.ndarray:
    """Draw so many of the allowed lumels, each as likely as any other; in ascending order."""
    rows = np.flatnonzero(allowed)
    if len(rows) <= count:
        return rows
    return np.sort(np.random.default_rng(seed).choice(rows, count, replace=False))


def hidden_share(places: LumelPlaces, probe) -> np.ndarray:
    """Share of every lumel's places that lie inside a solid. (n,)

    Parameters
    ----------
    probe : callable    ``probe(positions, normals) -> (k,) bool``: whether places are inside.
    """
    inside = probe(places.positions, places.geometric_normals).astype(np.float64)
    return np.add.reduceat(inside, places.start) / places.count
