"""Blender's procedural textures as functions of arrays of coordinates, with the values of Cycles; a module for each."""
