"""Objects of the scene description as Mitsuba shapes: one for each material that an object shows."""

from dataclasses import dataclass, field

import mitsuba as mi
import numpy as np

from ...arrays import pointer_id, upload
from ...errors import SceneError
from ...luminaires.emitters.portals import Portal, find_portals
from ...requirements.facts import pictures
from ...scene.material import CATCHER, HOLDOUT, Material
from ...scene.mesh import Geometry, Mesh, find_uv_map
from . import emission
from .compiled_light import surface_emitter
from .lights import Source
from .material_palette import MaterialPalette
from .mirrors import Plane, find_planes

SAME_NORMAL, SAME_PLACE = 0.999999, 1e-5
"""From which cosine on triangles face the same way, and up to which part of their size corners are the same. [-]"""


@dataclass
class Part:
    """Triangles of one object that share a material.

    ``source``: its emission, None when it does not glow; ``mirrors``: its planes in the world if it is a plane mirror or a
    flat pane, and ``planes``: which of them each triangle lies in, -1: none; ``meets_light``, ``meets_camera``: which rays
    meet it; ``owner``: the material by which its light is switched.
    """

    shape: object
    number: int
    slot: int
    material: str
    triangles: int
    is_transparent: bool
    source: Source | None
    mirrors: list[Plane] = field(default_factory=list)
    planes: np.ndarray | None = None
    meets_light: bool = True
    meets_camera: bool = True
    owner: str = ""


@dataclass
class Body:
    """An object at work.

    ``low``, ``high`` (3,): its bounds in the world [m]; ``panes``: its flat panes, in the world; ``is_split``: whether the
    camera would see other surfaces of it than light meets.
    """

    item: object
    geometry: Geometry | None
    low: np.ndarray
    high: np.ndarray
    parts: list[Part] = field(default_factory=list)
    panes: list[Portal] = field(default_factory=list)
    is_split: bool = False

    def is_moved(self, item, geometry) -> bool:
        """Tell whether the triangles of the object's new state stand elsewhere or are others."""
        old = self.item
        if type(item) is not type(old):
            return True
        if isinstance(item, Mesh):
            return item is not old
        return (
            geometry is not self.geometry
            or item.meets_light != old.meets_light
            or is_met(item) != is_met(old)
            or item.is_holdout != old.is_holdout
            or item.is_catcher != old.is_catcher
            or (self.is_split and item.visible_to_camera != old.visible_to_camera)
            or not np.array_equal(item.frame, old.frame)
        )


def is_met(item) -> bool:
    """Tell whether any ray meets an object; what none meets can still be baked."""
    return item.meets_light or item.visible_to_camera


def check_mesh(mesh: Mesh, materials: dict[str, Material]) -> None:
    """Refuse index errors before they reach native code, where they would end the process."""
    for key in mesh.materials:
        if key not in materials:
            raise SceneError(
                f"object '{mesh.name}' refers to a material that the scene does not hold ({key})"
            )
    if not np.all(np.isfinite(mesh.vertices)):
        raise SceneError(f"object '{mesh.name}' has a vertex that is not a finite number")
    if len(mesh.triangles) and (
        mesh.triangles.min() < 0 or mesh.triangles.max() >= len(mesh.vertices)
    ):
        raise SceneError(
            f"object '{mesh.name}' has a triangle that names a vertex outside its list"
        )
    if len(mesh.material_index) and (
        mesh.material_index.min() < 0 or mesh.material_index.max() >= len(mesh.materials)
    ):
        raise SceneError(
            f"object '{mesh.name}' has a triangle in a material slot that does not exist"
        )


def needs_new_shape(old: Material, new: Material) -> bool:
    """Tell whether a change of material reaches further than the surface of a shape."""
    if old.seen is not None and new.seen is not None and needs_new_shape(old.seen, new.seen):
        return True
    return (
        (old.seen is None) != (new.seen is None)
        or old.surface.passes_straight != new.surface.passes_straight
        or old.surface.is_window != new.surface.is_window
        or old.surface.is_mirror != new.surface.is_mirror
        or old.surface.is_mirroring_pane != new.surface.is_mirroring_pane
        or uv_map_of(old) != uv_map_of(new)
        or not _glows_alike(old.emission, new.emission)
    )


def _glows_alike(old, new) -> bool:
    if not is_glowing(old) or not is_glowing(new):
        return is_glowing(old) == is_glowing(new)
    if old.two_sided != new.two_sided:
        return False
    return old.pattern is new.pattern or (
        old.pattern is not None and old.pattern.is_same(new.pattern)
    )


