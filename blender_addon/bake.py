"""The bake: from selected objects to lux maps in the file and on disk.

Three steps: `prepare` reads Blender's data (main thread), `BakeJob.run` computes and writes files (any thread, no bpy),
`store` puts UV maps and images into the file (main thread).
"""

import re
from dataclasses import dataclass, field
from pathlib import Path

import bpy
import numpy as np

from ..engine.accuracy.stopping import StopRule
from ..engine.analysis.false_colour import nice_maximum, write_false_colour
from ..engine.atlas.sheet import compose_sheet
from ..engine.atlas.unwrap import AtlasChart, unwrap
from ..engine.errors import Cancelled, SceneError
from ..engine.formats import exr
from ..engine.formats.report import compose, quantity_of_map, write_json
from ..engine.scene.scene import SceneDelta
from ..engine.session import BakeTarget, LuxMap, Session
from .report import ConversionReport
from .sync.meshes import MESH_TYPES
from .sync.scene import convert_scene

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
    """A bake that is ready to run; owns copies of all it needs."""

    delta: SceneDelta
    names: list[str]
    settings: BakeSettings
    report: ConversionReport
    file: str
    session: Session = field(default_factory=Session)
    charts: dict[str, AtlasChart] = field(default_factory=dict)
    maps: list[LuxMap] = field(default_factory=list)
    files: list[Path] = field(default_factory=list)
    _cancelled: bool = False

    def cancel(self) -> None:
        """Ask the job to end."""
        self._cancelled = True
        self.session.cancel()

    def run(self, progress=None) -> list[LuxMap]:
        """Unwrap, compute, write the files. Raises `LumenrayError` with one sentence on any fault."""
        meshes = {item.name: item for item in self.delta.changed if item.id.startswith("mesh:")}
        settings = self.settings
        targets = []
        for name in self.names:
            if self._cancelled:
                raise Cancelled("cancelled")
            mesh = meshes.get(name)
            if mesh is None:
                self.report.error(
                    name, "the object has no surface that is rendered", "it is not baked"
                )
                continue
            density = settings.densities.get(name, settings.density)
            charts = unwrap(mesh, density, settings.largest, settings.margin)
            if charts.density < 0.999 * density:
                self.report.warn(
                    name,
                    f"{density:g} lumels per metre do not fit a map of {settings.largest} pixels",
                    f"baked with {charts.density:.3g} lumels per metre",
                )
            self.charts[name] = charts
            targets.append(BakeTarget(mesh, charts))
        if not targets:
            raise SceneError("nothing to bake: none of the objects has a surface that is rendered")
        self.session.apply(self.delta)
        if self._cancelled:
            raise Cancelled("cancelled")
        self.maps = self.session.bake(
            targets, settings.rule, settings.seed, settings.margin, settings.transport, progress
        )
        self._write()
        return self.maps

    def _write(self) -> None:
        folder = self.settings.folder
        high = nice_maximum(np.concatenate([m.illuminance[m.covered] for m in self.maps]))
        for made in self.maps:
            stem = folder / file_stem(made.name)
            attributes = {
                "unit": "lx",
                "quantity": "illuminance",
                "object": made.name,
                "sceneHash": made.provenance.scene_hash,
                "seed": str(made.provenance.seed),
                "samples": str(made.samples),
            }
            self.files.append(
                exr.write_channels(
                    stem.with_name(stem.name + "_illuminance.exr"),
                    {"Y": made.illuminance, "standard_error.Y": made.standard_error},
                    attributes,
                )
            )
            self.files.append(
                write_false_colour(
                    stem.with_name(stem.name + "_illuminance.png"),
                    made.illuminance,
                    made.covered,
                    made.name,
                    high=high,
                )
            )
        self._write_sheet(high)
        seconds = sum(made.provenance.seconds for made in self.maps)
        content = compose(
            self.file,
            self.maps[0].provenance,
            seconds,
            [quantity_of_map(made) for made in self.maps],
            self.report.to_dicts(),
        )
        self.files.append(write_json(folder / "report.json", content))

    def _write_sheet(self, high: float) -> None:
        """Write all maps on one sheet, for looking at and for tools that want one file."""
        sheet = compose_sheet(self.maps)
        folder = self.settings.folder
        channels = {"Y": sheet.illuminance, "standard_error.Y": sheet.standard_error}
        attributes = {
            "unit": "lx",
            "quantity": "illuminance",
            "sceneHash": self.maps[0].provenance.scene_hash,
        }
        self.files.append(
            exr.write_channels(folder / "illuminance_atlas.exr", channels, attributes)
        )
        captions = [(name, x, y + height) for name, x, y, _, height in sheet.places]
        self.files.append(
            write_false_colour(
                folder / "illuminance_atlas.png",
                sheet.illuminance,
                sheet.covered,
                "Illuminance",
                high=high,
                captions=captions,
            )
        )


