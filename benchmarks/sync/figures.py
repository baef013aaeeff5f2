"""Sizes of the scenes, and parts of the time."""

SCENES = {"10k": 10_000, "100k": 100_000, "1M": 1_000_000, "3M": 3_000_000}
"""Triangles of a scene by its name."""

PARTS = ("edit", "depsgraph", "walk", "transfer", "commit", "first sample", "rest")
"""Where the time goes: see `Timing`."""
