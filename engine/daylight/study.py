"""The study of a daylight year: light of every state of the blinds, and all figures of it with their errors."""

from dataclasses import dataclass, field

import numpy as np

from ..errors import SceneError
from ..sky.place import Place
from . import en17037, lm83, metrics
from .blinds import Rule, RuledLight, check_rules, follows_standard, move_blinds
from .coefficients import DaylightCoefficients
from .factors import find_factors
from .light import Light, ShadedLight, YearLight, find_closed
from .occupancy import CountedHours, Schedule, occupied_hours
from .replicated import MetricEstimate, estimate, find_by_sensor, over_area
from .sunlight import SunlitDay, day_hours, year_hours
from .year import Year

OWN_RULES = "blinds follow rules of one's own in all figures but sDA, whose blinds are those of LM-83 always"
"""What has to be known of a year with such rules."""


@dataclass(frozen=True)
class Question:
    """What is asked of a year.

    Parameters
    ----------
    zone : str or None    Of the clocks that people live by; None: that of the weather, without daylight saving time.
    schedule : Schedule    When they are there.
    target : float    Illuminance that a place needs. [lx]
    useful : (float, float, float)    Bounds of useful daylight illuminance. [lx]
    is_from_above : bool    Whether the openings are in the roof, for EN 17037.
    ground_reflectance : float    For daylight factors. [-]
    day : SunlitDay or None    Whose sunlight is judged; its suns follow those of the year in the coefficients.
    blinds : tuple of blinds.Rule    When those of each group of windows are closed, or of all groups; none: by LM-83.
    """

    zone: str | None = None
    schedule: Schedule = Schedule()
    target: float = metrics.TARGET
    useful: tuple[float, float, float] = metrics.USEFUL
    is_from_above: bool = False
    ground_reflectance: float = 0.2
    day: SunlitDay | None = None
    blinds: tuple[Rule, ...] = ()

    def zone_at(self, place: Place) -> str:
        """Clocks that people live by at a place."""
        return place.zone if self.zone is None else self.zone


@dataclass(frozen=True, eq=False)
class Figures:
    """What a year is judged by.

    Parameters
    ----------
    sensors : dict of MetricEstimate    By name, (n,); shares are of 1, and units are in the names.
    area : dict of MetricEstimate    The same of all sensors together, ().
    provision : dict of en17037.Provision    By method: ``factors``, ``illuminances``.
    sunlight_level : str    Level of exposure to sunlight by EN 17037; empty where no day was asked for.
    hourly : MetricEstimate    Mean over the area at the lit hours. (h,) [lx]
    is_closed : (groups, h) bool array    When blinds are closed.
    notes : tuple of str    For people.
    """

    sensors: dict[str, MetricEstimate]
    area: dict[str, MetricEstimate]
    provision: dict[str, en17037.Provision]
    sunlight_level: str
    hourly: MetricEstimate
    is_closed: np.ndarray
    notes: tuple[str, ...] = field(default=())


def shade(
    year: Year,
    opened: DaylightCoefficients,
    closed: tuple[DaylightCoefficients, ...],
    areas=None,
    question: Question | None = None,
) -> Light:
    """Return the light of a year whose blinds are closed by LM-83, or by rules of one's own.

    Parameters
    ----------
    year : Year
    opened : DaylightCoefficients    All blinds open, or none there.
    closed : tuple of DaylightCoefficients    By group of windows, with the blinds of it alone closed.
    areas : (n,) array or None    That sensors stand for. [m2]
    question : Question or None    Whose rules count; None: LM-83.

    Raises
    ------
    SceneError    As of `blinds.check_rules`.
    """
    light = YearLight(opened, year)
    rules = () if question is None else question.blinds
    check_rules(rules, len(closed), year)
    if not closed:
        return light
    shaded = tuple(YearLight(each, year) for each in closed)
    if follows_standard(rules):
        return ShadedLight(light, shaded, find_closed(light, shaded, areas))
    return move_blinds(rules, light, shaded, question.zone_at(year.weather.place), areas)


