"""From the content of a report to its pages: the summary with the verdicts first, then areas, luminaires, glare, method."""

import math

import numpy as np

from ..accuracy.extremes import PROBABILITY, Extreme
from ..accuracy.stopping import format_seconds
from ..analysis.ugr_table import REFLECTANCES, ROOMS, UgrTable
from ..judgement.assessment import Assessment
from ..judgement.requirement import AREAS, LIGHT, LIMITS, RATIOS
from ..judgement.verdict import WRONG, Range, State, Verdict
from ..requirements.budget import tell_parts
from .blocks import Beside, Cell, Document, Facts, Figure, Heading, Points, Table, Text
from .results import LightingScene, LuminaireSheet, Report, SensorArea

KIND = "Lighting report"

MOST_VALUES = 600
"""Sensors of an area whose values are printed one by one."""

COLUMNS = 10
"""Columns of a grid beside each other in a table."""

PLAIN = {LIMITS[name] for name in RATIOS} | set(LIGHT.values())
"""Names of limits without a unit."""

ALTERED = "changed since it was measured"


def compose(report: Report) -> Document:
    """Lay a report out."""
    facts = [
        ("Client", report.client),
        ("By", report.author),
        ("Date", report.date),
        ("File", report.file),
        ("Luminaires", _count_luminaires(report)),
        ("Power", _tell_power(report)),
        ("Maintenance factor", f"{report.maintenance:g} on illuminances in verdicts"),
    ]
    footer = " · ".join(
        filter(None, [report.title, report.date, f"Lumenray {report.version}", _hash(report)])
    )
    facts = tuple((label, text) for label, text in facts if text)
    blocks = [
        *_summarise(report),
        *(block for scene in report.scenes for block in _tell_scene(report, scene)),
        *_tell_luminaires(report),
        *_tell_glare(report),
        *_tell_method(report),
    ]
    return Document(report.title, KIND, facts, footer, blocks)


def estimate(value: float, error: float, unit: str = "") -> str:
    """A value with its standard error, both to the second digit of the error."""
    unit = f" {unit}" if unit else ""
    if not (0.0 < error < math.inf):
        return f"{value:.4g}{unit}"
    digits = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{digits}f} ± {error:.{digits}f}{unit}"


# ---- summary ----


def _summarise(report: Report):
    """Table of verdicts: of every area in every lighting scene."""
    yield Heading(2, "Summary")
    several = len(report.scenes) > 1
    for scene in report.scenes:
        if several:
            yield Heading(3, scene.name)
            yield Text(scene.levels, is_note=True)
        yield _table_of_verdicts(scene)
    yield Text(
        "Values are means over the area with their standard error (one standard deviation); least over mean is the "
        f"uniformity U0. A verdict that is stated is wrong in at most {100 * WRONG:g} % of cases.",
        is_note=True,
    )
    count = len(report.remarks)
    if count:
        yield Text(
            f"{count} remark{'' if count == 1 else 's'} on what was assumed, left out, not reached: see Method and errors.",
            is_note=True,
        )
    pictures = [scene.pictures[0] for scene in report.scenes if scene.pictures][:1]
    for shown in pictures:
        yield Figure(shown.picture, shown.caption, 0.8)


def _table_of_verdicts(scene: LightingScene) -> Table:
    rows = []
    for area in scene.areas:
        made = area.assessment
        verdict = Cell("-")
        required = ""
        if area.observers:
            required = f"UGR at most {area.observers[0].limit:g}"
            verdict = Cell(area.state.value, area.state)
        elif made is not None:
            verdict = Cell(_tell_state(made), made.state)
            required = f"{made.requirement.title} ({made.requirement.standard}), {made.area}"
        elif area.problem:
            verdict = Cell("not judged")
        words = f"{area.name} ({ALTERED})" if area.changed else area.name
        mean = tell_mean(area)
        is_field = len(area.values) > 1 and not area.is_rating
        uniformity = f"{area.figures.overall.value:.2f}" if is_field else "-"
        rows.append((words, required or "-", mean, uniformity, verdict))
    head = ("Area", "Requirement", "Mean", "U0", "Verdict")
    return Table(head, tuple(rows), (0.19, 0.33, 0.18, 0.08, 0.22), texts=2)


def tell_mean(area: SensorArea) -> str:
    """The mean of an area, or the worst rating of its observers."""
    if not area.is_rating:
        return estimate(area.figures.mean, area.figures.mean_error, area.unit)
    known = np.isfinite(area.values)
    if not known.any():
        return "no glare source"
    worst = int(np.nanargmax(area.values))
    return (
        f"UGR {'up to ' * (len(area.values) > 1)}{estimate(area.values[worst], area.errors[worst])}"
    )


