"""Settings of sensors: a group of the empties that are sensors, and one of the scene that says how they are measured."""

import math

from bpy.props import (
    BoolProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import Object, PropertyGroup

from ...imports import loaded_when_used
from ..foundation.settings import PATH_OPTIONS, percentage, redraw_views, tag_owner

with loaded_when_used():
    from . import requirements


def _is_mesh(self, thing) -> bool:
    return thing.type == "MESH"


def _is_camera(self, thing) -> bool:
    return thing.type == "CAMERA"


LAYOUTS = [
    ("POINT", "Point", "One sensor, at the empty", 0),
    ("LINE", "Line", "Sensors along the empty's X axis", 1),
    ("GRID", "Rectangle", "A grid on a rectangle in the empty's XY plane, about the empty", 2),
    (
        "FACE",
        "Face",
        "A grid on what of a mesh lies in the empty's XY plane and faces its Z axis",
        3,
    ),
    ("FLOOR", "Floor", "A level grid at a height over all that is level of a mesh", 4),
    (
        "BAND",
        "Band",
        "A grid on the band around a rectangle in the empty's XY plane, as around a task area",
        5,
    ),
    (
        "CAMERA",
        "Camera",
        "The parts of a camera's picture, in rows and columns, of which the mean luminances are told",
        6,
    ),
    (
        "SPHERE",
        "Goniometer",
        "Detectors on a sphere about the empty, which measure the intensities of the luminaire within its radius",
        7,
    ),
]

QUANTITIES = [
    ("PLANAR", "Planar", "Illuminance of the plane that the empty's Z axis points away from", 0),
    (
        "VERTICAL",
        "Vertical",
        "Illuminance of an upright plane that looks along the empty's X axis, as eyes do",
        1,
    ),
    (
        "CYLINDRICAL",
        "Cylindrical",
        "Mean over the side of a small upright cylinder, as of faces from all around",
        2,
    ),
    (
        "SEMICYLINDRICAL",
        "Semicylindrical",
        "Mean over the half of such a cylinder that looks along the empty's X axis",
        3,
    ),
    ("SPHERICAL", "Spherical", "Mean over a small sphere", 4),
    (
        "LUMINANCE",
        "Luminance",
        "Mean luminance in cd/m² within a cone about the empty's X axis, as a meter reads it",
        5,
    ),
    (
        "GLARE",
        "Glare",
        "Unified glare rating (UGR) of an observer whose eye is here and looks along the empty's X axis",
        6,
    ),
    (
        "INTENSITY",
        "Intensity",
        "Luminous intensities in cd of the luminaire within a goniometer, by the empty's axes: gamma is 0 along -Z",
        7,
    ),
]

JUDGED_AREAS = [
    (
        "AUTO",
        "By Quantity",
        "Task area of planar, cylindrical of cylindrical illuminance, else none",
        0,
    ),
    ("NONE", "None", "The sensors are not judged", 1),
    ("TASK", "Task", "Where the task is done", 2),
    ("SURROUNDINGS", "Surroundings", "The band around a task area", 3),
    ("BACKGROUND", "Background", "What lies around the surroundings", 4),
    ("WALLS", "Walls", "Walls", 5),
    ("CEILING", "Ceiling", "The ceiling", 6),
    ("CYLINDRICAL", "Cylindrical", "Faces of people", 7),
    (
        "MELANOPIC",
        "Melanopic",
        "Eyes, by melanopic equivalent daylight illuminance; it takes the spectrum",
        8,
    ),
]


def _search_requirements(_self, context, typed: str):
    """Keys of the requirements that the scene knows, with their titles."""
    known = requirements.known_keys(context.scene)
    return [(key, each.title) for key, each in known.items() if typed.lower() in key]


class LumenraySensorSettings(PropertyGroup):
    """The sensors that an empty stands for, and what they told when they were measured last."""

    is_sensor: BoolProperty(
        name="Sensors",
        description="Let this empty stand for illuminance sensors. Default off: empties are none",
        default=False,
        update=tag_owner,
    )
    layout: EnumProperty(
        name="Layout",
        description="Where the sensors stand. Default Point: one place",
        items=LAYOUTS,
        default="POINT",
        update=tag_owner,
    )
    quantity: EnumProperty(
        name="Quantity",
        description="What is measured. Default Planar: the illuminance of work places and floors",
        items=QUANTITIES,
        default="PLANAR",
        update=tag_owner,
    )
    acceptance: FloatProperty(
        name="Acceptance Angle",
        description="Full width of the cone of luminance meters. Default 1°: that of most meters",
        default=math.radians(1.0),
        min=math.radians(0.01),
        max=math.radians(120.0),
        soft_max=math.radians(20.0),
        subtype="ANGLE",
        update=tag_owner,
    )
    length: FloatProperty(
        name="Length",
        description=(
            "Of the line or the rectangle along the empty's X axis, in metres; the empty's scale does not count. Default "
            "2: that of a desk with what is around it"
        ),
        default=2.0,
        min=0.01,
        max=10000.0,
        soft_max=100.0,
        update=tag_owner,
    )
    width: FloatProperty(
        name="Width",
        description="Of the rectangle along the empty's Y axis, in metres. Default 1: that of a desk",
        default=1.0,
        min=0.01,
        max=10000.0,
        soft_max=100.0,
        update=tag_owner,
    )
    band: FloatProperty(
        name="Band",
        description=(
            "Width of the band around the rectangle, in metres. Default 0.5: the immediate surroundings of a task by "
            "EN 12464-1, its background has 3"
        ),
        default=0.5,
        min=0.01,
        max=1000.0,
        soft_max=10.0,
        update=tag_owner,
    )
    surface: PointerProperty(
        name="Surface",
        description="Mesh that the grid is laid on or over; of a band, the floor that it ends with, if there is one",
        type=Object,
        poll=_is_mesh,
        update=tag_owner,
    )
    camera: PointerProperty(
        name="Camera",
        description="Camera whose picture is measured in parts; with none it is that of the scene",
        type=Object,
        poll=_is_camera,
        update=tag_owner,
    )
    columns: IntProperty(
        name="Columns",
        description="Number of parts of the picture across. Default 6: few enough for their numbers to be read",
        default=6,
        min=1,
        max=256,
        soft_max=32,
        update=tag_owner,
    )
    rows: IntProperty(
        name="Rows",
        description="Number of parts of the picture from below. Default 4: parts of usual pictures are about square",
        default=4,
        min=1,
        max=256,
        soft_max=32,
        update=tag_owner,
    )
    radius: FloatProperty(
        name="Radius",
        description=(
            "Of the ball about the empty: all that lies within is the luminaire, in metres; the empty's scale does not "
            "count. Default 0.5: most luminaires are smaller"
        ),
        default=0.5,
        min=0.001,
        max=1000.0,
        soft_max=5.0,
        update=tag_owner,
    )
    plane_step: FloatProperty(
        name="Plane Step",
        description="Angle between C planes, of which a turn holds a whole number. Default 15°: as most files have it",
        default=math.radians(15.0),
        min=math.radians(1.0),
        max=math.radians(90.0),
        subtype="ANGLE",
        update=tag_owner,
    )
    polar_step: FloatProperty(
        name="Gamma Step",
        description=(
            "Angle gamma between the detectors of a plane, of which 180° hold a whole number. Default 5°: as most files "
            "have it; narrow beams need less"
        ),
        default=math.radians(5.0),
        min=math.radians(0.1),
        max=math.radians(45.0),
        subtype="ANGLE",
        update=tag_owner,
    )
    use_distance: BoolProperty(
        name="Own Distance",
        description=(
            "State how far away the detectors are, as those of a real goniometer. Default off: so far that all of the "
            "luminaire lies in one direction"
        ),
        default=False,
        update=tag_owner,
    )
    distance: FloatProperty(
        name="Distance",
        description="Of the detectors from the empty, in metres. Default 10: that of many goniometers",
        default=10.0,
        min=0.01,
        max=1e5,
        soft_max=100.0,
        update=tag_owner,
    )
    height: FloatProperty(
        name="Height",
        description="Of the sensors over the floor, in metres. Default 0.75: that of desks",
        default=0.75,
        min=0.0,
        max=100.0,
        soft_max=2.0,
        update=tag_owner,
    )
    border: FloatProperty(
        name="Border",
        description=(
            "Width of the strip along the outline that has no sensors, in metres. Default 0.5: what EN 12464-1 leaves out "
            "along walls"
        ),
        default=0.5,
        min=0.0,
        max=10.0,
        soft_max=1.0,
        update=tag_owner,
    )
    requirement: StringProperty(
        name="Requirement",
        description=(
            "Key of what is required of the light here, such as emergency.open_area. Default empty: what is required of all "
            "sensors of the scene"
        ),
        search=_search_requirements,
        update=redraw_views,
    )
    lighting_scenes: StringProperty(
        name="In Scenes",
        description=(
            "Lighting scenes in which these sensors are judged, by their names with commas between them, such as Day, "
            "Evening. Default empty: in all of them"
        ),
        update=redraw_views,
    )
    area: EnumProperty(
        name="Area",
        description="Which area of a requirement the sensors are judged as. Default By Quantity: that of most",
        items=JUDGED_AREAS,
        default="AUTO",
        update=redraw_views,
    )
    use_spectrum: BoolProperty(
        name="Spectrum",
        description=(
            "Also find what the light does to the eye (melanopic and other equivalent daylight illuminances, CIE S 026), "
            "its colour temperature, Ra, Rf and Rg. Default off: it takes longer"
        ),
        default=False,
        update=tag_owner,
    )
    use_spacing: BoolProperty(
        name="Own Spacing",
        description=(
            "State the distance of sensors. Default off: that of EN 12464-1 follows from the size, 0.2 · 5^log10(d) for "
            "the length d in metres"
        ),
        default=False,
        update=tag_owner,
    )
    spacing: FloatProperty(
        name="Spacing",
        description="Distance of sensors from each other, in metres. Default 0.5: fit for rooms of usual size",
        default=0.5,
        min=0.001,
        max=1000.0,
        soft_min=0.05,
        soft_max=5.0,
        update=tag_owner,
    )
    show_isolux: BoolProperty(
        name="Isolux Lines",
        description="Draw lines of equal illuminance with their lx over a grid. Default on: they tell how light falls off",
        default=True,
        update=redraw_views,
    )
    show_values: BoolProperty(
        name="Values",
        description="Write every sensor's lx and its standard error beside it. Default on: numbers are what they are for",
        default=True,
        update=redraw_views,
    )
    kept: StringProperty(
        name="Readings", description="What the sensors told, as text", options={"HIDDEN"}
    )
    serial: StringProperty(
        name="Serial", description="Tells one measurement from the next", options={"HIDDEN"}
    )
    changed: StringProperty(
        name="Changed",
        description="What has changed in the scene since the sensors were measured; empty: nothing",
        options={"HIDDEN"},
    )


class LumenraySensorsSettings(PropertyGroup):
    """How the sensors of a scene are measured, and how they are shown."""

    error: FloatProperty(
        name="Relative Error",
        description=(
            "Relative standard error of the sensors together at which measuring ends, as a share. Default 0.01: far below "
            "what eyes tell apart"
        ),
        default=0.01,
        min=1e-4,
        max=1.0,
        subtype="FACTOR",
    )
    error_percent: percentage(
        "error",
        "Relative Error",
        "Relative standard error of the sensors together at which measuring ends. Default 1 %: far below what eyes tell "
        "apart",
    )
    time: FloatProperty(
        name="Seconds",
        description="Time in seconds after which measuring ends, whatever the error. Default 60: one waits that long",
        default=60.0,
        min=0.1,
        max=1e6,
        soft_max=3600.0,
    )
    refresh: BoolProperty(
        name="Refresh by Itself",
        description=(
            "Measure again in the background once the scene was changed and is left alone for a while. Default off: it "
            "takes the processor's time"
        ),
        default=False,
    )
    requirement: StringProperty(
        name="Requirement",
        description=(
            "What the readings are judged by, such as office.writing: a key of the requirements that ship, or of your "
            "own file. Default empty: nothing is judged"
        ),
        search=_search_requirements,
        update=redraw_views,
    )
    requirements_file: StringProperty(
        name="Own File",
        description=(
            "File of requirements of your own (.toml), which count before those that ship. Default empty: none but these"
        ),
        subtype="FILE_PATH",
        options=PATH_OPTIONS,
        update=redraw_views,
    )
    maintenance: FloatProperty(
        name="Maintenance",
        description=(
            "Maintenance factor on judged illuminances, for luminaires without one of their own. Default 1: they have one"
        ),
        default=1.0,
        min=0.01,
        max=1.0,
        update=redraw_views,
    )
    modified: BoolProperty(
        name="Modified Value",
        description=(
            "Ask for the modified mean illuminance where the requirement has one. Default off: the usual one"
        ),
        default=False,
        update=redraw_views,
    )
    automatic: BoolProperty(
        name="Automatic Scale",
        description="Fit the scale of the colours to the readings. Default on: nothing has to be known before",
        default=True,
        update=redraw_views,
    )
    logarithmic: BoolProperty(
        name="Logarithmic",
        description=(
            "Spread the colours over three powers of ten, so that equal ratios are equal steps. Default off: equal "
            "differences are"
        ),
        default=False,
        update=redraw_views,
    )
    high: FloatProperty(
        name="To",
        description="Upper end of the scale of the colours in lx. Default 1000: offices lie below",
        default=1000.0,
        min=1e-3,
        max=1e6,
        update=redraw_views,
    )


def is_sensor(thing) -> bool:
    """Whether an object stands for sensors."""
    return thing is not None and thing.type == "EMPTY" and thing.lumenray.sensor.is_sensor


def find_sensors(scene) -> list:
    """Return the empties of a scene that stand for sensors and take part in renders, by name."""
    found = [thing for thing in scene.objects if is_sensor(thing) and not thing.hide_render]
    return sorted(found, key=lambda thing: thing.name)


CLASSES = (LumenraySensorSettings, LumenraySensorsSettings)
"""For registration."""
