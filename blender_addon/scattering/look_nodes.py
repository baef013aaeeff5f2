"""The fitted look of a measured material as Blender's own settings and nodes, for solid shading, EEVEE and Cycles.

A material keeps its own nodes and viewport values: the look is made of further nodes, which the outputs show in place of
what they had. What was there before comes back as soon as the file does not count any more.
"""

import bpy

from ...engine.errors import LumenrayError
from ...engine.scattering.look import Look
from ..bake.nodes import MARK
from ..file_assets.kind import NotReadyError
from ..foundation.node_trees import uses_nodes
from .files import is_measured, scattering_files

PREFIX = "Lumenray Look"
"""How the names of the look's nodes begin."""

OWN_SURFACE = "lumenray_surface"
"""Custom property of an output: node and socket that it showed before, two empty texts if none."""

LEAST_TRANSLUCENCY = 0.01
"""Below it no nodes are added for it."""

DROP = 400.0
"""How far below the material's own nodes those of the look lie."""


def show_look(material, look: Look) -> None:
    """Give a material the look; its own nodes and values are kept for `hide_look`."""
    settings = material.lumenray.measured
    if not settings.has_look:
        settings.has_look = True
        settings.own_colour = material.diffuse_color
        settings.own_metallic, settings.own_roughness = material.metallic, material.roughness
        settings.own_use_nodes = uses_nodes(material)
    if not uses_nodes(material):
        material.use_nodes = True
    tree = material.node_tree
    _remove_look(tree)
    _set_viewport(material, look)
    shader = _make_shader(tree, look, material.lumenray.measured.rotation)
    # Baked light, while it is shown, goes before the look.
    outputs = [node for node in tree.nodes if _is_output(node) and MARK not in node]
    for output in outputs:
        surface = output.inputs["Surface"]
        links = [(link.from_node.name, link.from_socket.identifier) for link in surface.links]
        output[OWN_SURFACE] = list(links[0] if links else ("", ""))
    for output in outputs or [_add(tree, "ShaderNodeOutputMaterial", 0.0)]:
        tree.links.new(shader.outputs[0], output.inputs["Surface"])


def hide_look(material) -> None:
    """Give a material back what it was before its look; nothing happens to one without."""
    settings = material.lumenray.measured
    if not settings.has_look:
        return
    settings.has_look = False
    material.diffuse_color = settings.own_colour
    material.metallic, material.roughness = settings.own_metallic, settings.own_roughness
    if material.node_tree is not None:
        _remove_look(material.node_tree)
    if not settings.own_use_nodes:
        material.use_nodes = False


def wear_look(material, look: Look) -> None:
    """Make the look a material's own: for one that has never had another."""
    if not uses_nodes(material):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    _set_viewport(material, look)
    shader = _make_shader(tree, look, material.lumenray.measured.rotation)
    output = _add(tree, "ShaderNodeOutputMaterial", 0.0)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])


def follow_override(material) -> None:
    """Show a material's look while its file counts, and what it was before while it does not."""
    settings = material.lumenray.measured
    if not is_measured(material):
        settings.is_look_wanted = settings.is_look_wanted or settings.has_look
        hide_look(material)
    elif settings.is_look_wanted:
        settings.is_look_wanted = False
        show_when_ready(material)


def show_when_ready(material) -> None:
    """Give a material the look of its file as soon as that is read."""
    session_uid = material.session_uid

    def show() -> bool:
        # Looked up anew: an undo makes another object of it.
        found = next((m for m in bpy.data.materials if m.session_uid == session_uid), None)
        if found is None or not is_measured(found):
            return True
        try:
            show_look(
                found, scattering_files.obtain(found.lumenray.measured, is_patient=False).look
            )
        except NotReadyError:
            return False
        except LumenrayError:
            # The panel says what is wrong with the file.
            return True
        return True

    scattering_files.call_when_ready(show)


def _is_output(node) -> bool:
    return node.bl_idname == "ShaderNodeOutputMaterial"


def _set_viewport(material, look: Look) -> None:
    material.diffuse_color = (*look.overall_colour, 1.0)
    material.roughness, material.metallic = look.roughness, look.metallic


def _remove_look(tree) -> None:
    """Take the nodes of a look out of a tree, and let the outputs show what they did before."""
    for node in [node for node in tree.nodes if node.name.startswith(PREFIX)]:
        tree.nodes.remove(node)
    for output in [node for node in tree.nodes if OWN_SURFACE in node]:
        name, identifier = output[OWN_SURFACE]
        del output[OWN_SURFACE]
        source = tree.nodes.get(name)
        for socket in source.outputs if source is not None else ():
            if socket.identifier == identifier:
                tree.links.new(socket, output.inputs["Surface"])


def _make_shader(tree, look: Look, rotation: float):
    """Add a Principled BSDF, mixed with a Translucent BSDF where light passes diffusely; return what ends the shader."""
    principled = _add(tree, "ShaderNodeBsdfPrincipled", -300.0)
    values = {
        "Base Color": (*look.base_colour, 1.0),
        "Metallic": look.metallic,
        "Roughness": look.roughness,
        "IOR": look.ior,
        "Anisotropic": look.anisotropy,
        # Of a full turn.
        "Anisotropic Rotation": (rotation + look.grain) / 6.283185307179586 % 1.0,
        "Transmission Weight": look.transmission,
    }
    for name, value in values.items():
        principled.inputs[name].default_value = value
    if look.translucency < LEAST_TRANSLUCENCY:
        return principled
    mix = _add(tree, "ShaderNodeMixShader", -180.0)
    translucent = _add(tree, "ShaderNodeBsdfTranslucent", -300.0, DROP)
    mix.inputs[0].default_value = look.translucency
    translucent.inputs["Color"].default_value = (*look.translucent_colour, 1.0)
    tree.links.new(principled.outputs[0], mix.inputs[1])
    tree.links.new(translucent.outputs[0], mix.inputs[2])
    return mix


def _add(tree, kind: str, left: float, lower: float = 0.0):
    node = tree.nodes.new(kind)
    node.name = node.label = f"{PREFIX} {node.bl_label}"
    node.location = (300.0 + left, -DROP - lower)
    return node
