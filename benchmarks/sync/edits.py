"""What a user does to a scene of `grid_scene`, one edit at a time.

Data-blocks are looked up anew for every edit, because undo makes all references invalid.
"""

import random
from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import Enum

import bpy

from .grid_scene import LAMPS, MATERIALS, reshape

MODELS = ("CONDUCTOR", "COATED", "DIFFUSE")
"""Kinds of surface that a material is changed to in turn."""


class Answer(Enum):
    """What an edit has to lead to."""

    SAMPLE = "a new sample of the changed scene"
    VIEW = "a new sample of the same scene"
    NOTHING = "nothing is sent"


@dataclass(frozen=True)
class Edit:
    """One kind of edit.

    Parameters
    ----------
    name : str
    prepare : callable    ``prepare(desk, nth)`` returns the function that makes the edit, which alone is timed.
    answer : Answer
    """

    name: str
    prepare: Callable
    answer: Answer = Answer.SAMPLE


class Desk:
    """Hands out objects that nobody has touched since the last full sync, in a random order.

    Parameters
    ----------
    synchronise : callable    Brings the engine up to date and waits for its sample.
    """

    def __init__(self, seed: int, synchronise: Callable[[], None]):
        self.synchronise = synchronise
        self._names = sorted(o.name for o in bpy.context.scene.objects if o.type == "MESH")
        random.Random(seed).shuffle(self._names)  # noqa: S311 - nothing secret
        self.kept = self._names.pop()
        self.hidden = ""

    def pick(self):
        """Return an untouched patch."""
        return bpy.data.objects[self._names.pop()]


# ---- objects ----


def _move(desk, nth):
    return _lift(desk.pick(), nth)


def _move_again(desk, nth):
    return _lift(bpy.data.objects[desk.kept], nth)


def _lift(item, nth):
    def edit():
        item.location.z += 0.05 + 0.01 * nth

    return edit


def _deform(desk, nth):
    mesh = desk.pick().data
    return lambda: reshape(mesh, 100.0 + nth)


def _add(desk, nth):
    model = desk.pick()
    mesh = model.data.copy()
    reshape(mesh, 200.0 + nth)
    place = model.location.copy()

    def edit():
        made = bpy.data.objects.new(f"Added {nth}", mesh)
        made.location = (place.x, place.y, 0.3)
        bpy.context.scene.collection.objects.link(made)

    return edit


def _delete(desk, _nth):
    item = desk.pick()
    return lambda: bpy.data.objects.remove(item)


def _duplicate(desk, _nth):
    item = desk.pick()

    def edit():
        made = item.copy()
        made.data = item.data.copy()
        made.location.z += 0.3
        bpy.context.scene.collection.objects.link(made)

    return edit


def _rename(desk, nth):
    item = desk.pick()

    def edit():
        item.name = f"Renamed {nth}"

    return edit


def _select(desk, _nth):
    item = desk.pick()

    def edit():
        item.select_set(True)
        bpy.context.view_layer.objects.active = item

    return edit


def _hide(desk, _nth):
    item = desk.pick()
    desk.hidden = item.name
    return lambda: item.hide_set(True)


def _unhide(desk, _nth):
    item = bpy.data.objects[desk.hidden]
    return lambda: item.hide_set(False)


def _undo(desk, nth):
    item = desk.pick()
    bpy.ops.ed.undo_push(message="before")
    _lift(item, nth)()
    desk.synchronise()
    bpy.ops.ed.undo_push(message="after")
    return bpy.ops.ed.undo


# ---- materials ----


def _material_colour(_desk, nth):
    material = bpy.data.materials[f"Paint {nth % (MATERIALS // 2):02}"]
    colour = material.node_tree.nodes["Principled BSDF"].inputs["Base Color"]

    def edit():
        colour.default_value = (0.2, 0.1 + 0.05 * nth, 0.5, 1.0)

    return edit


def _material_value(_desk, nth):
    material = bpy.data.materials[f"Paint {nth % (MATERIALS // 2):02}"]
    roughness = material.node_tree.nodes["Principled BSDF"].inputs["Roughness"]

    def edit():
        roughness.default_value *= 0.9

    return edit


def _material_type(_desk, nth):
    number = MATERIALS // 2 + nth % (MATERIALS // 2)
    settings = bpy.data.materials[f"Paint {number:02}"].lumenray
    others = [model for model in MODELS if model != settings.model]

    def edit():
        settings.model = others[nth % len(others)]

    return edit


# ---- light ----


def _lamp(nth):
    return bpy.data.objects[LAMPS[nth % len(LAMPS)].title()]


def _light_power(_desk, nth):
    data = _lamp(nth).data

    def edit():
        data.energy *= 1.1

    return edit


def _light_colour(_desk, nth):
    data = _lamp(nth).data

    def edit():
        data.color = (1.0, 0.9 - 0.05 * nth, 0.5)

    return edit


def _light_move(_desk, nth):
    item = _lamp(nth)

    def edit():
        item.location.x += 0.3

    return edit


def _world(_desk, _nth):
    strength = bpy.context.scene.world.node_tree.nodes["Background"].inputs["Strength"]

    def edit():
        strength.default_value *= 1.1

    return edit


def turned(camera, nth: int):
    """Return a camera of the engine, moved a little. [m]"""
    frame = camera.frame.copy()
    frame[:3, 3] += (0.05 * nth, 0.02 * nth, 0.0)
    return replace(camera, frame=frame)


GROUPS = (
    (
        Edit("move", _move),
        Edit("move again", _move_again),
        Edit("deform", _deform),
        Edit("camera", lambda _desk, _nth: None, Answer.VIEW),
        Edit("light power", _light_power),
        Edit("light colour", _light_colour),
        Edit("light move", _light_move),
        Edit("material colour", _material_colour),
        Edit("material value", _material_value),
        Edit("material type", _material_type),
    ),
    (
        Edit("add", _add),
        Edit("duplicate", _duplicate),
        Edit("hide", _hide),
        Edit("unhide", _unhide),
        Edit("undo", _undo),
    ),
    (
        Edit("delete", _delete),
        Edit("rename", _rename, Answer.NOTHING),
        Edit("select", _select, Answer.NOTHING),
        Edit("world", _world),
    ),
)
"""Groups of edits; each begins with a full sync, so that its first edit is the first one there is."""

NAMES = tuple(edit.name for group in GROUPS for edit in group)

PARAMETERS = (
    "camera",
    "light power",
    "light colour",
    "material colour",
    "material value",
)
"""Edits of a parameter, in the sense of the bars."""

OBJECTS = ("move", "add", "delete")
"""Edits of one object, in the sense of the bars."""
