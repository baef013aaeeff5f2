"""Baked light in EEVEE and material preview: materials get an output of their own for it, beside the one that they have.

Nothing that the user made is changed: Blender lets a material end in one output for EEVEE and another for all else, so what
is added reads the user's nodes and is taken away again as a whole. Lumenray and Cycles do not see it.
"""

from contextlib import contextmanager
from dataclasses import dataclass, field

import bpy
import numpy as np

from ...engine.errors import SceneError
from ...engine.photometry.colour import MIDDLE_GREY, REC709_LUMINANCE, scene_linear
from ...engine.photometry.spectra import (
    GRID,
    evaluate_emission,
    evaluate_reflectance,
    illuminant,
    observer,
)
from ...engine.scene.material import Coated, Diffuse, Fabric
from ...engine.scene.spectrum import Constant, Rgb
from ..foundation.node_trees import uses_nodes
from ..foundation.report import ConversionReport
from ..sync.materials.materials import DEFAULT_REFLECTANCE
from ..sync.materials.overrides import convert_override
from . import images as baked_images
from . import nodes as baked_nodes
from . import year_images
from .nodes import MARK, PLACE, Place
from .uv_maps import name_map

PLACEHOLDER = "Lumenray Default"
"""Name of the material that objects without one get while baked light is shown."""

MARK_NODES = "lumenray_without_nodes"
"""Custom property of a material whose nodes were switched on."""

REPLACED = "lumenray_replaced"
"""Custom property of our output that names the user's own output for EEVEE."""

COPIED = {
    "ShaderNodeBsdfPrincipled": {
        "Base Color": "Base Color",
        "Metallic": "Metallic",
        "Transmission Weight": "Transmission",
        "Alpha": "Alpha",
        "Emission Color": "Emission Color",
        "Emission Strength": "Emission Strength",
    },
    "ShaderNodeEeveeSpecular": {"Base Color": "Base Color"},
    "ShaderNodeBsdfDiffuse": {"Color": "Base Color"},
    "ShaderNodeBsdfTranslucent": {"Color": "Base Color"},
    "ShaderNodeBsdfSheen": {"Color": "Base Color"},
    "ShaderNodeSubsurfaceScattering": {"Color": "Base Color"},
    "ShaderNodeEmission": {"Color": "Emission Color", "Strength": "Emission Strength"},
    "ShaderNodeGroup": {"Base Color": "Base Color", "Color": "Base Color"},
}
"""Shaders that take part: their inputs, and those of our group that get the same. Others, such as glass, stay as is."""

FAR = 400.0
"""How far from the user's nodes ours stand."""


@dataclass
class _Shown:
    """What is shown on what: places by number from 1 on, and their groups."""

    places: list[Place] = field(default_factory=list)
    groups: list = field(default_factory=list)


def automatic_white(illuminance: float) -> float:
    """Luminance that becomes white where nobody states it: middle grey shows half of it reflected. [lx -> cd/m2]"""
    return max(0.5 * illuminance / np.pi / MIDDLE_GREY, 1e-6)


def baked_objects(scene) -> list:
    """Return the objects of a scene on which an atlas lies."""
    return [
        source
        for source in scene.objects
        if source.type == "MESH"
        and source.lumenray.baked_image is not None
        and source.data.uv_layers.get(source.lumenray.baked_uv) is not None
    ]


def list_layers(settings, images) -> None:
    """Make a row of sliders for each layer of the images; rows of names that were there keep what they are set to."""
    facts = [baked_images.facts_of(image) for image in images]
    names = [each["group"] for each in facts if each["quantity"] == baked_images.LAYER]
    atlases = {source.lumenray.baked_image for source in baked_objects(settings.id_data)}
    wanted = {*names, *(name for image in atlases for name in baked_images.layers_of(image))}
    rows = settings.layers
    for number in reversed(range(len(rows))):
        if rows[number].name not in wanted:
            rows.remove(number)
    for name in names:
        if name not in rows:
            rows.add().name = name
    settings.layer_index = 0