def _tell_state(made: Assessment) -> str:
    if made.state is not State.UNDECIDED:
        return made.state.value
    if made.seconds is None:
        return "not decided: value and limit are the same as far as can be told"
    return f"{made.state.value}: about {format_seconds(made.seconds)} more"


# ---- areas ----


def _tell_scene(report: Report, scene: LightingScene):
    name = scene.name or "Sensor areas"
    yield Heading(1, name)
    if scene.levels:
        yield Text(scene.levels)
    for shown in scene.pictures:
        yield Figure(shown.picture, shown.caption, 0.9)
    for area in scene.areas:
        yield from _tell_area(report, area)


def _tell_area(report: Report, area: SensorArea):
    yield Heading(2, area.name)
    if area.changed:
        yield Text(f"Out of date: {ALTERED}: {area.changed}")
    if area.is_rating:
        yield from _tell_observers(area)
        return
    figures, count = area.figures, len(area.values)
    lines = [("Quantity", area.quantity), ("Sensors", str(count))]
    mean = estimate(figures.mean, figures.mean_error, area.unit)
    if count == 1:
        lines.append(("Value", mean))
    else:
        lines += [
            ("Mean", mean),
            ("Minimum", _range(figures.least, area.unit)),
            ("Maximum", _range(figures.largest, area.unit)),
            ("Uniformity U0 (least/mean)", _range(figures.overall, "")),
            ("Uniformity Ud (least/largest)", _range(figures.diversity, "")),
        ]
    lines += [(label[0].upper() + label[1:], words) for label, words in area.light]
    lines.append(("Samples", f"{area.samples} for each sensor, seed {area.seed}"))
    error = figures.mean_error / figures.mean if figures.mean > 0.0 else math.inf
    if parts := tell_parts(error, area.simplified):
        lines.append(("Error of the mean", parts))
    yield Facts(tuple(lines))
    if area.assessment is not None:
        yield from _tell_assessment(area.assessment)
    elif area.problem:
        yield Text(f"Not judged: {area.problem}")
    if area.plan is not None:
        words = f"{area.name}: {area.quantity} [{area.unit}] with lines of equal value"
        yield Figure(area.plan, words, 0.9)
    yield from _list_values(area)


def _tell_observers(area: SensorArea):
    """Ratings of observers, and what is allowed."""
    yield Text(
        "Unified glare ratings (CIE 117) of observers at these places, found in pictures of what each sees with all light "
        "as in the scene, whatever the levels of light groups."
    )
    if area.problem:
        yield Text(f"Not judged: {area.problem}")
    rows = []
    for k, (place, value) in enumerate(zip(area.positions, area.values, strict=True)):
        verdict = area.observers[k] if area.observers else None
        rows.append(
            (
                str(k + 1),
                *(f"{each:.3f}" for each in place),
                estimate(value, area.errors[k]) if np.isfinite(value) else "no glare source",
                "-" if verdict is None else f"at most {verdict.limit:g}",
                Cell("-") if verdict is None else Cell(verdict.state.value, verdict.state),
            )
        )
    head = ("Observer", "x [m]", "y [m]", "z [m]", "UGR", "Required", "Verdict")
    yield Table(head, tuple(rows), (0.12, 0.11, 0.11, 0.11, 0.17, 0.16, 0.22))


def _tell_assessment(made: Assessment):
    requirement = made.requirement
    title = f"{requirement.title}, {made.area} ({requirement.standard}; {requirement.key})"
    yield Heading(3, f"Required: {title}")
    rows = [
        (verdict.name, _limit(verdict, made.area), *_found(verdict, made.area), _verdict(verdict, made))
        for verdict in made.verdicts
    ]  # fmt: skip
    head = ("Limit", "Required", "Found", "True value within", "Verdict")
    yield Table(head, tuple(rows), (0.22, 0.17, 0.15, 0.22, 0.24))
    words = ""
    if requirement.is_direct:
        words = "Of the light that was not reflected, as the standard counts it. "
    if made.maintenance != 1.0:
        words += f"Illuminances are multiplied by the maintenance factor {made.maintenance:g}. "
    yield Text(f"{words}Source of the requirement: {requirement.source or 'not stated'}.", True)


def _verdict(verdict: Verdict, made: Assessment) -> Cell:
    words = verdict.state.value
    if verdict.state is State.UNDECIDED and verdict.more is None:
        words = "not decided: the same as far as can be told"
    elif verdict.state is State.UNDECIDED and made.seconds is not None:
        words += f": up to {format_seconds(made.seconds)} more"
    return Cell(words, verdict.state)


