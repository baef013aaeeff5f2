"""Nodes that change colours or numbers place by place.

Every function takes the node's `Inputs` and returns the `Field` of the wanted output.
"""

import numpy as np

from ....libraries import spectra
from . import arithmetic, blending
from .fields import constant, luminance, rgb

_RAMP_SIZE = 256
_PLANCK_NM_K = 1.438776877e7
"""Second radiation constant. [nm K]"""

_REC709_FROM_XYZ = np.array(
    [
        [3.2404542, -1.5371385, -0.4985314],
        [-0.9692660, 1.8760108, 0.0415560],
        [0.0556434, -0.2040259, 1.0572252],
    ]
)


def _clamped(field_values, is_clamped):
    return np.clip(field_values, 0, 1) if is_clamped else field_values


def _mix(at):
    node = at.node
    kind = {"FLOAT": "Float", "VECTOR": "Vector", "RGBA": "Color"}.get(node.data_type)
    if kind is None:
        at.note("A rotation is mixed", "0 is used")
        return constant(0.0)
    is_per_channel = node.data_type == "VECTOR" and node.factor_mode == "NON_UNIFORM"
    factor = at("Factor_Vector" if is_per_channel else "Factor_Float")
    mode = node.blend_type if node.data_type == "RGBA" else "MIX"
    is_clamped = node.clamp_result and node.data_type == "RGBA"

    def mix(t, first, second):
        return _clamped(
            blending.blend(mode, _clamped(t, node.clamp_factor), first, second), is_clamped
        )

    return at.map(mix, factor, at(f"A_{kind}"), at(f"B_{kind}"))


def _mix_rgb(at):
    node = at.node

    def mix(t, first, second):
        return _clamped(
            blending.blend(node.blend_type, np.clip(t, 0, 1), first, second), node.use_clamp
        )

    return at.map(mix, at("Fac"), at("Color1"), at("Color2"))


def _math(at):
    node = at.node

    def calculate(*values):
        return _clamped(arithmetic.calculate(node.operation, *values), node.use_clamp)

    return at.map(calculate, *(at.field(socket) for socket in node.inputs[:3]))


def _vector_math(at):
    operation = at.node.operation
    vectors = [at.field(socket) for socket in at.node.inputs[:3]]
    if operation in arithmetic.VECTOR_OPERATIONS:
        return at.map(lambda *v: arithmetic.calculate(operation, *map(rgb, v)), *vectors)
    products = {
        "DOT_PRODUCT": lambda a, b: (rgb(a) * rgb(b)).sum(axis=-1, keepdims=True),
        "DISTANCE": lambda a, b: np.linalg.norm(rgb(a) - rgb(b), axis=-1, keepdims=True),
        "LENGTH": lambda a, b: np.linalg.norm(rgb(a), axis=-1, keepdims=True),
        "NORMALIZE": _normalise,
    }
    if operation == "SCALE":
        return at.map(lambda a, s: rgb(a) * s, vectors[0], at("Scale"))
    if operation in products:
        return at.map(products[operation], *vectors[:2])
    at.note(f"Vector operation {operation} is not supported", "its first vector is used")
    return vectors[0]


def _normalise(a, _):
    length = np.linalg.norm(rgb(a), axis=-1, keepdims=True)
    return np.where(length > 0, rgb(a) / np.where(length > 0, length, 1), 0)


def _clamp(at):
    def clamp(value, low, high):
        if at.node.clamp_type == "RANGE":
            low, high = np.minimum(low, high), np.maximum(low, high)
        return np.minimum(np.maximum(value, low), high)

    return at.map(clamp, at("Value"), at("Min"), at("Max"))


