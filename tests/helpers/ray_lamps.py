"""Lights from ray sets with closed forms, and floors under them."""

import functools
from types import SimpleNamespace
from unittest import mock

import numpy as np
from baking_rooms import lumel_places
from ray_files import zemax
from small_scenes import paint, quad

from lumenray.benchmarks.common.ray_sources import RADIUS, disk, even_numbers
from lumenray.engine.raysets import emission
from lumenray.engine.raysets.cloud import Fluctuation
from lumenray.engine.raysets.emission import Wish, prepare_light
from lumenray.engine.raysets.record import Rays
from lumenray.engine.scene.light import Luminaire, Output, Quantity
from lumenray.engine.scene.spectrum import Constant

SIZE = 0.1
"""Diameter of the source. [m]"""

SCALE = SIZE / (2.0 * RADIUS)
CHOSEN = {(disk, 20_000): 0.0064}
"""Shares of all rays that are neighbours of one, as `choose_share` finds them in many seconds."""

FLUX = 100.0
WHITE = Constant(1.0)
BLACK = paint(0.0, "black")


def rays_of(source, count, seed=1):
    position, direction = source(even_numbers(count, seed))
    return Rays(
        (position * SCALE).astype(np.float32), direction, np.full(count, FLUX / count, np.float32)
    )


@functools.cache
def light_of(source, count=20_000):
    """A ray file of a source of 100 lm, made ready."""
    import tempfile
    from pathlib import Path

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "lamp.dat"
        rays = rays_of(source, count)
        path.write_bytes(zemax(np.column_stack([1e3 * rays.position, rays.direction, rays.weight])))
        # A quarter of the rays that make a distribution: what it is off by is the few rays of the file.
        with mock.patch.object(emission, "GENERATED", emission.GENERATED // 4):
            return prepare_light(path, Wish(Fluctuation(CHOSEN.get((source, count)))))


def lamp_at(position, source=disk, spectrum=WHITE, count=None, **more):
    """The light of a source at a place, of ``count`` rays where the usual ones are more than is asked."""
    made = light_of(source) if count is None else light_of(source, count)
    frame = np.eye(4)
    frame[:3, 3] = position
    output = Output(Quantity.LUMINOUS_FLUX, FLUX, spectrum)
    return Luminaire("led", "led", output, frame, made.distribution, rays=made.emission, **more)


def exact_disk(places, centre):
    """Illuminance of horizontal places under a Lambertian disk that shines down, see `disk`. (n, 3) -> (n,) [lx]"""
    away = places - centre
    square, height, radius = (away[:, :2] ** 2).sum(axis=1), -away[:, 2], 0.5 * SIZE
    total = square + height**2 + radius**2
    factor = 0.5 * (1.0 - (total - 2.0 * radius**2) / np.sqrt(total**2 - 4.0 * radius**2 * square))
    return FLUX / (np.pi * radius**2) * factor


def floor(side, name="floor", height=0.0, material="black"):
    return quad(name, (-side / 2, -side / 2, height), (side, 0, 0), (0, side, 0), material)


def lumels_of(result, mesh):
    """Values and places of the lumels of the only map whose places are known."""
    values, places = result.lumels(0), lumel_places(result, result.maps[0], mesh)[0]
    known = np.isfinite(places[:, 0])
    columns = ("illuminance", "standard_error", "area")
    return SimpleNamespace(**{name: getattr(values, name)[known] for name in columns}), places[
        known
    ]
