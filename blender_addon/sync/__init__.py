"""Conversion of Blender's data-blocks into the engine's pure data."""
