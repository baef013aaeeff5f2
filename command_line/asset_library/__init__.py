"""Luminaires and materials as Blender assets: pictures, files of assets, and what the commands that make them share."""
