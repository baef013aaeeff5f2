"""Figures of a daylight year on the lumels of objects: judged object by object, and laid out on pages."""

import math
from dataclasses import dataclass

import numpy as np

from ..atlas.gutters import NOBODY, fill
from ..daylight import lm83
from ..daylight.coefficients import DaylightCoefficients
from ..daylight.light import Light
from ..daylight.other_sensors import follow_states, take_sensors
from ..daylight.replicated import MetricEstimate
from ..daylight.study import Figures, Question, judge
from .lumel_sheet import LumelSheet, SheetSurface
from .order import Departure
from .year_figures import COVERAGE, KINDS


@dataclass(frozen=True, eq=False)
class YearPage:
    """A page of maps. Row 0 is the bottom row; gutters and lumels inside solids are filled from their neighbours.

    Parameters
    ----------
    number, width, height : int
    covered : (h, w) bool array    Lumels that lie on a surface and were computed.
    values, errors : dict of (h, w) float32 arrays    By figure, with their standard errors.
    """

    number: int
    width: int
    height: int
    covered: np.ndarray
    values: dict[str, np.ndarray]
    errors: dict[str, np.ndarray]


@dataclass(frozen=True, eq=False)
class ObjectYear:
    """Figures of the lumels of one object.

    Parameters
    ----------
    surface : SheetSurface
    lumels, filled : int    How many were computed, and how many lie inside solids.
    figures : Figures or None    None: no lumel can be seen.
    """

    surface: SheetSurface
    lumels: int
    filled: int
    figures: Figures | None


@dataclass(frozen=True, eq=False)
class YearMaps:
    """Maps of a year.

    Parameters
    ----------
    objects : tuple of ObjectYear
    pages : tuple of YearPage
    departures : tuple of Departure    What is not as ordered.
    """

    objects: tuple[ObjectYear, ...]
    pages: tuple[YearPage, ...]
    departures: tuple[Departure, ...] = ()


def make_year_maps(
    sheet: LumelSheet,
    states: tuple[DaylightCoefficients, ...],
    first: int,
    light: Light,
    question: Question,
    margin: int,
) -> YearMaps:
    """Return the maps of a year.

    Parameters
    ----------
    sheet : LumelSheet
    states : tuple of DaylightCoefficients    All blinds open, then those of each group closed; the sheet's valid lumels
        come from the sensor ``first`` on.
    first : int
    light : Light    Of the sensors before, whose blinds count.
    question : Question
    margin : int    Rings by which charts are extended. [lumel]
    """
    objects, made = [], []
    for number, surface in enumerate(sheet.surfaces):
        rows = np.flatnonzero(sheet.owner == number)
        known = sheet.is_valid[rows]
        count = int(np.count_nonzero(known))
        figures = None
        if count:
            part = slice(first, first + count)
            opened, *closed = (take_sensors(each, part) for each in states)
            own = follow_states(light, opened, tuple(closed))
            figures = judge(own, question, sheet.area[rows[known]])
            made.append(find_columns(figures))
        objects.append(ObjectYear(surface, count, len(rows) - count, figures))
        first += count
    columns = {
        name: tuple(
            np.concatenate([getattr(each[name], part) for each in made])
            for part in ("value", "standard_error")
        )
        for name in (made[0] if made else ())
    }
    pages = tuple(_lay_out(number, sheet, columns, margin) for number in range(len(sheet.sizes)))
    return YearMaps(tuple(objects), pages, sheet.departures)


def find_columns(figures: Figures) -> dict[str, MetricEstimate]:
    """Return the figures of sensors that maps are made of, by name."""
    known = {**figures.sensors, COVERAGE: find_coverage(figures.sensors["lm83_autonomy"])}
    return {kind.name: known[kind.name] for kind in KINDS}


def find_coverage(autonomy: MetricEstimate) -> MetricEstimate:
    """Where a sensor has enough daylight by LM-83: 1, elsewhere 0.

    The error is what is left of doubt, the root of p (1 - p) with the probability p that it has enough.
    """
    bound = lm83.SHARE_OF_HOURS
    has_enough = autonomy.value >= bound - lm83.metrics.CLOSE
    away = (autonomy.value - bound) / np.maximum(autonomy.standard_error, 1e-12)
    share = 0.5 * (1.0 + np.vectorize(math.erf, otypes=[float])(away / math.sqrt(2.0)))
    return MetricEstimate(
        has_enough.astype(np.float64), np.sqrt(share * (1.0 - share)), autonomy.freedom
    )


def _lay_out(number: int, sheet: LumelSheet, columns, margin: int) -> YearPage:
    width, height = (int(side) for side in sheet.sizes[number])
    on_page = sheet.page == number
    known = np.zeros(height * width, dtype=bool)
    known[sheet.index[on_page & sheet.is_valid]] = True
    chart = np.full(height * width, NOBODY, dtype=np.int32)
    chart[sheet.index[on_page]] = sheet.chart[on_page]
    valid = on_page[sheet.is_valid]
    layers = np.zeros((2 * len(columns), height * width), dtype=np.float32)
    index = sheet.index[sheet.is_valid][valid]
    for row, column in zip(layers, (c for pair in columns.values() for c in pair), strict=True):
        row[index] = column[valid]
    shape = (height, width)
    filled, _ = fill(layers.reshape(-1, *shape), known.reshape(shape), chart.reshape(shape), margin)
    return YearPage(
        number,
        width,
        height,
        known.reshape(shape),
        dict(zip(columns, filled[::2], strict=True)),
        dict(zip(columns, filled[1::2], strict=True)),
    )
