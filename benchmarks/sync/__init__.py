"""How long an edit in Blender takes until the live view shows it."""
