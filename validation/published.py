"""What others published: figures of programs on the CIE tests, and the printed tables of CIE 171:2006.

The facts lie in ``reference/published.json``: ``reference_system`` (``values``, ``bands``: share of them below so many
percent), ``sources`` (text by key), ``results`` (a `Result` each), ``tables`` (a `PrintedTable` each) and ``tables_remark``.
"""

import json
from dataclasses import dataclass
from functools import lru_cache

from .reference import FOLDER


@dataclass(frozen=True)
class Result:
    """What a program got on a CIE test, as its source says.

    Parameters
    ----------
    program : str
    year : int or None
    test : str    Section of CIE 171:2006, such as ``5.8``.
    subject : str
    cases : tuple of str    Ids of the cases here that have the same subject; none: outside this suite.
    passes : str    ``yes`` or ``partly`` by the source's own rule; empty: the source does not say.
    largest, mean : float or None    Relative errors without sign. [-]
    remark : str
    source : str    Key of `Published.sources`.
    """

    program: str
    year: int | None
    test: str
    subject: str
    cases: tuple[str, ...]
    passes: str
    largest: float | None
    mean: float | None
    remark: str
    source: str


@dataclass(frozen=True)
class PrintedTable:
    """Part of a printed CIE table, with its errors.

    Parameters
    ----------
    table : str    Its number and the section.
    rounding : float    Half of the last printed digit, in the group's unit.
    rows : dict of dict of float    By group id and label of the reference.
    remark : str
    """

    table: str
    rounding: float
    rows: dict[str, dict[str, float]]
    remark: str = ""


@dataclass(frozen=True)
class Published:
    """All of it.

    Parameters
    ----------
    values : int    Analytic values of the CIE list that the reference system was judged by.
    bands : dict of float    Share of them below so many percent, by that number: 1, 3, 5, 10.
    sources : dict of str
    results : tuple of Result
    tables : tuple of PrintedTable
    remark : str    On ``tables``.
    """

    values: int
    bands: dict[int, float]
    sources: dict[str, str]
    results: tuple[Result, ...]
    tables: tuple[PrintedTable, ...]
    remark: str

    def results_of(self, case: str) -> tuple[Result, ...]:
        """Results on the subject of a case."""
        return tuple(result for result in self.results if case in result.cases)

    def printed(self, group: str) -> dict[str, float]:
        """Printed values of a group by label; empty where the selection has none."""
        return {
            label: value
            for table in self.tables
            for label, value in table.rows.get(group, {}).items()
        }


@lru_cache
def load_published() -> Published:
    """Read the facts."""
    data = json.loads((FOLDER / "published.json").read_text(encoding="utf-8"))
    system = data["reference_system"]
    return Published(
        values=system["values"],
        bands={int(band): share for band, share in system["bands"].items()},
        sources=data["sources"],
        results=tuple(
            Result(**{**entry, "cases": tuple(entry["cases"])}) for entry in data["results"]
        ),
        tables=tuple(PrintedTable(**entry) for entry in data["tables"]),
        remark=data["tables_remark"],
    )
