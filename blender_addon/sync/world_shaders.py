"""Shader nodes of a world: the radiance that comes of backgrounds, mixed and added."""

import numpy as np

from ...engine.scene.checks import LARGEST_AMOUNT
from ..foundation.report import Severity
from .nodes.directions import DirectionContext
from .nodes.evaluation import Inputs
from .nodes.fields import Field, constant
from .nodes.graph import node_key, trace

BACKGROUNDS = {"ShaderNodeBackground", "ShaderNodeEmission"}
"""Nodes that shine."""


def world_radiance(socket, context: DirectionContext, groups=()) -> Field | None:
    """Return the radiance, as a linear colour, that arrives at a shader input for every direction; None: nothing shines."""
    origin = trace(socket, groups)
    if origin.problem:
        context.add(Severity.ERROR, socket.node.name, origin.problem, "black is used")
    if not origin.is_output:
        return None
    node = origin.socket.node
    at = Inputs(node, origin.socket, context, origin.groups)
    key = (*node_key(node, origin.groups), "shader")
    if key in context.active:
        at.fail("The links run in a circle", "black is used")
        return None
    context.active.add(key)
    try:
        made = _SHADERS.get(node.bl_idname, _unsupported)(at)
    finally:
        context.active.discard(key)
    return made


def _background(at) -> Field:
    colour, strength = at("Color"), at("Strength")
    least, largest = strength.limits()
    # Where it varies a part below 0 may be a slip, and the rest still counts.
    least = max(least, 0.0) if not strength.is_constant else least
    if not 0.0 <= least <= largest <= LARGEST_AMOUNT:
        at.fail(f"the strength is {largest:.3g}", "the background is black")
        return constant(0.0)
    if not np.isfinite(colour.limits()).all():
        at.fail("the colour is no number", "the background is black")
        return constant(0.0)
    return at.map(lambda colour, strength: colour * strength, colour, strength)


def _branch(at, number: int) -> Field | None:
    return world_radiance(at.node.inputs[number], at.context, at.groups)


def _mix(at) -> Field | None:
    factor = at.field(at.node.inputs[0]).clipped()
    # A branch that never shows must not fill the report.
    first = None if factor.is_everywhere(1) else _branch(at, 1)
    second = None if factor.is_everywhere(0) else _branch(at, 2)
    if first is None and second is None:
        return None
    parts = (constant(0.0) if each is None else each for each in (first, second))
    return at.map(lambda f, a, b: a * (1.0 - f) + b * f, factor, *parts)


def _add(at) -> Field | None:
    parts = [each for each in (_branch(at, 0), _branch(at, 1)) if each is not None]
    return at.map(lambda *values: sum(values), *parts) if parts else None


def _unsupported(at) -> None:
    at.fail(f"{at.node.bl_label} is not converted in a world", "it is black")


_SHADERS = {
    **dict.fromkeys(BACKGROUNDS, _background),
    "ShaderNodeMixShader": _mix,
    "ShaderNodeAddShader": _add,
}
"""What each shader node of a world becomes, by its ``bl_idname``."""
