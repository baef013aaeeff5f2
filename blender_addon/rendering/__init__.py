"""The render engine that Blender calls: F12, the rendered view, and what they are fed with."""
