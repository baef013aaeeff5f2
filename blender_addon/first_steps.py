"""The first steps with a scene, from a light to lux that can be seen, and which of them are done.

What takes a look at objects is found by a timer while a panel asks for it, and once when a scene is shown first; the rest is
read as it is.
"""

import time
from dataclasses import dataclass, field
from enum import Enum

import bpy

from ..imports import loaded_when_used
from .foundation import preferences
from .foundation.redraw import redraw
from .luminaires.settings import is_luminaire
from .raysets.settings import is_rayset
from .rendering.render_engine import LumenrayRenderEngine
from .sync.meshes import MESH_TYPES

with loaded_when_used():
    from .sync.lights import portals

QUIET = 0.3
"""How long it takes at least until a change is seen. [s]"""

SHARE = 0.05
"""Share of the time that looking may take."""


class Step(Enum):
    """A step, by what is so when it is done."""

    ENGINE = "Lumenray renders"
    LIGHT = "Light of stated amount"
    SURFACE = "Surface of known reflectance"
    BAKE = "Illuminance baked"
    LUX = "Lux in false colours"


@dataclass(frozen=True)
class Found:
    """Whether an object of a scene is a light of stated amount, and whether one has a surface of stated reflectance."""

    light: bool = False
    surface: bool = False


@dataclass
class _State:
    """What was found, by session uid of the scene; the scenes that a panel asks for; what the last look took. [s]"""

    held: dict[int, Found] = field(default_factory=dict)
    asked: set[int] = field(default_factory=set)
    seconds: float = 0.0


_state = _State()


def follow(scene) -> None:
    """Have a scene looked at soon, for a panel that shows its steps; cheap enough for every redraw."""
    if scene.session_uid not in _state.held:
        refresh(scene)
    if bpy.app.background:
        return
    _state.asked.add(scene.session_uid)
    if not bpy.app.timers.is_registered(_look_soon):
        interval = max(QUIET, _state.seconds / SHARE)
        bpy.app.timers.register(_look_soon, first_interval=interval)


def refresh(scene) -> bool:
    """Look at a scene anew, and tell whether anything is other than before."""
    now = find(scene)
    is_other = _state.held.get(scene.session_uid) != now
    _state.held[scene.session_uid] = now
    return is_other


def find(scene) -> Found:
    """Look for a light of stated amount and for a surface of stated reflectance; no longer than for the first of each."""
    world = scene.world
    light = world is not None and (
        world.lumenray.source == "CIE" or world.lumenray.unit != "BLENDER"
    )
    surface = False
    for thing in _things(scene):
        light = light or _states_amount(thing)
        surface = surface or _states_reflectance(thing)
        if light and surface:
            break
    return Found(light, surface)


def done(scene) -> dict[Step, bool]:
    """Return all steps in their order, each with whether it is done; only reads, for panels."""
    own, found = scene.lumenray, _state.held.get(scene.session_uid, Found())
    is_baked = len(own.baked.rows) > 0
    is_false_view = own.viewport.display == "FALSE_ILLUMINANCE"
    return {
        Step.ENGINE: scene.render.engine == LumenrayRenderEngine.bl_idname,
        Step.LIGHT: found.light,
        Step.SURFACE: found.surface,
        Step.BAKE: is_baked,
        Step.LUX: is_baked and (is_false_view or (own.look.is_shown and own.look.kind == "FALSE")),
    }


def are_shown(scene) -> bool:
    """Whether there is something left to do, and the user wants to be told."""
    return preferences.shows_steps() and not all(done(scene).values())


def _things(scene):
    """Objects of a scene that renders show, and those of collections that they are instances of."""
    for thing in scene.objects:
        if thing.hide_render:
            continue
        yield thing
        if thing.instance_type == "COLLECTION" and thing.instance_collection is not None:
            yield from thing.instance_collection.all_objects


def _states_amount(thing) -> bool:
    if is_luminaire(thing) or is_rayset(thing):
        return True
    return (
        thing.type == "LIGHT"
        and thing.data.lumenray.use_physical
        and not portals.is_portal(thing.data)
    )


def _states_reflectance(thing) -> bool:
    if thing.type not in MESH_TYPES:
        return False
    materials = (slot.material for slot in thing.material_slots)
    stated = (each.lumenray for each in materials if each is not None)
    return any(each.use_override and each.model != "EMITTER" for each in stated)


def _look_soon():
    """Look at the scenes that were asked for, once."""
    start = time.perf_counter()
    wanted = [scene for scene in bpy.data.scenes if scene.session_uid in _state.asked]
    _state.asked.clear()
    is_other = [refresh(scene) for scene in wanted]
    _state.seconds = time.perf_counter() - start
    if any(is_other):
        redraw("VIEW_3D")


def detach():
    """Look no more, and forget what was found."""
    if bpy.app.timers.is_registered(_look_soon):
        bpy.app.timers.unregister(_look_soon)
    _state.held.clear()
    _state.asked.clear()
