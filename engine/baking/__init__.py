"""The bake: from objects of a scene to finished pages of lux maps; `run.Bake` is its door."""
