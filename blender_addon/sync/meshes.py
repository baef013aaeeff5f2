"""Evaluated objects of Blender as geometries of the engine."""

from collections.abc import Callable

from ...imports import loaded_when_used

with loaded_when_used():
    import numpy as np

    from ...engine.scene import mesh as scene_mesh

BAKED_MAP = "Lumenray"
"""UV map by which lux maps lie on a mesh; others of them begin with it."""

BAKED_TREE = "lumenray_baked"
"""Custom property of the node trees that show baked light."""

MESH_TYPES = {"MESH", "CURVE", "SURFACE", "META", "FONT"}
"""Object types that have a surface."""


def read_geometry(
    source,
    geometry_id: str,
    change: "Callable[[scene_mesh.Geometry, object], scene_mesh.Geometry] | None" = None,
    look: "Callable[[object, scene_mesh.Geometry], None] | None" = None,
) -> "scene_mesh.Geometry | None":
    """Read the surface of one evaluated object, in the object's own frame and in Blender units.

    Parameters
    ----------
    source : bpy.types.Object    Evaluated; of an instance the object that the instance shows.
    geometry_id : str    Identity of the result.
    change : callable or None    From the geometry and the mesh that it was read from to what is used in its place.
    look : callable or None    Given the mesh and what is used while the mesh is there, to read more of it.

    Returns
    -------
    Geometry or None    None when there is no face.
    """
    mesh = source.to_mesh()
    if mesh is None:
        return None
    try:
        made = _convert(mesh, geometry_id, _hidden_maps(source, mesh))
        if made is not None and change is not None:
            made = change(made, mesh)
        if made is not None and look is not None:
            look(mesh, made)
        return made
    finally:
        source.to_mesh_clear()


def fingerprint(geometry: "scene_mesh.Geometry | None") -> int:
    """Return a number of 64 bits that tells contents apart within one process."""
    if geometry is None:
        return 0
    arrays = (
        geometry.vertices,
        geometry.triangles,
        geometry.material_index,
        geometry.corner_normals,
        geometry.polygon,
        *geometry.uv_maps.values(),
    )
    parts = (None if array is None else hash(array.tobytes()) for array in arrays)
    return hash((*parts, *geometry.uv_maps))


def _hidden_maps(source, mesh) -> set[str]:
    """UV maps of lux maps that no material asks for: a bake must not change the scene that it was made of."""
    own = {each.name for each in mesh.uv_layers if f"{each.name} ".startswith(f"{BAKED_MAP} ")}
    if own:
        for slot in source.material_slots:
            if slot.material is not None and slot.material.node_tree is not None:
                own -= _named_maps(slot.material.node_tree, set())
    return own


def _named_maps(tree, seen: set) -> set[str]:
    """Names of UV maps that the nodes of a tree ask for, but for the trees that show baked light."""
    if tree in seen or tree.get(BAKED_TREE):
        return set()
    seen.add(tree)
    found = set()
    for node in tree.nodes:
        found |= {getattr(node, name, "") for name in ("uv_map", "attribute_name")}
        if getattr(node, "node_tree", None) is not None:
            found |= _named_maps(node.node_tree, seen)
    return found


def _convert(mesh, geometry_id, hidden) -> "scene_mesh.Geometry | None":
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    if count == 0:
        return None
    # The triangles' own vertices, polygons and materials would be read one by one: attributes are copied whole.
    corners = corners_of(mesh)
    corner_vertex = read_values(
        mesh.attributes[".corner_vert"].data, "value", np.int32, len(mesh.loops)
    )
    polygon = read_values(mesh.loop_triangle_polygons, "value", np.int32, count)
    material = mesh.attributes.get("material_index")
    if material is None:
        slot = np.zeros(count, np.int32)
    else:
        slot = read_values(material.data, "value", np.int32, len(mesh.polygons))[polygon]
    normals = None
    if mesh.normals_domain != "FACE":
        normals = read_values(mesh.corner_normals, "vector", np.float32, (len(mesh.loops), 3))
    return scene_mesh.Geometry(
        id=geometry_id,
        vertices=read_values(
            mesh.attributes["position"].data, "vector", np.float32, (len(mesh.vertices), 3)
        ),
        triangles=corner_vertex[corners],
        material_index=np.maximum(slot, 0),
        corner_normals=None if normals is None else normals.take(corners, axis=0),
        uv_maps={
            layer.name: read_values(layer.uv, "vector", np.float32, (len(mesh.loops), 2)).take(
                corners, axis=0
            )
            for layer in sorted(mesh.uv_layers, key=lambda layer: not layer.active_render)
            if layer.name not in hidden
        },
        polygon=polygon,
        box=np.array([mesh.texspace_location, mesh.texspace_size], dtype=np.float64),
    )


def corners_of(mesh) -> "np.ndarray":
    """Return the corners of a mesh's polygons that its triangles have. (t, 3) int32"""
    count = len(mesh.loop_triangles)
    if count == len(mesh.polygons):
        return np.arange(3 * count, dtype=np.int32).reshape(count, 3)
    return read_values(mesh.loop_triangles, "loops", np.int32, (count, 3))


def read_values(collection, attribute: str, dtype, shape) -> "np.ndarray":
    """Return a property of all members of a collection of Blender as an array."""
    values = np.empty(shape, dtype=dtype)
    collection.foreach_get(attribute, values.reshape(-1))
    return values
