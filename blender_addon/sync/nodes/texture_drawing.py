"""Textures that are calculated from coordinates: as a picture of a UV tile, or at samples where there is no UV map."""

from dataclasses import dataclass

import numpy as np

from ....engine.scene.memo import recall
from . import fields, needs
from .fields import SAMPLES, Field, Layout, constant, rgb, spread
from .mapping import legacy_matrix
from .texture_nodes import placement_of

_SMALLEST, _LARGEST = 256, 1024
"""Sides of the pictures that textures are drawn on, as far as inputs are not finer. [pixels]"""

_WAVE = 16
"""Pixels for the finest wave or cell that counts, where so many are affordable."""

_COARSEST = 4
"""Pixels for a wave or cell with which it is still to be recognised."""

_AFFORDABLE = 1e7
"""Noises in three dimensions that one picture may take, about three seconds' worth."""

_PIECE = 1 << 14
"""Places evaluated at once, so that intermediate results stay in the processor's cache."""

_AT_THEIR_OWN = {"ShaderNodeTexWhiteNoise"}
"""Textures that have no coordinates of the object where nothing is linked."""

_PLACES = "values at places spread evenly over a unit cube are taken, and the mean of what comes of them is used"


@dataclass(frozen=True)
class Grain:
    """How fine a texture is and how much work it makes.

    Attributes
    ----------
    waves : float    Waves or cells per unit of the coordinates.
    octaves : float    Octaves above the first.
    work : float    What one octave at one place costs, in noises in three dimensions.
    is_endless : bool    Whether every place has a value of its own.
    """

    waves: float
    octaves: float = 0.0
    work: float = 1.0
    is_endless: bool = False


def draw_texture(at, draw, inputs, grain, has_places=True):
    """Return the field of a texture.

    Parameters
    ----------
    at : Inputs
    draw : callable
        Takes coordinates, three arrays, and an array for each input, or three for a vector, all of one shape; returns that
        shape and channels.
    inputs : sequence of Field
    grain : Grain
    has_places : bool    Whether the texture depends on its Vector input.
    """
    inputs = [_finite(at, each) for each in inputs]
    is_laid = has_places and at.context.lies_on_maps
    placement = placement_of(at, is_uv_by_default=False) if is_laid else None
    if not has_places:
        places, matrix = constant(0, 0, 0), np.eye(4)
    elif placement is None:
        legacy = legacy_matrix(at.node)
        places, matrix = _other_places(at), np.eye(4) if legacy is None else legacy
    elif not placement.matrix[:3, :2].any():
        places, matrix = constant(*placement.matrix[:3, 3]), np.eye(4)
    else:
        places, matrix = _tile(at, inputs, grain, placement), placement.matrix
        inputs = [_no_finer(each, places) for each in inputs]
    places, *inputs = _of_one_kind(at, places, *inputs)
    if at.context.has_texels:
        _weigh(at, places, matrix, grain)

    def drawn(places, matrix, *values):
        return _by_pieces(draw, places, matrix.reshape(3, 4), values)

    return at.map(drawn, places, constant(*matrix[:3].ravel()), *inputs)


def _weigh(at, places, matrix, grain):
    """Tell the picture of an object how fine the texture is."""
    if grain.is_endless:
        at.context.want(_LARGEST)
    waves = 0.0 if grain.is_endless else grain.waves * np.linalg.norm(matrix[:3, :3], 2)
    at.context.weigh(at, places, waves, grain.work * (1 + grain.octaves))


def _finite(at, field):
    """Return an input with 0 or the largest number in place of what is not finite."""
    if np.isfinite(field.limits()).all():
        return field
    at.note("An input is not finite", "0 or the largest number is used")
    return Field(np.nan_to_num(field.values), field.layout, True)


def _of_one_kind(at, *varying):
    """Return fields of which either none is made of samples or none is a picture, so that the texture is drawn once."""
    kinds = [field.is_spread for field in varying if not field.is_constant]
    if len(set(kinds)) < 2:
        return varying
    others = "varies over the map" if kinds[0] else "does not vary over the map"
    at.note("Inputs vary over a UV map and in other ways", f"the mean of what {others} is used")
    is_other = [not field.is_constant and field.is_spread != kinds[0] for field in varying]
    return [
        Field(field.mean(), None, field.is_stand_in) if is_mean else field
        for field, is_mean in zip(varying, is_other, strict=True)
    ]


