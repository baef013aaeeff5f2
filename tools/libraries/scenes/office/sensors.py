"""What the office is to comply with: light groups, lighting scenes, and sensors with their requirements."""

import math

import bpy

from .furniture import PLACES, on_desk

GROUPS = {"LED Panel": "Ceiling", "Desk Lamp": "Desk Lamp"}
"""Light groups of lights by the beginnings of their names; the sky is a group of its own."""

SKY_GROUP = "Daylight"

LIGHTING_SCENES = {
    "Day": {"Ceiling": 0.5, "Desk Lamp": 0.0},
    "Evening": {"Daylight": 0.0},
    "Emergency": {"Ceiling": 0.05, "Desk Lamp": 0.0, "Daylight": 0.0},
}
"""Factors on the flux of light groups; others shine as they are. In an emergency the batteries of the panels hold 5 %."""

WRITING, NORMAL = "office.writing", "Day, Evening"

DESK_HEIGHT, EYE_HEIGHT = 0.75, 1.2
"""Of work, and of the eyes of people who sit. [m]"""

TASK, TASK_AT = (0.8, 0.4), 0.1
"""Length and width of the task area on a desk, and its middle towards the user, clear of what stands on the desk. [m]"""


def build_sensors(collection):
    """Name the light groups, keep lighting scenes, and add sensors."""
    scene = bpy.context.scene
    for light in (item for item in scene.objects if item.type == "LIGHT"):
        group = next((name for start, name in GROUPS.items() if light.name.startswith(start)), "")
        light.data.lumenray.light_group = group
    scene.world.lumenray.light_group = SKY_GROUP
    # Renders keep no groups apart unless they are asked to, which takes more samples.
    mix = scene.lumenray.light_mix
    names = sorted({*GROUPS.values(), SKY_GROUP})
    for name in names:
        mix.rows.add().name = name
    for name, factors in LIGHTING_SCENES.items():
        row = mix.scenes.add()
        row.name = name
        for group in names:
            level = row.rows.add()
            level.name, level.factor = group, factors.get(group, 1.0)
            level.is_on = level.factor > 0.0
    for desk, (_, turn) in PLACES.items():
        _add_task(collection, desk, turn)
    settings = _add_floor(collection, "Faces", "CYLINDRICAL", EYE_HEIGHT)
    settings.requirement, settings.lighting_scenes = WRITING, NORMAL
    eye = _add(collection, "Eyes at Desk A", "POINT", "GLARE")
    # Above the chair, looking over the desk.
    eye.location = on_desk("A", 0.0, 0.75, EYE_HEIGHT - DESK_HEIGHT)
    eye.rotation_euler = (0.0, 0.0, math.radians(PLACES["A"][1] - 90.0))
    eye.lumenray.sensor.requirement, eye.lumenray.sensor.lighting_scenes = WRITING, NORMAL
    settings = _add_floor(collection, "Escape Area", "PLANAR", 0.0)
    settings.requirement, settings.lighting_scenes = "emergency.open_area", "Emergency"


def _add_task(collection, desk: str, turn: float):
    """Add the task area of a desk."""
    empty = _add(collection, f"Desk {desk}", "GRID", "PLANAR")
    empty.location = on_desk(desk, 0.0, TASK_AT, 0.03)
    empty.rotation_euler = (0.0, 0.0, math.radians(turn))
    settings = empty.lumenray.sensor
    settings.length, settings.width = TASK
    settings.requirement, settings.area, settings.lighting_scenes = WRITING, "TASK", NORMAL


def _add_floor(collection, name: str, quantity: str, height: float):
    """Add sensors over the floor, and return their settings."""
    settings = _add(collection, name, "FLOOR", quantity).lumenray.sensor
    settings.surface, settings.height = bpy.data.objects["Floor"], height
    return settings


def _add(collection, name: str, layout: str, quantity: str):
    empty = bpy.data.objects.new(name, None)
    empty.empty_display_type, empty.empty_display_size = "ARROWS", 0.15
    settings = empty.lumenray.sensor
    settings.is_sensor, settings.layout, settings.quantity = True, layout, quantity
    collection.objects.link(empty)
    return empty
