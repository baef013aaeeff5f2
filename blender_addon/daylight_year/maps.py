"""Maps of a year in Blender: UV maps of the objects, an image of every figure, and pictures in false colours."""

import bpy
import numpy as np

from ...engine.analysis.false_colour import draw_false_colour, nice_maximum
from ...engine.baking.year_figures import COVERAGE, KINDS, Kind
from ...engine.baking.year_maps import YearMaps
from ..bake.images import Content, make_image
from ..bake.uv_maps import name_map, place_layout
from ..bake.year_images import FACTS, UV_MAP
from ..foundation.report import ConversionReport

PICTURED = ("daylight_autonomy", "useful_enough", COVERAGE, "mean_lx", "daylight_factor")
"""Figures that are drawn in false colours too."""

NOT_SHOWN = "its map of the year is in the images, but cannot be shown on it"


def store_maps(maps: YearMaps, names: dict[str, str], report: ConversionReport) -> list:
    """Put the maps of a year into the file.

    Parameters
    ----------
    maps : YearMaps
    names : dict of str    Of objects by the engine's ids.
    report : ConversionReport    Gets a row for every object whose mesh cannot hold its layout.

    Returns
    -------
    list of bpy.types.Image    Those with the numbers.
    """
    for each in maps.objects:
        source = bpy.data.objects.get(names.get(each.surface.id, ""))
        if source is not None:
            name = name_map(source, UV_MAP)
            layout, pages = each.surface.layout, len(maps.pages)
            place_layout(source, layout, pages, name, report, NOT_SHOWN)
    return [_store(kind, maps) for kind in KINDS]


def draw_maps(maps: YearMaps) -> dict:
    """Return pictures of the maps in false colours, by names of images."""
    made = {}
    for kind in (each for each in KINDS if each.name in PICTURED):
        shown = [kind.factor * page.values[kind.name][page.covered] for page in maps.pages]
        high = kind.high or nice_maximum(np.concatenate(shown))
        for page in maps.pages:
            title = f"{kind.title}, page {page.number + 1}"
            values = kind.factor * page.values[kind.name]
            made[f"{_name(kind)}, Colours {page.number + 1}"] = draw_false_colour(
                values, page.covered, title, kind.unit, high
            )
    return made


def _name(kind: Kind) -> str:
    return f"Daylight Map {kind.title}"


def _store(kind: Kind, maps: YearMaps):
    pages = tuple(kind.factor * page.values[kind.name] for page in maps.pages)
    covered = [values[page.covered] for page, values in zip(maps.pages, pages, strict=True)]
    image = make_image(Content(_name(kind), kind.title, kind.unit, "", pages))
    image[FACTS] = {
        "figure": kind.name,
        "unit": kind.unit,
        "high": kind.high or nice_maximum(np.concatenate(covered)),
    }
    # They have no user of their own, and what has none is not saved.
    image.use_fake_user = True
    return image