def judge(light: Light, question: Question, areas=None) -> Figures:
    """Return all figures of a year.

    Parameters
    ----------
    light : Light
    question : Question
    areas : (n,) array or None    That sensors stand for; None: all alike. [m2]

    Raises
    ------
    SceneError    No hour counts, or the weather does not fit what is asked.
    """
    year, opened = light.year, light.opened
    interval = year.weather.interval
    times, place = year.middles, year.weather.place
    zone = question.zone_at(place)
    occupied = occupied_hours(times, zone, question.schedule)
    counted = CountedHours.of_year(occupied, year.lit, interval)
    standard = CountedHours.of_year(occupied_hours(times, zone), year.lit, interval)
    versions, by_sun, hourly = _judge_sensors(light, opened, question, counted, standard, areas)
    freedom, each_hour = light.freedom, 1.0 / max(counted.count, 1)

    def of_sensors(name: str, step=0.0, column=None) -> MetricEstimate:
        own = versions[name] if column is None else versions[name][..., column]
        return estimate(own, freedom, step)

    kept = {
        "daylight_autonomy": of_sensors("daylight_autonomy", each_hour),
        "continuous_autonomy": of_sensors("continuous_autonomy"),
        **{
            f"useful_{name}": of_sensors("useful", each_hour, column)
            for column, name in enumerate(("too_little", "supplemented", "enough", "too_much"))
        },
        "lm83_autonomy": of_sensors("lm83", 1.0 / max(standard.count, 1)),
        "mean_lx": of_sensors("mean"),
        "exposure_lx_h": of_sensors("exposure"),
        "sunlit_h": MetricEstimate.exact(by_sun["sunlit"]),
        "sunshine_h": MetricEstimate.exact(by_sun["sunshine"]),
    }
    whole = {
        "mean_lx": over_area(lambda v: metrics.area_mean(v, areas), versions["mean"], freedom),
        "daylight_autonomy": over_area(
            lambda v: metrics.area_mean(v, areas), versions["daylight_autonomy"], freedom
        ),
        "sda": over_area(
            lambda v: lm83.spatial_autonomy(v, areas),
            versions["lm83"],
            freedom,
            _step(areas, light),
        ),
        "ase": estimate_sun(by_sun, areas, light),
    }
    provision, notes = {}, []
    if not isinstance(light, ShadedLight):
        notes.append("no blinds are told: sDA is that of windows without any")
    if isinstance(light, RuledLight):
        notes += [OWN_RULES, *light.notes]
    factors = find_factors(opened.coefficients, question.ground_reflectance)
    kept["daylight_factor"] = estimate(factors, freedom)
    for name, metric in (
        ("daylight_factor_median", metrics.area_median),
        ("daylight_factor_mean", metrics.area_mean),
        ("daylight_factor_least", metrics.area_least),
        ("daylight_factor_uniformity", metrics.uniformity),
    ):
        whole[name] = over_area(lambda v, metric=metric: metric(v, areas), factors, freedom)
    try:
        provision = _provide(light, question, factors, versions, areas)
    except SceneError as error:
        notes.append(f"EN 17037: {error}")
    level = ""
    if question.day is not None:
        seen = opened.coefficients.direct[:, len(year.suns) :] > 0.0
        hours = day_hours(seen, question.day)
        kept["sunlight_of_day_h"] = MetricEstimate.exact(hours)
        level = en17037.exposure_level(float(hours.max(initial=0.0)))
    is_closed = light.is_closed if isinstance(light, ShadedLight) else np.zeros((0, len(year.lit)))
    return Figures(kept, whole, provision, level, hourly, is_closed.astype(bool), tuple(notes))


def estimate_sun(by_sun: dict, areas, light: Light) -> MetricEstimate:
    """Return the annual sunlight exposure; what of it is not certain are sensors that the sun's edge passes."""
    value = lm83.sunlight_exposure(by_sun["sunlit"], areas)
    most = lm83.sunlight_exposure(by_sun["sunlit_most"], areas)
    least = lm83.sunlight_exposure(by_sun["sunlit_least"], areas)
    error = max(most - value, value - least)
    return MetricEstimate(np.array(value), np.array(float(error)), light.freedom)


