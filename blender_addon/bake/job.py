"""The bake: from selected objects to lux maps in the file and on disk.

Three steps: `prepare` reads Blender's data (main thread), `BakeJob.run` lets the engine compute and write files (any thread,
no bpy), `store` puts UV maps and images into the file (main thread).
"""

from dataclasses import dataclass, field, fields, replace
from pathlib import Path

import bpy
import numpy as np

from ...engine.accuracy.stopping import StopRule
from ...engine.analysis.false_colour import nice_maximum
from ...engine.baking.files import find_shortfall
from ...engine.baking.order import BakeOrder, BakeResult, LuxMap
from ...engine.errors import Cancelled, LumenrayError, SceneError
from ...engine.scene.scene import Scene
from ..assumptions import refuse_media
from ..foundation.exposure import white_luminance
from ..foundation.report import ConversionReport
from ..light_groups import find_groups
from ..sync.meshes import MESH_TYPES
from ..sync.scene import convert_scene
from ..sync.step import PART_BYTES, split
from . import folders as bake_folders
from . import images as baked_images
from . import look as baked_look
from . import results as baked_results
from . import uv_maps as baked_layout
from .folders import checkpoint_path

GLTF = "baked.glb"
"""Name of the glTF file, where no other is asked for."""


GLTF_ENDINGS = (".glb", ".gltf")
"""Endings of glTF files: all in one, and with its pictures beside it."""


@dataclass(frozen=True)
class BakeSettings:
    """What a bake is asked for: an order that names no objects yet, and what is done around it.

    Parameters
    ----------
    order : BakeOrder    Without objects, groups and names of files.
    folder : Path    Where maps are written.
    densities : dict of str to float    Lumels per metre by object name, where it is not the order's.
    two_sided : tuple of str    Names of the objects whose back sides are wanted.
    layers : str    ``none``, ``groups`` or ``each``.
    overwrite : bool    Whether results of other bakes in the folder may be replaced; else a folder beside it is taken.
    use_checkpoint : bool    Whether the state is kept in the folder.
    resume : bool    Whether an interrupted bake there goes on; else it is forgotten.
    gltf : Path or None    Where the objects are written with their light.
    gltf_textures, gltf_size : int    Most textures of that file, and the largest side of one. [-, texel]
    white : float or None    Luminance that becomes white there; None: found from the maps. [cd/m2]
    """

    order: BakeOrder
    folder: Path
    densities: dict[str, float] = field(default_factory=dict)
    two_sided: tuple[str, ...] = ()
    layers: str = "none"
    overwrite: bool = False
    use_checkpoint: bool = False
    resume: bool = False
    gltf: Path | None = None
    gltf_textures: int = 16
    gltf_size: int = 2048
    white: float | None = None

    def ask(self, **changes) -> "BakeSettings":
        """Return the same with changes of the order."""
        return replace(self, order=replace(self.order, **changes))


