"""The fitted look of a measured material as Blender's own settings and nodes, for solid shading, EEVEE and Cycles."""

import bpy

from ...engine.errors import LumenrayError
from ...engine.scattering.look import Look
from . import files

PLAIN = {
    "ShaderNodeBsdfPrincipled",
    "ShaderNodeOutputMaterial",
    "ShaderNodeMixShader",
    "ShaderNodeBsdfTranslucent",
}
"""Nodes of trees that hold nothing worth keeping: values alone."""

MIX, TRANSLUCENT = "Lumenray Mix", "Lumenray Translucent"
"""Names of the nodes that are added for diffuse light that passes."""

LEAST_TRANSLUCENCY = 0.01
"""Below it no nodes are added for it."""


def is_plain(material) -> bool:
    """Whether a material's nodes may be written to without being asked."""
    tree = material.node_tree
    return tree is None or all(node.bl_idname in PLAIN for node in tree.nodes)


def show_look(material, look: Look, is_forced: bool = False) -> bool:
    """Give a material the look, and tell whether its nodes got it too.

    Parameters
    ----------
    material : bpy.types.Material
    look : Look
    is_forced : bool    Whether nodes are written to that are not plain; what is linked to the values is unlinked.
    """
    material.diffuse_color = (*look.overall_colour, 1.0)
    material.roughness, material.metallic = look.roughness, look.metallic
    if not (is_forced or is_plain(material)):
        return False
    if material.node_tree is None or (bpy.app.version < (5, 0, 0) and not material.use_nodes):
        material.use_nodes = True
    tree = material.node_tree
    output = tree.get_output_node("EEVEE") or tree.nodes.new("ShaderNodeOutputMaterial")
    principled = _find_principled(output) or _add(tree, "ShaderNodeBsdfPrincipled", output, 300.0)
    turn = material.lumenray.measured.rotation + look.grain
    values = {
        "Base Color": (*look.base_colour, 1.0),
        "Metallic": look.metallic,
        "Roughness": look.roughness,
        "IOR": look.ior,
        "Alpha": 1.0,
        "Specular IOR Level": 0.5,
        "Anisotropic": look.anisotropy,
        # Of a full turn.
        "Anisotropic Rotation": turn / 6.283185307179586 % 1.0,
        "Transmission Weight": look.transmission,
    }
    for name, value in values.items():
        _set(tree, principled.inputs[name], value)
    _wire(tree, output, principled, look)
    return True


def show_when_ready(material) -> None:
    """Give a material the look of its file as soon as that is read."""
    session_uid = material.session_uid

    def show() -> bool:
        # Looked up anew: an undo makes another object of it.
        found = next((m for m in bpy.data.materials if m.session_uid == session_uid), None)
        if found is None:
            return True
        try:
            show_look(found, files.obtain(found.lumenray.measured, is_patient=False).look)
        except files.NotReadyError:
            return False
        except LumenrayError:
            # The panel says what is wrong with the file.
            return True
        return True

    files.call_when_ready(show)


def _find_principled(output):
    """The Principled BSDF that an output ends in, behind shaders that mix others too; None if there is none."""
    waiting, seen = [output], set()
    while waiting:
        node = waiting.pop(0)
        if node.name in seen:
            continue
        seen.add(node.name)
        if node.bl_idname == "ShaderNodeBsdfPrincipled":
            return node
        sockets = [socket for socket in node.inputs if socket.type == "SHADER"]
        waiting += [link.from_node for socket in sockets for link in socket.links]
    return None


def _wire(tree, output, principled, look: Look) -> None:
    """Let an output show the Principled BSDF, mixed with a Translucent BSDF where light passes diffusely."""
    mix, translucent = tree.nodes.get(MIX), tree.nodes.get(TRANSLUCENT)
    surface = output.inputs["Surface"]
    if look.translucency < LEAST_TRANSLUCENCY:
        for node in (mix, translucent):
            if node is not None:
                tree.nodes.remove(node)
        tree.links.new(principled.outputs[0], surface)
        return
    if mix is None:
        mix = _add(tree, "ShaderNodeMixShader", output, 180.0, MIX)
    if translucent is None:
        translucent = _add(tree, "ShaderNodeBsdfTranslucent", output, 300.0, TRANSLUCENT)
        translucent.location[1] += 180.0
    _set(tree, mix.inputs[0], look.translucency)
    _set(tree, translucent.inputs["Color"], (*look.translucent_colour, 1.0))
    tree.links.new(principled.outputs[0], mix.inputs[1])
    tree.links.new(translucent.outputs[0], mix.inputs[2])
    tree.links.new(mix.outputs[0], surface)


def _add(tree, kind: str, output, left: float, name: str = ""):
    node = tree.nodes.new(kind)
    node.location = (output.location[0] - left, output.location[1])
    if name:
        node.name = node.label = name
    return node


def _set(tree, socket, value) -> None:
    for link in list(socket.links):
        tree.links.remove(link)
    socket.default_value = value
