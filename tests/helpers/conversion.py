"""What Blender's data become for the engine."""

import bpy

from lumenray.blender_addon.foundation.report import ConversionReport, Severity
from lumenray.blender_addon.sync.lights.lights import convert_light
from lumenray.blender_addon.sync.materials.materials import convert_material
from lumenray.blender_addon.sync.scene import convert_scene
from lumenray.engine.accuracy.stopping import StopRule
from lumenray.engine.scene.scene import Scene
from lumenray.engine.session import Session


def converted_scene():
    """Return the conversion of the scene as it stands."""
    bpy.context.view_layer.update()
    return convert_scene(bpy.context.evaluated_depsgraph_get())


def scene_hash():
    """Return the hash of the scene that the engine gets."""
    scene = Scene()
    scene.apply(convert_scene(bpy.context.evaluated_depsgraph_get()).delta)
    return scene.hash()


def converted_light(source, scale=1.0, efficacy=177.83):
    """Return the engine's light and the rows of the report."""
    bpy.context.view_layer.update()
    evaluated = source.evaluated_get(bpy.context.evaluated_depsgraph_get())
    report = ConversionReport()
    light = convert_light(
        evaluated, "id", source.name, evaluated.matrix_world, scale, efficacy, report
    )
    return light, [row for row, _ in report.rows]


def measure_light(position, normal=(0, 0, 1), samples=1 << 14):
    """Measure what comes to a sensor in the scene: illuminance and standard error. [lx]"""
    session = Session(witness=False)
    session.apply(converted_scene().delta)
    made = session.measure([position], [normal], StopRule(samples=samples))
    return made.illuminance[0], made.standard_error[0]


def converted_material(material):
    """Return the engine's surface and the rows of the report."""
    report = ConversionReport()
    made = convert_material(material, "key", report, 177.83)
    return made.surface, [row for row, _ in report.rows]


def error_messages(rows):
    """Return what the rows of errors say."""
    return [row.message for row in rows if row.severity is Severity.ERROR]


def messages_of(rows):
    """Return what rows say, as one text."""
    return " | ".join(row["message"] for row in rows)


def rgb_of(spectrum):
    """Return the channels of a spectrum that is a colour."""
    return (spectrum.red, spectrum.green, spectrum.blue)
