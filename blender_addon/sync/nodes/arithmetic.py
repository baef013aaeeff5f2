"""Blender's Math and Map Range nodes on arrays.

References
----------
Blender source, ``intern/cycles/kernel/svm/math_util.h`` and ``map_range.h``.
"""

import numpy as np


def calculate(operation: str, a, b, c) -> np.ndarray:
    """Apply one operation of the Math node, or of Vector Math to each component.

    Parameters
    ----------
    operation : str    Blender's identifier, such as ``MULTIPLY_ADD``.
    a, b, c : arrays    The three inputs; operations with fewer ignore the rest.

    Returns
    -------
    array    Where Blender's rule is "0 if undefined" that is 0, never NaN.
    """
    with np.errstate(all="ignore"):
        return np.nan_to_num(_ALL[operation](a, b, c), posinf=3e38, neginf=-3e38)


def _where_nonzero(divisor, function):
    safe = np.where(divisor != 0, divisor, 1)
    return np.where(divisor != 0, function(safe), 0.0)


def _power(a, b, _):
    is_real = (a >= 0) | (b == np.floor(b))
    return np.where(is_real, np.power(a, np.where(is_real, b, 0.0)), 0.0)


def _logarithm(a, b, _):
    is_valid = (a > 0) & (b > 0)
    base = np.log(np.where(is_valid, b, 2.0))
    return np.where(is_valid, _where_nonzero(base, lambda d: np.log(np.where(a > 0, a, 1)) / d), 0)


def _smooth_minimum(a, b, c):
    safe = np.where(c != 0, c, 1)
    h = np.maximum(c - np.abs(a - b), 0) / safe
    return np.where(c != 0, np.minimum(a, b) - h**3 * c / 6, np.minimum(a, b))


def _wrap(a, b, c):
    span = b - c
    return np.where(span != 0, a - span * np.floor((a - c) / np.where(span != 0, span, 1)), c)


def _ping_pong(a, b, _):
    return _where_nonzero(b, lambda d: np.abs(np.mod((a - d) / (2 * d), 1.0) * d * 2 - d))


OPERATIONS = {
    "ADD": lambda a, b, c: a + b,
    "SUBTRACT": lambda a, b, c: a - b,
    "MULTIPLY": lambda a, b, c: a * b,
    "DIVIDE": lambda a, b, c: _where_nonzero(b, lambda d: a / d),
    "MULTIPLY_ADD": lambda a, b, c: a * b + c,
    "POWER": _power,
    "LOGARITHM": _logarithm,
    "SQRT": lambda a, b, c: np.sqrt(np.maximum(a, 0)),
    "INVERSE_SQRT": lambda a, b, c: np.where(a > 0, 1 / np.sqrt(np.where(a > 0, a, 1)), 0),
    "ABSOLUTE": lambda a, b, c: np.abs(a),
    "EXPONENT": lambda a, b, c: np.exp(a),
    "MINIMUM": lambda a, b, c: np.minimum(a, b),
    "MAXIMUM": lambda a, b, c: np.maximum(a, b),
    "LESS_THAN": lambda a, b, c: (a < b) * 1.0,
    "GREATER_THAN": lambda a, b, c: (a > b) * 1.0,
    "SIGN": lambda a, b, c: np.sign(a),
    "COMPARE": lambda a, b, c: (np.abs(a - b) <= np.maximum(c, 1e-5)) * 1.0,
    "SMOOTH_MIN": _smooth_minimum,
    "SMOOTH_MAX": lambda a, b, c: -_smooth_minimum(-a, -b, c),
    "ROUND": lambda a, b, c: np.floor(a + 0.5),
    "FLOOR": lambda a, b, c: np.floor(a),
    "CEIL": lambda a, b, c: np.ceil(a),
    "TRUNC": lambda a, b, c: np.trunc(a),
    "FRACT": lambda a, b, c: a - np.floor(a),
    "MODULO": lambda a, b, c: _where_nonzero(b, lambda d: np.fmod(a, d)),
    "FLOORED_MODULO": lambda a, b, c: _where_nonzero(b, lambda d: a - np.floor(a / d) * d),
    "WRAP": _wrap,
    "SNAP": lambda a, b, c: _where_nonzero(b, lambda d: np.floor(a / d) * d),
    "PINGPONG": _ping_pong,
    "SINE": lambda a, b, c: np.sin(a),
    "COSINE": lambda a, b, c: np.cos(a),
    "TANGENT": lambda a, b, c: np.tan(a),
    "ARCSINE": lambda a, b, c: np.arcsin(np.clip(a, -1, 1)),
    "ARCCOSINE": lambda a, b, c: np.arccos(np.clip(a, -1, 1)),
    "ARCTANGENT": lambda a, b, c: np.arctan(a),
    "ARCTAN2": lambda a, b, c: np.arctan2(a, b),
    "SINH": lambda a, b, c: np.sinh(a),
    "COSH": lambda a, b, c: np.cosh(a),
    "TANH": lambda a, b, c: np.tanh(a),
    "RADIANS": lambda a, b, c: np.radians(a),
    "DEGREES": lambda a, b, c: np.degrees(a),
}
"""Operations of the Math node by Blender's identifiers."""

VECTOR_OPERATIONS = {
    name: OPERATIONS[name]
    for name in (
        *("ADD", "SUBTRACT", "MULTIPLY", "DIVIDE", "MULTIPLY_ADD", "POWER", "SIGN"),
        *("ABSOLUTE", "MINIMUM", "MAXIMUM", "FLOOR", "CEIL", "MODULO", "WRAP", "SNAP"),
        *("SINE", "COSINE", "TANGENT"),
    )
} | {"FRACTION": OPERATIONS["FRACT"]}
"""Operations of the Vector Math node that act on each component alone."""

_ALL = OPERATIONS | VECTOR_OPERATIONS


def map_range(interpolation: str, value, source, target, steps) -> np.ndarray:
    """Carry values from one range to another.

    Parameters
    ----------
    interpolation : str    ``LINEAR``, ``STEPPED``, ``SMOOTHSTEP`` or ``SMOOTHERSTEP``.
    value, steps : arrays    Values, and number of steps for ``STEPPED``.
    source, target : pair of arrays    Ends of the ranges; an empty source range gives 0.
    """
    span = source[1] - source[0]
    share = (value - source[0]) / np.where(span != 0, span, 1)
    if interpolation == "STEPPED":
        share = np.where(
            steps > 0, np.floor(share * (steps + 1)) / np.where(steps > 0, steps, 1), 0
        )
    elif interpolation == "SMOOTHSTEP":
        share = np.clip(share, 0, 1)
        share = share**2 * (3 - 2 * share)
    elif interpolation == "SMOOTHERSTEP":
        share = np.clip(share, 0, 1)
        share = share**3 * (share * (share * 6 - 15) + 10)
    return np.where(span != 0, target[0] + share * (target[1] - target[0]), 0)
