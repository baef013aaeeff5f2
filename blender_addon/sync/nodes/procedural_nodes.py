"""Nodes that calculate a texture from coordinates, and the mapping of coordinates that are no UV map.

On a UV map the texture is drawn as a picture of the unit tile. Elsewhere it is evaluated at samples of the coordinates.
Every function takes the node's `Inputs` and returns the `Field` of the wanted output.
"""

from dataclasses import dataclass
from functools import cache

import bpy
import mathutils
import numpy as np

from ....engine.scene.memo import recall
from . import fields
from .fields import SAMPLES, Field, Layout, constant, rgb, spread
from .mapping import legacy_matrix
from .procedural import gabor, gradient, magic, noise, voronoi, wave, white_noise
from .texture_nodes import placement_of

_SMALLEST, _LARGEST = 256, 1024
"""Sides of the pictures that textures are drawn on, as far as inputs are not finer. [pixels]"""

_WAVE = 16
"""Pixels for the finest wave or cell that counts, where so many are affordable."""

_COARSEST = 4
"""Pixels for a wave or cell with which it is still to be recognised."""

_FAINT = 0.1
"""Octaves fainter than this count for nothing in the choice of a picture."""

_AFFORDABLE = 1e7
"""Noises in three dimensions that one picture may take, about five seconds' worth."""

_PIECE = 1 << 14
"""Places evaluated at once, so that intermediate results stay in the processor's cache."""

_BY_BITS = bpy.app.version < (5, 0, 0)
"""Whether Blender strews the points of Voronoi cells as before its version 5.0."""

_AT_THEIR_OWN = {"ShaderNodeTexWhiteNoise"}
"""Textures that have no coordinates of the object where nothing is linked."""

_PLACES = "values at places spread evenly over a unit cube are taken, and the mean of what comes of them is used"


@dataclass(frozen=True)
class _Grain:
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


def _draw(at, draw, inputs, grain, has_places=True):
    """Return the field of a texture.

    Parameters
    ----------
    at : Inputs
    draw : callable
        Takes coordinates, three arrays, and an array for each input, all of one shape; returns that shape and channels.
    inputs : sequence of Field
    grain : _Grain
    has_places : bool    Whether the texture depends on its Vector input.
    """
    places, matrix = _places(at, inputs, grain) if has_places else (constant(0, 0, 0), np.eye(4))
    places, *inputs = _of_one_kind(at, places, *inputs)
    if not places.is_constant:
        inputs = [_no_finer(each, places) for each in inputs]

    def drawn(places, matrix, *values):
        return _by_pieces(draw, places, matrix.reshape(3, 4), values)

    return at.map(drawn, places, constant(*matrix[:3].ravel()), *inputs)


def _of_one_kind(at, *varying):
    """Return fields of which either none is made of samples or none is a picture, so that the texture is drawn once."""
    kinds = [field.is_spread for field in varying if not field.is_constant]
    if len(set(kinds)) < 2:
        return varying
    at.note("Inputs vary over a UV map, and others in another way", "the mean of some is used")
    is_other = [not field.is_constant and field.is_spread != kinds[0] for field in varying]
    return [
        Field(field.mean(), None, field.is_stand_in) if is_mean else field
        for field, is_mean in zip(varying, is_other, strict=True)
    ]


def _no_finer(field, places):
    """Return a field as it is at the pixels of the tile that a texture is drawn on, if it is finer than those."""
    side = places.values.shape[0]
    if field.is_constant or field.is_spread or _side_of(field) <= side:
        return field
    if field.layout.uv_map != places.layout.uv_map:
        return field
    transform = field.layout.transform
    u, v = np.moveaxis(_tile(side)[..., :2] @ transform[:2, :2].T + transform[:2, 2], -1, 0)
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
            made = draw(moved.T.astype(np.float32), *(each[piece, 0] for each in values))
        pieces.append(np.broadcast_to(made, (len(moved), made.shape[-1])))
    return np.concatenate(pieces).reshape(*shape, -1)


