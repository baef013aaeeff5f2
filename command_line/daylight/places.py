"""Where the daylight of a year is asked for: sensors from a list, or in a grid above floors, and lumels of maps."""

import numpy as np

from ...blender_addon.daylight_year.job import Places, find_keys
from ..options import words


def find_places(options, scene, objects: dict[str, str]) -> Places:
    """Return sensors from a list, or in a grid over floors; ``objects``: ids of the scene's by name."""
    if options.sensors is not None:
        from ...engine.formats.sensors import read_sensors

        sensors = read_sensors(options.sensors)
        return Places(sensors, np.ones(len(sensors)))
    from ...engine.daylight.grid import lay_grid

    keys = find_keys(objects, words(options.floor), f"{options.file}: the scene")
    grid = lay_grid(
        [scene.mesh(key) for key in keys], options.spacing, options.height, options.margin
    )
    up = np.tile([0.0, 0.0, 1.0], (len(grid), 1))
    return Places(np.column_stack([grid, up]), np.full(len(grid), options.spacing**2))


def find_maps(options, objects: dict[str, str]):
    """Return what maps of the year are asked for, a `BakeOrder` or None, and the names of their objects by ids.

    ``objects``: ids of the scene's by name.
    """
    if options.maps is None:
        return None, {}
    from ...engine.accuracy.stopping import StopRule
    from ...engine.baking.order import BakeOrder

    names = tuple(dict.fromkeys(words(options.maps)))
    keys = find_keys(objects, names, f"{options.file}: the scene")
    order = BakeOrder(keys, StopRule(samples=1), density=options.lumels_per_m)
    return order, dict(zip(keys, names, strict=True))