def _no_finer(field, places):
    """Return a field as it is at the pixels of the tile that a texture is drawn on, if it is finer than those."""
    side = places.values.shape[0]
    if field.is_constant or field.is_spread or field.layout.tiles or _side_of(field) <= side:
        return field
    if field.layout.uv_map != places.layout.uv_map:
        return field
    transform = field.layout.transform
    u, v = np.moveaxis(places.values[..., :2] @ transform[:2, :2].T + transform[:2, 2], -1, 0)
    values = recall(
        field.values, ("on tile", side, *field.key()[1:]), lambda _: fields.look_up(field, u, v)
    )
    return Field(values, places.layout, field.is_stand_in)


def _side_of(field):
    """Return how many pixels of a picture lie along a UV tile, at most."""
    return int(np.ceil(fields.pixels_on(field, np.eye(3)).max()))


def _by_pieces(draw, places, matrix, values):
    arrays = (rgb(places), *values)
    shape = np.broadcast_shapes(*(each.shape[:-1] for each in arrays))
    flat = [np.broadcast_to(each, (*shape, each.shape[-1])) for each in arrays]
    places, *values = (each.reshape(-1, each.shape[-1]) for each in flat)
    pieces = []
    for start in range(0, len(places), _PIECE):
        piece = slice(start, start + _PIECE)
        moved = places[piece] @ matrix[:, :3].T.astype(np.float64) + matrix[:, 3]
        with np.errstate(all="ignore"):
            made = draw(moved.T.astype(np.float32), *(_channels(each[piece]) for each in values))
        pieces.append(np.broadcast_to(made, (len(moved), made.shape[-1])))
    return np.concatenate(pieces).reshape(*shape, -1)


def _channels(values):
    return values[:, 0] if values.shape[-1] == 1 else values.T


def _tile(at, inputs, grain, placement):
    """Return the field of the coordinates (u, v, 0) on a unit tile."""
    at.remark("A procedural texture never repeats", "it is drawn for one UV tile and repeated")
    at.context.needs.add(needs.tile(placement.uv_map))
    tile = at.context.images.tile(_side(at, inputs, grain, placement.matrix))
    interpolation = "closest" if grain.is_endless else "linear"
    return Field(tile, Layout(placement.uv_map, np.eye(3), interpolation, "repeat", at.node.name))


def _side(at, inputs, grain, matrix):
    """Return the side of the picture that a texture is drawn on."""
    waves = grain.waves * np.linalg.norm(matrix[:3, :2], axis=0).max()
    pictures = [each for each in inputs if not (each.is_constant or each.is_spread)]
    finest = min(max([0, *map(_side_of, pictures)]), fields.LARGEST_TILE)
    if grain.is_endless:
        at.remark("Every point has a value of its own", f"{_LARGEST} x {_LARGEST} are drawn")
        return _LARGEST
    wanted = max(np.clip(waves * _WAVE, _SMALLEST, _LARGEST), finest)
    affordable = np.sqrt(_AFFORDABLE / (grain.work * (1 + grain.octaves)))
    side = int(2 ** np.ceil(np.log2(wanted)))
    while side > max(affordable, _SMALLEST / 2):
        side //= 2
    if side < _COARSEST * waves:
        at.note(
            f"Details of the texture are only {1 / waves:.2g} of a UV tile wide",
            f"it is drawn on {side} x {side} pixels, on which they are lost",
        )
    return side


def _other_places(at):
    """Return coordinates that are no UV map, as they come in or as samples of a unit cube."""
    socket = at.node.inputs["Vector"]
    places = None
    if any(not link.is_muted for link in socket.links):
        places = at.field(socket)
        if not places.is_stand_in or (at.context.has_texels and not places.is_spread):
            return places
    elif at.node.bl_idname in _AT_THEIR_OWN:
        return at.field(socket)
    else:
        places = at.context.coordinates()
        if places is not None:
            return places
    at.context.needs.add(needs.SURFACE)
    at.note("A procedural texture without a UV map", _PLACES)
    if places is not None and places.is_spread:
        return places
    random = np.random.default_rng(0)
    return spread(np.stack([(random.permutation(SAMPLES) + 0.5) / SAMPLES for _ in range(3)], -1))
