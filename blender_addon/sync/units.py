"""Blender's units of length."""


def metres_per_unit(scene) -> float:
    """Length of a Blender unit. [m]"""
    settings = scene.unit_settings
    return settings.scale_length if settings.system != "NONE" else 1.0
