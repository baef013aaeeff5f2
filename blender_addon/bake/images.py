"""The atlas as images of the file: float, in lx, packed. Several pages are tiles of one image.

All images of one atlas carry the same number; the objects that it lies on point at the one with the whole illuminance.
"""

import math
import tempfile
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ...engine.analysis.looking import WORDS
from ...engine.baking.order import AtlasPage, BakeResult
from ...engine.photometry.colour import scene_linear
from ..foundation.report import ConversionReport
from .uv_maps import tile_number

FACTS = "lumenray"
"""Custom property of an image that tells what it holds."""

LUX, EXITANCE = "Lux atlas", "Exitance atlas"
"""Names of the images."""

ILLUMINANCE, LAYER, LEAVING = "illuminance", "illuminance layer", "luminous exitance"
"""Quantities that images hold."""

MOST_LAYERS = 6
"""Layers that are kept as images: a material takes one texture for each, or two of an atlas with several pages."""

OTHERS = "Others"
"""Name of the layer that holds what is left then."""


@dataclass(frozen=True)
class Content:
    """What an image is to hold: for each page (h, w) or (h, w, 3), row 0 at the bottom."""

    name: str
    quantity: str
    unit: str
    group: str
    pages: tuple[np.ndarray, ...]


def store_images(result: BakeResult, placed, report: ConversionReport) -> list:
    """Make the images of an atlas, the whole illuminance first; those of atlases that lie on nothing any more go.

    Parameters
    ----------
    result : BakeResult    With the pages' arrays.
    placed : list of bpy.types.Object    On which the new atlas is to lie; they point at none now.
    report : ConversionReport    Gets a row where layers are put together.
    """
    _remove_unused()
    number = 1 + max((facts_of(image).get("atlas", 0) for image in bpy.data.images), default=0)
    made = []
    for content in _contents(result, report):
        image = make_image(content)
        image[FACTS] = _facts(result, content) | {"atlas": number, "objects": len(placed)}
        # Layers have no other user, and what has none is not saved.
        image.use_fake_user = True
        made.append(image)
    return made


def has_atlas() -> bool:
    """Whether the file holds a baked atlas; cheap enough for every redraw."""
    return any(image.name.startswith(LUX) for image in bpy.data.images)


def facts_of(image) -> dict:
    """Return what an image of ours holds, empty for others."""
    facts = image.get(FACTS)
    return facts.to_dict() if hasattr(facts, "to_dict") else {}


def atlas_of(image) -> list:
    """Return all images of the atlas that an image belongs to, in the order of their names."""
    number = facts_of(image).get("atlas")
    if number is None:
        return []
    return [other for other in bpy.data.images if facts_of(other).get("atlas") == number]


def layers_of(image) -> dict:
    """Return the layers of an atlas, by light group."""
    facts = [(facts_of(other), other) for other in atlas_of(image)]
    return {each["group"]: other for each, other in facts if each["quantity"] == LAYER}


def exitance_of(image):
    """Return the image with the exitance of an atlas, None if it has none."""
    return next((o for o in atlas_of(image) if facts_of(o)["quantity"] == LEAVING), None)


def make_image(content: Content):
    """Make a float image of the file, packed; several pages are its tiles."""
    if len(content.pages) == 1:
        image = _paint(content.name, content.pages[0])
        image.pack()
        return image
    return _make_tiles(content)


def _remove_unused() -> None:
    used = {
        facts_of(source.lumenray.baked_image).get("atlas")
        for source in bpy.data.objects
        if source.lumenray.baked_image is not None
    }
    for image in list(bpy.data.images):
        number = facts_of(image).get("atlas")
        if number is not None and number not in used:
            bpy.data.images.remove(image)


def _contents(result: BakeResult, report: ConversionReport) -> list[Content]:
    pages = result.pages
    lux = tuple(page.illuminance for page in pages)
    contents = [Content(LUX, ILLUMINANCE, "lx", "", lux)]
    for name, values in _layers(pages, report).items():
        contents.append(Content(f"{LUX}: {name}", LAYER, "lx", name, values))
    if all(page.exitance is not None for page in pages):
        # X, Y, Z of which Y is the exitance become linear colours of that luminance.
        colours = tuple(scene_linear(page.exitance, 1.0) for page in pages)
        contents.append(Content(EXITANCE, LEAVING, "lm/m2", "", colours))
    return contents


