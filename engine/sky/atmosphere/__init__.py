"""Blender's Sky Texture: the light of a clear sky by the direction, and the disk of its sun."""
