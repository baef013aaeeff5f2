"""Materials of Blender as materials of the engine."""
