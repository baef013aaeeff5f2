"""A whole Blender scene at once, for an engine's scene that is still empty."""

from dataclasses import dataclass, field

from ...engine.scene.camera import Camera
from ...engine.scene.scene import SceneDelta
from ..foundation.report import ConversionReport
from .scene_sync import SceneSync


@dataclass(frozen=True)
class ConvertedScene:
    """A Blender scene for the engine.

    Parameters
    ----------
    delta : SceneDelta    Fills an empty engine scene.
    camera : Camera or None
    report : ConversionReport
    objects : dict of str to str
        Engine ids of the objects with a surface by their full names; instances are not among them.
    luminous : tuple of (str, str)    Ids and names of all that gives light, see `SceneSync.luminous`.
    """

    delta: SceneDelta
    camera: Camera | None
    report: ConversionReport
    objects: dict[str, str] = field(default_factory=dict)
    luminous: tuple[tuple[str, str], ...] = ()


def convert_scene(depsgraph, report: ConversionReport | None = None) -> ConvertedScene:
    """Convert everything that the dependency graph shows.

    Objects that are hidden in renders are left out, whichever kind of graph it is.
    """
    sync = SceneSync(final=True)
    step = sync.walk(depsgraph)
    report = ConversionReport() if report is None else report
    report.include(step.report)
    camera = sync.camera(depsgraph, report)
    return ConvertedScene(step.delta, camera, report, sync.objects, sync.luminous)
