"""Sun lights and dated notes that follow a world's place and time: after every edit, frame and undo.

A frame of an animation is told by Blender after it has evaluated it, in renders without a window too; what is set here then
has it evaluated once more before it is rendered. Nothing is written that stands there already, so that nothing goes round.
"""

import math

import bpy
from bpy.app.handlers import persistent

from ...engine.errors import LumenrayError
from ...imports import loaded_when_used
from ..foundation.handlers import leave, listen
from ..foundation.redraw import redraw

with loaded_when_used():
    import numpy as np

    from ...engine.photometry import colour as photometry_colour
    from ...engine.sky import solar_position
    from . import moment as daylight_moment
    from . import sunlight as daylight_sunlight

NEAR = 1e-6
"""Relative difference up to which a property holds a number; it is of single precision."""


def redraw_arc(self, context) -> None:
    """Have the 3D views drawn again."""
    redraw("VIEW_3D")


def follow_edit(self, context) -> None:
    """Tell the dependency graph of an edit of a world's settings, and let all that follows them follow."""
    self.id_data.update_tag()
    follow_world(self.id_data)


def follow_world(world) -> None:
    """Let all that follows a world follow it in the scenes that have it."""
    for scene in bpy.data.scenes:
        if scene.world == world:
            follow(scene, world)
    redraw("VIEW_3D")


def follow(scene, world, shown=None) -> None:
    """Set the Sun light and the note of a scene to the moment of its world.

    Parameters
    ----------
    scene : bpy.types.Scene
    world : bpy.types.World    Whose light it is.
    shown : bpy.types.World or None    The same, evaluated; it has what is animated.
    """
    shown = world if shown is None else shown
    lamp = lamp_of(scene, world)
    is_noted = world.lumenray.time.use_note
    if lamp is None and not is_noted:
        return
    # What cannot be known is said by the panel and the conversion report; nothing is better than what was at another moment.
    try:
        moment = daylight_moment.find_moment(shown, daylight_moment.frame_of(scene))
    except LumenrayError:
        moment = None
    if is_noted:
        _note(scene.render, moment.title if moment is not None else "")
    if lamp is not None:
        if moment is not None:
            _turn(lamp, moment)
        _shine(lamp.data, shown, moment, scene.lumenray.efficacy)


def is_sun(thing) -> bool:
    """Tell whether an object, or None, is a Sun light."""
    return thing is not None and thing.type == "LIGHT" and thing.data.type == "SUN"


def lamp_of(scene, world):
    """Return the Sun light object of a scene that follows a world, None without one."""
    lamp = world.lumenray.sun.lamp
    if not is_sun(lamp):
        return None
    return lamp if scene.objects.get(lamp.name) == lamp else None


def rotation_of(moment: "daylight_moment.Moment") -> tuple[float, float, float]:
    """Return Euler angles of a light that shines from the sun: tipped about x, then turned about z. [rad]"""
    x, y, z = (float(value) for value in moment.towards_sun)
    return -math.acos(min(max(z, -1.0), 1.0)), 0.0, -math.atan2(x, y)


def add_lamp(scene, chosen):
    """Let a Sun light, or a new one, follow the scene's world, and return it.

    ``chosen``: Sun light object of the scene, or None.
    """
    lamp = chosen
    if lamp is None:
        lamp = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
        scene.collection.objects.link(lamp)
    _prepare(lamp)
    scene.world.lumenray.sun.lamp = lamp
    return lamp


def _prepare(lamp) -> None:
    """Prepare a Sun light for following: physical parameters, the sun's size and the spectrum of sunlight."""
    lamp.rotation_mode = "XYZ"
    data = lamp.data
    data.angle = math.radians(2.0 * solar_position.RADIUS)
    if hasattr(data, "normalize"):
        data.normalize = True
    own = data.lumenray
    own.quantity, own.use_physical, own.spectrum = "ILLUMINANCE", True, "SUNLIGHT"


def _turn(lamp, moment: "daylight_moment.Moment") -> None:
    wanted = rotation_of(moment)
    if lamp.rotation_mode != "XYZ":
        lamp.rotation_mode = "XYZ"
    if not np.allclose(lamp.rotation_euler, wanted, rtol=0.0, atol=NEAR):
        lamp.rotation_euler = wanted


def _shine(light, world, moment: "daylight_moment.Moment | None", efficacy: float) -> None:
    """Set a light in Lumenray's terms and, as far as other engines know it, in Blender's; dark where it cannot be known."""
    try:
        sunlight = None if moment is None else daylight_sunlight.find_sunlight(world, moment)
    except LumenrayError:
        sunlight = None
    if sunlight is None:
        _darken(light)
        return
    colour = sunlight.colour
    own = light.lumenray
    _set(own, "value", sunlight.illuminance)
    _set(own, "turbidity", world.lumenray.sun.turbidity)
    _set(own, "sun_elevation", math.radians(max(moment.elevation, 0.0)))
    watts = sunlight.illuminance / (efficacy * float(photometry_colour.REC709_LUMINANCE @ colour))
    _set(light, "energy", watts / 2.0 ** getattr(light, "exposure", 0.0))
    if not np.allclose(light.color, colour, rtol=0.0, atol=NEAR):
        light.color = colour
    if getattr(light, "use_temperature", False):
        light.use_temperature = False


def _darken(light) -> None:
    _set(light.lumenray, "value", 0.0)
    _set(light, "energy", 0.0)


def _set(owner, name: str, value: float) -> None:
    if not math.isclose(getattr(owner, name), value, rel_tol=NEAR, abs_tol=NEAR):
        setattr(owner, name, value)


def _note(render, text: str) -> None:
    if not (render.use_stamp and render.use_stamp_note):
        _burn_note(render)
    if render.stamp_note_text != text:
        render.stamp_note_text = text


def _burn_note(render) -> None:
    """Switch the note on; where nothing was burnt in before, nothing but the note is now."""
    if not render.use_stamp:
        for entry in render.bl_rna.properties:
            name = entry.identifier
            is_part = name.startswith("use_stamp_") and entry.type == "BOOLEAN"
            if is_part and name not in {"use_stamp_note", "use_stamp_labels"}:
                setattr(render, name, False)
        render.use_stamp_labels = False
        render.use_stamp = True
    render.use_stamp_note = True


def take_notes_away(world) -> None:
    """Burn the note of a world's time into pictures no longer."""
    for scene in bpy.data.scenes:
        if scene.world == world:
            scene.render.use_stamp_note = False
            scene.render.stamp_note_text = ""


@persistent
def _after_frame(scene, depsgraph=None) -> None:
    world = scene.world
    if world is None:
        return
    shown = world if depsgraph is None else world.evaluated_get(depsgraph)
    if daylight_moment.follows_frames(shown):
        # Blender does not know that the world depends on the frame.
        world.update_tag()
    follow(scene, world, shown)


@persistent
def _after_change(*_) -> None:
    for scene in bpy.data.scenes:
        if scene.world is not None:
            follow(scene, scene.world)


_HANDLERS = {
    "frame_change_post": _after_frame,
    "undo_post": _after_change,
    "redo_post": _after_change,
    "load_post": _after_change,
}


def attach():
    """Follow from now on."""
    listen(_HANDLERS)


def detach():
    """Follow no more."""
    leave(_HANDLERS)
