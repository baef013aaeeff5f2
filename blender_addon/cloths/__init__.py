"""Cloths in Blender: their compositions as settings, the tables computed of them, and their looks."""
