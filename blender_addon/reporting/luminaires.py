"""What a report tells of luminaires: numbers of their files, polar diagrams, tables of glare; and of other lights."""

from ...engine.analysis.polar_diagram import draw_polar_diagram
from ...engine.analysis.ugr_table import find_ugr_table
from ...engine.errors import SceneError
from ...engine.judgement.schedule import Fitting, Schedule, make_schedule
from ...engine.luminaires.formats.record import LUMINOUS
from ...engine.luminaires.summary import summarise
from ...engine.reading.printable import printable
from ...engine.reporting.results import LuminaireSheet, OtherLight
from ..light_list import find_lights
from ..luminaires.fittings import find_fittings
from ..luminaires.settings import is_luminaire

SIDE = 720
"""Of polar diagrams. [pixel]"""

TOLD = {
    "Maker": ("MANUFAC", "MANUFACTURER", "COMPANY"),
    "Catalogue": ("LUMCAT", "LUMINAIRE NUMBER"),
    "Lamp": ("LAMP", "LAMPCAT"),
    "Test": ("TEST", "TESTLAB", "MEASUREMENT REPORT"),
}
"""Labels, and keywords of photometric files that stand for them."""


def find_luminaires(depsgraph):
    """Find luminaires and other lights that renders show.

    Returns
    -------
    schedule : Schedule
    sheets : tuple of LuminaireSheet    Of every kind.
    others : tuple of OtherLight
    problems : list of str    Why lights could not be taken.
    """
    fittings, problems, _ = find_fittings(depsgraph)
    schedule: Schedule = make_schedule(fittings)
    sheets, seen = [], []
    for fitting in schedule.fittings:
        # Luminaires at different levels have the same file.
        if not any(fitting.file is file for file in seen):
            seen.append(fitting.file)
            sheets.append(describe(fitting))
    listed = find_lights(depsgraph)
    sources = {thing.original.session_uid: thing for thing in depsgraph.scene.objects}
    others = tuple(
        OtherLight(printable(row.name), row.count, row.amount, row.unit)
        for row in listed.rows
        if row.uid not in sources or not is_luminaire(sources[row.uid])
    )
    return schedule, tuple(sheets), others, [*problems, *listed.problems]


def describe(fitting: Fitting) -> LuminaireSheet:
    """Return what is told of a kind of luminaire."""
    file = fitting.file
    facts = tuple(_facts(fitting))
    diagram = draw_polar_diagram(file, (SIDE, SIDE))
    try:
        return LuminaireSheet(fitting, facts, diagram, find_ugr_table(file))
    except SceneError as error:
        return LuminaireSheet(fitting, facts, diagram, problem=str(error))


def _facts(fitting: Fitting):
    file, made = fitting.file, summarise(fitting.file)
    for label, keys in TOLD.items():
        text = next((file.metadata[key] for key in keys if file.metadata.get(key, "").strip()), "")
        if text:
            yield label, printable(" ".join(text.split()))
    units = file.units
    yield "Count", str(fitting.count)
    yield (
        "Flux of each",
        f"{fitting.luminous_flux:.4g} lm as set, {made.total_flux:.4g} {units.flux} by the file",
    )
    if file.watts is not None:
        told = f"{file.watts:g} W"
        if made.efficacy is not None and file.quantity == LUMINOUS:
            told += f", {made.efficacy:.4g} lm/W"
        yield "Power", told
    if made.light_output_ratio is not None:
        yield "Light output ratio", f"{100.0 * made.light_output_ratio:.3g} %"
    if made.downward_fraction is not None:
        yield "Downward share", f"{100.0 * made.downward_fraction:.3g} %"
    c, gamma = made.peak_direction
    yield "Largest intensity", f"{made.peak:.4g} {units.intensity} at C {c:g}°, gamma {gamma:g}°"
    angles = ["-" if each is None else f"{each:.3g}°" for each in made.beam_angles]
    yield "Beam angle (50 %)", f"{angles[0]} in C0-C180, {angles[1]} in C90-C270"
    yield "CIE flux code", " ".join(f"{100.0 * code:.0f}" for code in made.flux_codes)
    lamp = next(iter(file.lamps), None)
    if lamp is not None and (lamp.colour or lamp.colour_rendering or lamp.colour_temperature):
        parts = [lamp.colour, lamp.colour_rendering]
        if lamp.colour_temperature:
            parts.append(f"{lamp.colour_temperature:.0f} K")
        yield "Light colour", printable(", ".join(part for part in parts if part))
    yield "File", f"{file.format}, type {file.photometric_type}"
