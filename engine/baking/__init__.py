"""The bake: from objects of a scene to finished pages of lux maps; `run.bake` is its door."""
