"""Evaluated objects of Blender as triangle meshes of the engine."""

import numpy as np

from ...engine.scene.mesh import Mesh

MESH_TYPES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}
"""Object types that have a surface."""


def read_mesh(instance, mesh_id: str, name: str, materials: tuple[str, ...], scale: float):
    """Read one evaluated instance.

    Parameters
    ----------
    instance : bpy.types.DepsgraphObjectInstance
    mesh_id, name : str    Identity and name for people.
    materials : tuple of str    Material ids by slot; at least one.
    scale : float    Metres per Blender unit.

    Returns
    -------
    Mesh or None    None when there is no face.
    """
    source = instance.object
    mesh = source.to_mesh()
    if mesh is None:
        return None
    try:
        return _convert(mesh, instance, mesh_id, name, materials, scale)
    finally:
        source.to_mesh_clear()


def _convert(mesh, instance, mesh_id, name, materials, scale) -> Mesh | None:
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    triangles = _read(mesh.loop_triangles, "vertices", np.int32, (count, 3))
    loops = _read(mesh.loop_triangles, "loops", np.int32, (count, 3))
    vertices = _read(mesh.vertices, "co", np.float32, (len(mesh.vertices), 3)).astype(np.float64)
    polygon = _read(mesh.loop_triangles, "polygon_index", np.int32, (count,))
    slot = _read(mesh.loop_triangles, "material_index", np.int32, (count,))

    matrix = np.array(instance.matrix_world, dtype=np.float64)
    linear = matrix[:3, :3]
    vertices = (vertices @ linear.T + matrix[:3, 3]) * scale
    normals = None
    if mesh.normals_domain != "FACE":
        corner = _read(mesh.corner_normals, "vector", np.float32, (len(mesh.loops), 3))
        normals = _turn_normals(corner, linear)[loops]
    uv_maps = {
        layer.name: _read(layer.uv, "vector", np.float32, (len(mesh.loops), 2))[loops]
        for layer in sorted(mesh.uv_layers, key=lambda layer: not layer.active_render)
    }
    if np.linalg.det(linear) < 0.0:
        # A mirrored object keeps its outside outside.
        triangles = triangles[:, ::-1]
        normals = None if normals is None else normals[:, ::-1]
        uv_maps = {key: uv[:, ::-1] for key, uv in uv_maps.items()}
    source = instance.object
    return Mesh(
        id=mesh_id,
        name=name,
        vertices=vertices,
        triangles=np.ascontiguousarray(triangles),
        materials=materials,
        material_index=np.clip(slot, 0, len(materials) - 1),
        corner_normals=normals,
        uv_maps=uv_maps,
        polygon=polygon,
        visible_to_camera=source.visible_camera,
        index=source.pass_index,
    )


def _read(collection, attribute: str, dtype, shape) -> np.ndarray:
    values = np.empty(int(np.prod(shape)), dtype=dtype)
    collection.foreach_get(attribute, values)
    return values.reshape(shape)


def _turn_normals(normals, linear) -> np.ndarray:
    """Turn normals with a linear map: by its inverse transpose, then to unit length; mirroring needs no more."""
    if abs(np.linalg.det(linear)) < 1e-30:
        return normals
    turned = normals.astype(np.float64) @ np.linalg.inv(linear)
    length = np.linalg.norm(turned, axis=1, keepdims=True)
    return (turned / np.maximum(length, 1e-12)).astype(np.float32)
