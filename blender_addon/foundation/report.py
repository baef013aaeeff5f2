"""The conversion report: everything of the Blender scene that could not be taken over as it is."""

from dataclasses import dataclass
from enum import Enum

from ...engine.errors import LumenrayError, SceneError
from ...engine.reading.printable import printable


class Severity(Enum):
    """How much a row matters."""

    INFO = "info"
    WARNING = "warning"
    ERROR = "error"


@dataclass(frozen=True)
class Row:
    """One departure: where (``datablock``, ``node``), what (``message``), what was done instead (``remedy``).

    ``is_missing``: a file that the scene is made of cannot be used, so no number of this scene can be right. ``is_medium``:
    a volume sends light to other places, so no illuminance of this scene can be right.
    """

    severity: Severity
    datablock: str
    node: str
    message: str
    remedy: str
    is_missing: bool = False
    is_medium: bool = False

    def text(self) -> str:
        """One line, whatever the names in it hold."""
        where = f"{self.datablock} / {self.node}" if self.node else self.datablock
        line = f"{self.severity.value}: {where}: {self.message}; {self.remedy}"
        return "".join(sign if sign.isprintable() else "?" for sign in line)


class ConversionReport:
    """Rows in order of appearance, equal ones counted rather than repeated."""

    def __init__(self):
        self._counts: dict[Row, int] = {}

    def add(self, severity, datablock, node, message, remedy, is_missing=False, is_medium=False):
        """Note one departure."""
        words = map(printable, (datablock, node, message, remedy))
        row = Row(severity, *words, is_missing, is_medium)
        self._counts[row] = self._counts.get(row, 0) + 1

    def include(self, other: "ConversionReport"):
        """Note all departures of another report."""
        for row, count in other.rows:
            self._counts[row] = self._counts.get(row, 0) + count

    def include_new(self, other: "ConversionReport"):
        """Note the departures of another report that this one lacks."""
        for row, count in other.rows:
            self._counts.setdefault(row, count)

    def info(self, datablock, message, remedy, node=""):
        """Note something that changes little."""
        self.add(Severity.INFO, datablock, node, message, remedy)

    def warn(self, datablock, message, remedy, node=""):
        """Note something that changes the result."""
        self.add(Severity.WARNING, datablock, node, message, remedy)

    def error(self, datablock, message, remedy, node=""):
        """Note something that was left out."""
        self.add(Severity.ERROR, datablock, node, message, remedy)

    def miss(self, datablock, message, remedy, node=""):
        """Note a file that is not there, cannot be read or says nothing of use."""
        self.add(Severity.ERROR, datablock, node, message, remedy, is_missing=True)

    def medium(self, datablock, message, remedy, node=""):
        """Note a volume that sends light to other places."""
        self.add(Severity.ERROR, datablock, node, message, remedy, is_medium=True)

    def fault(self, datablock, error: LumenrayError, remedy, node=""):
        """Note what kept something out: a `SceneError` lies in the scene, all others in a file."""
        is_missing = not isinstance(error, SceneError)
        self.add(Severity.ERROR, datablock, node, str(error), remedy, is_missing)

    def forget(self, message: str):
        """Leave out what does not matter to those who use the scene in another way."""
        self._counts = {row: n for row, n in self._counts.items() if row.message != message}

    @property
    def rows(self) -> list[tuple[Row, int]]:
        """All rows with their counts."""
        return list(self._counts.items())

    @property
    def by_weight(self) -> list[tuple[Row, int]]:
        """All rows with their counts, the worst first."""
        order = list(Severity)[::-1]
        return sorted(self._counts.items(), key=lambda item: order.index(item[0].severity))

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
                "missing": row.is_missing,
            }
            for row, count in self.rows
        ]
