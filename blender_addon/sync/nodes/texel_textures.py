"""Pictures and regular patterns at the texels of an object's surface, wherever their coordinates come from.

References
----------
Blender source, ``intern/cycles/kernel/svm/image.h``, ``checker.h`` and ``brick.h``, and ``kernel/camera/projection.h``.
"""

import numpy as np

from ....engine.scene.memo import recall, recall_latest
from . import fields, patterns
from .fields import Field, Layout, constant, map_fields, rgb
from .graph import node_key
from .mapping import legacy_matrix

_NUDGE, _SHRINK = 1e-6, 0.999999
"""What Cycles does to the coordinates of a checker, so that surfaces on its planes are of one colour."""


def places_of(at, is_uv_by_default: bool) -> Field:
    """Return the coordinates that a texture goes by."""
    socket = at.node.inputs["Vector"]
    if any(not link.is_muted for link in socket.links):
        places = at.field(socket).settled()
    else:
        places = at.context.uv() if is_uv_by_default else at.context.coordinates()
    legacy = legacy_matrix(at.node)
    if legacy is None:
        return places
    matrix = constant(*legacy[:3].ravel())

    def move(places, matrix):
        matrix = matrix.reshape(3, 4)
        return rgb(places) @ matrix[:, :3].T + matrix[:, 3]

    return at.map(move, places, matrix)


def draw_checker(at) -> Field:
    """Return where a checker has its first colour."""
    places, scale = places_of(at, False), at("Scale")
    at.context.weigh(at, places, 0.5 * _largest(scale), is_sharp=True)

    def draw(places, scale):
        cell = np.floor((rgb(places) * scale + _NUDGE) * _SHRINK).astype(np.int64)
        odd = np.abs(cell) % 2
        return ((odd[..., 0] == odd[..., 1]) == (odd[..., 2] == 1)).astype(np.float32)[..., None]

    return at.map(draw, places, scale)


def draw_bricks(at, bonding) -> tuple[Field, Field]:
    """Return the share of mortar and the tint of bricks."""
    places, scale = places_of(at, False), at("Scale")
    finest = max(abs(bonding.mortar_size), 1e-3 * abs(bonding.row_height))
    at.context.weigh(at, places, 0.25 * _largest(scale) / finest, is_sharp=True)

    def draw(places, scale, *_numbers):
        x, y, _ = np.moveaxis(rgb(places) * scale, -1, 0)
        return np.stack(patterns.draw_bricks(x, y, bonding), axis=-1).astype(np.float32)

    numbers = constant(bonding.mortar_size, bonding.mortar_smooth, bonding.bias)
    sizes = constant(bonding.brick_width, bonding.row_height)
    both = at.map(draw, places, scale, numbers, sizes)
    return tuple(
        Field(np.ascontiguousarray(both.values[..., k : k + 1]), both.layout, both.is_stand_in)
        for k in (0, 1)
    )


def _largest(field: Field) -> float:
    return float(np.nan_to_num(np.max(np.abs(field.limits()))))


def look_up_picture(at, pixels, tiles=()) -> Field:
    """Return a picture's values by the projection that its node has.

    Parameters
    ----------
    at : Inputs
    pixels : (height, width, c) array
    tiles : tuple of Tile    As of `ImageTexture`.
    """
    node, context = at.node, at.context
    places = places_of(at, node.projection == "FLAT")
    height, width = pixels.shape[:2]
    if tiles:
        width, height = (max(tile[k] for tile in tiles) for k in (2, 3))
    if height * width > 1:
        is_sharp = node.interpolation == "Closest"
        context.weigh(at, places, 0.25 * max(height, width), is_sharp=is_sharp)
        if not tiles:
            pixels = _coarsened(pixels, context.step_of(places))
    inputs = [places]
    if node.projection == "BOX":
        inputs.append(context.normals())
    shown = _Shown(pixels, node.interpolation == "Closest", node.extension.lower(), tiles)
    blend = node.projection_blend

    def show(places, *normals):
        places = np.asarray(rgb(places), np.float64)
        if node.projection == "BOX":
            return _on_box(shown, places, np.asarray(rgb(normals[0]), np.float64), blend)
        return shown.at(*_PROJECTIONS[node.projection](places))

    pictures = [each for each in inputs if not each.is_constant]
    if not pictures:
        return map_fields(show, *inputs, note=at.note)

    def make():
        made = map_fields(show, *inputs, note=at.note)
        return made.values, made.layout

    place = (context.datablock, *node_key(node, at.groups), at.output.identifier, "shown")
    how = (node.projection, node.interpolation, node.extension, blend, tiles)
    first, *others = (each.values for each in pictures)
    keys = (how, [each.key() for each in inputs])
    values, layout = recall_latest(first, place, [*others, pixels], keys, make)
    return Field(values, layout, any(each.is_stand_in for each in inputs))


def with_black_border(pixels, transform):
    """Make "black outside" a picture whose edge pixels go on for ever."""
    height, width = pixels.shape[:2]
    shrink = np.array(
        [
            [width / (width + 2), 0, 1 / (width + 2)],
            [0, height / (height + 2), 1 / (height + 2)],
            [0, 0, 1],
        ]
    )
    bordered = recall(pixels, "bordered", lambda p: np.pad(p, ((1, 1), (1, 1), (0, 0))))
    return bordered, shrink @ transform


