"""Makes Blender assets of a folder of luminaires: one file with all of them, and the catalogues they are sorted into.

A luminaire becomes a light with its photometric file embedded; a lamp of several emitters becomes a collection of lights.
"""

import uuid
from dataclasses import dataclass, field, replace
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

from ...blender_addon.file_assets.places import digest_of
from ...blender_addon.luminaires.files import photometric_files
from ...engine.errors import FileFormatError, LumenrayError
from ...engine.luminaires.coordinates import directions
from ...engine.luminaires.distribution import flux, intensity, peak
from ...engine.luminaires.formats.lm63.writer import write_lm63
from ...engine.luminaires.formats.radiant import require_luminous
from ...engine.luminaires.formats.reader import parse_luminaire
from ...engine.luminaires.formats.record import LuminaireFile
from ...engine.photometry.units import BLENDER_EFFICACY
from ...engine.reading.content import read_bytes
from ...engine.reading.whole_file import write_whole
from ...libraries.luminaires import Library, Model, Problem
from .stage import part_frame, part_opening

ASSETS = "luminaires.blend"
"""File of the assets, in the library's folder."""

CATALOGUES = "blender_assets.cats.txt"
"""File of the catalogues, where Blender looks for it."""

ROOT = "Luminaires"
"""Catalogue above all others, so that ours stay together beside those of other libraries."""

PREVIEW = 256
"""Side of the preview pictures. [pixel]"""

MANUFACTURER = "MANUFAC"
"""Key under which photometric files name their maker."""

_NAMESPACE = uuid.UUID("6f1c7c1e-53a0-5f0b-9d5e-6c7b0f3c2a10")

_CATALOGUE_HEAD = """# This is an Asset Catalog Definition file for Blender.
#
# Empty lines and lines starting with `#` will be ignored.
# The first non-ignored line should be the version indicator.
# Other lines are of the format "UUID:catalog/path/for/assets:simple catalog name"

VERSION 1

"""


@dataclass
class Built:
    """What became of a library.

    Parameters
    ----------
    path : Path    The file of the assets.
    names : list of str    Models that are in it: luminaires or materials.
    problems : list of Problem    Files and descriptions that were left out.
    """

    path: Path
    names: list[str] = field(default_factory=list)
    problems: list[Problem] = field(default_factory=list)


def build_assets(library: Library, folder: Path | None = None) -> Built:
    """Write the assets of a library and its catalogues; the open Blender file makes room for an empty one.

    Parameters
    ----------
    library : Library
    folder : Path or None    Where to; None: the library's own folder.

    Raises
    ------
    LumenrayError    Nothing can be written there, or there is nothing to write.
    """
    path = (folder or library.folder) / ASSETS
    return write_assets(library, library.models, _make_asset, path, ROOT, "photometric file")


def write_assets(library, models, make, path: Path, root: str, kind: str) -> Built:
    """Write a file with an asset of each model, and the catalogues beside it.

    Parameters
    ----------
    library : Library of luminaires or materials
    models : list    What of it becomes assets; each has ``name``, ``file`` and ``category``.
    make : callable    Makes the asset of a model in the open file; raises `LumenrayError` where that cannot be.
    path : Path    Of the file.
    root : str    Catalogue above all others.
    kind : str    What a model is, for messages.

    Raises
    ------
    LumenrayError    Nothing can be written there, or there is nothing to write.
    """
    built = Built(path, problems=list(library.problems))
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    for model in models:
        try:
            make(model)
        except LumenrayError as error:
            fault = error.fault if isinstance(error, FileFormatError) else str(error)
            built.problems.append(Problem(model.file or library.folder, fault))
        else:
            built.names.append(model.name)
    if not built.names:
        raise LumenrayError(f"{library.folder}: there is no {kind} that can be used")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _save_file(path)
        _write_catalogues(path.with_name(CATALOGUES), {model.category for model in models}, root)
    except (OSError, RuntimeError) as error:
        raise LumenrayError(f"{path}: cannot be written ({error})") from None
    return built


def _save_file(path: Path) -> None:
    """Save the open file without a backup beside it. Writing single data-blocks would lose the pictures of collections."""
    settings = bpy.context.preferences.filepaths
    kept, settings.save_version = settings.save_version, 0
    try:
        bpy.ops.wm.save_as_mainfile(filepath=str(path.resolve()), compress=True, copy=True)
    finally:
        settings.save_version = kept


# ---- catalogues ----


def catalogue_path(category: str, root: str = ROOT) -> str:
    """Return the path of a category's catalogue in the Asset Browser, below one for all of a kind."""
    parts = [part.strip() for part in category.replace(":", " ").replace("\\", "/").split("/")]
    return "/".join([root, *(part for part in parts if part)])


def catalogue_id(category: str, root: str = ROOT) -> str:
    """Return the identity of a category's catalogue: the same for the same path in all libraries."""
    return str(uuid.uuid5(_NAMESPACE, catalogue_path(category, root)))


