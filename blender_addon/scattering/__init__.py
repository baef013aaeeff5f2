"""Measured materials in Blender: settings, the files behind them, their way into the engine's scene, and their look."""
