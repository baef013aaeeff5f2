"""From the sensors that stand in a scene to the job that measures them."""

from ...engine.accuracy.stopping import StopRule
from ...engine.errors import SceneError
from ...engine.scene.scene import Scene
from .. import assumptions
from ..foundation.report import ConversionReport
from ..light_groups import find_groups
from ..rendering.light_mix import levels_of
from ..rendering.lighting_scenes import choose_all
from ..sync.scene import convert_scene
from .job import SensorJob
from .places import place_sensors, signature_of
from .requirements import requirements_of
from .scene_verdicts import required_of
from .settings import find_sensors

FLOOR = 0.1
"""Readings below it count as large as it where every sensor is to reach an error. [lx]"""


def rule_of(settings) -> StopRule:
    """Return the rule of a scene's sensors; ``settings``: a `LumenraySensorsSettings`."""
    return StopRule(error=settings.error, seconds=settings.time, floor=FLOOR)


def prepare(
    depsgraph,
    empties=None,
    rule: StopRule | None = None,
    accept_missing: bool = False,
    files=(),
) -> tuple[SensorJob, ConversionReport]:
    """Return the job of a scene's sensors, and what could not be taken over.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph    Evaluated.
    empties : list or None    None: all that stand in the scene.
    rule : StopRule or None    None: as the scene says.
    accept_missing : bool    Whether to go on where files are missing.
    files : iterable of Path    Of requirements, besides those that the scene knows.

    Raises
    ------
    LumenrayError    There are no sensors, one of them stands nowhere, or the scene does not fit.
    """
    scene = depsgraph.scene.original if depsgraph.scene.is_evaluated else depsgraph.scene
    empties = find_sensors(scene) if empties is None else list(empties)
    if not empties:
        raise SceneError("no sensors stand in the scene; add some with Add > Sensors")
    places = [place_sensors(empty, depsgraph) for empty in empties]
    converted = convert_scene(depsgraph)
    assumptions.refuse_missing(converted.report, accept_missing)
    assumptions.refuse_media(converted.report)
    own = Scene()
    own.apply(converted.delta)
    settings = scene.lumenray
    mode = settings.light_mix.groups.lower()
    job = SensorJob(
        own,
        places,
        [str(signature_of(empty)) for empty in empties],
        rule_of(settings.sensors) if rule is None else rule,
        seed=settings.seed,
        transport=settings.transport.lower(),
        method=settings.bake.method.lower(),
        groups=find_groups(converted.luminous, scene.world, mode),
        mixes=(*(chosen.levels for chosen in choose_all(scene)), levels_of(scene)),
        wants_direct=asks_for_direct(scene, empties, files),
    )
    return job, converted.report


def asks_for_direct(scene, empties, files=()) -> bool:
    """Whether anything that is required of sensors is of light that was not reflected; ``files``: as of `prepare`."""
    known = requirements_of(scene, files)
    keys = {required_of(empty, scene) for empty in empties}
    return any(key in known and known[key].is_direct for key in keys)
