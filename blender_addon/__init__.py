"""Everything that knows Blender's data."""
