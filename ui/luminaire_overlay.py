"""Polar solids of luminaires in the 3D view: how each throws its light, where and as it is mounted.

The selected luminaires show theirs, and all that are told to. A solid is one call to the graphics card, the curves and
openings of all luminaires are one more.
"""

from collections import defaultdict
from dataclasses import dataclass, field

import bpy
import gpu
from bpy.app.handlers import persistent
from gpu_extras.batch import batch_for_shader
from mathutils import Matrix

from ..blender_addon.foundation import preferences
from ..blender_addon.foundation.handlers import leave, listen
from ..blender_addon.foundation.units import metres_per_unit
from ..imports import loaded_when_used

with loaded_when_used():
    import numpy as np

    from ..blender_addon.luminaires import places as luminaire_places
    from ..blender_addon.luminaires import solid as luminaire_solid

SOLID_COLOUR = (1.0, 0.86, 0.48)
"""Colour of what faces the light of the solid; darker where it does not."""

SOLID_OPACITY = 0.55

CURVE_COLOURS = ((0.95, 0.2, 0.16, 1.0), (0.2, 0.45, 1.0, 1.0))
"""Colours of the curves in the planes C0-C180 and C90-C270."""

OPENING_COLOUR = (1.0, 1.0, 1.0, 0.8)

LINE_WIDTH = 1.6
"""Of curves and openings. [pixel]"""

CURVE_POINTS, FEW_POINTS, MANY = 160, 64, 60
"""Segments of a curve, and of one where more than so many luminaires are shown."""

KEPT_SHAPES = 256
"""Distributions whose geometry is kept."""

CONCERNING = (bpy.types.Light, bpy.types.Collection, bpy.types.Scene, bpy.types.Text)
"""Data-blocks, beside some objects, that decide which luminaires are shown and how; a scene, what is visible."""


@dataclass
class _Shown:
    """What a 3D view shows until something of the scene changes."""

    places: list
    centres: "np.ndarray"
    radius: float
    lines: object = None


@dataclass
class _Cache:
    """Geometry on the graphics card, on Blender's main thread."""

    views: dict = field(default_factory=dict)
    solids: dict = field(default_factory=dict)
    curves: dict = field(default_factory=dict)


_cache = _Cache()


def draw() -> None:
    """Draw the solids of the luminaires in a 3D view; called by Blender for every 3D view."""
    context = bpy.context
    space = context.space_data
    if not (space.overlay.show_overlays and space.overlay.show_extras):
        return
    shown = _shown(context)
    if not shown.places:
        return
    region = context.region_data
    levels = luminaire_places.choose_levels(
        shown.centres, shown.radius, region.perspective_matrix, context.region.height
    )
    before = gpu.state.depth_test_get(), gpu.state.depth_mask_get(), gpu.state.blend_get()
    gpu.state.depth_test_set("LESS_EQUAL")
    gpu.state.depth_mask_set(False)
    gpu.state.blend_set("ALPHA")
    _draw_solids(shown, levels, np.asarray(region.perspective_matrix)[3])
    _draw_lines(shown, context.region)
    gpu.state.face_culling_set("NONE")
    gpu.state.depth_test_set(before[0])
    gpu.state.depth_mask_set(before[1])
    gpu.state.blend_set(before[2])


def _draw_solids(shown, levels, depth) -> None:
    """Draw the solids that are large enough, the farthest first."""
    shader = gpu.shader.from_builtin("SMOOTH_COLOR")
    distance = shown.centres @ depth[:3]
    for number in sorted(np.flatnonzero(levels >= 0), key=lambda n: -distance[n]):
        place = shown.places[number]
        batch = _solid(shader, place, int(levels[number]))
        if batch is None:
            continue
        matrix = Matrix(shown.radius * place.turn)
        # The far side would be seen through the near one.
        gpu.state.face_culling_set("BACK" if matrix.determinant() > 0.0 else "FRONT")
        with gpu.matrix.push_pop():
            gpu.matrix.multiply_matrix(Matrix.Translation(place.centre) @ matrix.to_4x4())
            batch.draw(shader)


def _draw_lines(shown, region) -> None:
    shader = gpu.shader.from_builtin("POLYLINE_SMOOTH_COLOR")
    if shown.lines is None:
        points, colours = _lines(shown, metres_per_unit(bpy.context.scene))
        shown.lines = batch_for_shader(shader, "LINES", {"pos": points, "color": colours})
    shader.uniform_float("viewportSize", (region.width, region.height))
    shader.uniform_float("lineWidth", LINE_WIDTH * bpy.context.preferences.system.pixel_size)
    shown.lines.draw(shader)


