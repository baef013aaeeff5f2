"""What is registered with Blender, in order. The classes of operators and panels are handed in by the root."""

import bpy

from . import properties
from .rendering import render_engine


def _groups():
    """Modules with something to register: classes, and functions that tie them to Blender and off again."""
    from . import (
        asset_libraries,
        feedback,
        first_steps,
        migrate,
        preferences,
        setting_presets,
        shown_lights,
    )
    from .bake import results as baked_results
    from .bake import running as running_bake
    from .cloths.tables import cloth_tables
    from .daylight import following, ready
    from .foundation import background_job, engine_process, identity, running_trials
    from .inks.tables import ink_tables
    from .modelling import results as modelling_results
    from .paints.tables import paint_tables
    from .raysets.files import ray_files
    from .rendering import light_mix, view_drawing, viewport
    from .scattering.files import scattering_files
    from .sensors import refresh as refreshed_sensors
    from .sensors import results as sensor_results
    from .sync import live

    return (
        properties,
        migrate,
        preferences,
        asset_libraries,
        setting_presets,
        feedback,
        shown_lights,
        first_steps,
        identity,
        following,
        ready,
        baked_results,
        sensor_results,
        modelling_results,
        live,
        ray_files,
        scattering_files,
        paint_tables,
        ink_tables,
        cloth_tables,
        engine_process,
        running_bake,
        running_trials,
        background_job,
        refreshed_sensors,
        light_mix,
        viewport,
        view_drawing,
        render_engine,
    )


def register(classes=()) -> None:
    """Register properties, the render engine and ``classes``; what is registered already stays."""
    for group in _groups():
        _add(getattr(group, "CLASSES", ()))
        if hasattr(group, "attach"):
            group.attach()
    _add(classes)


def unregister(classes=()) -> None:
    """Undo `register`, in reverse order."""
    _remove(classes)
    for group in reversed(_groups()):
        if hasattr(group, "detach"):
            group.detach()
        _remove(getattr(group, "CLASSES", ()))


def _add(classes) -> None:
    for cls in classes:
        if not getattr(cls, "is_registered", False):
            bpy.utils.register_class(cls)


def _remove(classes) -> None:
    for cls in reversed(classes):
        if getattr(cls, "is_registered", False):
            bpy.utils.unregister_class(cls)