def is_glowing(glow) -> bool:
    """Tell whether an emission gives light."""
    return glow is not None and glow.luminance > 0.0


def reglow(part: Part, old: Material, new: Material) -> None:
    """Change the light of a glowing part in place."""
    if part.source is None:
        return
    made = emission.luminous(new.emission.luminance, new.emission.spectrum)
    part.source.emitter.radiance = mi.load_dict(made.texture())
    part.source.density = made.density
    part.source.flux *= new.emission.luminance / old.emission.luminance


def extent(item, geometry: Geometry | None) -> tuple[np.ndarray, np.ndarray]:
    """Corners of an object's bounds: of its triangles, or of its geometry's box where it stands. (3,), (3,) [m]"""
    points = item.vertices if geometry is None and isinstance(item, Mesh) else None
    if points is None:
        if geometry is None or len(geometry.vertices) == 0:
            return np.full(3, np.inf), np.full(3, -np.inf)
        box = np.stack([geometry.vertices.min(axis=0), geometry.vertices.max(axis=0)])
        corners = np.stack(np.meshgrid(*box.T.astype(np.float64)), axis=-1).reshape(-1, 3)
        frame = np.asarray(item.frame, dtype=np.float64)
        points = corners @ frame[:3, :3].T + frame[:3, 3]
    elif len(points) == 0:
        return np.full(3, np.inf), np.full(3, -np.inf)
    return points.min(axis=0), points.max(axis=0)


def make_body(
    item, geometry, mesh: Mesh, origin: np.ndarray, material_palette: MaterialPalette, pool
) -> Body:
    """Build the shapes of an object and put their surfaces into the pool.

    Parameters
    ----------
    item : Placement or Mesh    As the scene holds it.
    geometry : Geometry or None    Of a placement.
    mesh : Mesh    The object in the world.
    origin : (3,) array    Of the compiled scene's frame. [m]
    material_palette : MaterialPalette    Holds all materials of the object.
    pool : SurfacePool
    """
    body = Body(item, geometry, *extent(item, geometry))
    body.is_split = (
        item.is_holdout
        or item.is_catcher
        or any(material_palette.item(key).seen is not None for key in mesh.materials)
    )
    if len(mesh.triangles) == 0 or not is_met(item):
        return body
    only = len(mesh.materials) == 1
    for slot, key in enumerate(mesh.materials):
        triangles = None if only else np.flatnonzero(mesh.material_index == slot)
        if not only and len(triangles) == 0:
            continue
        material = material_palette.item(key)
        for met, meets_light, meets_camera in _surfaces_of(item, material):
            part = _make_part(mesh, slot, met, triangles, origin, material_palette, pool)
            part.meets_light, part.meets_camera, part.owner = meets_light, meets_camera, key
            body.parts.append(part)
        if material.surface.is_window:
            used = mesh.triangles if only else mesh.triangles[triangles]
            body.panes += find_portals([(mesh.vertices, used)])
    return body


def _surfaces_of(item, material: Material) -> list[tuple[Material, bool, bool]]:
    """What rays meet of a material of an object, and whether those of light and of the camera do."""
    seen = HOLDOUT if item.is_holdout else CATCHER if item.is_catcher else material.seen
    if seen is None or not item.visible_to_camera:
        # Whether the camera sees the whole object may change without new shapes.
        return [(material, item.meets_light, True)]
    lit = [(material, True, False)] if item.meets_light else []
    return [*lit, (seen, False, True)]


def _make_part(mesh, slot, material: Material, triangles, origin, material_palette, pool) -> Part:
    properties = mi.Properties()
    # The surface is looked up in the pool; without one Mitsuba would make a new one for every shape.
    properties["bsdf"] = material_palette.palette
    used = mesh.triangles if triangles is None else mesh.triangles[triangles]
    source = None
    if is_glowing(material.emission):
        source = _make_source(mesh, used, material, origin, material_palette)
        if source is not None:
            properties["emitter"] = source.emitter
    positions = (mesh.vertices - origin).astype(np.float32)
    faces = used
    if triangles is not None:
        kept, faces = np.unique(used, return_inverse=True)
        positions, faces = positions[kept], faces.reshape(-1, 3)
    uv = find_uv_map(mesh.uv_maps, uv_map_of(material))
    if uv is not None and triangles is not None:
        uv = uv[triangles]
    normals = mesh.corner_normals
    if normals is not None and triangles is not None:
        normals = normals[triangles]
    # Only sampling of a glowing pattern asks the shape itself for coordinates, which then need corners of their own.
    pattern = source is not None and material.emission.pattern is not None and uv is not None
    if pattern:
        shape = _make_shape(
            mesh.name, positions[faces].reshape(-1, 3), np.arange(faces.size), properties, uv
        )
    else:
        shape = _make_shape(mesh.name, positions, faces, properties)
    number = pointer_id(shape)
    pool.add_mesh(number, positions, faces, normals, uv)
    transparent = material.surface.passes_straight
    part = Part(shape, number, slot, material.id, len(used), transparent, source)
    is_pane = material.surface.is_mirroring_pane
    if is_pane or material.surface.is_mirror:
        part.mirrors, part.planes = _find_mirrors(mesh, used, normals, is_pane)
    return part


