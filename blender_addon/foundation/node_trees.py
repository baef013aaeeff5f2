"""Node trees of Blender's data, in all versions of Blender."""

import bpy


def uses_nodes(data) -> bool:
    """Whether the nodes of a material or a world count; since Blender 5.0 they always do, and 6.0 drops the property."""
    return data.node_tree is not None and (bpy.app.version >= (5, 0, 0) or data.use_nodes)
