"""Surfaces of a set-up as they are drawn: flat sheets of one look, cut off near what the case is about."""

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from lumenray.engine.scene.light import AreaLight, Luminaire, PointLight, SpotLight
from lumenray.engine.scene.material import (
    Black,
    Coated,
    Conductor,
    Dielectric,
    Diffuse,
    Glossy,
    Material,
    TabulatedPane,
    ThinGlass,
    Transparent,
)
from lumenray.engine.scene.mesh import Geometry, Mesh, Placement, place
from lumenray.engine.scene.spectrum import Constant, Rgb, Tabulated

LOOKS = {
    "glowing": ((255, 205, 40), 0.92),
    "mirror": ((112, 150, 196), 0.62),
    "glass": ((128, 200, 226), 0.40),
    "opal": ((214, 196, 226), 0.70),
    "matt": ((206, 201, 192), 0.66),
    "glossy": ((178, 172, 186), 0.66),
    "black": ((134, 139, 148), 0.50),
    "opening": ((150, 200, 240), 0.12),
}
"""Colour and opacity of each kind of surface."""

NEAR = 3.0
"""A surface that is larger than so many times the region of interest does not set the scale."""

MARGIN = 0.14
"""Part of the region's size by which endless surfaces reach beyond it."""

MANY_TRIANGLES = 6000
"""Meshes of more triangles are thinned out for drawing."""

BALL_RINGS = 18
"""Rings that a sphere is drawn with."""


@dataclass
class Sheet:
    """Polygons that are drawn as one layer.

    Parameters
    ----------
    look : str    Key of `LOOKS`.
    colour : (3,) array    0 to 255.
    polygons : list of (k, 3) array    Convex.
    edges : (e, 2, 3) array    Lines that are drawn.
    normal : (3,) array or None    None: the polygons do not lie in one plane.
    """

    look: str
    colour: np.ndarray
    polygons: list[np.ndarray]
    edges: np.ndarray = field(default_factory=lambda: np.zeros((0, 2, 3)))
    normal: np.ndarray | None = None


@dataclass(frozen=True)
class Region:
    """Axis-aligned box. ``low``, ``high`` (3,) [m]"""

    low: np.ndarray
    high: np.ndarray

    @property
    def size(self) -> float:
        """Length of the diagonal. [m]"""
        return float(np.linalg.norm(self.high - self.low))

    def hold(self, points: np.ndarray) -> "Region":
        """Return the box that holds points (n, 3) too."""
        if not len(points):
            return self
        return Region(
            np.minimum(self.low, points.min(axis=0)), np.maximum(self.high, points.max(axis=0))
        )

    def grow(self, share: float) -> "Region":
        """Return a box that is larger on all sides by a share of the diagonal."""
        more = share * self.size
        return Region(self.low - more, self.high + more)


def light_places(items: Sequence) -> np.ndarray:
    """Where lights stand, (n, 3). [m]"""
    places = [item.position for item in items if isinstance(item, PointLight | SpotLight)]
    places += [
        np.asarray(item.frame)[:3, 3] for item in items if isinstance(item, AreaLight | Luminaire)
    ]
    return np.array(places, dtype=np.float64).reshape(-1, 3)


def collect_meshes(items: Sequence) -> list[Mesh]:
    """Meshes of a scene in world coordinates; area lights are rectangles of the material ``light``."""
    geometries = {item.id: item for item in items if isinstance(item, Geometry)}
    meshes = [item for item in items if isinstance(item, Mesh)]
    meshes += [
        place(geometries[item.geometry], item) for item in items if isinstance(item, Placement)
    ]
    return [_lighten(mesh) for mesh in meshes] + [
        _emitter(item) for item in items if isinstance(item, AreaLight)
    ]


def region_of_interest(meshes: Sequence[Mesh], points: np.ndarray) -> Region:
    """Box round points (n, 3), and round what stands near them; endless surfaces count with their near end. [m]"""
    boxes = [Region(mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)) for mesh in meshes]
    boxes.sort(key=lambda box: box.size)
    if len(points):
        region = Region(points.min(axis=0), points.max(axis=0))
    else:
        region = boxes.pop(0) if boxes else Region(-np.ones(3), np.ones(3))
    if region.size == 0.0 and boxes:
        corners = np.concatenate([mesh.vertices for mesh in meshes])
        away = np.linalg.norm(corners - region.low, axis=1)
        region = region.hold(corners[away <= 2.5 * away.min()])
    if region.size == 0.0:
        room = np.array([(-0.5, -0.5, 0.0), (0.5, 0.5, 1.0)])
        region = region.hold(region.low + room)
    reach = NEAR * region.size
    for box in boxes:
        near = np.stack(
            [np.clip(region.low, box.low, box.high), np.clip(region.high, box.low, box.high)]
        )
        whole = (box.high - box.low) <= reach
        near = np.where(whole, np.stack([box.low, box.high]), near)
        gap = np.maximum(np.maximum(near[0] - region.high, region.low - near[1]), 0.0)
        if np.linalg.norm(gap) <= reach:
            region = region.hold(near)
    return region


