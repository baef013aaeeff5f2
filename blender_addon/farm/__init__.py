"""What the tasks of a render farm call in ``blender -b``; `tasks` is the door."""