def _find_mirrors(mesh, used, normals, is_pane) -> tuple[list[Plane], np.ndarray | None]:
    """Planes of a mirror or pane and those of its triangles, none when it is curved or shaded as if it were."""
    if normals is not None:
        corners = mesh.vertices[used]
        flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        flat /= np.maximum(np.linalg.norm(flat, axis=1, keepdims=True), 1e-300)
        if np.abs(np.einsum("tci,ti->tc", normals, flat)).min(initial=1.0) < 0.999999:
            return [], None
    return find_planes(mesh.vertices, used, is_pane)


def _make_source(
    mesh, used, material: Material, origin, material_palette: MaterialPalette
) -> Source | None:
    corners = mesh.vertices[used]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = 0.5 * np.linalg.norm(normal, axis=1)
    area = float(areas.sum())
    if area <= 0.0:
        return None
    glow = material.emission
    luminance = emission.luminous(glow.luminance, glow.spectrum)
    pattern = (
        None if glow.pattern is None else material_palette.make.picture(glow.pattern, largest=1.0)
    )
    emitter = surface_emitter(luminance, glow.two_sided, pattern)
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-300)
    is_flat = bool((normal @ normal[np.argmax(areas)] > SAME_NORMAL).all())
    rectangle = _find_rectangle(corners) if is_flat and pattern is None else None
    if rectangle is not None:
        emitter.set_rectangle(rectangle[0] - origin, *rectangle[1:])
    corners = corners.reshape(-1, 3)
    centre = 0.5 * (corners.min(axis=0) + corners.max(axis=0))
    radius = float(np.linalg.norm(corners.max(axis=0) - centre))
    sides = 2 if glow.two_sided else 1
    flux = glow.luminance * np.pi * area * sides
    axis = normal[np.argmax(areas)] if is_flat and not glow.two_sided else None
    return Source(emitter, flux, luminance.density, centre - origin, radius, axis)


def _find_rectangle(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray] | None:
    """Centre and halves of two sides of a rectangle that two triangles make, None for anything else. (3,) each [m]

    ``corners``: (t, 3, 3) of triangles that face the same way.
    """
    if len(corners) != 2:
        return None
    # The corner opposite to the longest side of each is a right angle, and both lie opposite to each other.
    ends = []
    for triangle in corners:
        sides = np.linalg.norm(np.roll(triangle, -1, axis=0) - np.roll(triangle, 1, axis=0), axis=1)
        ends.append(np.roll(triangle, -int(np.argmax(sides)), axis=0))
    (a, b, d), (c, d_again, b_again) = ends
    x, y = b - a, d - a
    size = np.linalg.norm(x) + np.linalg.norm(y)
    apart = max(np.abs(each).max() for each in (b - b_again, d - d_again, b + d - a - c))
    is_right = abs(x @ y) <= SAME_PLACE * size**2
    if (
        not is_right
        or apart > SAME_PLACE * size
        or min(np.linalg.norm(x), np.linalg.norm(y)) <= 0.0
    ):
        return None
    return 0.5 * (a + c), 0.5 * x, 0.5 * y


def _make_shape(name: str, positions, faces, properties, uv=None):
    """Mitsuba mesh for the search tree and for sampling points on it."""
    properties["face_normals"] = True
    shape = mi.Mesh(name, len(positions), faces.size // 3, properties, False, uv is not None)
    values = mi.traverse(shape)
    values["vertex_positions"] = upload(mi.Float, positions)
    values["faces"] = upload(mi.UInt32, faces)
    if uv is not None:
        values["vertex_texcoords"] = upload(mi.Float, uv)
    values.update()
    return shape


def uv_map_of(material: Material) -> str:
    """Name of the UV map that a material's pictures use, or else its facets lie along.

    The converter sees to it that there is one at most.
    """
    for picture in pictures(material):
        return picture.uv_map
    return next(iter(material.surface.grain_maps), "")