@dataclass
class BakeJob:
    """A bake that is ready to run; owns copies of all it needs.

    ``names`` of objects by their engine ids; ``watch`` knows what has changed in Blender since.
    """

    parts: list
    names: dict[str, str]
    settings: BakeSettings
    report: ConversionReport
    order: BakeOrder
    result: BakeResult | None = None
    files: list[Path] = field(default_factory=list)
    watch: baked_results.Watch | None = None
    _session: object = None
    _cancelled: bool = False
    _stopped: bool = False

    @property
    def maps(self) -> tuple[LuxMap, ...]:
        """Lux maps of the finished bake."""
        return () if self.result is None else self.result.maps

    @property
    def notes(self) -> tuple[str, ...]:
        """What the engine notes of the finished bake, for people."""
        return self.maps[0].provenance.notes if self.maps else ()

    @property
    def shortfall(self) -> str:
        """Say what of its rule the finished bake has not met; empty if it has."""
        return "" if self.result is None else find_shortfall(self.order.rule, self.result)

    def cancel(self) -> None:
        """Ask the job to end."""
        self._cancelled = True
        if self._session is not None:
            self._session.cancel()

    def stop(self) -> None:
        """Ask the job to end as soon as what it has can be kept."""
        self._stopped = True
        if self._session is not None:
            self._session.stop()

    def run(self, session, progress=None) -> BakeResult:
        """Send the scene, unwrap, compute, write the files.

        Parameters
        ----------
        session : Session or RemoteSession    An empty one.
        progress : callable or None    Gets a `Progress`.

        Raises
        ------
        LumenrayError    One sentence on any fault.
        """
        self._session = session
        self._prepare_checkpoint()
        scene = None if self.settings.gltf is None else Scene()
        for part in self.parts:
            session.apply(part)
            if scene is not None:
                scene.apply(part)
            if self._cancelled or self._stopped:
                # There is nothing yet that could be kept.
                raise Cancelled("cancelled")
        # The engine holds the scene now.
        self.parts = []

        def report(state):
            if self._stopped:
                # The word may have come before the bake could hear it.
                session.stop()
            if progress is not None:
                progress(state)

        result = session.bake_objects(self.order, report)
        for departure in result.departures:
            note = self.report.error if departure.is_error else self.report.warn
            where = self.names.get(departure.name, departure.name)
            note(where, departure.message, departure.remedy)
        self.files = [Path(path) for path in result.files]
        if scene is not None:
            self.files += self._write_gltf(scene, result)
        self.result = result
        return result

    def _prepare_checkpoint(self) -> None:
        path = checkpoint_path(self.settings.folder)
        if not self.settings.resume:
            path.unlink(missing_ok=True)
        elif not path.is_file():
            raise SceneError(f"{self.settings.folder} holds no interrupted bake that could go on")
        bake_folders.claim(self.settings.folder, self.order)

    def _write_gltf(self, scene: Scene, result: BakeResult) -> list[Path]:
        from ...engine.formats.gltf import GltfLimits, write_gltf

        limits = GltfLimits(self.settings.gltf_textures, self.settings.gltf_size)
        meshes = [scene.mesh(key) for key, item in scene.meshes.items() if item.visible_to_camera]
        white = self.settings.white or baked_look.automatic_white(result.mean)
        try:
            return write_gltf(
                self.settings.gltf, meshes, scene.materials, result, white=white, limits=limits
            )
        except LumenrayError as error:
            # The maps are worth hours; they do not go with a file that comes on top.
            self.report.error(self.settings.gltf.name, str(error), "the glTF file is not written")
            return []


def gltf_path(wanted) -> Path:
    """Return the path of a glTF file that is wanted.

    Raises
    ------
    SceneError    It has another ending.
    """
    path = Path(wanted)
    if path.suffix.lower() not in GLTF_ENDINGS:
        raise SceneError(f"{path}: glTF files end in {' or '.join(GLTF_ENDINGS)}")
    return path


def bakeable(objects) -> list:
    """Objects of these that have a surface."""
    return [source for source in objects if source.type in MESH_TYPES]


def rule_of(settings) -> StopRule:
    """Return the stopping rule of bakes by their settings, a `LumenrayBakeSettings`.

    Raises
    ------
    SceneError    None is on.
    """
    return StopRule(
        samples=settings.samples if settings.use_samples else None,
        error=settings.error if settings.use_error else None,
        seconds=settings.time if settings.use_time else None,
        absolute=settings.absolute if settings.use_absolute else None,
    )


def read_settings(settings, objects, rule: StopRule, folder: Path) -> BakeSettings:
    """Return what a scene (its `LumenraySceneSettings`) and the objects' own settings ask for."""
    own = settings.bake
    order = BakeOrder(
        objects=(),
        rule=rule,
        seed=settings.seed,
        transport=settings.transport.lower(),
        **_shared(own, BakeOrder),
    )
    return BakeSettings(
        order=order,
        folder=folder,
        **_shared(own, BakeSettings),
        densities={s.name_full: s.lumenray.density for s in objects if s.lumenray.density > 0.0},
        two_sided=tuple(s.name_full for s in objects if s.lumenray.two_sided),
        gltf=folder / GLTF if own.use_gltf else None,
        white=white_luminance(settings),
    )