def collect_sheets(items: Sequence, meshes: Sequence[Mesh], region: Region) -> list[Sheet]:
    """Sheets of all meshes, cut off at a region."""
    materials = {item.id: item for item in items if isinstance(item, Material)}
    sheets = []
    for mesh in meshes:
        slots = np.minimum(mesh.material_index, len(mesh.materials) - 1)
        for slot in np.unique(slots):
            name = mesh.materials[slot]
            look, colour = _look(materials.get(name), name)
            corners = mesh.vertices[mesh.triangles[slots == slot]]
            sheets += [_cut(sheet, region) for sheet in _split(corners, look, colour)]
    return [sheet for sheet in sheets if sheet.polygons]


def _lighten(mesh: Mesh) -> Mesh:
    """Draw spheres and dense meshes with fewer triangles."""
    if len(mesh.triangles) <= MANY_TRIANGLES:
        return mesh
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    centre = 0.5 * (low + high)
    away = np.linalg.norm(mesh.vertices - centre, axis=1)
    if np.ptp(away) < 1e-3 * away.max():
        return _ball(mesh, centre, away.max())
    # Corners that fall into the same cell become one.
    cells = np.round((mesh.vertices - low) / max((high - low).max(), 1e-30) * 48.0)
    _, first, index = np.unique(cells, axis=0, return_index=True, return_inverse=True)
    triangles = index.reshape(-1)[mesh.triangles]
    a, b, c = triangles.T
    keep = (a != b) & (b != c) & (c != a)
    return _like(mesh, mesh.vertices[first], triangles[keep], mesh.material_index[keep])


def _ball(mesh: Mesh, centre: np.ndarray, radius: float) -> Mesh:
    """A coarse sphere; each of its triangles has the material of the nearest of the fine one."""
    theta = np.linspace(0.0, np.pi, BALL_RINGS + 1)
    phi = np.linspace(0.0, 2.0 * np.pi, 2 * BALL_RINGS, endpoint=False)
    unit = np.stack(
        [
            np.outer(np.sin(theta), np.cos(phi)),
            np.outer(np.sin(theta), np.sin(phi)),
            np.outer(np.cos(theta), np.ones_like(phi)),
        ],
        axis=-1,
    ).reshape(-1, 3)
    around = 2 * BALL_RINGS
    row, column = (x.ravel() for x in np.mgrid[0:BALL_RINGS, 0:around])
    a, b = row * around + column, row * around + (column + 1) % around
    triangles = np.concatenate(
        [np.stack([a, a + around, b + around], 1), np.stack([a, b + around, b], 1)]
    )
    vertices = centre + radius * unit
    middles = vertices[triangles].mean(axis=1)
    fine = mesh.vertices[mesh.triangles].mean(axis=1)
    slots = np.array(
        [
            mesh.material_index[np.argmin(((fine - middle) ** 2).sum(axis=1))]
            if len(mesh.materials) > 1
            else 0
            for middle in middles
        ]
    )
    return _like(mesh, vertices, triangles, slots)


def _like(mesh: Mesh, vertices, triangles, slots) -> Mesh:
    return Mesh(mesh.id, mesh.name, vertices, triangles, mesh.materials, slots)


def _emitter(light: AreaLight) -> Mesh:
    """The outline of an area light, facing the way it shines."""
    if light.shape == "rectangle":
        outline = np.array([(-1, -1), (-1, 1), (1, 1), (1, -1)], dtype=np.float64)
    else:
        angle = np.linspace(0.0, -2.0 * np.pi, 48, endpoint=False)
        outline = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    corners = np.zeros((len(outline), 3))
    corners[:, :2] = 0.5 * outline * (light.size_x, light.size_y)
    frame = np.asarray(light.frame, dtype=np.float64)
    triangles = np.array([(0, i, i + 1) for i in range(1, len(outline) - 1)])
    return Mesh(
        light.id,
        light.name,
        corners @ frame[:3, :3].T + frame[:3, 3],
        triangles,
        ("light",),
        np.zeros(len(triangles), dtype=np.int32),
    )


def _look(material: Material | None, name: str) -> tuple[str, np.ndarray]:
    """How a material is drawn."""
    if material is None:
        look = "glowing" if name == "light" else "matt"
        return look, np.array(LOOKS[look][0], dtype=np.float64)
    surface = material.surface
    colour = None
    if material.emission is not None and material.emission.luminance > 0.0:
        look = "glowing"
    elif isinstance(surface, Diffuse):
        look = "opal" if surface.transmittance is not None else "matt"
        colour = _paint(surface.reflectance) if look == "matt" else None
        if look == "matt" and surface.reflectance == Constant(0.0):
            look, colour = "black", None
    elif isinstance(surface, Glossy | Conductor):
        look = "mirror" if surface.roughness == 0.0 else "glossy"
    elif isinstance(surface, Dielectric | ThinGlass | TabulatedPane):
        look = "glass"
    elif isinstance(surface, Transparent):
        look = "opening"
    elif isinstance(surface, Black):
        look = "black"
    else:
        look = "glossy" if isinstance(surface, Coated) else "matt"
    return look, np.array(LOOKS[look][0] if colour is None else colour, dtype=np.float64)


