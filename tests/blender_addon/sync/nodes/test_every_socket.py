"""Every input and setting of every shader node of Blender: it changes what the engine gets, or the report says something.

The lists are Blender's own, so that a node, an input or a setting that a new version brings is tried too.
"""

import re
from dataclasses import dataclass

import bpy
import numpy as np
import pytest
from material_trees import new_tree

from lumenray.blender_addon.foundation.report import ConversionReport
from lumenray.blender_addon.sync.materials.materials import convert_material
from lumenray.engine.scene.scene import content_digest

pytestmark = pytest.mark.blender

ENDS = {
    *("ShaderNode", "ShaderNodeTree", "ShaderNodeCustomGroup", "ShaderNodeGroup"),
    *("ShaderNodeOutputMaterial", "ShaderNodeOutputWorld", "ShaderNodeOutputLight"),
    *("ShaderNodeOutputLineStyle", "ShaderNodeOutputAOV", "ShaderNodeUVAlongStroke"),
}
"""What is no node of a material that gives something."""

KINDS = sorted(
    name for name in dir(bpy.types) if name.startswith("ShaderNode") and name not in ENDS
)

COMMON = {each.identifier for each in bpy.types.ShaderNode.bl_rna.properties}

WITHOUT = {
    # The factor's own value lies within 0 and 1; with links it is compared with Cycles elsewhere.
    ("ShaderNodeMix", "clamp_factor"),
    # Cycles has one way of each.
    ("ShaderNodeMixRGB", "use_alpha"),
    ("ShaderNodeTangent", "uv_map"),
}
"""Settings that change nothing in Cycles."""

BELONGS = {"Rotation": "Anisotropy", "Tangent": "Anisotropy"}
"""What is told by the name of another input."""

STIRS = (1, 2)
"""Seeds of values that inputs have."""

NUMBERS, COLOURS, VECTORS = {"VALUE", "INT"}, {"RGBA"}, {"VECTOR", "ROTATION"}


@dataclass(frozen=True)
class Made:
    """What came of a material: digest, and rows of the report."""

    digest: bytes
    rows: tuple[str, ...]


def convert(material) -> Made:
    report = ConversionReport()
    made = convert_material(material, "key", report, 177.83)
    return Made(content_digest(made), tuple(sorted(row.text() for row, _ in report.rows)))


def outputs_of(kind, data_type):
    """Identifiers of the outputs of a new node for a type of data."""
    try:
        node = new_tree().nodes.new(kind)
    except RuntimeError:
        return []
    if data_type is not None:
        node.data_type = data_type
    return [each.identifier for each in node.outputs if each.enabled]


def types_of(kind):
    """Types of data that a node can be set to, of which each has inputs of its own; None where there is no choice."""
    if "data_type" not in getattr(bpy.types, kind).bl_rna.properties:
        return [None]
    node = new_tree().nodes.new(kind)
    found = []
    for each in node.bl_rna.properties["data_type"].enum_items:
        try:
            node.data_type = each.identifier
        except TypeError:
            # Blender has it for other kinds of trees.
            continue
        found.append(each.identifier)
    return found


def stage(kind, output, data_type, seed):
    """A material that shows an output of a node, with all inputs away from what they are at first; ``seed`` 0: as at first.

    None where the output is not there for this type of data.
    """
    tree = new_tree()
    node = tree.nodes.new(kind)
    if data_type is not None:
        node.data_type = data_type
    shown = next(each for each in node.outputs if each.identifier == output)
    if not shown.enabled:
        return None
    if shown.type != "SHADER":
        emission = tree.add("Emission")
        tree.material.node_tree.links.new(shown, emission.inputs["Color"])
        tree.surface(emission)
    else:
        tree.surface(node)
        paints = [each for each in node.inputs if each.type == "SHADER"]
        for number, socket in enumerate(paints):
            paint = tree.add("BsdfDiffuse", Color=(0.2 + 0.3 * number, 0.5, 0.4))
            tree.material.node_tree.links.new(paint.outputs[0], socket)
    random = np.random.default_rng(seed)
    for socket in settable(node) if seed else ():
        set_value(socket, float(random.uniform(0.05, 0.95)), 2.0)
    return tree, node


def settable(node):
    """Inputs whose own values count."""
    kinds = NUMBERS | COLOURS | VECTORS | {"BOOLEAN"}
    return [s for s in node.inputs if s.enabled and not s.hide_value and s.type in kinds]


