"""Evaluation of colour and value sub-graphs of a shader tree."""

from copy import copy
from dataclasses import replace

import numpy as np

from ....engine.scene.memo import recall_latest
from ...foundation.report import ConversionReport, Severity
from ..images.cache import SMALL, ImageCache
from . import colour_nodes, coordinate_nodes, needs, procedural_nodes, stand_ins, texture_nodes
from .fields import OTHER_PLACES, TWO_MAPS, Field, constant, luminance, map_fields, rgb
from .graph import find_socket, node_key, settings_of, trace

_FUNCTIONS = (
    colour_nodes.FUNCTIONS
    | texture_nodes.FUNCTIONS
    | procedural_nodes.FUNCTIONS
    | coordinate_nodes.FUNCTIONS
)

_NUMBERS = {"VALUE", "INT", "BOOLEAN"}
_TRIPLES = {"RGBA", "VECTOR", "ROTATION"}


class Context:
    """One data-block's conversion: where departures are noted and what is known already.

    Parameters
    ----------
    datablock : str    Name of the material or world, for the report.
    report : ConversionReport    Where departures go.
    images : ImageCache or None    What was read before.

    Attributes
    ----------
    metres : float    That a unit of Blender stands for. [m]
    relief : scene.relief.Relief or None    Of a displacement, which all normals start from.
    lies_on_maps : bool    Whether coordinates that are a UV map are known as one, and textures drawn on it.
    is_camera : bool    Whether rays of the camera are asked for, and not those that carry light.
    is_material : bool    Whether an object shows it, whose own values a conversion of its own can take.
    material_index : float or None    The material's own number, if it is one.
    has_texels : bool    Whether nodes are evaluated at texels of an object's surface, not on tiles of UV maps.
    has_angles : bool    Whether they are evaluated by the side and the angle as well, so that pictures count by their means.
    take_angle : callable or None    Returns what a node (`Inputs`) gives by these, None if it does not depend on them.
    needs : set of tuple    What was asked for of the object that shows it, as `needs` has them.
    """

    metres = 1.0
    relief = None
    lies_on_maps = True
    is_camera = is_material = has_texels = has_angles = False
    material_index: float | None = None
    take_angle = None

    def __init__(self, datablock: str, report: ConversionReport, images: ImageCache | None = None):
        self.datablock = datablock
        self.needs: set[tuple] = set()
        self.report = report
        self.images = ImageCache() if images is None else images
        self.readings: dict = {}
        self.known: dict = {}
        self.active: set = set()

    def branch(self, report: ConversionReport | None = None) -> "Context":
        """Return the same conversion to be done once more; what it asks of the object counts for both.

        Parameters
        ----------
        report : ConversionReport or None    Where departures go; None: as before.
        """
        made = copy(self)
        made.report = self.report if report is None else report
        made.readings, made.known, made.active = {}, {}, set()
        return made

    def add(self, severity, node, message, remedy, is_missing=False):
        """Note one departure of a node."""
        self.report.add(severity, self.datablock, node, message, remedy, is_missing)

    def take_output(self, at) -> "Field | None":
        """Return what a node gives here in place of what it gives on a surface; None: the same."""
        if self.material_index is not None and at.output.identifier == "Material Index":
            return constant(self.material_index)
        self.needs |= needs.needs_of_node(at.node, at.output)
        return None

    def settle(self, field: "Field") -> "Field":
        """Return what a node gives as it is used here."""
        return field

    def coordinates(self) -> "Field | None":
        """Return what textures go by where nothing is linked; None: coordinates of the object, which are not known."""
        self.needs.add(needs.SURFACE)

    def take_profile(self, node) -> float | None:
        """Return the number that an IES texture stands for; None: it cannot be taken over here."""
        return None


