"""The commands ``lumenray scene …``: what is in a file, and changes of it, without Blender's window."""