def _limit(verdict: Verdict, area: str) -> str:
    return f"{'at most' if verdict.is_most else 'at least'} {verdict.limit:g}{_unit(verdict, area)}"


def _found(verdict: Verdict, area: str) -> tuple[str, str]:
    found, unit = verdict.found, _unit(verdict, area)
    if found is None:
        return "not measured", "-"
    return f"{_short(found.value)}{unit}", f"{_short(found.low)} to {_short(found.high)}{unit}"


def _unit(verdict: Verdict, area: str) -> str:
    return "" if verdict.name in PLAIN else f" {AREAS[area].replace('m2', 'm²')}"


def _range(extreme: Extreme | Range, unit: str) -> str:
    tell = _short if unit else "{:.3f}".format
    value, low, high = (tell(each) for each in (extreme.value, extreme.low, extreme.high))
    return f"{value} {unit} ({low} to {high})".replace("  ", " ")


def _short(value: float) -> str:
    if not math.isfinite(value):
        return "not known" if value > 0.0 else "none"
    return f"{value:.0f}" if abs(value) >= 1000.0 else f"{value:.4g}"


def _list_values(area: SensorArea):
    """Tables of all values with their errors, unless there are too many."""
    if len(area.values) > MOST_VALUES:
        words = f"The values of all {len(area.values)} sensors are in the CSV and JSON files."
        yield Text(words, is_note=True)
        return
    if area.grid is None:
        if len(area.values) > 1:
            yield _list_one_by_one(area)
        return
    grid = area.grid
    words = f"Values and standard errors [{area.unit}], by x (across) and y (down) in the plane [m]"
    yield Text(words, is_note=True)
    # As seen on the plan: the largest y is on top.
    rows = range(len(grid.y) - 1, -1, -1)
    for start in range(0, len(grid.x), COLUMNS):
        columns = range(start, min(start + COLUMNS, len(grid.x)))
        cells = tuple(
            (
                f"{grid.y[row]:.2f}",
                *(_reading(grid.values[row, col], grid.errors[row, col]) for col in columns),
            )
            for row in rows
        )
        share = 1.0 / (COLUMNS + 0.7)
        widths = (0.7 * share, *(share for _ in columns))
        head = ("y \\ x", *(f"{grid.x[column]:.2f}" for column in columns))
        yield Table(head, cells, widths, texts=1, is_small=True)


def _list_one_by_one(area: SensorArea) -> Table:
    rows = tuple(
        (str(k + 1), *(f"{each:.3f}" for each in area.positions[k]), _reading(value, error))
        for k, (value, error) in enumerate(zip(area.values, area.errors, strict=True))
    )
    head = ("Sensor", "x [m]", "y [m]", "z [m]", f"Value [{area.unit}]")
    return Table(head, rows, (0.12, 0.14, 0.14, 0.14, 0.22), is_small=True)


def _reading(value: float, error: float) -> str:
    """A value to the first digit of its error, which is told, in few letters."""
    if not math.isfinite(value):
        return ""
    if not error > 0.0:
        return f"{value:.4g}"
    digits = min(max(0, -math.floor(math.log10(error))), 3)
    return f"{value:.{digits}f} ±{max(round(error, digits), 10.0**-digits):.{digits}f}"


# ---- luminaires and glare ----


def _tell_luminaires(report: Report):
    if not report.schedule.fittings and not report.others:
        return
    yield Heading(1, "Luminaires")
    if report.schedule.fittings:
        rows = [
            (each.name, str(each.count), _number(each.luminous_flux), _number(each.watts),
             _number(each.count * each.luminous_flux), _number(_times(each.count, each.watts)))
            for each in report.schedule.fittings
        ]  # fmt: skip
        total = report.schedule
        rows.append(
            ("All", str(total.count), "", "", _number(total.luminous_flux), _number(total.watts))
        )
        head = ("Luminaire", "Count", "lm each", "W each", "lm", "W")
        yield Table(head, tuple(rows), (0.40, 0.10, 0.13, 0.12, 0.13, 0.12))
        power = _tell_power(report)
        if power:
            yield Text(f"Installed power: {power}.")
    for each in report.luminaires:
        yield from _tell_luminaire(each)
    if report.others:
        yield Heading(2, "Lights without a photometric file")
        rows = tuple(
            (each.name, str(each.count), f"{_number(each.amount)} {each.unit}")
            for each in report.others
        )
        yield Table(("Light", "Count", "Together"), rows, (0.55, 0.15, 0.25))
        yield Text("Their power is not known, and not part of any sum of watts.", is_note=True)


