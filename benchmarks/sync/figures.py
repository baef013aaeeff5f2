"""Sizes of the scenes, parts of the time, and how they are summed up."""

SCENES = {"10k": 10_000, "100k": 100_000, "1M": 1_000_000, "3M": 3_000_000}
"""Triangles of a scene by its name."""

PARTS = ("edit", "depsgraph", "walk", "transfer", "commit", "first sample", "rest")
"""Where the time goes: see `Timing`."""


def median(values) -> float:
    """Return the middle value, or the mean of the two."""
    row = sorted(values)
    return 0.5 * (row[(len(row) - 1) // 2] + row[len(row) // 2])
