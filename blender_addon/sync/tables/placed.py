"""Materials that are made for single objects, and how fine their pictures are."""

import math
from dataclasses import dataclass, field

import numpy as np

from ....engine.errors import LumenrayError
from ....engine.scene.material import Material
from ....engine.scene.spectrum import Rgb
from ...foundation.report import ConversionReport
from ..materials.materials import convert_material
from ..nodes.placed import AFFORDABLE, COARSEST, FINEST, PlacedContext
from ..placing import Place

TEXELS = 1 << 22
"""Texels of all pictures that are made for single objects; each gets its share by the root of its area."""

LIVE_TEXELS = TEXELS // 4
"""The same for the rendered view, whose edits are waited for."""

MOST_OVER = 8
"""Times its share that a surface of many parts may take. [-]"""

MOST = 1024
"""Objects that one material is made for at most; the others show what it is for all."""


@dataclass
class Placed:
    """A material for one object, or for all that would get the same one.

    Parameters
    ----------
    place : Place
    owner : int    Session uid of Blender's material.
    made_of : tuple    What it was made of last.
    """

    place: Place
    owner: int
    made_of: tuple = ()
    digest: bytes = b""
    name: str = ""
    is_luminous: bool = False
    paints: tuple[Rgb, ...] = ()
    glow: Rgb | None = None
    report: ConversionReport = field(default_factory=ConversionReport)


def pictures_of(made: Material) -> list:
    """Return all pictures of a material, those of what the camera sees in its place aside."""
    pattern = None if made.emission is None else made.emission.pattern
    return [*made.surface.pictures, *([] if pattern is None else [pattern])]


def shares(room: int, places: dict[str, Place]) -> dict[str, int]:
    """Return how many texels of ``room`` the picture of each may have, by keys; less for smaller surfaces."""
    sizes = {key: math.sqrt(_area(place)) for key, place in places.items() if place.surface}
    total = sum(sizes.values())
    return {key: int(room * size / total) if total > 0 else 0 for key, size in sizes.items()}


def _area(place: Place) -> float:
    """About the area that a slot's triangles have in the world. [Blender unit²]"""
    linear = place.subject.matrix[:3, :3]
    return place.surface.area(place.slot, place.is_last) * abs(np.linalg.det(linear)) ** (2 / 3)


def convert_for(place: Place, share: int, block, report, efficacy, images, is_patient, metres):
    """Convert a material for one object.

    At first at as few texels as its charts need, which tells how many it takes to show its textures; then at those.

    Parameters
    ----------
    place : Place
    share : int    Texels that it may have.
    block : bpy.types.Material    Evaluated.
    report, efficacy, images, is_patient, metres    As of `convert_material`.
    """

    def convert(factor, report):
        texels = rows = None
        if charts is not None:
            texels, rows = charts.texels(factor), place.surface.rows(place.slot, place.is_last)
        context = PlacedContext(
            block.name, report, images, place.subject, place.surface, texels, rows
        )
        made = convert_material(
            block, place.key, report, efficacy, images, is_patient, metres, context
        )
        return made, context

    charts = None if place.surface is None else _charts_of(place, share, block, report)
    first = ConversionReport()
    made, context = convert(1, first)
    factor = 1 if charts is None else _factor(charts, context, share)
    if place.is_optional and context.wanted > COARSEST * factor:
        # Pictures that repeat on a UV map keep their pixels.
        charts = None
        return convert(1, report)[0]
    if factor > 1:
        made, _ = convert(factor, report)
    else:
        report.include(first)
    if context.wanted > COARSEST * factor:
        report.warn(
            block.name,
            "The picture of an object has fewer texels than its textures ask for",
            f"{charts.width * factor} x {charts.height * factor} are drawn",
        )
    if charts is not None and is_patient:
        # No edits follow a render, so that what they would be quick by is only memory.
        charts.forget()
    return made


def _charts_of(place: Place, share: int, block, report):
    """Return the charts of a surface, None where it has none or there is no room for so many."""
    try:
        charts = place.surface.charts(place.slot, place.is_last)
    except LumenrayError:
        charts = None
        is_full = place.surface.area(place.slot, place.is_last) > 0.0
    else:
        is_full = charts is not None and charts.width * charts.height > MOST_OVER * share
    if is_full:
        report.error(
            block.name,
            "The surface of an object has more parts than its picture has room for",
            "textures that lie by the object count by their means there",
        )
    return None if is_full else charts


def _factor(charts, context, share: int) -> int:
    """Return how many times finer than its charts a picture is to be, a power of two."""
    count = max(len(context.texels), 1)
    wanted = 2.0 ** math.ceil(math.log2(max(context.wanted, 1.0)))
    most = min(
        FINEST / max(charts.width, charts.height),
        math.sqrt(max(share, 1) / count),
        math.sqrt(AFFORDABLE / (max(context.work, 1e-9) * count)),
    )
    return int(min(wanted, 2.0 ** math.floor(math.log2(max(most, 1.0)))))
