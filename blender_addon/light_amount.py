"""The amount of light that Blender's own settings of a light stand for, for its physical parameters to start with."""

import bpy

from ..engine.scene.light import Quantity
from .foundation.report import ConversionReport
from .foundation.units import metres_per_unit
from .sync.lights.kinds import kind_of, read_light
from .sync.lights.lights import convert_light

SAME = 1e-5
"""Relative difference up to which a stated amount counts as the one that was found here; properties are single precision."""


def find_amount(light, scene) -> tuple[str, float]:
    """Return quantity and value of what a light gives without physical parameters.

    Parameters
    ----------
    light : bpy.types.Light
    scene : bpy.types.Scene    For the meaning of watts, and an object that has the light.
    """
    converted = _convert(light, scene)
    if converted is None:
        return kind_of(light).whole.name, 0.0
    quantity, value = converted.output.quantity, converted.output.value
    if quantity is Quantity.LUMINOUS_INTENSITY:
        return Quantity.LUMINOUS_FLUX.name, read_light(converted).flux
    # A luminance is that of a light which is not normalised by its size: it stays when the light is made larger.
    return quantity.name, value


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