def _map_range(at):
    node = at.node
    suffix = "_FLOAT3" if node.data_type == "FLOAT_VECTOR" else ""
    names = ["From_Min", "From_Max", "To_Min", "To_Max"]
    if not suffix:
        names = [name.replace("_", " ") for name in names]
    ends = [at(name + suffix) for name in names]
    is_clamped = node.clamp and node.interpolation_type in {"LINEAR", "STEPPED"}

    def carry(value, steps, *ends):
        result = arithmetic.map_range(node.interpolation_type, value, ends[:2], ends[2:], steps)
        if not is_clamped:
            return result
        return np.clip(result, np.minimum(*ends[2:]), np.maximum(*ends[2:]))

    return at.map(carry, at("Vector" if suffix else "Value"), at("Steps" + suffix), *ends)


def _gamma(at):
    def power(colour, gamma):
        positive = colour > 0
        return np.where(positive, np.power(np.where(positive, colour, 1), gamma), colour)

    return at.map(power, at("Color"), at("Gamma"))


def _contrast(at):
    return at.map(blending.adjust_contrast, at("Color"), at("Bright"), at("Contrast"))


def _invert(at):
    return at.map(lambda t, c: c * (1 - t) + (1 - c) * t, at("Fac"), at("Color"))


def _hue_saturation(at):
    parts = [at(name) for name in ("Color", "Hue", "Saturation", "Value", "Fac")]
    return at.map(blending.shift_hue, *parts)


def _grey(at):
    return at.map(luminance, at("Color"))


def _ramp(at):
    ramp = at.node.color_ramp
    table = np.array([ramp.evaluate(i / (_RAMP_SIZE - 1)) for i in range(_RAMP_SIZE)], np.float32)
    channels = slice(3, 4) if at.output.identifier == "Alpha" else slice(0, 3)

    def look_up(position):
        position = np.clip(position[..., 0], 0, 1)
        if position.size == 1:
            flat = [ramp.evaluate(float(value))[channels] for value in position.ravel()]
            return np.array(flat).reshape(*position.shape, -1)
        place = position * (_RAMP_SIZE - 1)
        low = place.astype(int)
        if ramp.interpolation == "CONSTANT":
            return table[low][..., channels]
        share = (place - low)[..., None]
        high = np.minimum(low + 1, _RAMP_SIZE - 1)
        return (table[low] * (1 - share) + table[high] * share)[..., channels]

    return at.map(look_up, at("Fac"))


def _curve(mapping, index, values):
    """Evaluate one curve of a curve mapping on an array."""
    low, high = float(values.min()), float(values.max())
    size = 2 if low == high else 1024
    places = np.linspace(low, high, size)
    curve = mapping.curves[index]
    table = [mapping.evaluate(curve, float(place)) for place in places]
    return np.interp(values, places, table)


def _rgb_curves(at):
    mapping = at.node.mapping
    mapping.initialize()

    def apply(factor, colour):
        together = _curve(mapping, 3, rgb(colour))
        channels = [_curve(mapping, i, together[..., i]) for i in range(3)]
        return colour * (1 - factor) + np.stack(channels, axis=-1) * factor

    return at.map(apply, at("Fac"), at("Color"))


def _vector_curves(at):
    mapping = at.node.mapping
    mapping.initialize()

    def apply(factor, vector):
        channels = [_curve(mapping, i, rgb(vector)[..., i]) for i in range(3)]
        return vector * (1 - factor) + np.stack(channels, axis=-1) * factor

    return at.map(apply, at("Fac"), at("Vector"))


def _float_curve(at):
    mapping = at.node.mapping
    mapping.initialize()

    def apply(factor, value):
        return value * (1 - factor) + _curve(mapping, 0, value) * factor

    return at.map(apply, at("Factor"), at("Value"))


_INTO = {"RGB": rgb, "HSV": blending.rgb_to_hsv, "HSL": blending.rgb_to_hsl}
_FROM = {"RGB": rgb, "HSV": blending.hsv_to_rgb, "HSL": blending.hsl_to_rgb}


def _separate(at):
    mode = getattr(at.node, "mode", "RGB")
    index = list(at.node.outputs).index(at.output)
    return at.map(
        lambda c: _INTO[mode](rgb(c))[..., index : index + 1], at.field(at.node.inputs[0])
    )


