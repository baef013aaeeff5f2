"""All surfaces of a scene in a few long arrays, from which the surface at a hit is looked up.

Asking the shapes themselves would make the tracer visit every one of them for every kernel, so a scene of a thousand objects
would take a second to start any job. With look-ups by the shape's number the kernel is the same whatever the scene holds.
"""

import drjit as dr
import mitsuba as mi
import numpy as np

from ...arrays import upload

MESH, FLAT, SPHERE, TUBE = range(4)
"""Kinds of surfaces: triangles, a plane shape (rectangle or disk), a sphere, the curved side of a cylinder."""

ROOM = 1.25
"""Room for growth when an array has to become longer."""

COLUMNS = ("kind", "face", "normal", "uv", "bsdf", "emitter")
"""What is known of each shape: first triangle, first corner normals and coordinates plus 1 (0: none), plug-ins."""


def _round_up(count: int) -> int:
    """Length that whole vectors of two, three and four fill."""
    return -(-count // 12) * 12


class _Store:
    """A long array on the device of which parts are taken and given back."""

    def __init__(self, kind):
        self.kind = kind
        self.values = upload(kind, np.zeros(_round_up(1)))
        self.used = self.free = 0
        self._holes: dict[int, list[int]] = {}
        self._staged: list[tuple[int, np.ndarray]] = []

    def put(self, values: np.ndarray) -> int:
        """Take room for values (flat) and return where it begins; they arrive with `commit`."""
        count = len(values)
        holes = self._holes.get(count)
        if holes:
            start = holes.pop()
            self.free -= count
        else:
            start = self.used
            self.used += count
        self._staged.append((start, values))
        return start

    def give_back(self, start: int, count: int) -> None:
        """Let others use a part again."""
        self._holes.setdefault(count, []).append(start)
        self.free += count

    def commit(self) -> None:
        """Write what was put."""
        staged, self._staged = self._staged, []
        if staged and self.used > dr.width(self.values):
            old = np.array(self.values)
            whole = np.zeros(_round_up(int(self.used * ROOM)), dtype=old.dtype)
            whole[: len(old)] = old
            for start, values in staged:
                whole[start : start + len(values)] = values
            self.values = upload(self.kind, whole)
        else:
            for start, values in staged:
                index = dr.arange(mi.UInt32, len(values)) + dr.opaque(mi.UInt32, start)
                dr.scatter(self.values, upload(self.kind, values), index)
            dr.eval(self.values)


class SurfacePool:
    """Looks up surfaces by the number of their shape (`arrays.pointer_id`).

    ``has_grain``: whether some surface has a direction of its own, so that frames have to follow the coordinates.
    ``has_relief``: whether some surface needs to know how places follow from coordinates.
    """

    def __init__(self):
        self.has_grain = self.has_relief = False
        self._stores = {
            "positions": _Store(mi.Float),
            "faces": _Store(mi.UInt32),
            "normals": _Store(mi.Float),
            "uv": _Store(mi.Float),
        }
        self._ranges: dict[int, list[tuple[str, int, int]]] = {}
        self._rows: dict[int, tuple] = {}
        self._axes: dict[int, tuple] = {}
        self._tubes = None

    @property
    def is_wasteful(self) -> bool:
        """Whether more than half of the memory is held by nothing."""
        return any(s.free > s.used / 2 and s.free > 1 << 22 for s in self._stores.values())

    def add_mesh(self, number: int, positions, faces, normals=None, uv=None) -> None:
        """Add triangles.

        Parameters
        ----------
        number : int    Of the shape.
        positions : (v, 3) float32 array    In the scene's frame. [m]
        faces : (t, 3) array    Vertex indices.
        normals : (t, 3, 3) float32 array or None    By corner; None: flat.
        uv : (t, 3, 2) float32 array or None    By corner; None: barycentric.
        """
        self._ranges[number] = []
        first = self._take(number, "positions", positions) // 3
        face = self._take(number, "faces", np.asarray(faces, dtype=np.uint32) + np.uint32(first))
        normal = 0 if normals is None else self._take(number, "normals", normals) // 9 + 1
        coordinates = 0 if uv is None else self._take(number, "uv", uv) // 6 + 1
        self._rows[number] = (MESH, face // 3, normal, coordinates, (0.0, 0.0, 0.0))

    def add_flat(self, number: int, normal) -> None:
        """Add a plane shape by its normal (3,)."""
        self._rows[number] = (FLAT, 0, 0, 0, tuple(normal))

    def add_sphere(self, number: int, centre) -> None:
        """Add a sphere by its centre (3,) in the scene's frame. [m]"""
        self._rows[number] = (SPHERE, 0, 0, 0, tuple(centre))

    def add_tube(self, number: int, centre, axis) -> None:
        """Add the curved side of a cylinder by a point of its axis (3,) [m] and the axis' direction (3,)."""
        self._rows[number] = (TUBE, 0, 0, 0, tuple(centre))
        self._axes[number] = tuple(axis)

    def remove(self, number: int) -> None:
        """Forget a shape."""
        del self._rows[number]
        self._axes.pop(number, None)
        for name, start, count in self._ranges.pop(number, ()):
            self._stores[name].give_back(start, count)

    def commit(self, size: int, bsdfs: np.ndarray, emitters: np.ndarray, lamps) -> None:
        """Bring the tables up to date.

        Parameters
        ----------
        size : int    Of the tables.
        bsdfs, emitters : (size,) int array    Numbers of the plug-ins of every shape, 0: none.
        lamps : (size,) int array or None    Row by which the emitter that lamps share knows a shape; None: none do.
        """
        for store in self._stores.values():
            store.commit()
        table = np.zeros((size, len(COLUMNS)), dtype=np.uint32)
        vectors = np.zeros((size, 3), dtype=np.float32)
        if self._rows:
            numbers = np.fromiter(self._rows, dtype=np.int64, count=len(self._rows))
            table[numbers, :4] = [row[:4] for row in self._rows.values()]
            vectors[numbers] = [row[4] for row in self._rows.values()]
        table[:, 4], table[:, 5] = bsdfs, emitters
        self._table = upload(mi.UInt32, table)
        self._lamps = None if lamps is None else upload(mi.Float, lamps)
        self._vectors = upload(mi.Float, vectors)
        axes = np.zeros_like(vectors)
        for number, axis in self._axes.items():
            axes[number] = axis
        self._tubes = upload(mi.Float, axes) if self._axes else None

    def triangles(self, number: int) -> np.ndarray:
        """Corners of a mesh's triangles in the scene's frame. (t, 3, 3) float32 [m]"""
        ranges = {name: (start, count) for name, start, count in self._ranges[number]}
        start, count = ranges["faces"]
        faces = self._host("faces")[start : start + count].reshape(-1, 3)
        return self._host("positions").reshape(-1, 3)[faces]

    def _host(self, name: str) -> np.ndarray:
        # Lengths are whole numbers of vectors, so the view below never copies.
        return np.array(self._stores[name].values, copy=False)

    def _take(self, number: int, name: str, values) -> int:
        dtype = np.uint32 if name == "faces" else np.float32
        flat = np.ascontiguousarray(values, dtype=dtype).reshape(-1)
        start = self._stores[name].put(flat)
        self._ranges[number].append((name, start, len(flat)))
        return start

    # ---- look-up, inside kernels ----

    def _column(self, number, name: str, active):
        place = number * len(COLUMNS) + COLUMNS.index(name)
        return dr.gather(mi.UInt32, self._table, place, active)

    def bsdf(self, si, active):
        """Return the surface model at an interaction."""
        number = dr.reinterpret_array(mi.UInt32, si.shape)
        return dr.reinterpret_array(mi.BSDFPtr, self._column(number, "bsdf", active))

    def emitter(self, si, active):
        """Return the emitter at an interaction, null where the surface does not glow."""
        number = dr.reinterpret_array(mi.UInt32, si.shape)
        return dr.reinterpret_array(mi.EmitterPtr, self._column(number, "emitter", active))

    def interaction(self, hit, ray, active):
        """Surface at a preliminary hit.

        Returns
        -------
        SurfaceInteraction3f    With position, normals, coordinates, shape and directions; no derivatives but those of meshes
            by their coordinates, where something has a relief.
        """
        valid = mi.Bool(active) & hit.is_valid()
        number = dr.reinterpret_array(mi.UInt32, hit.shape)
        kind = self._column(number, "kind", valid)
        is_mesh = valid & (kind == MESH)
        face = self._column(number, "face", is_mesh) + hit.prim_index
        corners = dr.gather(mi.Vector3u, self._stores["faces"].values, face, is_mesh)
        positions = self._stores["positions"].values
        a, b, c = (dr.gather(mi.Point3f, positions, corner, is_mesh) for corner in corners)
        v, w = hit.prim_uv.x, hit.prim_uv.y
        u = 1.0 - v - w
        point = mi.Point3f(a * u + b * v + c * w)
        normal = dr.normalize(dr.cross(b - a, c - a))
        shading, uv = mi.Normal3f(normal), mi.Point2f(hit.prim_uv)

        first = self._column(number, "normal", is_mesh)
        smooth = is_mesh & (first > 0)
        place = (first - 1 + hit.prim_index) * 3
        stored = self._stores["normals"].values
        na, nb, nc = (dr.gather(mi.Normal3f, stored, place + k, smooth) for k in range(3))
        bent = na * u + nb * v + nc * w
        smooth &= dr.squared_norm(bent) > 0.0
        shading = dr.select(smooth, dr.normalize(bent), shading)

        first = self._column(number, "uv", is_mesh)
        laid = is_mesh & (first > 0)
        place = (first - 1 + hit.prim_index) * 3
        stored = self._stores["uv"].values
        ta, tb, tc = (dr.gather(mi.Point2f, stored, place + k, laid) for k in range(3))
        uv = dr.select(laid, ta * u + tb * v + tc * w, uv)

        is_body = valid & (kind != MESH)
        vector = dr.gather(mi.Vector3f, self._vectors, number, is_body)
        on_ray = ray(hit.t)
        outwards = self._outwards(kind, number, vector, on_ray, is_body)
        point = dr.select(is_body, on_ray, point)
        normal = dr.select(is_body, mi.Normal3f(outwards), normal)
        shading = dr.select(is_body, mi.Normal3f(outwards), shading)

        si = dr.zeros(mi.SurfaceInteraction3f)
        si.t = dr.select(valid, hit.t, dr.inf)
        si.time, si.wavelengths = mi.Float(0.0), ray.wavelengths
        if self._lamps is not None:
            # An emitter of many lamps is told by the time which of them is meant.
            si.time = dr.gather(mi.Float, self._lamps, number, valid)
        si.p, si.n, si.uv = point, mi.Normal3f(normal), uv
        si.sh_frame = mi.Frame3f(mi.Vector3f(shading))
        if self.has_grain:
            si.sh_frame = _grain_frame(shading, (b - a, c - a), (tb - ta, tc - ta), laid)
        if self.has_relief:
            si.dp_du, si.dp_dv = _derivatives((b - a, c - a), (tb - ta, tc - ta), laid)
        si.wi = dr.select(valid, si.to_local(-ray.d), -ray.d)
        si.shape, si.prim_index = hit.shape, hit.prim_index
        return si

    def _outwards(self, kind, number, vector, point, active):
        """Normal of a body at a point of it. ``vector``: what is known of it."""
        away = point - mi.Point3f(vector)
        made = dr.select(kind == SPHERE, dr.normalize(away), vector)
        if self._tubes is None:
            return made
        is_tube = active & (kind == TUBE)
        axis = dr.gather(mi.Vector3f, self._tubes, number, is_tube)
        return dr.select(is_tube, dr.normalize(away - axis * dr.dot(axis, away)), made)


def _derivatives(edges, coordinates, laid):
    """How places follow from U and V, 0 where they do not; parameters as of `_grain_frame`. (Vector3f, Vector3f) [m]"""
    (first, second), (u, v) = edges, coordinates
    area = u.x * v.y - v.x * u.y
    share = dr.select(laid & (area != 0.0), 1.0 / area, 0.0)
    return (first * v.y - second * u.y) * share, (second * u.x - first * v.x) * share


def _grain_frame(normal, edges, coordinates, laid):
    """Frame about a normal whose first axis goes along U, or along the world's x or y where nothing is laid out.

    Parameters
    ----------
    normal : Normal3f
    edges, coordinates : pair of Vector3f, pair of Vector2f    Two sides of the triangle, and what they are in U and V.
    laid : Bool    Whether there are coordinates.
    """
    (first, second), (u, v) = edges, coordinates
    area = u.x * v.y - v.x * u.y
    along = dr.select(area < 0.0, -1.0, 1.0) * (first * v.y - second * u.y)
    along -= normal * dr.dot(normal, along)
    length = dr.norm(along)
    is_usable = laid & (length > 1e-12 * (dr.norm(first) + dr.norm(second))) & (area != 0.0)
    other = dr.select(dr.abs(normal.x) > 0.99, mi.Vector3f(0, 1, 0), mi.Vector3f(1, 0, 0))
    other = dr.normalize(other - normal * dr.dot(normal, other))
    first_axis = dr.select(is_usable, along / dr.maximum(length, 1e-30), other)
    return mi.Frame3f(first_axis, mi.Vector3f(dr.cross(normal, first_axis)), mi.Vector3f(normal))
