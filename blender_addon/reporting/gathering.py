"""From the open file to the content of its report: what sensors told in every lighting scene, luminaires, pictures."""

from pathlib import Path

import bpy

from ...engine import VERSION
from ...engine.analysis.value_plan import draw_grid, even_scale
from ...engine.errors import SceneError
from ...engine.formats.report import find_remarks
from ...engine.reading.printable import printable
from ...engine.reporting.results import Floor, Grid, LightingScene, Report, SensorArea
from ..rendering import lighting_scenes
from ..sensors import results
from ..sensors.drawing import axes_of
from ..sensors.judging import ALL_LIGHT, UNMIXED
from ..sensors.places import LUMINANCE, floor_area
from ..sensors.readings import Readings, readings_of
from ..sensors.scene_verdicts import SceneVerdicts, judge_all
from ..sensors.settings import find_sensors
from ..sensors.words import TITLES, brief, describe_light
from . import picture as pictures
from .luminaires import find_luminaires

KEPT = (
    "the values are those that the file has kept of its last measurement; what was noted then, and whether it reached its "
    "goal, is not kept with them"
)
"""Remark of reports of which nothing was measured."""

PLAN = (760, 480)
"""Size of plans. [pixel]"""


def gather(
    depsgraph,
    picture=None,
    conversion=(),
    notes=(),
    shortfalls=(),
    date: str = "",
    files=(),
) -> Report:
    """Bring the report of a scene together from what its sensors have told.

    Parameters
    ----------
    depsgraph : bpy.types.Depsgraph    Evaluated.
    picture : views.Picture or None    Of the camera.
    conversion : list of dict    The conversion report's rows.
    notes, shortfalls : iterable of str    What is to be known of the values; what of them was not reached.
    date : str    Of the cover.
    files : iterable of Path    Of requirements, besides those that the scene knows.

    Raises
    ------
    SceneError    No sensor has been measured.
    FileFormatError    A file of requirements cannot be read.
    """
    scene = depsgraph.scene.original if depsgraph.scene.is_evaluated else depsgraph.scene
    settings = scene.lumenray
    held = [(empty, readings_of(empty)) for empty in find_sensors(scene)]
    all_known = [(empty, readings) for empty, readings in held if readings is not None]
    known = [each for each in all_known if not each[1].is_distribution]
    if not known:
        raise SceneError("no sensor of the scene has been measured; measure them first")
    remarks = [
        f"sensors '{empty.name}' have not been measured" for empty, each in held if each is None
    ]
    remarks += [
        f"goniometer '{empty.name}': {brief(readings)}; its photometric file has its intensities"
        for empty, readings in all_known
        if readings.is_distribution
    ]
    scenes = []
    chosen_scenes = lighting_scenes.choose_all(scene)
    for chosen in chosen_scenes:
        verdicts = judge_all(scene, chosen, files)
        areas = tuple(
            _tell_area(empty, readings, settings, chosen.levels, verdicts)
            for empty, readings in known
        )
        shown = () if picture is None else pictures.show(picture, chosen.levels, settings)
        words = chosen.levels.text()
        if chosen.name:
            words = f"Light groups: {words or 'all as in the scene'}."
        elif words:
            words = f"Light mix: {words}."
        scenes.append(LightingScene(printable(chosen.name), words, areas, shown))
        groups = dict.fromkeys(name for _, readings in known for name in readings.groups)
        remarks += lighting_scenes.remarks_of(chosen, groups)
        remarks += [
            f"sensors '{empty.name}': {ALL_LIGHT if readings.is_rating else UNMIXED}"
            for empty, readings in known
            if not readings.is_told(chosen.levels)
        ]
    schedule, sheets, others, problems = find_luminaires(depsgraph)
    told = list(find_remarks(conversion, notes))
    goals = [f"goal: {words}" for words in dict.fromkeys(filter(None, shortfalls))]
    remarks = dict.fromkeys([*goals, *told, *remarks, *problems])
    own, name = settings.report, Path(bpy.data.filepath).name
    return Report(
        title=own.title.strip() or Path(name).stem or "Untitled",
        file=name,
        version=VERSION,
        transport=settings.transport.lower(),
        scenes=tuple(scenes),
        schedule=schedule,
        luminaires=sheets,
        others=others,
        floor=_find_floor(known, depsgraph, chosen_scenes[0].levels),
        settings=tuple(_tell_settings(settings)),
        remarks=tuple(printable(remark) for remark in remarks),
        maintenance=settings.sensors.maintenance,
        client=own.client.strip(),
        author=own.author.strip(),
        date=date,
    )


def _tell_area(empty, readings: Readings, settings, levels, verdicts: SceneVerdicts) -> SensorArea:
    values, errors = readings.mixed(levels)
    quantity = TITLES[readings.quantity].lower()
    if readings.is_rating:
        quantity = "unified glare rating of observers"
    elif readings.quantity != LUMINANCE:
        quantity = f"{quantity} illuminance"
    grid = _grid_of(readings, values, errors) if readings.is_field else None
    plan = None if grid is None else _draw(grid, quantity, readings.unit, settings.sensors)
    return SensorArea(
        printable(empty.name),
        quantity,
        readings.unit,
        readings.figures(levels),
        readings.positions,
        readings.normals,
        values,
        errors,
        readings.samples,
        readings.seed,
        readings.method,
        readings.scene_hash,
        grid,
        plan,
        verdicts.areas.get(empty.name),
        verdicts.problems.get(empty.name, ""),
        results.why_outdated(empty),
        verdicts.observers.get(empty.name, ()),
        readings.simplified,
        describe_light(readings, levels),
    )


def _grid_of(readings: Readings, values, errors) -> Grid:
    x, y = axes_of(readings)
    return Grid(x, y, readings.grid(values), readings.grid(errors))


def _draw(grid: Grid, quantity: str, unit: str, settings):
    """Draw a plan; ``settings``: a `LumenraySensorsSettings`, which may state the scale of illuminances."""
    high = None if settings.automatic or unit != "lx" else settings.high
    known = grid.values[grid.values == grid.values]
    scale = even_scale(known, unit, high)
    title = f"{quantity.capitalize()} [{unit}]"
    return draw_grid(title, grid.x, grid.y, grid.values, "", scale, unit=unit, size=PLAN)


def _find_floor(known, depsgraph, levels) -> Floor | None:
    """Return the floor that installed power is stated for: the only one that level sensors stand over."""
    floors = {}
    for empty, readings in known:
        settings = empty.lumenray.sensor
        if settings.layout == "FLOOR" and settings.surface is not None:
            best = floors.get(settings.surface.name)
            # The mean of sensors at the height of work counts, not of those on the floor.
            if best is None or settings.height > best[0].lumenray.sensor.height:
                floors[settings.surface.name] = (empty, readings)
    if len(floors) != 1:
        return None
    ((name, (empty, readings)),) = floors.items()
    mean = None
    if readings.quantity == "PLANAR":
        mean = readings.figures(levels).mean
    return Floor(printable(name), floor_area(empty, depsgraph), mean)


def _tell_settings(settings):
    sensors = settings.sensors
    yield (
        "Sensors measured until",
        f"a relative standard error of {100.0 * sensors.error:.3g} % of all together, or {sensors.time:g} s",
    )
    yield "Light groups", settings.light_mix.groups.lower()
    yield "Modified means", "asked for" if sensors.modified else "not asked for"