def _combine(at):
    mode = getattr(at.node, "mode", "RGB")

    def join(*channels):
        return _FROM[mode](np.concatenate(np.broadcast_arrays(*channels), axis=-1))

    return at.map(join, *(at.field(socket) for socket in at.node.inputs[:3]))


def _rec709(xyz):
    return _REC709_FROM_XYZ @ xyz


def blackbody_colour(temperature: float) -> np.ndarray:
    """Return the linear Rec. 709 colour of a Planck radiator with luminance 1, (3,).

    Parameters
    ----------
    temperature : float    Held within 800 and 12000 K, as Blender does. [K]
    """
    wavelengths, observer = spectra.observer()
    temperature = min(max(temperature, 800.0), 12000.0)
    power = wavelengths**-5 / np.expm1(_PLANCK_NM_K / (wavelengths * temperature))
    xyz = power @ observer
    return _rec709(xyz / xyz[1])


def _per_number(function):
    """Make a function of one number apply to arrays through a table."""

    def apply(values):
        if values.size == 1:
            return function(float(values.ravel()[0])).reshape(*values.shape[:-1], 3)
        places = np.linspace(float(values.min()), float(values.max()), 256)
        table = np.array([function(place) for place in places])
        return np.stack([np.interp(values[..., 0], places, table[:, i]) for i in range(3)], -1)

    return apply


def _blackbody(at):
    return at.map(_per_number(blackbody_colour), at("Temperature"))


def _wavelength_colour(wavelength):
    wavelengths, observer = spectra.observer()
    xyz = [np.interp(wavelength, wavelengths, observer[:, i], 0, 0) for i in range(3)]
    # Cycles divides by 2.52 so that the components stay near 0..1.
    return np.maximum(_rec709(np.array(xyz)) / 2.52, 0)


def _wavelength(at):
    return at.map(_per_number(_wavelength_colour), at("Wavelength"))


def _own_value(at):
    value = at.output.default_value
    return constant(*value[:3]) if at.output.type == "RGBA" else constant(value)


def _falloff(at):
    if at.output.identifier != "Quadratic":
        at.note(
            f"Light falloff {at.output.name!r} is not physical",
            "the strength falls with the square of the distance",
        )
    elif not at("Smooth").is_everywhere(0):
        at.note("A smoothed light falloff is not physical", "it is not smoothed")
    return at("Strength")


def _occlusion(at):
    at.note("Ambient occlusion depends on the surroundings", "the unoccluded value is used")
    return constant(1.0) if at.output.identifier == "AO" else at("Color")


FUNCTIONS = {
    "ShaderNodeRGB": _own_value,
    "ShaderNodeValue": _own_value,
    "ShaderNodeMix": _mix,
    "ShaderNodeMixRGB": _mix_rgb,
    "ShaderNodeMath": _math,
    "ShaderNodeVectorMath": _vector_math,
    "ShaderNodeClamp": _clamp,
    "ShaderNodeMapRange": _map_range,
    "ShaderNodeGamma": _gamma,
    "ShaderNodeBrightContrast": _contrast,
    "ShaderNodeInvert": _invert,
    "ShaderNodeHueSaturation": _hue_saturation,
    "ShaderNodeRGBToBW": _grey,
    "ShaderNodeValToRGB": _ramp,
    "ShaderNodeRGBCurve": _rgb_curves,
    "ShaderNodeVectorCurve": _vector_curves,
    "ShaderNodeFloatCurve": _float_curve,
    "ShaderNodeSeparateColor": _separate,
    "ShaderNodeSeparateRGB": _separate,
    "ShaderNodeSeparateXYZ": _separate,
    "ShaderNodeCombineColor": _combine,
    "ShaderNodeCombineRGB": _combine,
    "ShaderNodeCombineXYZ": _combine,
    "ShaderNodeBlackbody": _blackbody,
    "ShaderNodeWavelength": _wavelength,
    "ShaderNodeLightFalloff": _falloff,
    "ShaderNodeAmbientOcclusion": _occlusion,
}
"""What each node does, by its ``bl_idname``."""
