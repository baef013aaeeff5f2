"""What a material's nodes need to know of the object that shows it, as plain values to compare."""

from .graph import node_key, trace

SURFACE = ("surface",)
"""The surface itself, beyond one tile of a UV map: it needs a picture of its own."""

PLACE = ("place",)
"""Where the object stands in the world."""

_INFO = {"Color": "colour", "Alpha": "alpha", "Object Index": "index", "Random": "random"}

TILE, VALUE, ATTRIBUTE, FRAME = "tile", "value", "attribute", "frame"
"""Beginnings of needs with a name: a UV map whose first tile alone is drawn, one of the object's own values, one of its
properties, or the frame of another object, by session uid."""

_OWNERS = {"OBJECT", "INSTANCER", "VIEW_LAYER"}


def tile(uv_map: str) -> tuple:
    """Return the need of what is drawn for the first tile of a UV map."""
    return (TILE, uv_map)


def needs_of_node(node, output) -> set[tuple]:
    """Return what a node's output depends on beside UV maps, the view and constants."""
    kind, name = node.bl_idname, output.identifier
    if kind == "ShaderNodeObjectInfo":
        if name in _INFO:
            return {(VALUE, _INFO[name])}
        return {PLACE} if name == "Location" else set()
    if kind == "ShaderNodeAttribute" and node.attribute_type in _OWNERS:
        return {(ATTRIBUTE, node.attribute_type, node.attribute_name)}
    if kind == "ShaderNodeTexCoord":
        return _needs_of_coordinates(node, name)
    if kind == "ShaderNodeNewGeometry":
        if name in {"Position", "Normal", "True Normal"}:
            return {SURFACE, PLACE}
        return {SURFACE} if name in {"Pointiness", "Random Per Island"} else set()
    if kind == "ShaderNodeVectorTransform":
        spaces = {node.convert_from, node.convert_to}
        return {SURFACE, PLACE} if spaces == {"WORLD", "OBJECT"} else set()
    if kind == "ShaderNodeUVMap":
        return {(VALUE, "instance uv")} if node.from_instancer else {SURFACE}
    if kind == "ShaderNodeWireframe":
        return set() if node.use_pixel_size else {SURFACE, PLACE}
    return {SURFACE} if kind in {"ShaderNodeAttribute", "ShaderNodeVertexColor"} else set()


def all_needs(material, asked: set[tuple]) -> frozenset[tuple]:
    """Return what a material's nodes need, from what the conversion for all objects asked for.

    That one stops where a texture cannot be drawn; what is behind it is asked for as well.
    """
    if not asked:
        return frozenset()
    output = material.node_tree.get_output_node("CYCLES")
    found, seen = set(asked), set()
    waiting = [(output.inputs[name], ()) for name in ("Surface", "Volume")]
    while waiting:
        origin = trace(*waiting.pop())
        if not origin.is_output:
            continue
        node = origin.socket.node
        key = (*node_key(node, origin.groups), origin.socket.identifier)
        if key in seen:
            continue
        seen.add(key)
        # Whether a surface is needed was told for certain.
        found |= needs_of_node(node, origin.socket) - {SURFACE}
        waiting += [(socket, origin.groups) for socket in node.inputs]
    return frozenset(found)


def _needs_of_coordinates(node, name: str) -> set[tuple]:
    if node.from_instancer and name in {"Generated", "UV"}:
        return {(VALUE, f"instance {name.lower()}")}
    if name == "Object" and node.object is not None:
        return {SURFACE, PLACE, (FRAME, node.object.original.session_uid)}
    return {SURFACE} if name in {"Generated", "Normal", "UV", "Object"} else set()
