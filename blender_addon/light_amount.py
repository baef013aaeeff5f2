"""The amount of light that Blender's own settings of a light stand for, for its physical parameters to start with."""

import bpy

from ..engine.scene.light import (
    AreaLight,
    LineLight,
    Luminaire,
    PointLight,
    Quantity,
    SpotLight,
    SunLight,
)
from . import readout
from .foundation.report import ConversionReport
from .foundation.units import metres_per_unit
from .sync.lights.lights import convert_light

NOTHING = {"SUN": "ILLUMINANCE"}
"""Quantity of a light that gives nothing; a flux where none is named."""

SAME = 1e-5
"""Relative difference up to which a stated amount counts as the one that was found here; properties are single precision."""


def find_amount(light, scene) -> tuple[str, float]:
    """Return quantity and value of what a light gives without physical parameters.

    Parameters
    ----------
    light : bpy.types.Light
    scene : bpy.types.Scene    For the meaning of watts, and an object that has the light.
    """
    made = _convert(light, scene)
    if made is None:
        return NOTHING.get(light.type, "LUMINOUS_FLUX"), 0.0
    quantity, value = made.output.quantity, made.output.value
    match made:
        case SunLight():
            return "ILLUMINANCE", value
        case AreaLight() | LineLight() if quantity is Quantity.LUMINANCE:
            # Not normalised by its size: this is what stays when it is made larger.
            return "LUMINANCE", value
        case AreaLight() | LineLight() | Luminaire():
            return "LUMINOUS_FLUX", value
        case PointLight():
            return "LUMINOUS_FLUX", readout.read_point(quantity.name, value, made.radius).flux
        case SpotLight():
            reading = readout.read_spot(quantity.name, value, made.half_angle, made.blend)
            return "LUMINOUS_FLUX", reading.flux
    raise TypeError(f"{type(made).__name__} is no light that Blender's own settings make")


def start(light, scene) -> None:
    """State what the light gives, unless the user has stated something before."""
    settings = light.lumenray
    if settings.is_property_set("value") or settings.is_property_set("quantity"):
        return
    settings.quantity, settings.value = find_amount(light, scene)


def forget(light, scene) -> None:
    """Take a statement back that says no more than Blender's own settings, so that the next one starts with theirs."""
    settings = light.lumenray
    if not settings.is_property_set("value"):
        return
    quantity, value = find_amount(light, scene)
    if settings.quantity == quantity and abs(settings.value - value) <= SAME * value:
        settings.property_unset("quantity")
        settings.property_unset("value")


def _convert(light, scene):
    """Convert a copy of a light without physical parameters; None if it gives nothing."""
    owner = next((item for item in scene.objects if item.data == light), None)
    copy = light.copy()
    thing = bpy.data.objects.new(light.name, copy)
    try:
        own = copy.lumenray
        for settings, switch in (
            (own, "use_physical"),
            (own.luminaire, "use_file"),
            (own.rayset, "use_file"),
        ):
            if getattr(settings, switch):
                setattr(settings, switch, False)
        matrix = thing.matrix_world if owner is None else owner.matrix_world
        scale = metres_per_unit(scene)
        efficacy = scene.lumenray.efficacy
        return convert_light(thing, "", light.name, matrix, scale, efficacy, ConversionReport())
    finally:
        bpy.data.objects.remove(thing)
        bpy.data.lights.remove(copy)
