"""Node groups that turn baked light into what a surface looks like in EEVEE.

One group for each way in which an atlas lies on objects, and one that all of them share: what the scene's sliders say, by
drivers without Python, so that they work in any Blender and can be animated.
"""

from dataclasses import dataclass

import bpy
import numpy as np

from ...engine.analysis.false_colour import STOPS, colours
from ...engine.photometry import units
from ...engine.photometry.colour import REC709_LUMINANCE
from ..sync.meshes import BAKED_TREE
from . import images as baked_images

MARK = BAKED_TREE
"""Custom property of all that the baked look adds to materials and node groups."""

PLACE = "lumenray_place"
"""Custom property of an object that tells which way of lying is its own."""

LEVELS, LOOK = "Lumenray Light Levels", "Lumenray Baked Light"
"""Names of the groups."""

INPUTS = (
    ("Surface", "NodeSocketShader", None),
    ("Base Color", "NodeSocketColor", (0.8, 0.8, 0.8, 1.0)),
    ("Metallic", "NodeSocketFloat", 0.0),
    ("Transmission", "NodeSocketFloat", 0.0),
    ("Alpha", "NodeSocketFloat", 1.0),
    ("Emission Color", "NodeSocketColor", (1.0, 1.0, 1.0, 1.0)),
    ("Emission Strength", "NodeSocketFloat", 0.0),
    ("Luminance", "NodeSocketFloat", 0.0),
    ("Matt", "NodeSocketFloat", 1.0),
)
"""Inputs of a group that shows baked light: name, type and value. The surface is what other objects keep; the emission is in
Blender's unit, the luminance in cd/m2, and the light that leaves by itself is that of
both. What is not matt has no false colours."""

RAMP = 3 * (len(STOPS) - 1) + 1
"""Colours of Blender's ramp, which holds 32 at most: all of the scale's own are among them."""

LIGHT, EXITANCE, FALSE = 0.0, 1.0, 2.0
"""Numbers of the looks, as in ``LumenrayLookSettings.kind``."""


@dataclass(frozen=True)
class Place:
    """A way of lying on objects: an atlas (its image with the whole illuminance) by UV maps; ``back`` may be empty."""

    image: object
    uv: str
    back: str = ""


