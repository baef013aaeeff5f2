"""Luminaires in Blender: their settings, the files behind them, their body, and their way into the engine's scene."""
