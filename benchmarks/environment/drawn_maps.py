"""Equirectangular pictures with suns and lamps that are known: even disks, by the part of each cell that they cover."""

from dataclasses import dataclass

import numpy as np

FINE = 16
"""Places along each side of a cell by which it is told how much of it a disk covers."""


@dataclass(frozen=True)
class Spot:
    """An even disk.

    Parameters
    ----------
    elevation, azimuth : float    Of its middle, the azimuth from +y over +x. [degree]
    diameter : float    [degree]
    illuminance : float    That it adds to a plane facing it, in units of the picture's values.
    colour : (float, float, float)    With a Rec. 709 luminance of 1.
    """

    elevation: float
    azimuth: float
    diameter: float = 0.533
    illuminance: float = 1.0
    colour: tuple[float, float, float] = (1.0, 1.0, 1.0)

    @property
    def towards(self):
        """Unit vector to its middle."""
        up, turn = np.radians([self.elevation, self.azimuth])
        return np.array([np.cos(up) * np.sin(turn), np.cos(up) * np.cos(turn), np.sin(up)])

    @property
    def luminance(self):
        """What it adds, of a disk seen from a plane that faces it."""
        return self.illuminance / (np.pi * np.sin(np.radians(0.5 * self.diameter)) ** 2)


def look(rows, columns, height):
    """Unit vectors to places (in pixels, from below and from the left) of a picture of a height."""
    polar, turn = np.pi * rows / height, (0.5 - columns / (2 * height)) * 2.0 * np.pi
    plan = np.sin(polar)
    return np.stack(
        np.broadcast_arrays(plan * np.cos(turn), plan * np.sin(turn), -np.cos(polar)), axis=-1
    )


def make_map(height, spots, sky=1.0, ground=0.2, clip=None):
    """Return a picture (height, 2 height, 3) of disks over an even sky, or one by a function of directions, and a ground.

    ``clip``: largest value that a component keeps, as a camera does.
    """
    rows, columns = np.arange(height)[:, None] + 0.5, np.arange(2 * height)[None, :] + 0.5
    values = np.full((height, 2 * height, 3), ground, np.float32)
    first = -(-height // 2)
    above = sky(look(rows[first:], columns, height))[..., None] if callable(sky) else sky
    values[first:] = above
    for spot in spots:
        row, column, part = _cover(spot, height)
        values[row, column] += part[:, None] * spot.luminance * np.array(spot.colour)
    return values if clip is None else np.minimum(values, np.float32(clip))


def _cover(spot, height):
    """Rows and columns of the cells that a disk touches, and the part of their solid angle that it covers."""
    half, step = np.radians(0.5 * spot.diameter), np.pi / height
    polar = np.radians(90.0 + spot.elevation)
    low, high = (int((polar + side * (half + step)) / step) for side in (-1, 1))
    rows = np.arange(max(low, 0), min(high + 1, height))
    middles = look(rows[:, None] + 0.5, np.arange(2 * height)[None, :] + 0.5, height)
    near = np.flatnonzero((middles @ spot.towards > np.cos(half + 2.0 * step)).ravel())
    row, column = np.divmod(near, 2 * height)
    row = rows[row]
    part = (np.arange(FINE) + 0.5) / FINE
    v = row[:, None, None] + part[None, :, None]
    u = column[:, None, None] + part[None, None, :]
    chord = np.linalg.norm(look(v, u, height) - spot.towards, axis=-1)
    weight = np.sin(np.pi * v / height) * np.ones_like(u)
    inside = chord <= 2.0 * np.sin(0.5 * half)
    return row, column, (weight * inside).sum(axis=(1, 2)) / weight.sum(axis=(1, 2))