def _places(at, inputs, grain):
    """Return the field of coordinates, and the matrix that is still to be applied to them."""
    placement = placement_of(at, is_uv_by_default=False)
    if placement is None:
        legacy = legacy_matrix(at.node)
        return _other_places(at), np.eye(4) if legacy is None else legacy
    matrix = placement.matrix
    if not matrix[:3, :2].any():
        return constant(*matrix[:3, 3]), np.eye(4)
    at.remark("A procedural texture never repeats", "it is drawn for one UV tile and repeated")
    layout = Layout(
        placement.uv_map,
        np.eye(3),
        "closest" if grain.is_endless else "linear",
        "repeat",
        at.node.name,
    )
    return Field(_tile(_side(at, inputs, grain, matrix)), layout), matrix


@cache
def _tile(side):
    """Return the coordinates (u, v, 0) of the pixels of a unit tile."""
    middles = ((np.arange(side) + 0.5) / side).astype(np.float32)
    u, v = np.meshgrid(middles, middles)
    places = np.stack([u, v, np.zeros_like(u)], axis=-1)
    places.flags.writeable = False
    return places


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
        if not places.is_stand_in:
            return places
    elif at.node.bl_idname in _AT_THEIR_OWN:
        return at.field(socket)
    at.note("A procedural texture without a UV map", _PLACES)
    if places is not None and places.is_spread:
        return places
    random = np.random.default_rng(0)
    return spread(np.stack([(random.permutation(SAMPLES) + 0.5) / SAMPLES for _ in range(3)], -1))


def _point(dimensions, places, w, scale):
    """Return the scaled coordinates that count in 1D, 2D, 3D or 4D."""
    parts = {"1D": (w,), "2D": places[:2], "3D": places, "4D": (*places, w)}[dimensions]
    return [np.asarray(part * scale, np.float32) for part in parts]


def _largest(field):
    return float(np.max(np.abs(field.limits())))


def _octaves_that_count(detail, roughness):
    """Return how many octaves above the first are to be seen."""
    many, faintest = min(_largest(detail), noise.MOST_DETAIL), min(_largest(roughness), 1.0)
    if faintest < 1:
        many = min(many, np.log(_FAINT) / np.log(max(faintest, 1e-6)))
    return many


def _grain(waves, scale, detail, roughness, lacunarity, work, factor=1.0):
    count = _octaves_that_count(detail, roughness)
    finer = max(_largest(lacunarity), 1.0) ** np.ceil(count)
    return _Grain(waves * _largest(scale) * finer * factor, _largest(detail), work)


def _noise(at):
    node, is_colour = at.node, at.output.identifier == "Color"
    dimensions = node.noise_dimensions
    size = int(dimensions[0])
    names = ("Scale", "Detail", "Roughness", "Lacunarity", "Distortion")
    scale, detail, roughness, lacunarity, distortion = (at(name) for name in names)
    has_offset = node.noise_type in {"HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL", "HETERO_TERRAIN"}
    has_gain = node.noise_type in {"HYBRID_MULTIFRACTAL", "RIDGED_MULTIFRACTAL"}
    w = at("W") if size in {1, 4} else constant(0)
    offset = at("Offset") if has_offset else constant(0)
    gain = at("Gain") if has_gain else constant(1)

    def draw(places, w, scale, detail, roughness, lacunarity, distortion, offset, gain):
        octaves = noise.Octaves(
            np.clip(detail, 0, noise.MOST_DETAIL),
            np.maximum(roughness, 0),
            lacunarity,
            offset,
            gain,
            node.noise_type,
            node.normalize,
        )
        return noise.draw_noise(
            _point(dimensions, places, w, scale), octaves, distortion, is_colour
        )

    inputs = (w, scale, detail, roughness, lacunarity, distortion, offset, gain)
    work = 2**size / 8 * (3 if is_colour else 1)
    finer = 1 + _largest(distortion)
    grain = _grain(1.0, scale, detail, roughness, lacunarity, work, finer)
    return _draw(at, draw, inputs, grain, size > 1)


