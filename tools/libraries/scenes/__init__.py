"""Builds the scenes that ship, in Blender."""
