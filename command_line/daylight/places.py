"""Where the daylight of a year is asked for: sensors from a list, or in a grid above floors."""

from dataclasses import dataclass

import numpy as np

from ...engine.errors import SceneError


@dataclass(frozen=True, eq=False)
class Places:
    """Sensors (n, 6) and the areas that they stand for (n,). [m, m2]"""

    sensors: np.ndarray
    areas: np.ndarray


def find_places(options, session) -> Places:
    """Sensors from a list, or in a grid over floors."""
    if options.sensors is not None:
        from ...engine.formats.sensors import read_sensors

        sensors = read_sensors(options.sensors)
        return Places(sensors, np.ones(len(sensors)))
    from ...engine.daylight.grid import lay_grid
    from ..options import words

    names = words(options.floor)
    floors = [
        session.scene.mesh(key)
        for name in names
        for key in find_keys(session, {name}, options.file)
    ]
    grid = lay_grid(floors, options.spacing, options.height, options.margin)
    up = np.tile([0.0, 0.0, 1.0], (len(grid), 1))
    return Places(np.column_stack([grid, up]), np.full(len(grid), options.spacing**2))


def find_keys(session, names: set[str], file) -> list[str]:
    """Ids of the scene's objects of some names."""
    meshes = session.scene.meshes
    missing = names - {item.name for item in meshes.values()}
    if missing:
        raise SceneError(f"{file}: the scene shows no object named {', '.join(sorted(missing))}")
    return [key for key, item in meshes.items() if item.name in names]