def _voronoi(at):
    node, output = at.node, at.output.identifier
    dimensions, feature, metric = node.voronoi_dimensions, node.feature, node.distance
    size = int(dimensions[0])
    is_octave = feature != "N_SPHERE_RADIUS"
    is_measured = feature in {"F1", "F2", "SMOOTH_F1"} and size > 1
    scale, randomness = at("Scale"), at("Randomness")
    w = at("W") if size in {1, 4} else constant(0)
    detail, roughness, lacunarity = (
        at(name) if is_octave else constant(value)
        for name, value in (("Detail", 0), ("Roughness", 0), ("Lacunarity", 1))
    )
    smoothness = at("Smoothness") if feature == "SMOOTH_F1" else constant(0)
    exponent = at("Exponent") if is_measured and metric == "MINKOWSKI" else constant(1)

    def draw(places, w, scale, detail, roughness, lacunarity, smoothness, exponent, randomness):
        cells = voronoi.Cells(
            feature,
            metric,
            node.normalize,
            np.clip(detail, 0, voronoi.MOST_DETAIL),
            np.clip(roughness, 0, 1),
            lacunarity,
            np.clip(smoothness / 2, 0, 0.5),
            exponent,
            np.clip(randomness, 0, 1),
            _BY_BITS,
        )
        return _look(output, feature, _point(dimensions, places, w, scale), cells, scale)

    inputs = (w, scale, detail, roughness, lacunarity, smoothness, exponent, randomness)
    work = (5 if feature == "SMOOTH_F1" else 3) ** size / 4
    grain = _grain(1.0, scale, detail, roughness, lacunarity, work)
    return _draw(at, draw, inputs, grain, size > 1)


def _look(output, feature, point, cells, scale):
    """Return one output of the Voronoi Texture; 0 where the feature has no such output."""
    nothing = np.zeros_like(point[0])
    if feature == "DISTANCE_TO_EDGE":
        shown = voronoi.draw_edges(point, cells) if output == "Distance" else nothing
        return shown[..., None]
    if feature == "N_SPHERE_RADIUS":
        shown = voronoi.draw_radius(point, cells) if output == "Radius" else nothing
        return shown[..., None]
    if output == "Radius":
        return nothing[..., None]
    found = voronoi.draw_voronoi(point, cells)
    if output == "Distance":
        return found.distance[..., None]
    if output == "Color":
        return found.colour
    place = [
        np.divide(each, scale, out=np.zeros_like(each), where=scale != 0) for each in found.place
    ]
    size = len(place)
    if output == "W":
        return (place[-1] if size in {1, 4} else nothing)[..., None]
    place = place[:3] if size > 1 else []
    return np.stack([*place, *[nothing] * (3 - len(place))], axis=-1)


def _wave(at):
    node = at.node
    form, profile = node.wave_type, node.wave_profile
    direction = node.bands_direction if form == "BANDS" else node.rings_direction
    names = ("Scale", "Distortion", "Detail", "Detail Scale", "Detail Roughness", "Phase Offset")
    inputs = scale, distortion, detail, _, _, _ = [at(name) for name in names]

    def draw(places, scale, distortion, detail, noise_scale, roughness, phase):
        octaves = noise.Octaves(np.clip(detail, 0, noise.MOST_DETAIL), roughness)
        point = [np.asarray(each * scale, np.float32) for each in places]
        return wave.draw_wave(
            point, form, direction, profile, phase, distortion, noise_scale, octaves
        )

    waves = 10 / np.pi * _largest(scale) * (1 + 0.1 * _largest(distortion))
    return _draw(at, draw, inputs, _Grain(waves, _largest(detail)))


