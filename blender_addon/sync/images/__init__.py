"""Pixels of Blender's images, read once."""
