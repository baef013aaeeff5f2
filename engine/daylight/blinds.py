"""When blinds are closed: by the rule of LM-83, by the clock, by a table of states, or where there is too much light.

A rule is asked for one group of windows, and answers for every lit hour of a year. What it decides is the same in all
versions of the year (`replicated`): states are part of the question, not of its error. Only a rule by the illuminance of the
sensors themselves knows that illuminance with an error; hours in which this leaves the state open are counted and told.

References
----------
IES LM-83-12, 2.2
U.S. Department of Energy: EnergyPlus Input Output Reference, WindowShadingControl (closing by solar radiation on the window,
on a horizontal plane, by the beam, and by a schedule)
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..errors import FileFormatError, SceneError
from ..reading.content import read_bytes
from ..reading.text_table import MAXIMUM_BYTES, parse_table
from ..sky.clock_range import ClockRange
from ..sky.nodes import SkyNodes, find_projection
from ..sky.place import to_local
from .light import ShadedLight, YearLight, find_closed
from .occupancy import EVERY_DAY
from .year import Year


@dataclass(frozen=True)
class StandardRule:
    """LM-83: closed where the sun through the group lights more than 2 % of the area with more than 1000 lx."""


@dataclass(frozen=True)
class FixedTimes:
    """Closed in a stretch of the year and the day, by the clocks that people live by.

    Parameters
    ----------
    range : ClockRange
    days : tuple of int    Of the week, 0 is Monday.
    """

    range: ClockRange = ClockRange()
    days: tuple[int, ...] = EVERY_DAY


@dataclass(frozen=True, eq=False)
class StateTable:
    """Closed as a table says.

    Parameters
    ----------
    is_closed : (n,) bool array    One state for every record of the weather file, in its order.
    """

    is_closed: np.ndarray


@dataclass(frozen=True)
class SunBound:
    """Closed while the direct normal irradiance is above a bound. [W/m2]"""

    bound: float


@dataclass(frozen=True)
class PlaneBound:
    """Closed while the irradiance of an unobstructed plane, by sun, sky and ground together, is above a bound.

    Parameters
    ----------
    bound : float    [W/m2]
    facing : (float, float, float)    Unit vector that the plane faces, in the scene; (0, 0, 1) is horizontal.
    """

    bound: float
    facing: tuple[float, float, float] = (0.0, 0.0, 1.0)


@dataclass(frozen=True)
class SensorBound:
    """Closed while the mean illuminance of the sensors, with all blinds open, is above a bound. [lx]"""

    bound: float


Rule = StandardRule | FixedTimes | StateTable | SunBound | PlaneBound | SensorBound


@dataclass(frozen=True, eq=False)
class RuledLight(ShadedLight):
    """Light of a year whose blinds follow rules of one's own.

    Parameters
    ----------
    by_standard : (groups, h) bool array    When the blinds of each group would be closed by LM-83.
    notes : tuple of str    What is uncertain about the states, for people.
    """

    by_standard: np.ndarray
    notes: tuple[str, ...] = ()

    @property
    def standard(self) -> ShadedLight:
        """The same with its blinds by LM-83."""
        return ShadedLight(self.opened, self.closed, self.by_standard)


def follows_standard(rules: tuple[Rule, ...]) -> bool:
    """Tell whether all groups of windows follow LM-83; without any rule they do."""
    return all(isinstance(rule, StandardRule) for rule in rules)


def check_rules(rules: tuple[Rule, ...], groups: int, year: Year) -> None:
    """Refuse rules that do not fit so many groups of windows, or the weather of a year.

    Raises
    ------
    SceneError    Says what does not fit.
    """
    if rules and not groups:
        raise SceneError("it is told when blinds are closed, but there are none")
    if len(rules) not in {0, 1, groups}:
        raise SceneError(
            f"{len(rules)} rules for the blinds of {groups} groups of windows, expected one of each or one of all"
        )
    for rule in rules:
        if isinstance(rule, StateTable) and len(rule.is_closed) != year.count:
            raise SceneError(
                f"the table of blinds has {len(rule.is_closed)} states, expected one for each of the weather file's "
                f"{year.count} records"
            )


def move_blinds(
    rules: tuple[Rule, ...],
    opened: YearLight,
    closed: tuple[YearLight, ...],
    zone: str,
    areas=None,
) -> RuledLight:
    """Return the light of a year with each group of windows' blinds by a rule.

    Parameters
    ----------
    rules : tuple of Rule    One for every group, or one for all.
    opened : YearLight    All blinds open.
    closed : tuple of YearLight    The blinds of one group closed, by group; one at least.
    zone : str    Of the clocks that people live by.
    areas : (n,) array or None    That sensors stand for; None: all alike. [m2]

    Raises
    ------
    SceneError    As of `check_rules`.
    """
    groups = len(closed)
    check_rules(rules, groups, opened.year)
    by_standard = find_closed(opened, closed, areas)
    made, notes = by_standard.copy(), []
    for group, rule in enumerate(rules if len(rules) == groups else rules * groups):
        if isinstance(rule, SensorBound):
            made[group], note = _by_sensors(rule, opened, areas)
            notes += [note] if note else []
        elif not isinstance(rule, StandardRule):
            made[group] = _by_weather(rule, opened.year, zone)
    return RuledLight(opened, closed, made, by_standard, tuple(dict.fromkeys(notes)))


def _by_weather(rule: Rule, year: Year, zone: str) -> np.ndarray:
    """When a rule closes blinds that asks for nothing but hours and weather. (h,) bool"""
    match rule:
        case FixedTimes():
            return _by_clock(rule, year, zone)
        case StateTable():
            return rule.is_closed[year.lit]
        case SunBound():
            return np.nan_to_num(year.hours.direct_normal)[year.lit] > rule.bound
    return find_plane_irradiance(year, rule.facing) > rule.bound


def find_plane_irradiance(year: Year, facing) -> np.ndarray:
    """Irradiance of an unobstructed plane by sun, sky and ground at the lit hours.

    The sky's irradiance is distributed as its luminance is, and the ground reflects all wavelengths alike.

    Parameters
    ----------
    year : Year
    facing : (3,) array    Unit vector in the scene.

    Returns
    -------
    (h,) array    [W/m2]
    """
    facing = np.asarray(facing, dtype=np.float64)
    hours, lit = year.hours, year.lit
    direct = np.nan_to_num(hours.direct_normal)[lit]
    diffuse = np.nan_to_num(hours.diffuse_horizontal)[lit]
    projection = find_projection(year.steps)
    cosine = np.maximum(projection.directions @ facing, 0.0)
    counted = (projection.areas * cosine) @ SkyNodes(year.steps).spread(projection.directions)
    # From light to heat by the ratio that the record itself has.
    level = np.maximum(year.diffuse_horizontal, 1e-30)
    total = (year.sky[:, :-1] @ counted) * diffuse / level
    towards = np.zeros((len(lit), 3))
    has_sun = year.sun >= 0
    towards[has_sun] = year.suns[year.sun[has_sun]]
    total += direct * np.maximum(towards @ facing, 0.0)
    horizontal = year.diffuse_horizontal + year.direct_normal * np.maximum(towards[:, 2], 0.0)
    reflectance = np.pi * year.sky[:, -1] / np.maximum(horizontal, 1e-30)
    heat = diffuse + direct * np.maximum(towards[:, 2], 0.0)
    return total + 0.5 * (1.0 - facing[2]) * reflectance * heat


def _by_clock(rule: FixedTimes, year: Year, zone: str) -> np.ndarray:
    clocks = [to_local(time, zone) for time in year.middles[year.lit]]
    hour = [clock.hour + clock.minute / 60.0 + clock.second / 3600.0 for clock in clocks]
    is_in = rule.range.holds([clock.month for clock in clocks], hour)
    return is_in & np.isin([clock.weekday() for clock in clocks], rule.days)


def _by_sensors(rule: SensorBound, light: YearLight, areas) -> tuple[np.ndarray, str]:
    """When the light of the sensors closes blinds, (h,) bool, and what is uncertain about it."""
    areas = np.ones(light.sensors) if areas is None else np.asarray(areas, dtype=np.float64)
    total, changes = np.zeros(len(light.year.lit)), 0.0
    for part in light.blocks():
        mean, causes = light.parts(part)
        total += areas[part] @ mean
        changes = changes + np.einsum("s,csh->ch", areas[part], causes)
    error = np.sqrt((np.asarray(changes) ** 2).sum(axis=0)) / areas.sum()
    mean = total / areas.sum()
    doubtful = int(np.count_nonzero(np.abs(mean - rule.bound) < 2.0 * error))
    if not doubtful:
        return mean > rule.bound, ""
    return mean > rule.bound, (
        f"in {doubtful} hours the light of the sensors is as near to {rule.bound:g} lx, at which blinds close, as its error "
        "is large, and they may be closed or open wrongly"
    )


# ---- files ----


def read_state_tables(path) -> tuple[StateTable, ...]:
    """Read states of blinds by the records of a weather file.

    Parameters
    ----------
    path : str or Path    One line for each record, in their order: 0 is open, 1 closed; a column for each group of windows,
        or one for all. A heading may come first.

    Returns
    -------
    tuple of StateTable    One for every column.

    Raises
    ------
    FileFormatError    It is no such table; names the line.
    """
    path = Path(path)
    expected = "0 (open) or 1 (closed), a column for each group of windows"
    rows = parse_table(path, read_bytes(path, MAXIMUM_BYTES), 1, expected).rows
    if not rows:
        raise FileFormatError(path, f"has no states, expected {expected}")
    width = len(rows[0][1])
    for line, values in rows:
        if len(values) != width:
            raise FileFormatError(path, f"has {len(values)} states, expected {width}", line)
        wrong = [value for value in values if value not in {0.0, 1.0}]
        if wrong:
            shown = "an empty field" if wrong[0] is None else f"the state {wrong[0]:g}"
            raise FileFormatError(path, f"has {shown}, expected {expected}", line)
    table = np.array([values for _, values in rows], dtype=bool)
    return tuple(StateTable(column) for column in table.T)
