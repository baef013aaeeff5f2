"""Blender's units of length."""

import bpy

INCH, FOOT = 0.0254, 0.3048
"""Lengths of scenes in imperial units. [m]"""


def metres_per_unit(scene) -> float:
    """Length of a Blender unit. [m]"""
    settings = scene.unit_settings
    return settings.scale_length if settings.system != "NONE" else 1.0


def format_lengths(metres, large: float = 1.0) -> str:
    """Return lengths in the units of the scene that is open: in m or feet from ``large`` [m] on, else in mm or inches."""
    is_small = max(metres) < large
    if bpy.context.scene.unit_settings.system == "IMPERIAL":
        unit, name = (INCH, "in") if is_small else (FOOT, "ft")
        return " × ".join(f"{length / unit:.4g}" for length in metres) + f" {name}"
    unit, name = (1e-3, "mm") if is_small else (1.0, "m")
    return " × ".join(f"{length / unit:.4g}" for length in metres) + f" {name}"
