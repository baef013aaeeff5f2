"""Verdicts of commands on the sensors that stand in a file."""


def find(options, scene):
    """Return the requirement that was asked for, else the scene's, before anything is computed; None without one.

    Parameters
    ----------
    scene : bpy.types.Scene

    Raises
    ------
    LumenrayError    There is no such requirement, or it asks nothing of the area.
    """
    from ..blender_addon.sensors.requirements import files_of
    from ..engine.judgement.assessment import count_limits
    from ..engine.judgement.reader import find_requirement

    key, area = options.require or (scene.lumenray.sensors.requirement, "")
    if not key:
        return None
    requirement = find_requirement(key, (*files_of(scene), *options.requirements))
    if area:
        count_limits(requirement, area, options.modified)
    return requirement


def judge(options, scene, job, levels, requirement):
    """Judge the readings of a job by a requirement; an area that was asked for is that of all illuminances."""
    from ..blender_addon.sensors.judging import area_of, judge_sensors

    own = scene.lumenray.sensors
    asked = options.require[1] if options.require is not None else ""
    named = []
    for placed in job.places:
        stated = asked.upper() or scene.objects[placed.name].lumenray.sensor.area
        readings = job.answer[placed.uid]
        named.append((placed.name, readings, area_of(readings, stated)))
    is_own = options.require is None
    maintenance = own.maintenance if is_own and options.maintenance == 1.0 else options.maintenance
    is_modified = options.modified or (is_own and own.modified)
    return judge_sensors(named, requirement, levels, maintenance, is_modified)