def _layers(pages: tuple[AtlasPage, ...], report: ConversionReport) -> dict[str, tuple]:
    """Illuminance of each page by layer; the faintest ones together where there are many."""
    names = list(pages[0].layers) if pages else []
    found = {name: tuple(page.layers[name] for page in pages) for name in names}
    if len(found) <= MOST_LAYERS:
        return found
    amount = {
        name: sum(float((page.layers[name] * page.area).sum()) for page in pages) for name in names
    }
    kept = set(sorted(names, key=lambda name: (-amount[name], name))[: MOST_LAYERS - 1])
    rest = [found[name] for name in names if name not in kept]
    report.info(
        LUX,
        f"{len(names)} layers are more than materials can show at once",
        f"the {len(rest)} faintest ones are together as '{OTHERS}' in Blender; the files hold each",
    )
    shown = {name: found[name] for name in names if name in kept}
    return shown | {OTHERS: tuple(sum(parts) for parts in zip(*rest, strict=True))}


def _facts(result: BakeResult, content: Content) -> dict:
    facts = {
        "quantity": content.quantity,
        "unit": content.unit,
        "group": content.group,
        "mean": result.mean,
        "pages": len(result.pages),
        "files": [file for page in result.pages for file in page.files],
    }
    # The error is that of the whole light: a faint layer may be known less well.
    is_whole = content.quantity == ILLUMINANCE
    if is_whole and math.isfinite(result.relative_standard_error):
        facts["relative_standard_error"] = result.relative_standard_error
    if not is_whole:
        facts["mean"] = _mean(result.pages, content)
    if content.quantity == LEAVING and any(page.is_denoised for page in result.pages):
        facts["filter"] = WORDS
    for made in result.maps[:1]:
        facts |= {"scene_hash": made.provenance.scene_hash, "seed": made.provenance.seed}
    areas = sum(made.lumels for made in result.maps)
    facts["samples"] = sum(made.samples * made.lumels for made in result.maps) / max(areas, 1)
    return facts


def _mean(pages, content: Content) -> float:
    """Area-weighted mean over all that was computed; of a colour, that of its luminance."""
    total = weight = 0.0
    for page, shown in zip(pages, content.pages, strict=True):
        values = page.exitance[..., 1] if shown.ndim == 3 else shown
        area = np.where(page.covered, page.area, 0.0)
        total += float((values * area).sum())
        weight += float(area.sum())
    return total / weight if weight > 0.0 else 0.0


def _paint(name: str, values: np.ndarray):
    """Make an image of one page."""
    height, width = values.shape[:2]
    image = bpy.data.images.new(
        name[:63], width, height, alpha=False, float_buffer=True, is_data=True
    )
    pixels = np.ones((height, width, 4), dtype=np.float32)
    pixels[..., :3] = values if values.ndim == 3 else values[..., None]
    image.pixels.foreach_set(pixels.ravel())
    image.update()
    return image


def _make_tiles(content: Content):
    """Make an image of several pages; Python can give pixels to tiles by files only."""
    height, width = content.pages[0].shape[:2]
    image = bpy.data.images.new(
        content.name[:63], width, height, alpha=False, float_buffer=True, is_data=True, tiled=True
    )
    with tempfile.TemporaryDirectory(dir=bpy.app.tempdir) as folder:
        for page, values in enumerate(content.pages):
            number = tile_number(page)
            tile = _paint("Lumenray tile", values)
            tile.file_format = "OPEN_EXR"
            tile.filepath_raw = str(Path(folder) / f"page.{number}.exr")
            tile.save()
            bpy.data.images.remove(tile)
            if page > 0:
                image.tiles.new(tile_number=number)
        image.source = "TILED"
        image.filepath = str(Path(folder) / "page.<UDIM>.exr")
        image.reload()
        image.pack()
    return image
