"""Walking through node trees: what feeds a socket, through reroutes, groups and muted nodes."""

from dataclasses import dataclass

import bpy

_LONGEST_WALK = 1000

# Blender 5 puts a group's nodes in its place: what passes its border is no longer converted to the
# type of the border's socket (seen in 5.0.1).
_CONVERTS_AT_BORDERS = bpy.app.version < (5, 0, 0)


@dataclass(frozen=True)
class Origin:
    """Where the value of an input socket comes from.

    Attributes
    ----------
    socket : bpy.types.NodeSocket or None
        An output of a node that does something, an unlinked input whose own value counts, or
        None when nothing arrives.
    groups : tuple of bpy.types.Node
        Group nodes around the socket, outermost first.
    types : tuple of str
        Socket types that the value passes on its way, the asking socket first.
    problem : str
        Why nothing arrives, where Blender itself would call it a fault; empty otherwise.
    """

    socket: object
    groups: tuple
    types: tuple
    problem: str = ""

    @property
    def is_output(self) -> bool:
        """Whether a node computes the value."""
        return self.socket is not None and self.socket.is_output


def find_socket(sockets, *identifiers):
    """Return the socket with the first identifier (or else name) that exists, or None."""
    for identifier in identifiers:
        for socket in sockets:
            if socket.identifier == identifier:
                return socket
    for name in identifiers:
        for socket in sockets:
            if socket.name == name:
                return socket
    return None


def trace(socket, groups=()) -> Origin:
    """Find what feeds an input socket.

    Parameters
    ----------
    socket : bpy.types.NodeSocket    An input.
    groups : tuple of bpy.types.Node    Group nodes that were entered to get to it.

    Returns
    -------
    Origin    Its `socket` is never a reroute, a group, a group's border or a muted node's output.
    """
    asking = Origin(socket, groups, (socket.type,))
    types = [socket.type]
    for _ in range(_LONGEST_WALK):
        link = next((link for link in socket.links if not link.is_muted), None)
        if link is None:
            return Origin(socket, groups, (*types, socket.type))
        output, node = link.from_socket, link.from_node
        types.append(output.type)
        problem = ""
        if node.mute:
            socket = _passed_through(node, output)
            if socket is None:
                return asking
        elif node.bl_idname == "NodeReroute":
            socket = node.inputs[0]
        elif node.bl_idname == "NodeGroupInput":
            socket = find_socket(groups[-1].inputs, output.identifier) if groups else None
            groups = groups[:-1]
            problem = "" if socket else "The group's input has no counterpart outside"
        elif node.type == "GROUP":
            socket = _inner_output(node, output.identifier)
            groups = (*groups, node)
            problem = "" if socket else f"The node group of {node.name!r} is missing"
        else:
            return Origin(output, groups, tuple(types))
        if socket is None:
            return Origin(None, groups, tuple(types), problem)
        if node.mute or node.bl_idname == "NodeReroute" or _CONVERTS_AT_BORDERS:
            types.append(socket.type)
        else:
            types.pop()
        if node.bl_idname != "NodeReroute":
            asking = Origin(socket, groups, (*types, socket.type))
    return Origin(None, groups, tuple(types), "The links run in a circle")


def _passed_through(node, output):
    """Return the input that a muted node hands on to `output`, None if nothing is linked to it.

    Blender then leaves the asking input unlinked, so that its own value counts.
    """
    inner = (link.from_socket for link in node.internal_links if link.to_socket == output)
    socket = next(inner, None)
    return socket if socket is not None and socket.is_linked else None


def _inner_output(node, identifier):
    tree = node.node_tree
    if tree is None:
        return None
    outputs = [inner for inner in tree.nodes if inner.bl_idname == "NodeGroupOutput"]
    active = next((inner for inner in outputs if inner.is_active_output), None)
    active = active or (outputs[0] if outputs else None)
    if active is None:
        return None
    return next((one for one in active.inputs if one.identifier == identifier), None)


def settings_of(node) -> tuple:
    """Return what a node itself is set to, its sockets aside, as values to compare."""
    common = bpy.types.ShaderNode.bl_rna.properties
    return (
        node.bl_idname,
        *(
            (prop.identifier, _value_of(node, prop))
            for prop in node.bl_rna.properties
            if prop.identifier not in common
        ),
    )


def _value_of(owner, prop):
    value = getattr(owner, prop.identifier)
    if prop.type == "COLLECTION":
        return tuple(_values_of(each) for each in value)
    if prop.type == "POINTER":
        return value if value is None else _values_of(value)
    return tuple(value) if getattr(prop, "is_array", False) else value


def _values_of(thing):
    """Return all values of a colour ramp, a curve mapping or the like; only the name of a data-block."""
    if isinstance(thing, bpy.types.ID):
        return thing.name_full
    properties = (p for p in thing.bl_rna.properties if p.identifier != "rna_type")
    return tuple(_value_of(thing, prop) for prop in properties)


def node_key(node, groups) -> tuple:
    """Return a key of a node that is unique within one material."""
    return (*(group.name for group in groups), node.name)
