"""How much the benchmark of ray sets draws, how far away, and how often."""

DISTANCES = (0.5, 1.0, 2.0, 5.0, 20.0)
"""Of the planes from the source's surface, in sizes."""

DRAWN, PIECE = 6 << 20, 1 << 20
"""Rays that are generated for every comparison, and at a time."""

SERIES_RAYS, REPLICATES = 2_000, 32
"""Rays of the file whose convergence is looked at, and repetitions."""

MAP_SIDE, MAP_SAMPLES = 24, 2048
"""Lumels along a map's side, and samples of each."""