def _coarsened(pixels, step: float):
    """Return a picture with the means of as many pixels as lie between texels, so that they count as they do on the whole.

    Parameters
    ----------
    pixels : (height, width, c) array
    step : float    Between texels, as a part of the picture.
    """
    height, width = pixels.shape[:2]
    factor = 1
    while 2 * factor <= step * min(height, width) and not (height | width) % (2 * factor):
        factor *= 2
    if factor == 1:
        return pixels

    def mean(values):
        rows, columns = height // factor, width // factor
        return values.reshape(rows, factor, columns, factor, -1).mean(axis=(1, 3))

    return recall(pixels, ("coarsened", factor), mean)


class _Shown:
    """A picture that is looked up at places of its own."""

    def __init__(self, pixels, is_closest: bool, extension: str, tiles=()):
        self._transform = np.eye(3)
        if extension == "clip" and tiles:
            extension = "extend"
        elif extension == "clip":
            pixels, self._transform = with_black_border(pixels, self._transform)
            extension = "extend"
        interpolation = "closest" if is_closest else "linear"
        self._field = Field(pixels, Layout("", np.eye(3), interpolation, extension, tiles=tiles))

    def at(self, u, v) -> np.ndarray:
        """Values at (u, v)."""
        (a, b, c), (d, e, f), _ = self._transform
        return fields.look_up(self._field, a * u + b * v + c, d * u + e * v + f)


def _flat(places):
    return places[..., 0], places[..., 1]


def _sphere(places):
    x, y, z = np.moveaxis(2.0 * places - 1.0, -1, 0)
    length = np.sqrt(x**2 + y**2 + z**2)
    u = np.where((x == 0) & (y == 0), 0.0, 0.5 * (1.0 - np.arctan2(x, y) / np.pi))
    v = 1.0 - np.arccos(np.clip(z / np.maximum(length, 1e-30), -1.0, 1.0)) / np.pi
    return np.where(length > 0, u, 0.0), np.where(length > 0, v, 0.0)


def _tube(places):
    x, y, z = np.moveaxis(2.0 * places - 1.0, -1, 0)
    has_side = np.hypot(x, y) > 0
    u = np.where(has_side, 0.5 * (1.0 - np.arctan2(x, y) / np.pi), 0.0)
    return u, np.where(has_side, 0.5 * (z + 1.0), 0.0)


_PROJECTIONS = {"FLAT": _flat, "SPHERE": _sphere, "TUBE": _tube}


def _on_box(shown: _Shown, places, normals, blend: float) -> np.ndarray:
    """Mix what the three directions of a box show, as the surface faces them."""
    normals = np.broadcast_to(normals, places.shape)
    x, y, z = np.moveaxis(places, -1, 0)
    sides = (
        (np.where(normals[..., 0] < 0, 1.0 - y, y), z),
        (np.where(normals[..., 1] > 0, 1.0 - x, x), z),
        (np.where(normals[..., 2] > 0, 1.0 - y, y), x),
    )
    weights = box_weights(normals, blend).astype(np.float32)
    return sum(weights[..., k, None] * shown.at(*sides[k]) for k in range(3))


def box_weights(normals: np.ndarray, blend: float) -> np.ndarray:
    """Return the shares of the three directions of a box projection. (..., 3)

    Parameters
    ----------
    normals : (..., 3) array    In the object's frame.
    blend : float    0: no mixing.
    """
    part = np.abs(normals)
    part = part / np.maximum(part.sum(axis=-1, keepdims=True), 1e-30)
    x, y, z = np.moveaxis(part, -1, 0)
    limit = 0.5 * (1.0 + blend)
    alone = [
        (x > limit * (x + y)) & (x > limit * (x + z)),
        (y > limit * (x + y)) & (y > limit * (y + z)),
        (z > limit * (x + z)) & (z > limit * (y + z)),
    ]
    one = np.eye(3)
    if blend <= 0.0:
        return np.select([each[..., None] for each in alone], list(one), one[0])
    pairs = [
        (z < (1.0 - limit) * (y + x), _between(x, y, blend), (0, 1)),
        (x < (1.0 - limit) * (y + z), _between(y, z, blend), (1, 2)),
        (y < (1.0 - limit) * (x + z), _between(x, z, blend), (0, 2)),
    ]
    made = ((2.0 - limit) * part + (limit - 1.0)) / (2.0 * limit - 1.0)
    for where, share, (first, second) in reversed(pairs):
        mixed = share[..., None] * one[first] + (1.0 - share)[..., None] * one[second]
        made = np.where(where[..., None], mixed, made)
    for where, side in zip(reversed(alone), reversed(one), strict=True):
        made = np.where(where[..., None], side, made)
    return made


def _between(first, second, blend: float) -> np.ndarray:
    share = first / np.maximum(first + second, 1e-30)
    return np.clip((share - 0.5 * (1.0 - blend)) / blend, 0.0, 1.0)