def _paint(reflectance) -> np.ndarray | None:
    """Colour of a matt surface; None: the plain one."""
    if isinstance(reflectance, Constant):
        return np.array((214.0, 208.0, 198.0)) * (0.72 + 0.28 * reflectance.value)
    if isinstance(reflectance, Rgb):
        bands = np.array((reflectance.red, reflectance.green, reflectance.blue))
    elif isinstance(reflectance, Tabulated):
        limits = ((590.0, 700.0), (490.0, 590.0), (400.0, 490.0))
        grids = [np.linspace(*limit, 23) for limit in limits]
        bands = np.array(
            [np.interp(g, reflectance.wavelengths, reflectance.values).mean() for g in grids]
        )
    else:
        return None
    return 90.0 + 150.0 * np.clip(bands / max(bands.max(), 1e-6), 0.0, 1.0)


def _split(corners: np.ndarray, look: str, colour: np.ndarray) -> list[Sheet]:
    """Sort triangles (t, 3, 3) into flat sheets; a surface of very many directions stays one."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sizes = np.linalg.norm(normals, axis=1)
    keep = sizes > 1e-14 * max(sizes.max(initial=0.0), 1e-30)
    corners, normals = corners[keep], normals[keep] / sizes[keep, None]
    if not len(corners):
        return []
    middle = corners.reshape(-1, 3).mean(axis=0)
    span = max(np.abs(corners - middle).max(), 1e-30)
    offsets = ((corners.mean(axis=1) - middle) * normals).sum(axis=1) / span
    planes = np.round(np.column_stack([normals, offsets]), 4) + 0.0
    _, index = np.unique(planes, axis=0, return_inverse=True)
    index = index.reshape(-1)
    if index.max() >= 24:
        return [Sheet(look, colour, list(corners))]
    return [
        Sheet(look, colour, list(corners[index == k]), _outline(corners[index == k], span), n)
        for k in range(index.max() + 1)
        for n in [normals[np.argmax(index == k)]]
    ]


def _outline(corners: np.ndarray, span: float) -> np.ndarray:
    """Edges that belong to one triangle only, (e, 2, 3)."""
    pairs = np.concatenate([corners[:, (i, (i + 1) % 3)] for i in range(3)])
    low = corners.reshape(-1, 3).min(axis=0)
    keys = np.round((pairs - low) / span * 1e6).astype(np.int64)
    turned = np.array([tuple(map(tuple, sorted(pair.tolist()))) for pair in keys])
    _, first, counts = np.unique(
        turned.reshape(len(turned), -1), axis=0, return_index=True, return_counts=True
    )
    return pairs[first[counts == 1]]


def _cut(sheet: Sheet, region: Region) -> Sheet:
    """Keep what lies inside a region; cuts get no edge."""
    polygons = []
    for polygon in sheet.polygons:
        kept = polygon
        for axis in range(3):
            kept = _cut_polygon(kept, kept[:, axis] - region.low[axis])
            kept = _cut_polygon(kept, region.high[axis] - kept[:, axis])
        if len(kept) >= 3:
            polygons.append(kept)
    edges = [cut for edge in sheet.edges if (cut := _cut_edge(edge, region)) is not None]
    return Sheet(
        sheet.look, sheet.colour, polygons, np.array(edges).reshape(-1, 2, 3), sheet.normal
    )


def _cut_polygon(polygon: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Keep the part with heights of at least 0."""
    if not len(polygon) or (height >= 0.0).all():
        return polygon
    kept = []
    for i in range(len(polygon)):
        k = (i + 1) % len(polygon)
        if height[i] >= 0.0:
            kept.append(polygon[i])
        if (height[i] >= 0.0) != (height[k] >= 0.0):
            share = height[i] / (height[i] - height[k])
            kept.append(polygon[i] + share * (polygon[k] - polygon[i]))
    return np.array(kept).reshape(-1, 3)


def _cut_edge(edge: np.ndarray, region: Region) -> np.ndarray | None:
    start, along = edge[0], edge[1] - edge[0]
    first, last = 0.0, 1.0
    for axis in range(3):
        if along[axis] == 0.0:
            if not region.low[axis] <= start[axis] <= region.high[axis]:
                return None
            continue
        limits = (
            (region.low[axis] - start[axis]) / along[axis],
            (region.high[axis] - start[axis]) / along[axis],
        )
        first, last = max(first, min(limits)), min(last, max(limits))
    return np.array([start + first * along, start + last * along]) if first < last else None