def show(scene) -> ConversionReport:
    """Let all materials of baked objects show baked light in EEVEE; what was shown before is replaced.

    Where the scene's look names a figure of a year, objects with maps of that show it in its place.

    Raises
    ------
    SceneError    Nothing is baked, or the year has no such map.
    """
    lying = _find_places(scene)
    hide()
    report, shown = ConversionReport(), _Shown()
    used: dict[object, set[int]] = {}
    for source, place in lying:
        if place not in shown.places:
            shown.places.append(place)
        number = shown.places.index(place) + 1
        source[PLACE] = number
        source.update_tag()
        for material in _materials(source):
            used.setdefault(material, set()).add(number)
    layers = dict.fromkeys(n for p in shown.places for n in baked_images.layers_of(p.image))
    levels = baked_nodes.make_levels(scene, list(layers), _automatic_white(shown.places))
    for number, place in enumerate(shown.places, start=1):
        shown.groups.append(baked_nodes.make_look(place, number, levels))
    for material, numbers in used.items():
        if material.library is not None:
            report.warn(
                material.name,
                "the material is linked from another file",
                "make it local to see baked light",
            )
            continue
        _wire(material, [shown.groups[number - 1] for number in sorted(numbers)], report)
    scene.lumenray.look.is_shown = True
    return report


def choose_figure(look, figure: str, unit: str, high: float) -> None:
    """Let a scene's look show a figure of a year in false colours from 0 on.

    Parameters
    ----------
    look : LumenrayLookSettings
    figure : str
    unit : str
    high : float    Upper end of the scale. [unit]
    """
    if not look.figure:
        look.lux_low, look.lux_high = look.low, look.high
    look.kind, look.figure, look.unit = "FALSE", figure, unit
    look.low, look.high = 0.0, high


def choose_light(look) -> None:
    """Let a scene's look show baked light again, on the scale that it had."""
    if look.figure:
        look.figure, look.unit = "", "lx"
        look.low, look.high = look.lux_low, look.lux_high


def hide() -> None:
    """Take away all that `show` added; materials are as they were."""
    for mesh in bpy.data.meshes:
        if mesh.get(MARK):
            mesh.materials.clear()
            del mesh[MARK]
    for material in list(bpy.data.materials):
        if material.get(MARK):
            bpy.data.materials.remove(material)
        elif material.node_tree is not None and material.library is None:
            _unwire(material)
    for source in bpy.data.objects:
        if PLACE in source:
            del source[PLACE]
            source.update_tag()
    baked_nodes.remove_groups()
    # Scenes share materials.
    for each in bpy.data.scenes:
        each.lumenray.look.is_shown = False


@contextmanager
def hidden(scene):
    """Let a scene be as it is without the look for the time being."""
    was_shown = scene.lumenray.look.is_shown
    if was_shown:
        hide()
    try:
        yield
    finally:
        if was_shown:
            show(scene)


def _find_places(scene) -> list[tuple[object, Place]]:
    """Return the objects that have something to show, and how it lies on them."""
    figure = scene.lumenray.look.figure
    if figure:
        image, sources = year_images.find_image(figure), year_images.find_objects(scene)
        if image is None or not sources:
            raise SceneError(
                "nothing to show: compute a year with maps of objects of this scene first"
            )
        return [(source, Place(image, name_map(source, year_images.UV_MAP))) for source in sources]
    sources = baked_objects(scene)
    if not sources:
        raise SceneError("nothing to show: bake objects of this scene first")
    return [
        (source, Place(own.baked_image, own.baked_uv, own.baked_back_uv))
        for source, own in ((source, source.lumenray) for source in sources)
    ]


def _automatic_white(places) -> float:
    # Figures of a year are shown in false colours alone.
    means = [baked_images.facts_of(place.image).get("mean", 1.0) for place in places]
    return automatic_white(float(np.mean(means)))


# ---- materials of objects ----