def set_value(socket, value, width=1.0):
    """Set an input to something that depends on a number between 0 and 1; plain numbers may be wider spread."""
    if socket.type in COLOURS:
        red, green, blue = (part * width for part in (value, 0.9 - value, 0.5 * value))
        socket.default_value = (red, green, blue, 1.0)
    elif socket.type in VECTORS:
        socket.default_value = [value + 0.2 * k for k in range(len(socket.default_value))]
    elif socket.type == "INT":
        socket.default_value = 2 + int(10 * value)
    elif socket.type == "BOOLEAN":
        socket.default_value = not socket.default_value
    else:
        socket.default_value = width * (value - 0.5) + 0.5


def edits_of(node, tree):
    """Yield words on each edit and the edit, which returns how it is taken back."""
    for socket in settable(node):
        yield socket.identifier, lambda socket=socket: change_input(socket)
    for socket in node.inputs:
        if socket.enabled and socket.type != "SHADER":
            yield socket.identifier, lambda socket=socket: link_picture(tree, socket)
    for prop in node.bl_rna.properties:
        if prop.identifier in COMMON or prop.is_readonly:
            continue
        if (node.bl_idname, prop.identifier) in WITHOUT:
            continue
        for value in values_of(node, prop):
            yield prop.identifier, lambda p=prop, v=value: change_setting(node, p.identifier, v)


def change_input(socket):
    before = socket.default_value
    before = before if isinstance(before, int | float) else tuple(before)
    set_value(socket, 0.83)
    return lambda: setattr(socket, "default_value", before)


def link_picture(tree, socket):
    """Link what varies over a UV map."""
    checker = tree.add("TexChecker", Vector=tree.add("UVMap").outputs[0], Scale=1.0)
    checker.inputs["Color1"].default_value = (0.9, 0.2, 0.4, 1.0)
    tree.material.node_tree.links.new(checker.outputs[0], socket)
    return lambda: tree.nodes.remove(checker)


def values_of(node, prop):
    """Other values of a setting."""
    now = getattr(node, prop.identifier)
    if prop.type == "ENUM" and not prop.is_enum_flag:
        return [each.identifier for each in prop.enum_items if each.identifier != now]
    if getattr(prop, "is_array", False):
        return []
    other = {"BOOLEAN": lambda: not now, "FLOAT": lambda: now + 0.4, "INT": lambda: now + 1}
    return [other[prop.type]()] if prop.type in other else []


def change_setting(node, name, value):
    before = getattr(node, name)
    try:
        setattr(node, name, value)
    except TypeError:
        # It depends on another setting whether Blender offers this one.
        return None
    return lambda: setattr(node, name, before)


def try_edits(tree, node):
    """Return words of edits that are silent, of those that are not, and the rows of the report without any."""
    first = convert(tree.material)
    silent, heard = set(), set()
    for words, edit in edits_of(node, tree):
        undo = edit()
        if undo is None:
            continue
        (silent if convert(tree.material) == first else heard).add(words)
        undo()
    return silent, heard, first.rows


def is_named(words, rows):
    """Whether rows tell of what an input or a setting belongs to, as of thin films or of a coat."""
    start = re.split(r"[ _]", BELONGS.get(words, words))[0].lower()[:8]
    return any(start in row.lower() for row in rows)


@pytest.mark.parametrize("kind", KINDS)
def test_no_input_and_no_setting_is_silent(kind):
    silent, heard, rows = set(), set(), ()
    types = types_of(kind)
    outputs = {output for each in types for output in outputs_of(kind, each)}
    for output in sorted(outputs):
        for data_type in types:
            for seed in (0, *STIRS):
                staged = stage(kind, output, data_type, seed)
                if staged is None:
                    continue
                more_silent, more_heard, told = try_edits(*staged)
                if told and seed == 0:
                    # The node as a whole is left out or replaced, and that is said.
                    break
                silent |= {(output, words) for words in more_silent}
                heard |= {(output, words) for words in more_heard}
                rows += told
    # A setting may be of some outputs only, an input of one type of data.
    any_heard = {words for _, words in heard}
    left = {words for _, words in silent} - any_heard
    assert sorted(words for words in left if not is_named(words, rows)) == []
