"""Blender's content, one feature in each scene, rendered here and by Cycles; `run` is the door."""
