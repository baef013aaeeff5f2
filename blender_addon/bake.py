"""The bake: from selected objects to lux maps in the file and on disk.

Three steps: `prepare` reads Blender's data (main thread), `BakeJob.run` lets the engine compute and write files (any thread,
no bpy), `store` puts UV maps and images into the file (main thread).
"""

from dataclasses import dataclass, field
from pathlib import Path

import bpy
import numpy as np

from ..engine.accuracy.stopping import StopRule
from ..engine.errors import Cancelled, SceneError
from ..engine.formats.names import file_stem
from ..engine.session import BakeOrder, Layout, LuxMap
from .report import ConversionReport
from .sync.meshes import MESH_TYPES
from .sync.scene import convert_scene
from .sync.step import PART_BYTES, split

UV_MAP = "Lumenray"
"""Name of the UV map that a lux map lies on."""


@dataclass(frozen=True)
class BakeSettings:
    """What a bake is asked for. ``densities``: lumels per metre by object name, where it is not ``density``."""

    density: float
    largest: int
    margin: int
    rule: StopRule
    seed: int
    transport: str
    folder: Path
    densities: dict[str, float] = field(default_factory=dict)


@dataclass
class BakeJob:
    """A bake that is ready to run; owns copies of all it needs. ``names`` of objects by their engine ids."""

    parts: list
    names: dict[str, str]
    settings: BakeSettings
    report: ConversionReport
    order: BakeOrder
    maps: list[LuxMap] = field(default_factory=list)
    files: list[Path] = field(default_factory=list)
    _session: object = None
    _cancelled: bool = False

    def cancel(self) -> None:
        """Ask the job to end."""
        self._cancelled = True
        if self._session is not None:
            self._session.cancel()

    def run(self, session, progress=None) -> list[LuxMap]:
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
        for part in self.parts:
            session.apply(part)
            if self._cancelled:
                raise Cancelled("cancelled")
        # The engine holds the scene now.
        self.parts = []
        result = session.bake_objects(self.order, progress)
        for departure in result.departures:
            note = self.report.error if departure.is_error else self.report.warn
            where = self.names.get(departure.name, departure.name)
            note(where, departure.message, departure.remedy)
        self.maps = list(result.maps)
        self.files = [Path(path) for path in result.files]
        return self.maps


def bakeable(objects) -> list:
    """Objects of these that have a surface."""
    return [source for source in objects if source.type in MESH_TYPES]


def prepare(depsgraph, objects, settings: BakeSettings) -> BakeJob:
    """Read everything that a bake needs out of Blender.

    Raises
    ------
    SceneError    None of the objects has a surface.
    """
    chosen = [source.name_full for source in bakeable(objects)]
    if not chosen:
        raise SceneError("nothing to bake: select at least one mesh object")
    converted = convert_scene(depsgraph)
    found = {}
    for name in chosen:
        key = converted.objects.get(name)
        if key is None:
            converted.report.error(
                name, "the object has no surface that is rendered", "it is not baked"
            )
        else:
            found[key] = name
    file = Path(bpy.data.filepath).name if bpy.data.filepath else "(not saved)"
    order = BakeOrder(
        objects=tuple(found),
        rule=settings.rule,
        density=settings.density,
        densities={
            key: settings.densities[name]
            for key, name in found.items()
            if name in settings.densities
        },
        largest=settings.largest,
        margin=settings.margin,
        seed=settings.seed,
        transport=settings.transport,
        folder=str(settings.folder),
        file=file,
        conversion=tuple(converted.report.to_dicts()),
    )
    parts = list(split(converted.delta, PART_BYTES))
    return BakeJob(parts, found, settings, converted.report, order)


def store(job: BakeJob) -> list[str]:
    """Put the maps into the file: a UV map on every object, an image for every map. Returns the images' names."""
    names = []
    for made in job.maps:
        source = bpy.data.objects.get(job.names[made.id])
        if source is None:
            continue
        if not _store_uv(source, made.layout):
            job.report.warn(
                source.name,
                "modifiers or its kind change the object's faces, so that its own UV maps cannot hold the layout",
                "the lux map is only written to disk; apply the modifiers to see it on the object",
            )
        names.append(_store_image(source, made, job.settings.folder).name)
    return names


def _store_uv(source, layout: Layout) -> bool:
    """Write the layout into a UV map of the object's own mesh; false where its faces are others."""
    if source.type != "MESH" or layout.polygon is None:
        return False
    data = source.data
    corners = layout.polygon[:, None].astype(np.int64) * layout.vertex_count + layout.triangles
    keys, first = np.unique(corners.ravel(), return_index=True)
    if layout.vertex_count != len(data.vertices) or len(keys) != len(data.loops):
        return False
    vertex = np.empty(len(data.loops), dtype=np.int32)
    data.loops.foreach_get("vertex_index", vertex)
    total = np.empty(len(data.polygons), dtype=np.int32)
    data.polygons.foreach_get("loop_total", total)
    polygon = np.repeat(np.arange(len(data.polygons), dtype=np.int64), total)
    wanted = polygon * layout.vertex_count + vertex
    found = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    if not np.array_equal(keys[found], wanted):
        return False
    # Objects that share one mesh are baked one by one, so each needs a layout of its own.
    name = UV_MAP if data.users == 1 else f"{UV_MAP} {source.name}"[:60]
    layer = data.uv_layers.get(name) or data.uv_layers.new(name=name, do_init=False)
    if layer is None:
        return False
    uv = layout.uv.reshape(-1, 2)[first[found]].astype(np.float32)
    layer.uv.foreach_set("vector", np.ascontiguousarray(uv).ravel())
    data.update()
    return True


def _store_image(source, made: LuxMap, folder: Path):
    name = f"Lux {source.name}"[:63]
    height, width = made.illuminance.shape
    image = bpy.data.images.get(name)
    if image is not None and tuple(image.size) != (width, height):
        bpy.data.images.remove(image)
        image = None
    if image is None:
        image = bpy.data.images.new(
            name, width, height, alpha=False, float_buffer=True, is_data=True
        )
    pixels = np.ones((height, width, 4), dtype=np.float32)
    pixels[..., :3] = made.illuminance[..., None]
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    image.pack()
    image["lumenray"] = {
        "quantity": "illuminance",
        "unit": "lx",
        "mean": made.mean,
        "relative_standard_error": made.relative_standard_error,
        "scene_hash": made.provenance.scene_hash,
        "seed": made.provenance.seed,
        "samples": made.samples,
        "file": str(folder / f"{file_stem(made.name)}_illuminance.exr"),
    }
    return image