def _shared(settings, record) -> dict:
    """Values of the settings that fields of a dataclass have their names from; the folder is the caller's."""
    known = settings.bl_rna.properties
    names = [each.name for each in fields(record) if each.name in known and each.name != "folder"]
    values = {name: getattr(settings, name) for name in names}
    return {
        name: value.lower() if known[name].type == "ENUM" else value
        for name, value in values.items()
    }


def prepare(depsgraph, objects, settings: BakeSettings) -> BakeJob:
    """Read everything that a bake needs out of Blender.

    Raises
    ------
    SceneError    None of the objects has a surface, there are too many light groups, or a volume scatters light.
    """
    chosen = [source.name_full for source in bakeable(objects)]
    if not chosen:
        raise SceneError("nothing to bake: select at least one mesh object")
    converted = convert_scene(depsgraph)
    refuse_media(converted.report)
    names = {}
    for name in chosen:
        key = converted.objects.get(name)
        if key is None:
            converted.report.error(
                name, "the object has no surface that is rendered", "it is not baked"
            )
        else:
            names[key] = name
    own = settings.densities
    order = replace(
        settings.order,
        objects=tuple(names),
        densities={key: own[name] for key, name in names.items() if name in own},
        two_sided=tuple(key for key, name in names.items() if name in settings.two_sided),
        groups=find_groups(converted.luminous, depsgraph.scene.world, settings.layers),
        file=Path(bpy.data.filepath).name if bpy.data.filepath else "(not saved)",
        scene=depsgraph.scene.name,
        conversion=tuple(converted.report.to_dicts()),
    )
    settings = _settle(settings, order)
    keeps_state = settings.use_checkpoint or settings.resume
    order = replace(
        order,
        folder=str(settings.folder),
        checkpoint=str(checkpoint_path(settings.folder)) if keeps_state else None,
    )
    parts = list(split(converted.delta, PART_BYTES))
    return BakeJob(parts, names, settings, converted.report, order)


def _settle(settings: BakeSettings, order: BakeOrder) -> BakeSettings:
    """Choose the folder: that of the interrupted bake, or one in which nothing else is lost."""
    wanted = settings.folder
    if settings.resume:
        folder = bake_folders.find_interrupted(wanted, settings.overwrite) or wanted
    elif settings.overwrite:
        folder = wanted
    else:
        folder = bake_folders.find_free(wanted, order)
    gltf = settings.gltf
    if gltf is not None and gltf.parent == wanted:
        gltf = folder / gltf.name
    return replace(settings, folder=folder, gltf=gltf)


def store(job: BakeJob, scene) -> list[str]:
    """Put a finished bake into the file: UV maps on its objects, and the atlas as images. Returns the images' names.

    Baked light that is shown stays shown, with the new atlas.
    """
    with baked_results.unchanged(scene):
        images = _store(job, scene)
    changed = () if job.watch is None else job.watch.end()
    baked_results.store_results(scene, job.result, job.settings.folder, changed, job.shortfall)
    return [image.name for image in images]


def _store(job: BakeJob, scene) -> list:
    was_shown = scene.lumenray.look.is_shown
    baked_look.hide()
    result = job.result
    sources = {key: bpy.data.objects.get(name) for key, name in job.names.items()}
    placed = baked_layout.store_layouts(result, sources, job.report)
    for source in placed:
        source.lumenray.baked_image = None
    images = baked_images.store_images(result, placed, job.report)
    for source in placed:
        source.lumenray.baked_image = images[0]
    look = scene.lumenray.look
    baked_look.choose_light(look)
    baked_look.list_layers(look, images)
    look.low = 0.0
    look.high = _scale_top(result)
    if was_shown:
        baked_look.show(scene)
    return images


def _scale_top(result: BakeResult) -> float:
    """Round illuminance that nearly all lumels lie under. [lx]"""
    return nice_maximum(np.concatenate([page.illuminance[page.covered] for page in result.pages]))