def _tell_luminaire(sheet: LuminaireSheet):
    yield Heading(2, sheet.fitting.name)
    facts = Facts(sheet.facts)
    if sheet.diagram is None:
        yield facts
        return
    caption = "Intensity distribution"
    yield Beside((Figure(sheet.diagram, caption),), (facts,), 0.45)


def _tell_glare(report: Report):
    told = [each for each in report.luminaires if each.ugr is not None or each.problem]
    if not told:
        return
    yield Heading(1, "Glare")
    yield Text(
        "Unified glare ratings of the luminaires in the rooms of CIE 190:2010, computed from their photometric files; "
        "spacing 0.25 H. X and Y are the sizes of the room across and along the line of sight, in heights H of the "
        "luminaires above the eye; C columns look across the lamps, E columns along them, by the reflectances of ceiling, "
        "walls and floor in per cent."
    )
    for sheet in told:
        yield Heading(2, sheet.fitting.name)
        if sheet.ugr is None:
            yield Text(f"No table of glare: {sheet.problem}.")
        else:
            yield _table_of_glare(sheet.ugr)


def _table_of_glare(table: UgrTable) -> Table:
    columns = ["/".join(f"{100 * part:.0f}" for part in each) for each in REFLECTANCES]
    head = ("X", "Y", *(f"{letter} {each}" for letter in "CE" for each in columns))
    rows = tuple(
        (f"{x} H", f"{y} H", *(_rating(value) for value in table.values[k].ravel()))
        for k, (x, y) in enumerate(ROOMS)
    )
    return Table(head, rows, (0.07, 0.07, *([0.086] * 10)), texts=2, is_small=True)


def _rating(value: float) -> str:
    return f"{value:.1f}" if np.isfinite(value) else "-"


def _number(value: float | None) -> str:
    if value is None:
        return "-"
    return f"{value:.0f}" if value >= 1000.0 else f"{value:.4g}"


def _times(count: int, value: float | None) -> float | None:
    return None if value is None else count * value


def _count_luminaires(report: Report) -> str:
    total = report.schedule
    told = [f"{total.count} with photometric files, {_number(total.luminous_flux)} lm"]
    count = sum(each.count for each in report.others)
    if count:
        told.append(f"{count} other light{'' if count == 1 else 's'}")
    return ", ".join(told if total.count else told[1:])


def _tell_power(report: Report) -> str:
    watts, floor = report.schedule.watts, report.floor
    if not report.schedule.fittings:
        return ""
    if watts is None:
        return "not known: files of luminaires do not state it"
    told = f"{_number(watts)} W"
    if floor is not None:
        told += f", {watts / floor.area:.3g} W/m² over {floor.area:.4g} m² ({floor.name})"
        if floor.illuminance:
            told += f", {report.schedule.relative_power(floor.area, floor.illuminance):.3g} W/m² per 100 lx"
    return told


# ---- method ----


def _tell_method(report: Report):
    yield Heading(1, "Method and errors")
    yield Text(
        "Light is computed by Monte Carlo transport in photometric units. Every value is an estimate with a standard error "
        "that is found from independent groups of samples; a value without ± is known to all its digits. Ranges of least, "
        f"largest and uniformities hold the true value in at least {100 * PROBABILITY:g} % of cases, "
        "those of verdicts so often "
        f"that a stated verdict is wrong in at most {100 * WRONG:g} % of cases over all its limits. Lighting scenes are "
        "sums of light groups that were computed apart: light adds up, groups are independent, and their errors add up as "
        "squares. What of the scene was simplified has a bound, which is in the errors and stated beside them."
    )
    yield Facts(
        (
            *report.settings,
            ("Engine", f"Lumenray {report.version}, transport: {report.transport}"),
            *_tell_origin(report),
        )
    )
    yield Heading(2, "How it was computed")
    methods = dict.fromkeys(area.method for scene in report.scenes for area in scene.areas)
    yield Points(tuple(method for method in methods if method) or ("not stated",))
    yield Heading(2, "Left out, assumed, not reached")
    yield Points(report.remarks or ("Nothing: all of the scene was taken over as it is.",))


def _tell_origin(report: Report):
    areas = [area for scene in report.scenes for area in scene.areas]
    for label, name in (("Scene hash", "scene_hash"), ("Seed", "seed"), ("Samples", "samples")):
        found = dict.fromkeys(str(getattr(area, name)) for area in areas)
        yield label, ", ".join(found)


def _hash(report: Report) -> str:
    areas = [area for scene in report.scenes for area in scene.areas]
    return f"scene {areas[0].scene_hash[:12]}" if areas else ""
