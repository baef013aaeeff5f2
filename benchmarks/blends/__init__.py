"""Scenes as people have them, from a folder of .blend files, beside Cycles: `run` is the door."""
