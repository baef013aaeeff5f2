"""Hair, curves without faces and clouds of points of Blender as geometries of the engine."""

import numpy as np

from ...engine.scene.mesh import Geometry
from .strands import Strands, Triangles, balls, join, smoothed, tubes, usable

HAIR_RADIUS, POINT_RADIUS = 0.005, 0.01
"""Radii of curves and points that have none of their own, as in Cycles. [Blender unit]"""


def hair_systems(source) -> list:
    """Particle systems of an evaluated object that are rendered as strands."""
    made = []
    for modifier in source.modifiers:
        if modifier.type != "PARTICLE_SYSTEM" or not modifier.show_render:
            continue
        settings = modifier.particle_system.settings
        if settings.type == "HAIR" and settings.render_type == "PATH":
            made.append(modifier.particle_system)
    return made


def read_hair(source, geometry_id: str, is_render: bool) -> tuple[Geometry | None, str]:
    """Read the particle hair of an evaluated object, in its own frame; also what is to be told of it.

    ``is_render``: whether strands are as finely divided as in renders.
    """
    systems = [_read_system(source, system, is_render) for system in hair_systems(source)]
    made = tubes(smoothed(usable(join(systems)))) if systems else None
    return _geometry(made, geometry_id)


def _read_system(source, system, is_render: bool) -> Strands:
    settings = system.settings
    steps = (1 << (settings.render_step if is_render else settings.display_step)) + 1
    if settings.kink == "SPIRAL":
        steps += settings.kink_extra_steps
    parents, children = len(system.particles), len(system.child_particles)
    # Children are numbered after their parents, and stand for them.
    has_children = settings.child_type != "NONE" and children > 0
    numbers = range(parents, parents + children) if has_children else range(parents)
    points = np.array(
        [
            system.co_hair(object=source, particle_no=number, step=step)
            for number in numbers
            for step in range(steps)
        ],
        np.float64,
    ).reshape(len(numbers), steps, 3)
    back = np.linalg.pinv(np.array(source.matrix_world, np.float64))
    points = points @ back[:3, :3].T + back[:3, 3]
    return Strands(
        points.reshape(-1, 3),
        _radii(settings, points).reshape(-1),
        np.full(len(numbers), steps),
        np.full(len(numbers), max(settings.material - 1, 0)),
    )


def _radii(settings, points: np.ndarray) -> np.ndarray:
    """Radii of strands (s, k, 3) by how far along they are, as the settings' shape has it. (s, k)"""
    pieces = np.linalg.norm(np.diff(points, axis=1), axis=2)
    way = np.concatenate([np.zeros((len(points), 1)), np.cumsum(pieces, axis=1)], axis=1)
    left = 1.0 - way / np.maximum(way[:, -1:], 1e-30)
    shape = settings.shape
    power = 1.0 + shape if shape < 0.0 else 1.0 / max(1.0 - shape, 1e-6)
    left = np.maximum(left, 0.0) ** power
    # Blender states diameters.
    root, tip = (
        0.5 * settings.radius_scale * each for each in (settings.root_radius, settings.tip_radius)
    )
    radii = tip + (root - tip) * left
    if settings.use_close_tip:
        radii[:, -1] = 0.0
    return radii


def read_curves(source, geometry_id: str, is_smooth: bool = True) -> tuple[Geometry | None, str]:
    """Read evaluated curves, as `read_hair`. ``is_smooth``: whether they run smoothly through their points."""
    data = source.data
    if not len(data.curves):
        return None, ""
    points = _vectors(data)
    ends = np.empty(len(data.curves) + 1, np.int32)
    data.curve_offset_data.foreach_get("value", ends)
    strands = Strands(
        points,
        _values(data, "radius", len(points), HAIR_RADIUS),
        np.diff(ends),
        _slots(data, len(data.curves)),
    )
    strands = usable(strands)
    return _geometry(tubes(smoothed(strands) if is_smooth else strands), geometry_id)


def read_points(source, geometry_id: str) -> tuple[Geometry | None, str]:
    """Read an evaluated cloud of points, as `read_hair`."""
    points = _vectors(source.data)
    radii = _values(source.data, "radius", len(points), POINT_RADIUS)
    return _geometry(balls(points, radii), geometry_id)


def _geometry(made: Triangles | None, geometry_id: str) -> tuple[Geometry | None, str]:
    if made is None or not len(made.triangles):
        return None, ""
    geometry = Geometry(
        geometry_id,
        made.vertices,
        made.triangles,
        made.slots,
        made.corner_normals,
    )
    return geometry, made.note


def _vectors(data) -> np.ndarray:
    """Positions of points. (n, 3)"""
    attribute = data.attributes.get("position")
    if attribute is None:
        return np.zeros((0, 3))
    values = np.empty((len(attribute.data), 3), np.float32)
    attribute.data.foreach_get("vector", values.reshape(-1))
    return values.astype(np.float64)


def _values(data, name: str, count: int, missing: float) -> np.ndarray:
    """Numbers of points by the name of their attribute. (n,)"""
    attribute = data.attributes.get(name)
    if attribute is None or attribute.domain != "POINT" or attribute.data_type != "FLOAT":
        return np.full(count, missing)
    values = np.empty(count, np.float32)
    attribute.data.foreach_get("value", values)
    return values.astype(np.float64)


def _slots(data, count: int) -> np.ndarray:
    """Material slots of curves. (s,)"""
    attribute = data.attributes.get("material_index")
    if attribute is None or attribute.domain != "CURVE" or attribute.data_type != "INT":
        return np.zeros(count, int)
    values = np.empty(count, np.int32)
    attribute.data.foreach_get("value", values)
    return np.maximum(values, 0)