def _write_catalogues(path: Path, categories, root: str) -> None:
    """Write the file of the catalogues; those that others made there stay."""
    rows = {}
    if path.is_file():
        for line in read_bytes(path).decode("utf-8").splitlines():
            if line.count(":") >= 2 and not line.startswith("#"):
                key, place, name = line.split(":", 2)
                rows[key] = (place, name)
    for category in categories:
        place = catalogue_path(category, root)
        rows[catalogue_id(category, root)] = (place, place.replace("/", "-"))
    lines = sorted(f"{place}\0{key}:{place}:{name}" for key, (place, name) in rows.items())
    text = "\n".join(line.split("\0", 1)[1] for line in lines)
    with write_whole(path, "utf-8") as file:
        file.write(f"{_CATALOGUE_HEAD}{text}\n")


# ---- assets ----


def _make_asset(model: Model) -> None:
    """Make what is dragged from the Asset Browser."""
    data = read_bytes(model.file)
    file = parse_luminaire(data, model.file, model.file.parent)
    require_luminous(model.file, file)
    if model.parts:
        asset = bpy.data.collections.new(model.title)
        for number, part in enumerate(model.parts, 1):
            asset.objects.link(_part(model, file, data, number, part))
    else:
        asset = _light(model.title, model, file, flux(file.distribution))
        _embed(asset.data.lumenray.luminaire, data, model.file.name)
    asset.asset_mark()
    _describe(asset.asset_data, model, file)
    set_preview(asset, model.thumbnail)


def _light(name: str, model: Model, file: LuminaireFile, amount: float):
    """Make a light object of the kind and size of the opening, for whoever draws it without our engine too."""
    opening = file.opening
    is_flat = opening.shape in {"rectangle", "ellipse"} and opening.axis == "z"
    kind = "AREA" if is_flat and _shines_ahead(file.distribution) else "POINT"
    light = bpy.data.lights.new(name, kind)
    if kind == "AREA":
        light.shape = "ELLIPSE" if opening.shape == "ellipse" else "RECTANGLE"
        light.size, light.size_y = opening.size[:2]
    else:
        light.shadow_soft_size = 0.5 * float(np.mean(opening.size))
    light.energy = amount / BLENDER_EFFICACY
    physical = light.lumenray
    physical.use_physical = True
    physical.quantity, physical.value = "LUMINOUS_FLUX", amount
    settings = physical.luminaire
    settings.emission = "OPENING"
    settings.spectrum_source = "FILE" if model.light is None else "LIGHT"
    if model.light is not None:
        physical.spectrum = model.light.kind.upper()
        if model.light.name:
            physical.illuminant = model.light.name
        else:
            physical.colour_temperature = model.light.temperature
    item = bpy.data.objects.new(name, light)
    item.visible_camera = True
    return item


def _shines_ahead(distribution) -> bool:
    """Whether nearly nothing goes to the back, to where Blender's area lights do not shine."""
    behind = directions(
        np.radians(np.arange(0.0, 360.0, 5.0))[:, None], np.radians(np.arange(95.0, 181.0, 5.0))
    )
    return bool(intensity(distribution, behind).max() < 0.02 * peak(distribution)[0])


def _part(model: Model, file: LuminaireFile, data: bytes, number: int, part):
    """Make the light of one emitter: the lamp's distribution from the emitter's own opening."""
    amount = part.share * flux(file.distribution)
    own = replace(file, opening=part_opening(part))
    item = _light(f"{model.title} {number}", model, own, amount)
    settings = item.data.lumenray.luminaire
    if own.opening.shape == "point":
        settings.emission = "POINT"
        _embed(settings, data, model.file.name)
    else:
        # A photometric file states one opening, so emitters of different size need files of their own.
        _embed(settings, write_lm63(own), f"{model.name} {number}.ies")
    settings.amount, settings.luminous_flux = "LUMENS", amount
    item.matrix_world = Matrix(part_frame(part).tolist())
    return item


def _embed(settings, data: bytes, name: str) -> None:
    """Embed a file without the place that it came from, which another machine does not have."""
    settings.text = photometric_files.embed(data, name)
    settings.digest = digest_of(data)
    settings.use_file = True


def _describe(metadata, model: Model, file: LuminaireFile) -> None:
    maker = model.maker or file.metadata.get(MANUFACTURER, "")
    watts = model.watts if model.watts is not None else file.watts
    amount = float(f"{flux(file.distribution):.4g}")
    facts = f"{amount:.9g} lm" + (f", {watts:g} W" if watts else "")
    metadata.description = f"{model.description} {facts}".strip()
    metadata.author = model.author or maker
    metadata.license = model.licence
    metadata.catalog_id = catalogue_id(model.category)
    for tag in (*model.tags, *([maker] if maker else [])):
        metadata.tags.new(tag, skip_if_exists=True)


def set_preview(asset, path: Path, side: int = PREVIEW) -> None:
    """Show a picture of an asset, with a side in pixels; without one Blender shows what it has for its kind."""
    if not path.is_file():
        return
    from PIL import Image

    with Image.open(path) as picture:
        shown = picture.convert("RGBA").resize((side, side))
    pixels = np.asarray(shown, dtype=np.float32)[::-1] / 255.0
    preview = asset.preview_ensure()
    preview.image_size = (side, side)
    preview.image_pixels_float.foreach_set(pixels.ravel())
