"""Other programs that answer the same queries: Radiance, and Cycles of Blender."""
