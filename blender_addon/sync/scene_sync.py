"""Keeps the engine's scene equal to Blender's: tags are noted as they come, one walk turns them into a delta."""

import time
from collections.abc import Callable

from ...engine.scene.camera import Camera
from ...engine.scene.light import Light
from ...engine.scene.light_groups import WORLD
from ...engine.scene.mesh import Placement
from ...engine.scene.scene import SceneDelta
from ..foundation import identity
from ..foundation.report import ConversionReport
from ..foundation.units import metres_per_unit
from . import live
from .camera import convert_camera
from .lights.portals import GEOMETRY
from .sent import Sent
from .step import SyncStats, SyncStep
from .tags import Tags
from .walk import Walk


class SceneSync:
    """Turns a Blender scene into deltas for one scene of the engine; the first one holds everything.

    Parameters
    ----------
    final : bool    Leave out what is hidden in renders; else the dependency graph alone decides.
    texels : int or None    Of all pictures that are made for single objects; None: as many as usual.

    Attributes
    ----------
    is_blurred : bool    Whether all moments of the shutter will be walked, so that motion blur is no departure.
    """

    def __init__(self, final: bool = False, texels: int | None = None):
        self.final, self.is_blurred = final, False
        self._texels = texels
        self._is_new = True
        self.start_over()
        live.keep(self)

    def start_over(self) -> None:
        """Forget what was sent, because another file was opened or the engine was started anew.

        The next delta holds everything, and takes away what is no longer there.
        """
        self._left: set[str] = set() if self._is_new else self._sent.ids() | self._left
        self._tags = Tags(scene=True)
        self._sent = Sent(self.final, self._texels)
        self._copies = 0
        self._report = ConversionReport()
        self._is_new = True

    def tag(self, updates) -> None:
        """Note what a dependency graph reports as changed; nothing else happens until the next walk."""
        self._tags.add(updates)

    def tag_scene(self) -> None:
        """Note that what is shown may differ in a way that Blender does not report, such as after an undo."""
        self._tags.scene = True
        self._sent.images.clear()

    @property
    def objects(self) -> dict[str, str]:
        """Engine ids of the objects that are shown by themselves, by their full names."""
        return {
            shown.name: shown.key
            for shown in self._sent.shown.values()
            if shown.is_own
            and shown.is_mapped
            and isinstance(shown.item, Placement)
            and shown.item.geometry != GEOMETRY
        }

    @property
    def luminous(self) -> tuple[tuple[str, str], ...]:
        """Ids that light groups have for all that gives light, and names for people."""
        sent = self._sent
        lights = [(s.key, s.name) for s in sent.shown.values() if isinstance(s.item, Light)]
        surroundings = [(WORLD, "World")] if sent.world.digest else []
        surroundings += [(sun.id, sun.name) for sun in sent.world.suns]
        return (*lights, *sent.materials.luminous(), *surroundings)

    def camera(self, depsgraph, report: ConversionReport) -> Camera | None:
        """Convert the scene's camera; None if it has none."""
        scene = depsgraph.scene
        if scene.camera is None:
            return None
        source, scale = scene.camera.evaluated_get(depsgraph), metres_per_unit(scene)
        return convert_camera(source, scene, scale, report)

    def walk(self, depsgraph, visible: Callable | None = None, is_moment: bool = False) -> SyncStep:
        """Find what changed since the last walk.

        Parameters
        ----------
        depsgraph : bpy.types.Depsgraph    Evaluated.
        visible : callable or None    Asked whether an instance (`bpy.types.DepsgraphObjectInstance`) is shown.
        is_moment : bool    Whether it is a moment of the shutter, at which what is not to be blurred stays as it was.
        """
        start = time.perf_counter()
        copies = identity.copies_since(self._copies)
        self._copies += len(copies)
        if not self._tags and not copies:
            return SyncStep(SceneDelta(), self._report, SyncStats(time.perf_counter() - start))
        # Renders walk on a thread of their own: what is tagged from here on is for the next walk.
        tags, self._tags = self._tags, Tags()
        sent = self._sent
        walk = Walk(sent, self.final, depsgraph, visible, tags, is_moment)
        try:
            walk.run()
        except BaseException:
            self.start_over()
            raise
        is_new, self._is_new = self._is_new, False
        geometries_made = len(sent.geometries.changed)
        reshaped = sent.geometries.reshaped
        geometries, geometries_gone = sent.geometries.flush()
        remade = sent.materials.remade
        materials, materials_gone = sent.materials.flush()
        pictures, pictures_gone = sent.pictures.flush()
        sent.images.sweep(walk.images())
        changed = (*pictures, *geometries, *materials, *walk.changed, *walk.worlds, *walk.wishes)
        gone = {*walk.removed, *geometries_gone, *materials_gone, *pictures_gone, *self._left}
        gone -= {item.id for item in changed}
        self._left = set()
        delta = SceneDelta(changed, tuple(sorted(gone)), tuple(copies))
        self._report = walk.report(self.is_blurred)
        lights = [item for item in walk.changed if not isinstance(item, Placement)]
        counts = {
            "picture": len(pictures),
            "geometry": geometries_made,
            "object": len(walk.changed) - len(lights),
            "material": len(materials),
            "light": len(lights),
            "world": len(walk.worlds),
            "modelling": len(walk.wishes),
        }
        told = (
            ("everything" if delta else "")
            if is_new
            else _describe(walk, reshaped, lights, materials)
        )
        seconds = time.perf_counter() - start
        stats = SyncStats(seconds, walk.visited, counts, len(gone), told, remade)
        return SyncStep(delta, self._report, stats)


def _describe(walk: Walk, reshaped, lights, materials) -> str:
    """Say in a few words what a walk found."""
    words, counts = [], walk.counts
    for what, verb in (("added", "added"), ("removed", "removed"), ("moved", "moved")):
        if counts[what]:
            words.append(f"{_number(counts[what], 'object')} {verb}")
    if reshaped:
        words.append(f"{_number(reshaped, 'mesh', 'meshes')} reshaped")
    if counts["changed"]:
        words.append(f"{_number(counts['changed'], 'object')} changed")
    for items, kind in ((lights, "light"), (materials, "material")):
        if len(items) == 1:
            words.append(f"{kind} '{items[0].name}'")
        elif items:
            words.append(_number(len(items), kind))
    words += ["world"] if walk.world_changed else []
    words += ["what is simplified"] if walk.wishes_changed else []
    return ", ".join(words)


def _number(count: int, one: str, many: str = "") -> str:
    return f"{count} {one if count == 1 else many or one + 's'}"
