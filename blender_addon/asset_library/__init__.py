"""Luminaires as Blender assets: pictures of their light, files of assets, and their place in the Asset Browser."""