class Inputs:
    """What a node's function sees: the node, the wanted output and the fields of its inputs."""

    def __init__(self, node, output, context: Context, groups: tuple):
        self.node = node
        self.output = output
        self.context = context
        self.groups = groups

    def __call__(self, *identifiers) -> Field:
        """Return the field of an input by its identifier; 0 if this version has no such input."""
        socket = find_socket(self.node.inputs, *identifiers)
        return constant(0.0) if socket is None else self.field(socket)

    def field(self, socket) -> Field:
        """Return the field of one of the node's inputs."""
        return evaluate_field(socket, self.context, self.groups)

    def map(self, function, *fields) -> Field:
        """Apply a function of arrays place by place; it follows from the node's settings and its inputs alone.

        The latest result of every node is kept for as long as the pictures that it was made of.
        """
        pictures = [field for field in fields if not field.is_constant]
        if all(field.values.nbytes < SMALL for field in pictures):
            return map_fields(function, *fields, note=self.note)
        place = (self.context.datablock, *node_key(self.node, self.groups), self.output.identifier)
        function_name = getattr(function, "__code__", function)

        def make():
            notes: list[tuple[str, str]] = []
            made = map_fields(function, *fields, note=lambda *words: notes.append(words))
            return made.values, made.layout, notes

        first, *others = (field.values for field in pictures)
        parameters = (settings_of(self.node), [field.key() for field in fields])
        values, layout, notes = recall_latest(
            first, (*place, function_name), others, parameters, make
        )
        for message, remedy in notes:
            self.note(message, remedy)
        return Field(values, layout, any(field.is_stand_in for field in fields))

    def plain(self, *identifiers) -> float:
        """Return an input as one number, the mean if it varies."""
        field = self(*identifiers).settled()
        if not field.is_constant:
            value = float(luminance(field.mean())[0])
            self.note(
                f"{identifiers[0]} varies over the surface", f"its mean, {value:.4g}, is used"
            )
        return float(luminance(field.mean())[0])

    def constant_of(self, socket, groups):
        """Return a vector input as (3,) array, None if it varies."""
        field = evaluate_field(socket, self.context, groups)
        return np.array(rgb(field.values), np.float64) if field.is_constant else None

    def remark(self, message, remedy):
        """Note something that changes little."""
        self.context.add(Severity.INFO, self.node.name, message, remedy)

    def note(self, message, remedy):
        """Note something that changes the result."""
        if message in {TWO_MAPS, OTHER_PLACES} and not self.context.has_angles:
            self.context.needs.add(needs.SURFACE)
        self.context.add(Severity.WARNING, self.node.name, message, remedy)

    def fail(self, message, remedy):
        """Note something that is left out."""
        self.context.add(Severity.ERROR, self.node.name, message, remedy)

    def miss(self, message, remedy):
        """Note a file that is not there or cannot be read."""
        self.context.add(Severity.ERROR, self.node.name, message, remedy, is_missing=True)


def evaluate_field(socket, context: Context, groups: tuple = ()) -> Field:
    """Evaluate what arrives at an input, in the channels of that input.

    Parameters
    ----------
    socket : bpy.types.NodeSocket    An input.
    context : Context    The conversion that it belongs to.
    groups : tuple of bpy.types.Node    Group nodes around it, outermost first.
    """
    origin = trace(socket, groups)
    if origin.problem:
        context.add(Severity.ERROR, socket.node.name, origin.problem, "0 is used")
    if origin.socket is None:
        return constant(0.0)
    if origin.is_output:
        field = _evaluate_output(origin.socket, context, origin.groups)
    else:
        field = _own_value(origin.socket)
    return _through_links(field, origin.types)


def _own_value(socket):
    if socket.type in _NUMBERS:
        return constant(float(socket.default_value))
    if socket.type in _TRIPLES:
        return constant(*tuple(socket.default_value)[:3])
    return constant(0.0)


def _through_links(field, types):
    """Apply Blender's conversions between the socket types that a value passes."""
    for before, after in zip(types[::-1], types[-2::-1], strict=False):
        if after in _NUMBERS and field.values.shape[-1] == 3:
            values = field.values
            grey = luminance(values) if before == "RGBA" else values.mean(axis=-1, keepdims=True)
            field = replace(field, values=grey)
    return field


def _evaluate_output(output, context, groups):
    node = output.node
    key = (*node_key(node, groups), output.identifier)
    if key in context.known:
        return context.known[key]
    inputs = Inputs(node, output, context, groups)
    if key in context.active:
        inputs.fail("The links run in a circle", "0 is used")
        return constant(0.0)
    context.active.add(key)
    try:
        field = None if context.take_angle is None else context.take_angle(inputs)
        if field is None:
            field = context.take_output(inputs)
        if field is None:
            field = context.settle(_FUNCTIONS.get(node.bl_idname, stand_ins.replace)(inputs))
    finally:
        context.active.discard(key)
    context.known[key] = field
    return field