def _step(areas, light: Light) -> float:
    """Share of the area that one sensor stands for, the smallest."""
    _, areas = metrics.check_areas(np.zeros(light.sensors), areas)
    return float(areas[areas > 0.0].min() / areas.sum())


def _judge_sensors(light, opened, question, counted, standard, areas):
    """Figures of sensors in all versions of the year, those by the sun alone, and means over the area by hour."""
    year = light.year
    daytime = np.zeros(len(year.lit), dtype=bool)
    is_whole_year = not (np.isnan(year.hours.diffuse_horizontal).any())
    if is_whole_year:
        diffuse = np.zeros(year.count)
        diffuse[year.lit] = year.diffuse_horizontal
        daytime = CountedHours.of_year(
            en17037.daylight_hours(diffuse), year.lit, year.weather.interval
        )
    of_sensors = {
        "daylight_autonomy": lambda e: metrics.daylight_autonomy(e, counted, question.target),
        "continuous_autonomy": lambda e: metrics.continuous_autonomy(e, counted, question.target),
        "useful": lambda e: metrics.useful_illuminance(e, counted, question.useful),
        "mean": lambda e: metrics.mean_illuminance(e, counted),
        "exposure": lambda e: metrics.light_exposure(e, counted),
        "lm83": lambda e: metrics.daylight_autonomy(e, standard, lm83.TARGET),
    }
    if is_whole_year:
        of_sensors["levels"] = lambda e: en17037.autonomy_by_level(e, daytime)
    _, areas = metrics.check_areas(np.zeros(light.sensors), areas)
    sums: list[np.ndarray] = []

    def follow(part: slice):
        for number, version in enumerate(light.versions(part)):
            if number == len(sums):
                sums.append(np.zeros(version.shape[1]))
            sums[number] += areas[part] @ version
            yield version

    versions = find_by_sensor(of_sensors, (follow(part) for part in light.blocks()))
    if isinstance(light, RuledLight):
        own = {"lm83": of_sensors["lm83"]}
        versions |= find_by_sensor(own, (light.standard.versions(part) for part in light.blocks()))
    hourly = estimate(np.stack(sums) / areas.sum(), light.freedom)
    return versions, _judge_sun(opened, standard), hourly


def _judge_sun(opened: YearLight, standard: CountedHours) -> dict[str, np.ndarray]:
    """Hours of too much sunlight by LM-83, with bounds of them, and of sunshine. (n,) each [h]"""
    year, found = opened.year, {}
    names = ("sunlit", "sunlit_most", "sunlit_least", "sunshine")
    rows: dict[str, list[np.ndarray]] = {name: [] for name in names}
    irradiance = np.nan_to_num(year.hours.direct_normal)[year.lit]
    for part in opened.blocks():
        direct, error = opened.direct_sun(part), opened.direct_sun_error(part)
        for name, value in (
            ("sunlit", direct),
            ("sunlit_most", direct + error),
            ("sunlit_least", direct - error),
        ):
            rows[name].append(lm83.sunlit_hours(value, standard))
        seen = direct / np.maximum(year.direct_normal, 1e-30) > 0.0
        rows["sunshine"].append(year_hours(seen, irradiance, year.weather.interval))
    for name, parts in rows.items():
        found[name] = np.concatenate(parts)
    return found


def _provide(light, question, factors, versions, areas) -> dict[str, en17037.Provision]:
    """Daylight provision by both methods."""
    year = light.year
    diffuse = np.full(year.count, np.nan)
    known = ~np.isnan(year.hours.diffuse_horizontal)
    diffuse[known] = 0.0
    diffuse[year.lit] = year.diffuse_horizontal
    median = en17037.median_illuminance(diffuse)
    above = question.is_from_above
    return {
        "factors": en17037.judge_factors(
            factors, median, light.freedom, areas, is_from_above=above
        ),
        "illuminances": en17037.judge_illuminances(
            versions["levels"], light.freedom, areas, is_from_above=above
        ),
    }