def file_stem(name: str) -> str:
    """Turn an object's name into a file name that every system takes."""
    return re.sub(r"[^\w\-. ]", "_", name).strip(" .").replace(" ", "_") or "object"


def bakeable(objects) -> list:
    """Objects of these that have a surface."""
    return [source for source in objects if source.type in MESH_TYPES]


def prepare(depsgraph, objects, settings: BakeSettings) -> BakeJob:
    """Read everything that a bake needs out of Blender.

    Raises
    ------
    SceneError    None of the objects has a surface.
    """
    names = [source.name_full for source in bakeable(objects)]
    if not names:
        raise SceneError("nothing to bake: select at least one mesh object")
    converted = convert_scene(depsgraph)
    file = Path(bpy.data.filepath).name if bpy.data.filepath else "(not saved)"
    return BakeJob(converted.delta, names, settings, converted.report, file)


def store(job: BakeJob) -> list[str]:
    """Put the maps into the file: a UV map on every object, an image for every map. Returns the images' names."""
    meshes = {item.name: item for item in job.delta.changed if item.id.startswith("mesh:")}
    names = []
    for made in job.maps:
        source = bpy.data.objects.get(made.name)
        if source is None:
            continue
        if not _store_uv(source, meshes[made.name], job.charts[made.name]):
            job.report.warn(
                made.name,
                "modifiers or its kind change the object's faces, so that its own UV maps cannot hold the layout",
                "the lux map is only written to disk; apply the modifiers to see it on the object",
            )
        names.append(_store_image(source, made, job.settings.folder).name)
    return names


def _store_uv(source, mesh, charts) -> bool:
    """Write the layout into a UV map of the object's own mesh; false where its faces are others."""
    if source.type != "MESH" or mesh.polygon is None:
        return False
    data = source.data
    corners = mesh.polygon[:, None].astype(np.int64) * len(mesh.vertices) + mesh.triangles
    keys, first = np.unique(corners.ravel(), return_index=True)
    if len(mesh.vertices) != len(data.vertices) or len(keys) != len(data.loops):
        return False
    vertex = np.empty(len(data.loops), dtype=np.int32)
    data.loops.foreach_get("vertex_index", vertex)
    total = np.empty(len(data.polygons), dtype=np.int32)
    data.polygons.foreach_get("loop_total", total)
    polygon = np.repeat(np.arange(len(data.polygons), dtype=np.int64), total)
    wanted = polygon * len(mesh.vertices) + vertex
    found = np.minimum(np.searchsorted(keys, wanted), len(keys) - 1)
    if not np.array_equal(keys[found], wanted):
        return False
    # Objects that share one mesh are baked one by one, so each needs a layout of its own.
    name = UV_MAP if data.users == 1 else f"{UV_MAP} {source.name}"[:60]
    layer = data.uv_layers.get(name) or data.uv_layers.new(name=name, do_init=False)
    if layer is None:
        return False
    uv = charts.uv.reshape(-1, 2)[first[found]].astype(np.float32)
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
