"""The conversion report: everything of the Blender scene that could not be taken over as it is."""

from dataclasses import dataclass
from enum import Enum

from ..engine.reading.printable import printable


class Severity(Enum):
    """How much a row matters."""

    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True)
class Row:
    """One departure: where (``datablock``, ``node``), what (``message``), what was done instead (``remedy``)."""

    severity: Severity
    datablock: str
    node: str
    message: str
    remedy: str


class ConversionReport:
    """Rows in order of appearance, equal ones counted rather than repeated."""

    def __init__(self):
        self._counts: dict[Row, int] = {}

    def add(self, severity, datablock, node, message, remedy):
        """Note one departure."""
        row = Row(severity, *map(printable, (datablock, node, message, remedy)))
        self._counts[row] = self._counts.get(row, 0) + 1

    def include(self, other: "ConversionReport"):
        """Note all departures of another report."""
        for row, count in other.rows:
            self._counts[row] = self._counts.get(row, 0) + count

    def info(self, datablock, message, remedy, node=""):
        """Note something that changes little."""
        self.add(Severity.INFO, datablock, node, message, remedy)

    def warn(self, datablock, message, remedy, node=""):
        """Note something that changes the result."""
        self.add(Severity.WARNING, datablock, node, message, remedy)

    def error(self, datablock, message, remedy, node=""):
        """Note something that was left out."""
        self.add(Severity.ERROR, datablock, node, message, remedy)

    @property
    def rows(self) -> list[tuple[Row, int]]:
        """All rows with their counts."""
        return list(self._counts.items())

    def to_dicts(self) -> list[dict]:
        """Rows as plain dictionaries, for JSON."""
        return [
            {
                "severity": row.severity.value,
                "object": row.datablock,
                "node": row.node,
                "message": row.message,
                "instead": row.remedy,
                "count": count,
            }
            for row, count in self.rows
        ]