def _materials(source) -> list:
    """Materials of an object; where it has none, one that reflects as Blender's own for such objects does."""
    if not source.material_slots:
        source.data.materials.append(_placeholder())
        source.data[MARK] = True
    for slot in source.material_slots:
        if slot.material is None:
            slot.material = _placeholder()
    return list(dict.fromkeys(slot.material for slot in source.material_slots))


def _placeholder():
    for material in bpy.data.materials:
        if material.get(MARK):
            return material
    material = bpy.data.materials.new(PLACEHOLDER)
    material[MARK] = True
    if material.node_tree is None:
        # Only before Blender 5.0, where materials have nodes at all times.
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    shader = tree.nodes.new("ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (*[DEFAULT_REFLECTANCE] * 3, 1.0)
    output = tree.nodes.new("ShaderNodeOutputMaterial")
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


# ---- nodes of a material ----


def _wire(material, groups, report: ConversionReport) -> None:
    """Add an output for EEVEE that ends in baked light where the material is matt or glows by itself."""
    if not uses_nodes(material):
        # Blender makes a tree of its own then, which is not used again when this is off.
        material.use_nodes = True
        material[MARK_NODES] = True
    wiring = _Wiring(material, groups)
    if wiring.end() is None:
        report.info(
            material.name,
            "the material is neither matt nor luminous, or a node group hides its base colour",
            "no baked light is seen there",
        )
        wiring.remove()


def _unwire(material) -> None:
    _remove_nodes(material.node_tree)
    if MARK_NODES in material:
        material.use_nodes = False
        del material[MARK_NODES]


def _remove_nodes(tree) -> None:
    for node in [node for node in tree.nodes if node.get(MARK)]:
        before = tree.nodes.get(node.get(REPLACED, ""))
        tree.nodes.remove(node)
        if before is not None:
            before.is_active_output = True


class _Wiring:
    """What is added to one material."""

    def __init__(self, material, groups):
        self.material, self.groups = material, groups
        self.tree = material.node_tree
        self.has_part = False
        self._made: dict[str, object] = {}
        self._rows = 0
        self._right = FAR + max((node.location.x for node in self.tree.nodes), default=0.0)

    def end(self):
        """Make the output; None where there is nothing to show."""
        before = self.tree.get_output_node("EEVEE")
        own = self.material.lumenray
        if own.use_override:
            surface = self._override(before)
        elif self.material.get(MARK_NODES):
            colour = (*self.material.diffuse_color[:3], 1.0)
            surface = self._chain(None, {"Base Color": colour})
        else:
            surface = None if before is None else self._mirror(before.inputs["Surface"], True)
        if not self.has_part:
            return None
        output = self._add("ShaderNodeOutputMaterial")
        output.target = "EEVEE"
        self.tree.links.new(surface, output.inputs["Surface"])
        for socket in before.inputs if before is not None else ():
            if socket.name != "Surface":
                _copy(self.tree, socket, output.inputs[socket.name])
        if self.tree.get_output_node("EEVEE") != output:
            # The user has one for EEVEE alone, too.
            active = (node for node in self.tree.nodes if getattr(node, "is_active_output", False))
            output[REPLACED] = next((node.name for node in active), "")
            output.is_active_output = True
        return output

    def remove(self) -> None:
        """Take away what was added."""
        _remove_nodes(self.tree)

    def _mirror(self, socket, is_whole: bool):
        """Return the output that gives what arrives at a shader input, with baked light in place of what is matt."""
        source = _source(socket)
        if source is None:
            return None
        node = source.node
        key = f"{node.name}/{source.identifier}"
        if key not in self._made:
            # A circle of links ends at the user's own node.
            self._made[key] = source
            self._made[key] = self._mirror_node(source, is_whole)
        return self._made[key]

    def _mirror_node(self, source, is_whole: bool):
        node = source.node
        if node.mute:
            return source
        if node.bl_idname in {"ShaderNodeMixShader", "ShaderNodeAddShader"}:
            return self._mirror_sum(node)
        copied = COPIED.get(node.bl_idname, {})
        pairs = [
            (socket, copied[socket.name])
            for socket in node.inputs
            if socket.name in copied and not socket.is_unavailable
        ]
        if not pairs:
            return source
        given = {ours: socket for socket, ours in pairs}
        if node.bl_idname == "ShaderNodeEmission":
            # What only glows is not lit; alone, it still has an illuminance to show in false colours.
            given |= {"Base Color": (0.0, 0.0, 0.0, 1.0), "Matt": float(is_whole)}
        return self._chain(source, given)

    def _mirror_sum(self, node):
        made = self._add(node.bl_idname)
        for socket, ours in zip(node.inputs, made.inputs, strict=True):
            if socket.type != "SHADER":
                _copy(self.tree, socket, ours)
                continue
            part = self._mirror(socket, False)
            if part is not None:
                self.tree.links.new(part, ours)
        return made.outputs[0]

    def _override(self, before):
        """Show what the physical override states, in place of the nodes."""
        settings = self.material.lumenray
        surface, emission = convert_override(settings, ConversionReport(), self.material.name)
        given = {}
        if isinstance(surface, Diffuse | Coated | Fabric):
            given["Base Color"] = (*_reflected_colour(surface.reflectance), 1.0)
        elif emission is not None:
            given["Base Color"] = (0.0, 0.0, 0.0, 1.0)
            given["Emission Color"] = (*_emitted_colour(settings, emission.spectrum), 1.0)
            given["Luminance"] = emission.luminance
        else:
            return None
        source = None if before is None else _source(before.inputs["Surface"])
        return self._chain(source, given)

    def _chain(self, surface, given: dict):
        """Put our groups after a shader, one for each place; ``given``: sockets to copy and values, by our inputs."""
        self.has_part = True
        for group in self.groups:
            node = self._add("ShaderNodeGroup")
            node.node_tree, node.label = group, group.name
            if surface is not None:
                self.tree.links.new(surface, node.inputs["Surface"])
            for name, value in given.items():
                if isinstance(value, bpy.types.NodeSocket):
                    _copy(self.tree, value, node.inputs[name])
                else:
                    node.inputs[name].default_value = value
            surface = node.outputs["Surface"]
        return surface

    def _add(self, kind: str):
        node = self.tree.nodes.new(kind)
        node[MARK] = True
        node.location = (self._right, -260.0 * self._rows)
        self._rows += 1
        return node


def _source(socket):
    """Return the output that an input gets its value from, past reroutes; None if it is not linked."""
    for _ in range(1000):
        link = next((link for link in socket.links if not link.is_muted), None)
        if link is None:
            return None
        if link.from_node.bl_idname != "NodeReroute":
            return link.from_socket
        socket = link.from_node.inputs[0]
    return None


def _copy(tree, socket, ours) -> None:
    """Give an input of ours what an input of the user's gets."""
    source = _source(socket)
    if source is not None:
        tree.links.new(source, ours)
    elif hasattr(socket, "default_value") and socket.type == ours.type:
        ours.default_value = socket.default_value


def _reflected_colour(reflectance) -> tuple[float, float, float]:
    """Linear colour of a reflectance under daylight."""
    match reflectance:
        case Constant():
            return (reflectance.value,) * 3
        case Rgb():
            return (reflectance.red, reflectance.green, reflectance.blue)
    daylight = illuminant(GRID, "D65")
    colour = _linear(evaluate_reflectance(reflectance, GRID) * daylight)
    return tuple(np.maximum(colour / (_linear(daylight) @ REC709_LUMINANCE), 0.0))


def _emitted_colour(settings, spectrum) -> tuple[float, float, float]:
    """Linear colour of what an emitter gives, of luminance 1."""
    if isinstance(spectrum, Rgb):
        colour = np.array(settings.reflectance_color, dtype=float)
    else:
        colour = np.maximum(_linear(evaluate_emission(spectrum, GRID)), 0.0)
    return tuple(colour / max(float(colour @ REC709_LUMINANCE), 1e-9))


def _linear(power) -> np.ndarray:
    """Linear colour of a spectrum over `GRID`, on any scale."""
    return scene_linear(power @ observer(), 1.0).astype(float)
