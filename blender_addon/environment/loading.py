"""A picture of the surroundings as a scene's world."""

from pathlib import Path

import bpy

from ...engine.errors import FileFormatError

EXTENSIONS = (".hdr", ".exr")
"""Endings of the names of such files."""


def show_picture(scene, path: str) -> bpy.types.Image:
    """Let a picture light a scene: by the world's Background, or that of a new world; other nodes of it stay.

    Parameters
    ----------
    scene : bpy.types.Scene
    path : str    Of an equirectangular picture.

    Returns
    -------
    bpy.types.Image

    Raises
    ------
    FileFormatError    Blender cannot read it.
    """
    try:
        image = bpy.data.images.load(path, check_existing=True)
    except RuntimeError:
        raise FileFormatError(path, "cannot be read as a picture") from None
    if image.size[0] * image.size[1] == 0:
        if image.users == 0:
            bpy.data.images.remove(image)
        raise FileFormatError(path, "holds no picture that can be read; is it damaged?")
    world = scene.world
    if world is None or world.library is not None:
        world = scene.world = bpy.data.worlds.new(Path(path).stem)
    if bpy.app.version < (5, 0, 0):
        world.use_nodes = True
    world.lumenray.source = "NODES"
    tree = world.node_tree
    texture = _texture_of(tree)
    texture.image = image
    world.lumenray.environment.found = ""
    return image


def _texture_of(tree):
    """Return the Environment Texture that the Background shows, made where it is missing."""
    output = tree.get_output_node("ALL") or tree.nodes.new("ShaderNodeOutputWorld")
    surface = output.inputs["Surface"]
    node = surface.links[0].from_node if surface.is_linked else None
    if node is None or node.bl_idname != "ShaderNodeBackground":
        node = tree.nodes.new("ShaderNodeBackground")
        tree.links.new(node.outputs["Background"], surface)
    colour = node.inputs["Color"]
    shown = colour.links[0].from_node if colour.is_linked else None
    if shown is not None and shown.bl_idname == "ShaderNodeTexEnvironment":
        return shown
    texture = tree.nodes.new("ShaderNodeTexEnvironment")
    texture.location = (node.location.x - 300.0, node.location.y)
    tree.links.new(texture.outputs["Color"], colour)
    return texture
