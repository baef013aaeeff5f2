"""Lights of Blender as lights of the engine."""
