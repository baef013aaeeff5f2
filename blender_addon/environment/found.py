"""What was found in a world's picture of the surroundings: analysed on demand, kept in the file, and shown in words."""

import json
from dataclasses import dataclass
from functools import partial

import bpy
import numpy as np

from ...engine.analysis.canvas import to_pixels
from ...engine.environment.analysis import Analysis, analyse, format_range, format_ratio
from ...engine.environment.marked_picture import draw_marked
from ...engine.environment.repair import (
    choose_time,
    find_north,
    find_times,
    find_tolerance,
    tell_times,
)
from ...engine.errors import SceneError
from ...engine.scene.texture import ImageTexture
from ...engine.sky.picture import find_illuminance
from ..daylight.moment import frame_of, read_place, state_moment
from ..foundation.report import ConversionReport
from ..readout import Description, format_amount
from ..sun_direction import UPWARDS
from ..sun_handle import keep_sun
from ..sync.world import find_picture
from ..sync.world_sources import choose_sun, read_coefficients, take_sources
from ..sync.world_suns import illuminance_of

SIZE = (1024, 760)
"""Of the picture with the sources marked. [pixel]"""

LISTED = 4
"""Sources that the panel lists."""

NO_PICTURE = "the world's nodes show no picture that gives light; link an Environment Texture to the Background"

STALE = "settings have changed since: analyse again"


@dataclass(frozen=True, eq=False)
class Found:
    """A world's picture, analysed.

    Parameters
    ----------
    analysis : Analysis    Of the picture as it is, by the world's unit and coefficients.
    picture, lights : float    Horizontal illuminance by the picture as it lights, and by the lights in it. [lx]
    sun : float    Of that by the sun; 0 without one. [lx]
    notes : tuple of str    What is odd, a sentence each.
    image : ImageTexture
    """

    analysis: Analysis
    picture: float
    lights: float
    sun: float
    notes: tuple[str, ...]
    image: ImageTexture


def analyse_world(world, efficacy: float) -> Found:
    """Analyse the picture that lights a world's surfaces.

    Parameters
    ----------
    world : bpy.types.World
    efficacy : float    Lumens per Blender watt. [lm/W]

    Raises
    ------
    SceneError    It shows none, or the coefficients are none.
    """
    report = ConversionReport()
    shown = find_picture(world, efficacy, report)
    if shown is None:
        raise SceneError(NO_PICTURE)
    image, rotation, per_unit = shown
    settings = world.lumenray.environment
    choose = partial(choose_sun, settings)
    analysis = analyse(image, per_unit, read_coefficients(settings), choose, rotation)
    picture, lights, sun = analysis.horizontal, 0.0, 0.0
    if settings.use_sources:
        taken = take_sources(world, image, rotation, report)
        picture = per_unit * find_illuminance(taken.image, rotation, UPWARDS)
        given = [
            per_unit * illuminance_of(disk) * max(disk.towards[2], 0.0) for disk in taken.disks
        ]
        lights = sum(given)
        sun = sum(amount for amount, disk in zip(given, taken.disks, strict=True) if disk.is_sun)
    notes = tuple(f"{row.message}: {row.remedy}" for row, _ in report.rows)
    return Found(analysis, picture, lights, sun, notes, image)


def keep(world, found: Found) -> None:
    """Keep what was found for the panel, with the settings that it holds for."""
    lines = list(_tell(world.lumenray.environment, found))
    kept = {
        "state": _state_of(world),
        "lines": lines,
        "words": [*found.analysis.verdict, *found.notes],
        "sun": keep_sun(world, found.analysis.sun),
    }
    world.lumenray.environment.found = json.dumps(kept)


def describe_found(world) -> tuple[Description, tuple[str, ...]]:
    """Return what was found in a world's picture, and sentences about it; no lines where it was not analysed."""
    text = world.lumenray.environment.found
    if not text:
        return Description(), ()
    kept = json.loads(text)
    problem = "" if kept["state"] == _state_of(world) else STALE
    lines = tuple((label, value) for label, value in kept["lines"])
    return Description(lines, problem), tuple(kept["words"])


def mark_picture(found: Found) -> bpy.types.Image:
    """Return an image that shows a picture with its sources marked; the one of before is drawn anew."""
    name = f"{found.image.name or 'World'} Sources"
    pixels = to_pixels(draw_marked(found.image, found.analysis, found.image.name, SIZE))
    height, width = pixels.shape[:2]
    image = bpy.data.images.get(name)
    if image is None or tuple(image.size) != (width, height):
        image = bpy.data.images.new(name, width, height)
    image.pixels.foreach_set(np.ascontiguousarray(pixels).ravel())
    image.pack()
    return image


def state_time(scene, world) -> str:
    """Set a world's time and north to where its picture shows the sun, and say it in one sentence.

    Parameters
    ----------
    scene : bpy.types.Scene    For its frame and its lumens per watt.
    world : bpy.types.World    Its place and its date hold.

    Raises
    ------
    SceneError    The picture shows no sun, or the sun never stands so high on the day.
    """
    analysis = analyse_world(world, scene.lumenray.efficacy).analysis
    shown, tolerance = analysis.sun, find_tolerance(analysis.height)
    if shown is None:
        raise SceneError("the picture shows no sun; choose Brightest Source where it is one")
    own, place = world.lumenray, read_place(world)
    time = own.time
    day = (time.year, time.month, time.day)
    times = find_times(shown.elevation, place, *day, time.use_refraction, tolerance)
    chosen = choose_time(times, own.environment.half == "MORNING")
    up, turn = np.radians([shown.elevation, shown.azimuth])
    towards = (np.cos(up) * np.sin(turn), np.cos(up) * np.cos(turn), np.sin(up))
    own.place.north = np.radians(find_north(towards, chosen.azimuth))
    state_moment(world, frame_of(scene), chosen.seconds)
    when = f"the sun stands {shown.elevation:.1f}° high at {chosen.clock:%H:%M}"
    return f"{when}; {tell_times(chosen, tolerance)}"


def _tell(settings, found: Found):
    """Lines (label, value) about what was found."""
    analysis = found.analysis
    yield "Horizontal", format_amount(analysis.horizontal, "lx")
    if analysis.ratio is not None:
        yield "Sun : rest", format_ratio(analysis.ratio)
    yield "Range", format_range(analysis.range)
    if settings.use_sources:
        yield "As rendered", format_amount(found.picture + found.lights, "lx")
        yield "By lights", format_amount(found.lights, "lx")
        rest = found.picture + found.lights - found.sun
        if settings.repair != "NONE" and found.sun > 0.0 and rest > 0.0:
            yield "Mended sun", format_ratio(found.sun / rest)
    for row in analysis.sources[:LISTED]:
        name = "Sun" if row.is_sun else "Lamp"
        where = f"{row.elevation:.1f}° high, azimuth {row.azimuth:.1f}°"
        yield name, f"{where}, {format_amount(row.illuminance, 'lx')}"
    if len(analysis.sources) > LISTED:
        yield "More lamps", str(len(analysis.sources) - LISTED)


def _state_of(world) -> str:
    """Return what the findings depend on, as far as it is set in the world's panels."""
    own = world.lumenray
    settings = own.environment
    names = [
        entry.identifier
        for entry in settings.bl_rna.properties
        if entry.identifier not in {"rna_type", "name", "found", "half"}
    ]
    values = [getattr(settings, name) for name in names]
    values = [
        tuple(value) if hasattr(value, "__len__") and not isinstance(value, str) else value
        for value in values
    ]
    return json.dumps([values, own.unit, own.illuminance, own.white, own.sun.turbidity])
