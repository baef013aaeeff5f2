"""Nodes that calculate a texture from coordinates.

Every function takes the node's `Inputs` and returns the `Field` of the wanted output.
"""

import bpy
import numpy as np

from .fields import constant, rgb
from .procedural import gabor, gradient, magic, noise, voronoi, wave, white_noise
from .texture_drawing import Grain, draw_texture

_FAINT = 0.1
"""Octaves fainter than this count for nothing in the choice of a picture."""

_BY_BITS = bpy.app.version < (5, 0, 0)
"""Whether Blender strews the points of Voronoi cells as before its version 5.0."""


def _point(dimensions, places, w, scale):
    """Return the scaled coordinates that count in 1D, 2D, 3D or 4D."""
    parts = {"1D": (w,), "2D": places[:2], "3D": places, "4D": (*places, w)}[dimensions]
    return [np.asarray(part * scale, np.float32) for part in parts]


def _largest(field):
    return float(np.nan_to_num(np.max(np.abs(field.limits()))))


def _octaves(detail):
    """Return the most octaves above the first."""
    return min(_largest(detail), noise.MOST_DETAIL)


def _octaves_that_count(detail, roughness):
    """Return how many octaves above the first are to be seen."""
    many, faintest = _octaves(detail), min(_largest(roughness), 1.0)
    if faintest < 1:
        many = min(many, np.log(_FAINT) / np.log(max(faintest, 1e-6)))
    return many


def _grain(waves, scale, detail, roughness, lacunarity, work, factor=1.0):
    count = _octaves_that_count(detail, roughness)
    with np.errstate(over="ignore"):
        finer = np.float64(max(_largest(lacunarity), 1.0)) ** np.ceil(count)
        waves = waves * _largest(scale) * finer * factor
    return Grain(waves, _octaves(detail), work)


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
    return draw_texture(at, draw, inputs, grain, size > 1)


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
    return draw_texture(at, draw, inputs, grain, size > 1)


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
        # Of the Noise Texture alone Blender takes no detail below 0; from -1 on there is no octave.
        octaves = noise.Octaves(np.clip(detail, -0.999, noise.MOST_DETAIL), roughness)
        point = [np.asarray(each * scale, np.float32) for each in places]
        return wave.draw_wave(
            point, form, direction, profile, phase, distortion, noise_scale, octaves
        )

    waves = 10 / np.pi * _largest(scale) * (1 + 0.1 * _largest(distortion))
    return draw_texture(at, draw, inputs, Grain(waves, _octaves(detail)))


def _magic(at):
    depth = at.node.turbulence_depth

    def draw(places, scale, distortion):
        return magic.draw_magic(places, scale, depth, distortion)

    inputs = scale, distortion = at("Scale"), at("Distortion")
    waves = _largest(scale) * (1 + min(_largest(distortion), 2.0) * depth)
    made = draw_texture(at, draw, inputs, Grain(waves))
    if at.output.identifier == "Color":
        return made
    return at.map(lambda colour: colour.mean(axis=-1, keepdims=True), made)


def _gradient(at):
    form = at.node.gradient_type
    return draw_texture(at, lambda places: gradient.draw_gradient(places, form), (), Grain(16.0))


def _white_noise(at):
    is_colour, dimensions = at.output.identifier == "Color", at.node.noise_dimensions
    size = int(dimensions[0])
    w = at("W") if size in {1, 4} else constant(0)

    def draw(places, w):
        return white_noise.draw_white_noise(_point(dimensions, places, w, 1), is_colour)

    return draw_texture(at, draw, (w,), Grain(1.0, is_endless=True), size > 1)


def _gabor(at):
    output, is_flat = at.output.identifier, at.node.gabor_type == "2D"
    scale, frequency, anisotropy = (at(n) for n in ("Scale", "Frequency", "Anisotropy"))
    if is_flat:
        direction = at("Orientation 2D")
    else:
        direction = at.map(lambda axis: np.array(rgb(axis)), at("Orientation 3D"))

    def draw(places, scale, frequency, anisotropy, direction):
        point = _point("2D" if is_flat else "3D", places, None, scale)
        return gabor.draw_gabor(point, frequency, anisotropy, direction)[output][..., None]

    inputs = (scale, frequency, anisotropy, direction)
    waves = _largest(scale) * max(1.0, _largest(frequency))
    return draw_texture(at, draw, inputs, Grain(waves, work=8 * 3 ** (2 if is_flat else 3) / 4))


FUNCTIONS = {
    "ShaderNodeTexNoise": _noise,
    "ShaderNodeTexVoronoi": _voronoi,
    "ShaderNodeTexWave": _wave,
    "ShaderNodeTexMagic": _magic,
    "ShaderNodeTexGradient": _gradient,
    "ShaderNodeTexWhiteNoise": _white_noise,
    "ShaderNodeTexGabor": _gabor,
}
"""What each node does, by its ``bl_idname``."""