def _magic(at):
    depth = at.node.turbulence_depth

    def draw(places, scale, distortion):
        return magic.draw_magic(places, scale, depth, distortion)

    inputs = scale, distortion = at("Scale"), at("Distortion")
    waves = _largest(scale) * (1 + min(_largest(distortion), 2.0) * depth)
    made = _draw(at, draw, inputs, _Grain(waves))
    if at.output.identifier == "Color":
        return made
    return at.map(lambda colour: colour.mean(axis=-1, keepdims=True), made)


def _gradient(at):
    form = at.node.gradient_type
    return _draw(at, lambda places: gradient.draw_gradient(places, form), (), _Grain(16.0))


def _white_noise(at):
    is_colour, dimensions = at.output.identifier == "Color", at.node.noise_dimensions
    size = int(dimensions[0])
    w = at("W") if size in {1, 4} else constant(0)

    def draw(places, w):
        return white_noise.draw_white_noise(_point(dimensions, places, w, 1), is_colour)

    return _draw(at, draw, (w,), _Grain(1.0, is_endless=True), size > 1)


def _gabor(at):
    output, is_flat = at.output.identifier, at.node.gabor_type == "2D"
    scale, frequency, anisotropy = (at(n) for n in ("Scale", "Frequency", "Anisotropy"))
    turn = at("Orientation 2D") if is_flat else constant(0)
    axis = constant(0, 0, 1) if is_flat else at("Orientation 3D")
    axes = [at.map(lambda v, c=channel: rgb(v)[..., c : c + 1], axis) for channel in range(3)]

    def draw(places, scale, frequency, anisotropy, turn, *axis):
        point = _point("2D" if is_flat else "3D", places, None, scale)
        direction = turn if is_flat else axis
        return gabor.draw_gabor(point, frequency, anisotropy, direction)[output][..., None]

    inputs = (scale, frequency, anisotropy, turn, *axes)
    waves = _largest(scale) * max(1.0, _largest(frequency))
    return _draw(at, draw, inputs, _Grain(waves, work=8 * 3 ** (2 if is_flat else 3) / 4))


def _mapping(at):
    """Map what is no UV map; where it is one, the textures ask for its placement."""
    kind = at.node.vector_type
    vector, scale = at("Vector"), at("Scale")
    location = at("Location") if kind in {"POINT", "TEXTURE"} else constant(0)
    angles = at("Rotation").settled()
    if not angles.is_constant:
        at.note("Rotation varies over the surface", "its mean is used")
    turned = mathutils.Euler([float(angle) for angle in rgb(angles.mean())], "XYZ").to_matrix()
    matrix = constant(*np.array(turned).ravel())

    def move(vector, scale, location, matrix):
        vector, matrix = rgb(vector), matrix.reshape(3, 3)
        if kind == "TEXTURE":
            return _divided((vector - location) @ matrix, scale)
        if kind != "NORMAL":
            return (vector * scale) @ matrix.T + location
        normal = _divided(vector, scale) @ matrix.T
        return _divided(normal, np.linalg.norm(normal, axis=-1, keepdims=True))

    return at.map(move, vector, scale, location, matrix)


def _divided(vector, divisor):
    divisor = np.broadcast_to(divisor, vector.shape)
    return np.divide(vector, divisor, out=np.zeros_like(vector), where=divisor != 0)


FUNCTIONS = {
    "ShaderNodeMapping": _mapping,
    "ShaderNodeTexNoise": _noise,
    "ShaderNodeTexVoronoi": _voronoi,
    "ShaderNodeTexWave": _wave,
    "ShaderNodeTexMagic": _magic,
    "ShaderNodeTexGradient": _gradient,
    "ShaderNodeTexWhiteNoise": _white_noise,
    "ShaderNodeTexGabor": _gabor,
}
"""What each node does, by its ``bl_idname``."""
