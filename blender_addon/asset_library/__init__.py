"""Luminaires and materials as Blender assets: pictures, files of assets, and their place in the Asset Browser."""