def _shown(context) -> _Shown:
    """Return what the view shows, found out anew only after a change of the scene or of the solids' size."""
    metres = metres_per_unit(context.scene)
    radius = preferences.solid_radius() / metres
    key = (context.space_data.as_pointer(), context.view_layer.as_pointer())
    shown = _cache.views.get(key)
    if shown is None or shown.radius != radius:
        places = luminaire_places.collect(context.view_layer, context.space_data, metres)
        centres = np.array([place.centre for place in places]).reshape(-1, 3)
        shown = _cache.views[key] = _Shown(places, centres, radius)
    return shown


def _solid(shader, place, level):
    """Batch of a solid, None where nothing is emitted."""
    key = (place.digest, level)
    if key not in _cache.solids:
        _, columns, rows = luminaire_places.LEVELS[level]
        solid = luminaire_solid.make_solid(place.distribution, columns, rows)
        _trim(_cache.solids)
        _cache.solids[key] = _solid_batch(shader, solid) if len(solid.triangles) else None
    return _cache.solids[key]


def _solid_batch(shader, solid):
    colours = np.empty((len(solid.vertices), 4), np.float32)
    colours[:, :3] = solid.brightness[:, None] * SOLID_COLOUR
    colours[:, 3] = SOLID_OPACITY
    content = {"pos": solid.vertices, "color": colours}
    return batch_for_shader(shader, "TRIS", content, indices=solid.triangles)


def _lines(shown, metres) -> "tuple[np.ndarray, np.ndarray]":
    """Return curves and openings of all luminaires as pairs of points in the world, with colours."""
    count = CURVE_POINTS if len(shown.places) <= MANY else FEW_POINTS
    alike = defaultdict(list)
    for place in shown.places:
        alike[place.digest, place.opening].append(place)
    points, colours = [np.zeros((0, 3))], [np.zeros((0, 4))]
    for places in alike.values():
        outline = luminaire_solid.make_outline(places[0].opening).reshape(-1, 3) / metres
        curves = [shown.radius * curve for curve in _curves(places[0], count)]
        turns, frames, centres = (
            np.array([getattr(place, name) for place in places])
            for name in ("turn", "frame", "centre")
        )
        for line, colour, axes in (
            (outline, OPENING_COLOUR, frames),
            (curves[0], CURVE_COLOURS[0], turns),
            (curves[1], CURVE_COLOURS[1], turns),
        ):
            made = line @ axes.transpose(0, 2, 1) + centres[:, None]
            points.append(made.reshape(-1, 3))
            colours.append(np.broadcast_to(colour, (points[-1].shape[0], 4)))
    return np.concatenate(points).astype(np.float32), np.concatenate(colours).astype(np.float32)


def _curves(place, count) -> "list[np.ndarray]":
    """Both curves of a luminaire as pairs of points. (n, 3) each"""
    key = (place.digest, count)
    if key not in _cache.curves:
        curves = [
            luminaire_solid.make_curve(place.distribution, plane, count)
            for plane in luminaire_solid.PLANES
        ]
        _trim(_cache.curves)
        _cache.curves[key] = [
            np.stack([curve[:-1], curve[1:]], axis=1).reshape(-1, 3) for curve in curves
        ]
    return _cache.curves[key]


def _trim(kept: dict) -> None:
    """Make room for one more; the oldest goes first."""
    while len(kept) >= KEPT_SHAPES:
        kept.pop(next(iter(kept)))


@persistent
def note_update(scene, depsgraph) -> None:
    """Find out anew what the views show if it can have changed: moving a mesh is no reason."""
    if any(_concerns(update.id) for update in depsgraph.updates):
        forget_views()


def _concerns(changed) -> bool:
    if isinstance(changed, bpy.types.Object):
        return changed.type in {"LIGHT", "EMPTY"}
    return isinstance(changed, CONCERNING)


@persistent
def forget_views(*_) -> None:
    """Find out anew what the views show: all of the scene may have changed."""
    _cache.views.clear()


_handles = []


_HANDLERS = {
    "depsgraph_update_post": note_update,
    "frame_change_post": note_update,
    "undo_post": forget_views,
    "redo_post": forget_views,
    "load_post": forget_views,
}


def attach():
    """Draw in every 3D view from now on."""
    if _handles or bpy.app.background:
        return
    _handles.append(bpy.types.SpaceView3D.draw_handler_add(draw, (), "WINDOW", "POST_VIEW"))
    listen(_HANDLERS)


def detach():
    """Draw no more."""
    while _handles:
        bpy.types.SpaceView3D.draw_handler_remove(_handles.pop(), "WINDOW")
    leave(_HANDLERS)
    for kept in (_cache.views, _cache.solids, _cache.curves):
        kept.clear()
