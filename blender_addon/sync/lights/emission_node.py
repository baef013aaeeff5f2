"""The node tree of a light: its Emission node, and what colour and strength arrive there."""

import numpy as np

from ....engine.scene.memo import recall
from ...foundation.report import Severity
from ..nodes.evaluation import Context, evaluate_field
from ..nodes.fields import as_colour, as_scalar
from ..nodes.graph import Origin, find_socket, trace


def find_emission(data) -> Origin | None:
    """Return where a light's surface comes from, None if it has no nodes."""
    tree = data.node_tree if getattr(data, "use_nodes", False) else None
    if tree is None:
        return None
    output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
    surface = find_socket(output.inputs, "Surface") if output else None
    return trace(surface) if surface else Origin(None, (), ())


def is_emission(origin: Origin) -> bool:
    """Whether that is an Emission node, the only one that is taken over."""
    return origin.is_output and origin.socket.node.bl_idname == "ShaderNodeEmission"


def evaluate_emission(origin: Origin, context: Context) -> tuple[np.ndarray, float]:
    """Return colour (3,) and strength of an Emission node; pictures count with their mean, which is an error."""
    node, groups = origin.socket.node, origin.groups
    colour, strength = (
        mean_light(find_socket(node.inputs, name), channels, context, groups)
        for name, channels in (("Color", 3), ("Strength", 1))
    )
    return colour, float(strength[0])


def mean_light(socket, channels: int, context: Context, groups) -> np.ndarray:
    """Return what arrives at an input that decides about light, the mean where it is not the same in all directions."""
    field = evaluate_field(socket, context, groups)
    node = socket.node.name
    if not (field.is_constant or field.is_spread):
        context.add(
            Severity.ERROR,
            node,
            f"A picture shapes the light by {socket.name!r}",
            "its mean is used in all directions; use a photometric file",
        )
    elif field.is_stand_in:
        context.add(
            Severity.ERROR,
            node,
            f"The light by {socket.name!r} depends on what cannot be taken over",
            "the mean of what comes out is used",
        )
    return mean_of(as_colour(field) if channels == 3 else as_scalar(field), channels)


def mean_of(value, channels: int) -> np.ndarray:
    """Numbers of a constant, or the mean of a picture."""
    if hasattr(value, "pixels"):
        return recall(value.pixels, "exact mean", _mean)[:channels]
    if hasattr(value, "red"):
        return np.array([value.red, value.green, value.blue])
    return np.full(channels, float(getattr(value, "value", value)))


def _mean(pixels) -> np.ndarray:
    return np.asarray(pixels, dtype=np.float64).reshape(-1, pixels.shape[2]).mean(axis=0)