class Tree:
    """A node group under construction."""

    def __init__(self, name: str):
        self.tree = bpy.data.node_groups.new(name, "ShaderNodeTree")
        self.tree[MARK] = True
        self._column = 0

    def add(self, kind: str, inputs=(), label: str = "", **attributes):
        """Add a node and link or set its inputs in their order; None leaves one as it is."""
        node = self.tree.nodes.new(kind)
        for name, value in attributes.items():
            setattr(node, name, value)
        node.label = label
        node.location = (180.0 * (self._column // 6), -170.0 * (self._column % 6))
        self._column += 1
        for socket, value in zip(node.inputs, inputs, strict=False):
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            elif value is not None:
                socket.default_value = value
        return node

    def math(self, operation: str, *inputs):
        """Return the result of an operation on numbers."""
        return self.add("ShaderNodeMath", inputs, operation=operation).outputs[0]

    def vector(self, operation: str, *inputs):
        """Return the result of an operation on colours, component by component."""
        return self.add("ShaderNodeVectorMath", inputs, operation=operation).outputs["Vector"]

    def scaled(self, colour, factor):
        """Return a colour times a number."""
        node = self.add("ShaderNodeVectorMath", (colour,), operation="SCALE")
        _fill(self.tree, factor, node.inputs["Scale"])
        return node.outputs["Vector"]

    def luminance(self, colour):
        """Return the luminance of a linear colour."""
        weights = tuple(float(weight) for weight in REC709_LUMINANCE)
        node = self.add("ShaderNodeVectorMath", (colour, weights), operation="DOT_PRODUCT")
        return node.outputs["Value"]

    def chosen(self, factor, first, second):
        """Return the first colour where a factor is 0, the second where it is 1."""
        node = self.add("ShaderNodeMix", data_type="RGBA", clamp_factor=True)
        for name, value in (("Factor_Float", factor), ("A_Color", first), ("B_Color", second)):
            _fill(self.tree, value, _by_identifier(node.inputs, name))
        return _by_identifier(node.outputs, "Result_Color")

    def socket(self, name: str, direction: str, kind: str, value=None) -> None:
        """Add a socket to the group's border."""
        made = self.tree.interface.new_socket(name, in_out=direction, socket_type=kind)
        if value is not None:
            made.default_value = value


def make_levels(scene, names, automatic_white: float):
    """Make the group that hands on what the scene's settings say.

    Parameters
    ----------
    scene : bpy.types.Scene    Whose settings drive it.
    names : list of str    Layers that it has an output for, with the light that each is to be multiplied by.
    automatic_white : float    What is white while the scene leaves it to the picture. [cd/m2]
    """
    group = Tree(LEVELS)
    outputs = []
    driver = _Driver(group.tree, scene)
    white = (
        f"white if mode == 0 else {float(units.luminance_from_ev100(0.0)):.9g} * pow(2, ev) "
        f"if mode == 1 else {automatic_white:.9g}"
    )
    variables = {"mode": "exposure", "white": "white_luminance", "ev": "ev100"}
    for name, expression, paths in (
        ("White", white, variables),
        ("Look", "look", {"look": "look.kind"}),
        ("Low", "low", {"low": "look.low"}),
        ("High", "high", {"high": "look.high"}),
        ("Efficacy", "efficacy", {"efficacy": "efficacy"}),
    ):
        node = group.add("ShaderNodeValue", label=name)
        driver.drive(node.outputs[0], expression, paths)
        outputs.append((name, "NodeSocketFloat", node.outputs[0]))
    known = [layer.name for layer in scene.lumenray.look.layers]
    for name in names:
        path = f"look.layers[{known.index(name)}]"
        colour = group.add("ShaderNodeCombineXYZ", label=name)
        for axis in range(3):
            driver.drive(colour.inputs[axis], "part", {"part": f"{path}.colour[{axis}]"})
        strength = group.add("ShaderNodeValue", label=name)
        driver.drive(strength.outputs[0], "strength", {"strength": f"{path}.strength"})
        # A colour never changes the amount of light.
        amount = group.math("MAXIMUM", group.luminance(colour.outputs[0]), 1e-6)
        factor = group.math("DIVIDE", strength.outputs[0], amount)
        outputs.append(
            (layer_output(name), "NodeSocketVector", group.scaled(colour.outputs[0], factor))
        )
    for name, kind, _ in outputs:
        group.socket(name, "OUTPUT", kind)
    group.add("NodeGroupOutput", [socket for *_, socket in outputs])
    return group.tree


def layer_output(name: str) -> str:
    """Return the name of a layer's output of the shared group; other outputs have other names."""
    return f"Layer {name}"


def make_look(place: Place, number: int, levels):
    """Make the group that shows an atlas on the objects of a place.

    Parameters
    ----------
    place : Place
    number : int    By which objects know it.
    levels : bpy.types.NodeTree    Of `make_levels`.
    """
    group = Tree(LOOK)
    for name, kind, value in INPUTS:
        group.socket(name, "INPUT", kind, value)
    group.socket("Surface", "OUTPUT", "NodeSocketShader")
    given = group.add("NodeGroupInput").outputs
    level = group.add("ShaderNodeGroup", node_tree=levels).outputs
    uv = _uv(group, place)
    illuminance = _illuminance(group, place, level, uv)
    per_white = group.math("DIVIDE", 1.0 / np.pi, level["White"])
    shown = group.vector("MULTIPLY", given["Base Color"], illuminance)
    exitance = baked_images.exitance_of(place.image)
    if exitance is not None:
        colour = _texture(group, exitance, uv)
        is_exitance = group.math("COMPARE", level["Look"], EXITANCE, 0.5)
        shown = group.chosen(is_exitance, shown, colour)
    shown = group.scaled(shown, per_white)
    own = group.math(
        "MULTIPLY_ADD", given["Emission Strength"], level["Efficacy"], given["Luminance"]
    )
    own = group.scaled(given["Emission Color"], group.math("DIVIDE", own, level["White"]))
    shown = group.vector("ADD", shown, own)
    is_false = group.math("COMPARE", level["Look"], FALSE, 0.5)
    shown = group.chosen(is_false, shown, _false_colour(group, level, illuminance, given["Matt"]))
    light = group.add("ShaderNodeEmission", (shown, 1.0)).outputs[0]
    clear = group.add("ShaderNodeBsdfTransparent").outputs[0]
    baked = group.add("ShaderNodeMixShader", (given["Alpha"], clear, light)).outputs[0]
    share = group.math(
        "MULTIPLY",
        group.math("SUBTRACT", 1.0, given["Metallic"]),
        group.math("SUBTRACT", 1.0, given["Transmission"]),
    )
    flag = group.add("ShaderNodeAttribute", attribute_type="OBJECT", attribute_name=f'["{PLACE}"]')
    is_here = group.math("COMPARE", flag.outputs["Fac"], float(number), 0.5)
    factor = group.math("MULTIPLY", share, is_here)
    result = group.add("ShaderNodeMixShader", (factor, given["Surface"], baked)).outputs[0]
    group.add("NodeGroupOutput", (result,))
    return group.tree


def remove_groups() -> None:
    """Take away all groups that were made here."""
    for tree in list(bpy.data.node_groups):
        if tree.get(MARK):
            bpy.data.node_groups.remove(tree)


def _uv(group: Tree, place: Place):
    front = group.add("ShaderNodeUVMap", uv_map=place.uv).outputs[0]
    if not place.back:
        return front
    back = group.add("ShaderNodeUVMap", uv_map=place.back).outputs[0]
    side = group.add("ShaderNodeNewGeometry").outputs["Backfacing"]
    return group.chosen(side, front, back)


def _texture(group: Tree, image, uv):
    node = group.add("ShaderNodeTexImage", (uv,), image=image, extension="EXTEND")
    return node.outputs["Color"]


def _illuminance(group: Tree, place: Place, level, uv):
    """Illuminance as a colour whose luminance is in lx."""
    layers = baked_images.layers_of(place.image)
    if not layers:
        return _texture(group, place.image, uv)
    total = None
    for name, image in layers.items():
        part = group.vector("MULTIPLY", _texture(group, image, uv), level[layer_output(name)])
        total = part if total is None else group.vector("ADD", total, part)
    return total


def _false_colour(group: Tree, level, illuminance, factor):
    span = group.math("MAXIMUM", group.math("SUBTRACT", level["High"], level["Low"]), 1e-9)
    above = group.math("SUBTRACT", group.luminance(illuminance), level["Low"])
    share = group.math("DIVIDE", above, span)
    node = group.add("ShaderNodeValToRGB", (share,))
    places = np.linspace(0.0, 1.0, RAMP)
    # The scale's colours are those of a display, and Blender's view encodes what nodes give.
    encoded = colours(places, 0.0, 1.0) / 255.0
    linear = np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)
    ramp = node.color_ramp
    while len(ramp.elements) < RAMP:
        ramp.elements.new(0.5)
    for element, at, colour in zip(ramp.elements, places, linear, strict=True):
        element.position = at
        element.color = (*colour, 1.0)
    return group.scaled(node.outputs["Color"], factor)


def _fill(tree, value, socket) -> None:
    if isinstance(value, bpy.types.NodeSocket):
        tree.links.new(value, socket)
    else:
        socket.default_value = value


def _by_identifier(sockets, identifier: str):
    return next(socket for socket in sockets if socket.identifier == identifier)


class _Driver:
    """Lets a scene's settings drive sockets of a node group."""

    def __init__(self, tree, scene):
        self.tree, self.scene = tree, scene

    def drive(self, socket, expression: str, paths: dict[str, str]) -> None:
        """Drive a socket by an expression of settings, by their paths below ``scene.lumenray``."""
        curve = socket.driver_add("default_value")
        driver = curve.driver
        driver.type = "SCRIPTED"
        for name, path in paths.items():
            variable = driver.variables.new()
            variable.name, variable.type = name, "SINGLE_PROP"
            target = variable.targets[0]
            target.id_type, target.id = "SCENE", self.scene
            target.data_path = f"lumenray.{path}"
        driver.expression = expression
